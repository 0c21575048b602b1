"""The claims in the text of the SBX-R paper, and the cells of its tables that they refer to."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from multisrt.experiments.crossing import Condition
from multisrt.presets.cells import Cells
from multisrt.presets.sbx_r_tables import (
    CLOSEST,
    OTHERS,
    PAPER,
    RADIO_RANGES_M,
    TEAMS,
    UTILITY,
    PaperTable,
)

Cell = tuple[str, int, int]
"""The strategy that SBX-R is compared with, the range of the radio (m), and the team size."""

ALL: dict[str, tuple[Cell, ...]] = {
    other: tuple((other, radio, robots) for radio in RADIO_RANGES_M for robots in TEAMS)
    for other in OTHERS
}
"""The cells of a table by the strategy that SBX-R is compared with."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellClaim:
    """A claim of the paper on some cells of a table.

    Attributes
    ----------
    text : str
        The claim.
    table : PaperTable
        The table.
    cells : tuple of Cell
        The cells that the claim refers to.
    better : bool
        Whether SBX-R is claimed to be better, or worse.
    """

    text: str
    table: PaperTable
    cells: tuple[Cell, ...]
    better: bool = True

    @property
    def rivals(self) -> tuple[str, ...]:
        """The strategies that SBX-R is compared with, in the order of `OTHERS`."""
        compared = {cell[0] for cell in self.cells}
        return tuple(other for other in OTHERS if other in compared)


def _cell_claims() -> list[CellClaim]:
    isolation, longest, beyond, time, distance = PAPER
    together = [
        CellClaim(text=f"{text} than with {other}.", table=table, cells=ALL[other])
        for text, table in (
            ("With self-bidding the time in which some robot is isolated is shorter", isolation),
            ("With self-bidding the longest isolation of a robot is shorter", longest),
            ("With self-bidding an isolated robot goes less far out of range", beyond),
        )
        for other in OTHERS
    ]
    return [
        *together,
        CellClaim(
            text="Self-bidding takes less time than both others in teams of 3 and 4 with a radio "
            "range of 20 or 30 m and in teams of 5 with one of 30 m, and less than closest in "
            "teams of 4 with one of 15 m.",
            table=time,
            cells=(
                *((o, radio, n) for o in OTHERS for radio in (20, 30) for n in (3, 4)),
                *((o, 30, 5) for o in OTHERS),
                (CLOSEST, 15, 4),
            ),
        ),
        CellClaim(
            text="Two robots with a radio range of 15 m take longer by self-bidding than by "
            "closest.",
            table=time,
            cells=((CLOSEST, 15, 2),),
            better=False,
        ),
        CellClaim(
            text="Five robots with a radio range of 15 m take longer by self-bidding than by "
            "utility.",
            table=time,
            cells=((UTILITY, 15, 5),),
            better=False,
        ),
        CellClaim(
            text="In teams of 3 to 5 distances are shorter by self-bidding than by closest, or do "
            "not differ significantly.",
            table=distance,
            cells=tuple((CLOSEST, radio, n) for radio in RADIO_RANGES_M for n in (3, 4, 5)),
        ),
        CellClaim(
            text="Two robots with a radio range of 20 m travel more by self-bidding than by both "
            "others.",
            table=distance,
            cells=tuple((o, 20, 2) for o in OTHERS),
            better=False,
        ),
        CellClaim(
            text="With a radio range of 15 m teams travel more by self-bidding than by utility.",
            table=distance,
            cells=tuple((UTILITY, 15, n) for n in TEAMS),
            better=False,
        ),
        CellClaim(
            text="With a radio range of 30 m teams of 3 and 4 travel less by self-bidding than by "
            "utility.",
            table=distance,
            cells=tuple((UTILITY, 30, n) for n in (3, 4)),
        ),
    ]


CLAIMS = _cell_claims()
"""Claims in the text of section IV, all of which the printed marks support."""


def claims_about(others: Collection[str], radio_m: int, robots: int) -> tuple[str, ...]:
    """Return the texts of the claims that refer to a radio and a team size.

    Parameters
    ----------
    others : collection of str
        The strategies of which at least one is compared there.
    radio_m, robots : int
        Range of the radio in metres, and team size.

    Examples
    --------
    >>> print(*claims_about(["closest", "utility"], 20, 2)[-1:])
    Two robots with a radio range of 20 m travel more by self-bidding than by both others.
    """
    return tuple(
        claim.text
        for claim in CLAIMS
        if any((other, radio_m, robots) in claim.cells for other in others)
    )


def conditions_by_cell(cells: Cells) -> dict[Cell, Condition]:
    """Return the conditions of an experiment by the cell that they are in, also of SBX-R."""
    return {(at.strategy, int(at.radio.split()[0]), at.robots): at for at in cells.conditions()}
