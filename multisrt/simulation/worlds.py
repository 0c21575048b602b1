"""The worlds that specs describe."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import shapely

from multisrt.environments.catalog import environment, names
from multisrt.environments.environment import Environment
from multisrt.environments.formats import read_environment
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.spec import CatalogEnvironment, EnvironmentSpec, FileEnvironment, InlineEnvironment


def environment_spec(
    text: str, *, resolution_m: float | None = None, threshold: float | None = None
) -> CatalogEnvironment | FileEnvironment:
    """Tell a name of the catalogue from a file.

    What is a name of the catalogue means that; write ``./office`` for a file of that name.

    Raises
    ------
    InvalidInputError
        If it is neither; the message lists the catalogue.
    """
    if text in names():
        if resolution_m is not None or threshold is not None:
            raise InvalidInputError(
                f"{text!r} is an environment of the catalogue: a resolution or a threshold is "
                "for images"
            )
        return CatalogEnvironment(name=text)
    path = Path(text)
    if not _exists(path) and not path.suffix and len(path.parts) == 1:
        raise InvalidInputError(
            f"there is no environment {text!r}{did_you_mean(text, names())} and no file of that "
            f"name; the catalogue has: {', '.join(names())}"
        )
    return FileEnvironment(path=text, resolution_m=resolution_m, threshold=threshold)


def _exists(path: Path) -> bool:
    # What cannot be asked for, by too long a name or for want of rights, is no file here.
    try:
        return path.exists()
    except OSError:
        return False


def inline(environment: Environment) -> InlineEnvironment:
    """Write an environment out, so that a spec holds it wholly."""
    return InlineEnvironment(
        name=environment.name,
        wkt=shapely.to_wkt(environment.free, rounding_precision=-1),
        starts=environment.starts,
    )


def build_environment(spec: EnvironmentSpec) -> Environment:
    """Build or read the world that a spec describes.

    Raises
    ------
    InvalidInputError
        If it cannot be built; the message says what is wrong.
    """
    if isinstance(spec, CatalogEnvironment):
        parameters: dict[str, Any] = dict(spec.parameters)
        return environment(spec.name, seed=spec.seed, **parameters)
    if isinstance(spec, FileEnvironment):
        return read_environment(
            Path(spec.path), resolution_m=spec.resolution_m, threshold=spec.threshold
        )
    try:
        with np.errstate(invalid="ignore"):  # coordinates that are no numbers are refused below
            free = shapely.from_wkt(spec.wkt)
    except shapely.errors.ShapelyError as error:
        raise InvalidInputError(f"environment {spec.name!r}: {error}") from None
    return Environment(spec.name, free, starts=spec.starts)
