"""The maps of a clone as worlds of this package, with the competition's sensor, radio and budgets.

What wins in the competition's simulator can so be compared in this one, with exact geometry and
any strategy. The two differ: here robots drive straight and have bodies, scans are exact, and each
strategy brings its news home in its own way, or not at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from multisrt.competition.clone import CELL_M, Clone
from multisrt.competition.published import SIZES, TEAMS, budget
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    BaseSpec,
    DriveSpec,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

RANGE_FINDER: Final = RangeFinderSpec(range_m=15.0)
"""The range finder of the competition; here exact instead of 2,500 rays."""

RADIO: Final = RadioSpec(range_m=15.0, walls="weaken", path_loss_exponent=3.5, wall_loss_db=3.0)
"""The nearest to the competition's links: 15, 12.3, 10.1 and 8.3 m through 0 to 3 walls.

There, each cell of a wall costs 10 dB of the 100 that a link bears at 1 m, and 15 m is a bound of
its own: through walls of three cells links reach 15, 15, 13.9 and 1.9 m.
"""

DRIVE: Final = DriveSpec(kind="holonomic", speed_m_s=0.3)
"""Three cells of 10 cm in a second: a step of the competition is a second here."""

BODY: Final = "disc:0.1"
"""The body: a robot of the competition is a cell that keeps another one from walls."""

APART_M: Final = 0.3
"""Distance of starts from the base's place, all of which are one cell in the competition."""


@dataclass(frozen=True, kw_only=True)
class CompetitionWorld:
    """A map of the competition with a place of the base.

    Attributes
    ----------
    name : str
        The map: ``"env1"`` to ``"env7"``.
    size : str
        ``"small"``, ``"medium"`` or ``"large"``, which gives the budgets.
    environment : Environment
        The world; its suggested starts are five places at that of the base.
    base : (x, y)
        The place of the base in metres.
    """

    name: str
    size: str
    environment: Environment
    base: tuple[float, float]

    def fields(self, robots: int) -> dict[str, Any]:
        """Return the fields of `RunSpec` that the competition gives for a number of robots.

        Parameters
        ----------
        robots : int
            Number of robots, 1 to 5.

        Returns
        -------
        dict
            ``environment``, ``robots``, ``radio``, ``base`` and ``stop``: the range finder of
            15 m, a body of a cell, the radio, the base, and the budget of steps as seconds.

        Raises
        ------
        InvalidInputError
            If the competition has no such team.
        """
        if robots not in TEAMS:
            raise InvalidInputError(
                f"the competition has teams of {TEAMS[0]} to {TEAMS[-1]} robots, not {robots}"
            )
        starts = self.environment.starts
        return {
            "environment": inline(self.environment),
            "robots": tuple(
                RobotSpec(start=(x, y, 0.0), footprint=BODY, drive=DRIVE, range_finder=RANGE_FINDER)
                for x, y in starts[:robots]
            ),
            "radio": RADIO,
            "base": BaseSpec(x=self.base[0], y=self.base[1]),
            "stop": StopRule(max_time_s=float(budget(self.name, robots))),
        }

    def spec(self, strategy: str, robots: int, *, seed: int = 0, **options: Any) -> RunSpec:
        """Return the spec of a run of a strategy under the competition's conditions.

        Parameters
        ----------
        strategy : str
            Name of a registered strategy.
        robots : int
            Number of robots, 1 to 5.
        seed : int
            Seed of the run.
        **options
            Options of the strategy.

        Raises
        ------
        InvalidInputError
            If the competition has no such team.
        """
        return RunSpec(strategy=strategy, options=options, seed=seed, **self.fields(robots))


def competition_worlds(
    folder: str | Path, names: Sequence[str] = (), *, draws: int = 1, seed: int = 0
) -> list[CompetitionWorld]:
    """Return the maps of the competition as worlds, with places of the base drawn on each.

    Parameters
    ----------
    folder : path-like
        A clone of the competition's repository.
    names : sequence of str
        Some of the maps; none for all seven.
    draws : int
        Places drawn on each map.
    seed : int
        Seed of the draws. They are those of ``multisrt compete`` with the same ``--draws`` and
        ``--seed``.

    Returns
    -------
    list of CompetitionWorld
        In the order of the maps, then of the draws.

    Raises
    ------
    InvalidInputError
        If the folder is not a clone, or has no such map.

    Examples
    --------
    >>> competition_worlds("elsewhere")
    Traceback (most recent call last):
        ...
    multisrt.geometry.errors.InvalidInputError: elsewhere is not a clone of the competition: ...
    """
    clone = Clone(Path(folder), any_version=True)
    found = []
    for name in clone.maps(tuple(names)):
        plain = clone.environment(name)
        rows = clone.cells(name)[0].shape[0]
        for column, row in clone.starts(name, draws, seed):
            x, y = (column + 0.5) * CELL_M, (rows - row - 0.5) * CELL_M
            around = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
            starts = [(x + APART_M * a, y + APART_M * b) for a, b in around]
            environment = Environment(name, plain.free, starts=starts, origin=plain.origin)
            found.append(
                CompetitionWorld(name=name, size=SIZES[name], environment=environment, base=(x, y))
            )
    return found


def competition_environment(folder: str | Path, name: str) -> Environment:
    """Return a map of the competition as a world.

    Parameters
    ----------
    folder : path-like
        A clone of the competition's repository.
    name : str
        The map: ``"env1"`` to ``"env7"``.

    Returns
    -------
    Environment
        The free cells inside of the building, 10 cm each, in metres with the lower left corner of
        the map at the origin.

    Raises
    ------
    InvalidInputError
        If the folder is not a clone, or has no such map.

    Examples
    --------
    >>> competition_environment("elsewhere", "env3")
    Traceback (most recent call last):
        ...
    multisrt.geometry.errors.InvalidInputError: elsewhere is not a clone of the competition: ...
    """
    return Clone(Path(folder), any_version=True).environment(name)
