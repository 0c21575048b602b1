"""The claims in the text of the SBX-R paper, and the cells of its tables that they refer to."""

from __future__ import annotations

from dataclasses import dataclass

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


def _cell_claims() -> list[CellClaim]:
    isolation, longest, beyond, time, distance = PAPER
    together = [
        CellClaim(text=f"{text} than with {other}.", table=table, cells=ALL[other])
        for text, table in (
            ("With self-bidding some robot is isolated for less time", isolation),
            ("With self-bidding the longest isolation of a robot is shorter", longest),
            ("With self-bidding an isolated robot goes less far out of range", beyond),
        )
        for other in OTHERS
    ]
    return [
        *together,
        CellClaim(
            text="In teams of 3 and 4 with a radio of 20 or 30 m self-bidding takes less time than "
            "both others.",
            table=time,
            cells=tuple((o, radio, n) for o in OTHERS for radio in (20, 30) for n in (3, 4)),
        ),
        CellClaim(
            text="Two robots with a radio of 15 m take longer by self-bidding than by closest.",
            table=time,
            cells=((CLOSEST, 15, 2),),
            better=False,
        ),
        CellClaim(
            text="Five robots with a radio of 15 m take longer by self-bidding than by utility.",
            table=time,
            cells=((UTILITY, 15, 5),),
            better=False,
        ),
        CellClaim(
            text="Teams of 3 to 5 travel less by self-bidding than by closest.",
            table=distance,
            cells=tuple((CLOSEST, radio, n) for radio in RADIO_RANGES_M for n in (3, 4, 5)),
        ),
        CellClaim(
            text="With a radio of 15 m teams travel more by self-bidding than by utility.",
            table=distance,
            cells=tuple((UTILITY, 15, n) for n in TEAMS),
            better=False,
        ),
        CellClaim(
            text="With a radio of 30 m teams of 3 and 4 travel less by self-bidding than by "
            "utility.",
            table=distance,
            cells=tuple((UTILITY, 30, n) for n in (3, 4)),
        ),
    ]


CLAIMS = _cell_claims()
"""Claims in the text of section IV, all of which the printed marks support."""
