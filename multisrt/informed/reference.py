"""How long a team that knows the map takes: the reference of the times of strategies.

The regret of a run is its time as a multiple of that. Like is compared with like: times until the
same share is covered, and times until all are done, driven home by both or by none.

A reference takes up to a minute to plan, so references are kept in a folder of the user's cache:
one small JSON file for each world, team and starts. A file that is missing, broken or of another
version of the program is computed again.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path

import msgspec
from platformdirs import user_cache_path

from multisrt.analysis.measuring import measure
from multisrt.analysis.metrics import ROUNDING, Metrics
from multisrt.environments.environment import Environment
from multisrt.events import Motion
from multisrt.geometry.errors import MultiSrtError
from multisrt.recording import Recording, atomic_write
from multisrt.simulation.simulate import simulate
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import build_environment
from multisrt.spec import RunSpec

MAX_FILES = 2_000
"""Number of references that are kept; those used least recently are deleted first."""


PLANNED_SHARE = 0.99
"""Share of the explorable area that a run covers to be compared by its end."""

HOME_M = 0.05
"""A robot this close to its start is at home."""


class Reference(msgspec.Struct, frozen=True, kw_only=True):
    """Times of the informed plan in a world, measured as any other run.

    Attributes
    ----------
    time_to_90_s, time_to_95_s, time_to_99_s : float or None
        When that share of the explorable area was covered; None if it never was.
    makespan_s : float
        When all robots were done.
    distance_m : float
        Distance that all robots drove.
    coverage : float
        Share of the explorable area that was covered.
    """

    time_to_90_s: float | None
    time_to_95_s: float | None
    time_to_99_s: float | None
    makespan_s: float
    distance_m: float
    coverage: float


class Regret(msgspec.Struct, frozen=True, kw_only=True):
    """Times of a run as multiples of those of the informed plan.

    Attributes
    ----------
    time_to_99 : float or None
        Of the time until 99 % are covered; None if either never came so far, or the plan sees
        them from the start.
    makespan : float or None
        Of the time until all are done; None if the plan takes no time, or covered more.
    """

    time_to_99: float | None
    makespan: float | None


def informed_reference(
    spec: RunSpec,
    environment: Environment | None = None,
    *,
    home: bool = False,
    planning: Callable[[float], None] | None = None,
) -> Reference:
    """Return what the informed plan takes for the team of a run, from the same starts.

    Parameters
    ----------
    spec : RunSpec
        The run: its environment, robots and starts count. Faults do not, as the plan is for
        robots that live.
    environment : Environment, optional
        The world that `spec.environment` describes, if it has been built already.
    home : bool
        Whether the robots drive home in the end.
    planning : callable, optional
        Called with the share of the planning that is done.

    Returns
    -------
    Reference
        The same for equal parameters.

    Raises
    ------
    InvalidInputError
        If there is no plan for such a team, as for cars.

    Examples
    --------
    >>> import multisrt as ms
    >>> world = ms.CatalogEnvironment(name="open", parameters={"size_m": 8.0})
    >>> spec = ms.RunSpec(environment=world, seed=1)
    >>> informed_reference(spec).time_to_99_s < ms.explore(spec).metrics.time_to_99_s
    True
    """
    if environment is None:
        environment = build_environment(spec.environment)
    asked = informed_run(spec, environment, home=home)
    found = kept_reference(asked, environment)
    if found is None:
        found = _driven(asked, environment, planning)
        keep_reference(asked, environment, found)
    return found


def informed_run(spec: RunSpec, environment: Environment, *, home: bool = False) -> RunSpec:
    """Return the run in which the informed plan is driven by the team of a run.

    Parameters
    ----------
    spec : RunSpec
        The run: its environment, robots and starts count.
    environment : Environment
        Its world.
    home : bool
        Whether the robots drive home in the end.

    Returns
    -------
    RunSpec
        A run of `informed`, equal for runs that are judged by the same plan.

    Raises
    ------
    InvalidInputError
        If the team does not fit into the world.

    Examples
    --------
    >>> import multisrt as ms
    >>> world = ms.CatalogEnvironment(name="open", parameters={"size_m": 8.0})
    >>> runs = [ms.RunSpec(environment=world, strategy=s) for s in ("minpos", "closest")]
    >>> plans = [informed_run(run, build_environment(world)) for run in runs]
    >>> plans[0].strategy, plans[0] == plans[1]
    ('informed', True)
    """
    starts = starts_of(spec, environment)
    return RunSpec(
        environment=spec.environment,
        strategy="informed",
        options={"home": home},
        robots=tuple(
            msgspec.structs.replace(robot, start=tuple(start))
            for robot, start in zip(spec.robots, starts, strict=True)
        ),
    ).canonical()


def reference_of(metrics: Metrics) -> Reference:
    """Return the reference that a run of the informed plan is.

    Parameters
    ----------
    metrics : Metrics
        The metrics of the run.

    Returns
    -------
    Reference
        Its times, distance and coverage.
    """
    return Reference(
        time_to_90_s=metrics.time_to_90_s,
        time_to_95_s=metrics.time_to_95_s,
        time_to_99_s=metrics.time_to_99_s,
        makespan_s=metrics.makespan_s,
        distance_m=metrics.total_distance_m,
        coverage=metrics.coverage,
    )


def regret(
    recording: Recording,
    metrics: Metrics,
    environment: Environment,
    planning: Callable[[float], None] | None = None,
) -> Regret:
    """Return the times of a run as multiples of those of the informed plan.

    Parameters
    ----------
    recording : Recording
        The run.
    metrics : Metrics
        Its metrics.
    environment : Environment
        Its world.
    planning : callable, optional
        As for `informed_reference`.

    Returns
    -------
    Regret
        The multiples. If the robots of the run drove home, so do those of the plan for `makespan`;
        a run that covered less than the plan, up to `PLANNED_SHARE`, has no such multiple.
    """
    spec = recording.spec
    there = informed_reference(spec, environment, planning=planning)
    back = there
    if _drove_home(recording):
        back = informed_reference(spec, environment, home=True, planning=planning)
    # A run that ends early is not compared with a plan that continues.
    is_alike = metrics.coverage >= min(PLANNED_SHARE, back.coverage) - ROUNDING
    return Regret(
        time_to_99=_multiple(metrics.time_to_99_s, there.time_to_99_s),
        makespan=_multiple(metrics.makespan_s, back.makespan_s) if is_alike else None,
    )


def _drove_home(recording: Recording) -> bool:
    # Whether every robot that moved ended where it had started.
    ends = {motion.robot: motion.waypoints[-1][1:3] for motion in recording.of(Motion)}
    return bool(ends) and all(
        math.dist(end, recording.starts[robot][:2]) <= HOME_M for robot, end in ends.items()
    )


def _multiple(time_s: float | None, reference_s: float | None) -> float | None:
    return time_s / reference_s if time_s is not None and reference_s else None


def _driven(
    spec: RunSpec, environment: Environment, planning: Callable[[float], None] | None
) -> Reference:
    return reference_of(measure(simulate(spec, environment, planning=planning), environment))


# The cache ----------------------------------------------------------------------------------


def kept_reference(asked: RunSpec, environment: Environment) -> Reference | None:
    """Return a reference from the cache.

    Parameters
    ----------
    asked : RunSpec
        The run of the plan; see `informed_run`.
    environment : Environment
        Its world.

    Returns
    -------
    Reference or None
        None if it is not there.
    """
    path = _path(asked, environment)
    try:
        found = msgspec.json.decode(path.read_bytes(), type=Reference)
        path.touch()
    except (OSError, msgspec.MsgspecError):
        return None
    return found


def keep_reference(asked: RunSpec, environment: Environment, reference: Reference) -> None:
    """Write a reference to the cache; one that cannot be written costs time, and nothing else.

    Parameters
    ----------
    asked : RunSpec
        The run of the plan; see `informed_run`.
    environment : Environment
        Its world.
    reference : Reference
        What the plan took.
    """
    path = _path(asked, environment)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as file:
            file.write(msgspec.json.encode(reference))
        files = sorted(path.parent.glob("*.json"), key=lambda file: file.stat().st_mtime)
        for old in files[:-MAX_FILES]:
            old.unlink(missing_ok=True)
    except (OSError, MultiSrtError):
        return


def _folder() -> Path:
    return user_cache_path("multisrt") / "informed"


def _path(spec: RunSpec, environment: Environment) -> Path:
    team = msgspec.json.encode((spec.robots, spec.options))
    text = b" ".join((_program().encode(), environment.digest.encode(), team))
    return _folder() / f"{hashlib.sha256(text).hexdigest()[:32]}.json"


@cache
def _program() -> str:
    """Return a digest of the source of this package."""
    top = Path(__file__).parents[1]
    digest = hashlib.sha256()
    # rglob does not descend into a symbolic link.
    for part in sorted(path for path in top.iterdir() if path.is_dir() or path.suffix == ".py"):
        base = part.resolve()
        for path in sorted(base.rglob("*.py")) if base.is_dir() else [base]:
            digest.update(f"{part.name}/{path.relative_to(base)}".encode())
            digest.update(path.read_bytes())
    packages = ("numba", "numpy", "scipy", "shapely")
    digest.update(" ".join(f"{name} {version(name)}" for name in packages).encode())
    return digest.hexdigest()
