"""The worlds that specs describe."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import shapely

from multisrt.environments import suites
from multisrt.environments.catalog import environment, names
from multisrt.environments.environment import Environment
from multisrt.environments.formats import read_environment
from multisrt.environments.formats.wkt import geometry_of
from multisrt.geometry.errors import InvalidInputError, did_you_mean, shown
from multisrt.spec import (
    CatalogEnvironment,
    EnvironmentSpec,
    FileEnvironment,
    InlineEnvironment,
    RunSpec,
    Scalar,
    SuiteEnvironment,
)

MAX_STARTS_LISTED = 3
"""Number of suggested starts that messages list."""


def environment_spec(
    text: str,
    *,
    parameters: Mapping[str, Scalar] | None = None,
    resolution_m: float | None = None,
    threshold: float | None = None,
    starts_from: str | None = None,
) -> CatalogEnvironment | SuiteEnvironment | FileEnvironment:
    """Return the spec of an environment that is named by a text.

    Parameters
    ----------
    text : str
        A name of the catalogue or of a world of a suite (``indoor-30/07``), or else the path of a
        file; write ``./office`` for a file whose name is in the catalogue.
    parameters : mapping of str to scalar, optional
        Parameters of a generator that are not its defaults, its seed among them.
    resolution_m : float, optional
        Metres per pixel, for an image whose file does not give them.
    threshold : float, optional
        Lightness in [0, 1] above which a pixel of a plain image is free.
    starts_from : str, optional
        A team file of MRESim that gives a plain image its suggested starts.

    Raises
    ------
    InvalidInputError
        If the text is none of these, an environment of the catalogue or of a suite is given a
        resolution, a threshold or a team file, or a file or a world of a suite is given parameters.

    Examples
    --------
    >>> environment_spec("office").name
    'office'
    >>> environment_spec("maze", parameters={"cells": 20, "seed": 3}).parameters
    {'cells': 20}
    >>> environment_spec("indoor-30/07").version
    1
    >>> environment_spec("./office.png", resolution_m=0.05).path
    './office.png'
    """
    if not text:
        raise InvalidInputError("the name of the world is empty: name an environment or a map file")
    kind = "suite" if suites.is_world(text) else "catalogue" if text in names() else ""
    if kind and any(value is not None for value in (resolution_m, threshold, starts_from)):
        raise InvalidInputError(
            f"{text!r} is an environment of the {kind}: a resolution, a threshold or a team file "
            "is for images"
        )
    if kind == "catalogue":
        given = dict(parameters or {})
        seed: Any = given.pop("seed", None)
        return CatalogEnvironment(name=text, parameters=given, seed=seed)
    if parameters:
        what = "a world of a suite, which is fixed" if kind else "a map file"
        raise InvalidInputError(
            f"{text!r} is {what}: parameters are for generators; leave out {', '.join(parameters)}"
        )
    if kind == "suite":
        suite = suites.load(text.partition("/")[0])
        suite.require_world(text)
        return SuiteEnvironment(name=text, version=suite.version)
    if text in suites.names():
        suite = suites.load(text)
        raise InvalidInputError(
            f"{text!r} is a suite of {len(suite)} worlds, for experiments; name one of them, "
            f"{suite.world_names[0]} to {suite.world_names[-1]}"
        )
    path = Path(text)
    if not _exists(path) and (meant := did_you_mean(text.partition("/")[0], suites.names())):
        raise InvalidInputError(
            f"there is no file {shown(text)}, and no suite of that name{meant}; suites are: "
            f"{', '.join(suites.names())}"
        )
    if not _exists(path) and not path.suffix and len(path.parts) == 1:
        raise InvalidInputError(
            f"there is no environment {shown(text)}{did_you_mean(text, names())} and no file of "
            f"that name; the catalogue has: {', '.join(names())}; suites are: "
            f"{', '.join(suites.names())}"
        )
    return FileEnvironment(
        path=text, resolution_m=resolution_m, threshold=threshold, starts_from=starts_from
    )


def _exists(path: Path) -> bool:
    # A path that cannot be looked up, as it is too long or for lack of rights, counts as no file.
    try:
        return path.exists()
    except OSError:
        return False


def inline(environment: Environment) -> InlineEnvironment:
    """Return a spec that contains an environment completely."""
    return InlineEnvironment(
        name=environment.name,
        wkt=shapely.to_wkt(environment.free, rounding_precision=-1),
        starts=environment.starts,
    )


def build_environment(spec: EnvironmentSpec) -> Environment:
    """Return the world that a spec describes: generated, read from a file, or parsed.

    Raises
    ------
    InvalidInputError
        If it cannot be built or read, or a file holds another world than the spec says; the message
        says why.
    """
    if isinstance(spec, CatalogEnvironment):
        parameters: dict[str, Any] = dict(spec.parameters)
        if "seed" in parameters:
            raise InvalidInputError(
                f"{spec.name}: the seed is not among the parameters of an environment, but a field "
                f"beside them: seed = {parameters['seed']}"
            )
        return environment(spec.name, seed=spec.seed, **parameters)
    if isinstance(spec, SuiteEnvironment):
        return suites.world(spec.name, version=spec.version)
    if isinstance(spec, FileEnvironment):
        world = read_environment(
            Path(spec.path),
            resolution_m=spec.resolution_m,
            threshold=spec.threshold,
            starts_from=spec.starts_from,
        )
        require_recorded(spec, world)
        return world
    # Coordinates that are not finite are refused by the environment.
    free = geometry_of(spec.wkt, f"environment {shown(spec.name)}")
    return Environment(spec.name, free, starts=spec.starts)


def require_recorded(spec: EnvironmentSpec, environment: Environment) -> None:
    """Check that a world from a file has the digest and the suggested starts that the spec has.

    Raises
    ------
    InvalidInputError
        If it has others.
    """
    if not isinstance(spec, FileEnvironment):
        return
    if spec.digest not in (None, environment.digest):
        found, given = environment.digest[:12], str(spec.digest)[:12]
        raise InvalidInputError(
            f"{spec.path} holds another world than when the spec was written: its free space has "
            f"the digest {found}..., and the spec has {given}...; restore the file, or remove the "
            "line 'digest' from the spec to explore the world that it holds now"
        )
    if spec.starts not in (None, environment.starts):
        raise InvalidInputError(
            f"{spec.starts_from or spec.path} suggests other starts than when the spec was "
            f"written: {_listed(environment.starts)}, and the spec has "
            f"{_listed(spec.starts or ())}; restore the file, or remove the line 'starts' from the "
            "spec to start where it suggests now"
        )


def _listed(starts: Sequence[tuple[float, float]]) -> str:
    texts = [f"({x:g}, {y:g})" for x, y in starts[:MAX_STARTS_LISTED]]
    if more := len(starts) - len(texts):
        texts.append(f"{more} more")
    return ", ".join(texts) or "none"


def with_record(
    spec: RunSpec, digest: str | None, starts: tuple[tuple[float, float], ...] | None
) -> RunSpec:
    """Return a spec with what its world was if that is from a file, or without it.

    Parameters
    ----------
    spec : RunSpec
        The spec of a run.
    digest : str or None
        Digest of its world, `Environment.digest`.
    starts : tuple of (x, y) or None
        Suggested starts of its world in metres. They are left out if no robot may start there.

    Examples
    --------
    >>> spec = RunSpec(environment=FileEnvironment(path="hall.wkt"))
    >>> there = with_record(spec, "1f0c", ((2.0, 3.0),)).environment
    >>> there.digest, there.starts
    ('1f0c', ((2.0, 3.0),))
    """
    if not isinstance(spec.environment, FileEnvironment):
        return spec
    if all(robot.start is not None for robot in spec.robots):
        starts = None
    file = msgspec.structs.replace(spec.environment, digest=digest, starts=starts)
    return msgspec.structs.replace(spec, environment=file)
