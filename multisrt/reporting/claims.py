"""A paper beside results: its judged claims and its printed figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["holds", "does not hold", "inconclusive", "not tested"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A claim of a paper with its verdict.

    Attributes
    ----------
    text : str
        The claim, in one sentence.
    source : str
        Where the paper makes it.
    verdict : str
        "holds", "does not hold", "inconclusive" if the difference may be chance, or
        "not tested" if there are too few runs.
    grounds : tuple of str
        The figures behind the verdict, one sentence each.
    would_show : str
        The smallest effect that this number of runs would have found, which tells a small effect
        from too few runs. Empty if the claim was not tested.
    other_verdicts : tuple of (str, str)
        Other quantities by which the claim can be judged, with the verdicts by them.

    Examples
    --------
    >>> claim = Claim(
    ...     text="It is faster.",
    ...     source="",
    ...     verdict="inconclusive",
    ...     grounds=(),
    ...     would_show="a difference of 12 % would have been detected",
    ... )
    >>> claim.told
    'inconclusive (a difference of 12 % would have been detected)'
    """

    text: str
    source: str
    verdict: Verdict
    grounds: tuple[str, ...]
    would_show: str = ""
    other_verdicts: tuple[tuple[str, Verdict], ...] = ()

    @property
    def told(self) -> str:
        """The verdict; if it is "inconclusive", followed by the effect it would have found."""
        if self.verdict != "inconclusive" or not self.would_show:
            return self.verdict
        return f"{self.verdict} ({self.would_show})"


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedTable:
    """A table of figures beside printed ones, or of the comparisons behind a claim.

    Attributes
    ----------
    title : str
        Title of the table.
    source : str
        Where the printed figures are from; empty if there are none.
    columns : tuple of str
        Headings of the columns.
    rows : tuple of tuple of str
        Rows with one field per column.
    note : str
        How to read the table; may be empty.
    """

    title: str
    source: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
