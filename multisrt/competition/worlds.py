"""The maps of a clone as worlds of this package, with the competition's sensor, radio and budgets.

They allow comparing any strategy of this package under the conditions of the competition, with
exact geometry. Its simulator and this one differ: here robots have bodies and drive along straight
lines, scans are exact, and strategies deliver data to the base by their own rules, or not at all.
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
"""The range finder of the competition; exact here, 2,500 rays there."""

RADIO: Final = RadioSpec(range_m=15.0, walls="weaken", path_loss_exponent=3.5, wall_loss_db=3.0)
"""The closest approximation of the competition's links.

Its links reach 15, 12.3, 10.1 and 8.3 m through 0 to 3 walls. In the competition each cell
of a wall costs 10 dB of the 100 dB that a link tolerates at 1 m, and the range is limited to 15 m:
through 0 to 3 walls of three cells, links reach 15, 15, 13.9 and 1.9 m.
"""

DRIVE: Final = DriveSpec(kind="holonomic", speed_m_s=0.3)
"""Three cells of 10 cm per second: a step of the competition corresponds to a second."""

BODY: Final = "disc:0.1"
"""The body: robots of the competition are one cell that keeps one cell of distance from walls."""

START_SPACING_M: Final = 0.3
"""Distance of starts from the base; in the competition they are all in its cell."""


@dataclass(frozen=True, kw_only=True)
class CompetitionWorld:
    """A map of the competition with a position of the base.

    Attributes
    ----------
    name : str
        The map: ``"env1"`` to ``"env7"``.
    size : str
        ``"small"``, ``"medium"`` or ``"large"``, which determines the numbers of steps.
    environment : Environment
        The world; its suggested starts are the position of the base and four around it.
    base : (x, y)
        Position of the base in metres.
    """

    name: str
    size: str
    environment: Environment
    base: tuple[float, float]

    def fields(self, robots: int) -> dict[str, Any]:
        """Return the fields of `RunSpec` that the competition prescribes for a number of robots.

        Parameters
        ----------
        robots : int
            Number of robots, 1 to 5.

        Returns
        -------
        dict
            ``environment``, ``robots`` (with body, drive and range finder), ``radio``, ``base`` and
            ``stop``, the number of steps as seconds.

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
    """Return the maps of the competition as worlds, each with drawn positions of the base.

    Parameters
    ----------
    folder : path-like
        A clone of the competition's repository.
    names : sequence of str
        Names of maps; empty for all seven.
    draws : int
        Number of positions drawn on each map.
    seed : int
        Seed of the draws. The positions are the starts of ``multisrt compete`` with the same
        ``--draws`` and ``--seed``.

    Returns
    -------
    list of CompetitionWorld
        Sorted by map, then by draw.

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
    worlds = []
    for name in clone.maps(tuple(names)):
        plain = clone.environment(name)
        rows = clone.cells(name)[0].shape[0]
        for column, row in clone.starts(name, draws, seed):
            x, y = (column + 0.5) * CELL_M, (rows - row - 0.5) * CELL_M
            around = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
            starts = [(x + START_SPACING_M * a, y + START_SPACING_M * b) for a, b in around]
            environment = Environment(name, plain.free, starts=starts, origin=plain.origin)
            worlds.append(
                CompetitionWorld(name=name, size=SIZES[name], environment=environment, base=(x, y))
            )
    return worlds


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
        The free cells of 10 cm inside the building. Coordinates are in metres from the lower left
        corner of the map.

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
