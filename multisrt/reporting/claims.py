"""What is shown of a paper beside results: its claims, judged, and its printed figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["holds", "does not hold", "not significant", "not tested"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A claim, and what the results say of it.

    Attributes
    ----------
    text : str
        The claim, in a sentence.
    source : str
        Where it is made.
    verdict : str
        "not significant": what was seen may be chance. "not tested": there are too few runs to
        say anything.
    grounds : tuple of str
        The numbers behind the verdict, a sentence each.
    """

    text: str
    source: str
    verdict: Verdict
    grounds: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedTable:
    """A table that puts figures beside printed ones, or lists those behind a claim.

    Attributes
    ----------
    title : str
        What it shows.
    source : str
        Where the printed figures are from; empty where there are none.
    columns : tuple of str
        Their headings.
    rows : tuple of tuple of str
        As many fields each as there are columns.
    note : str
        How to read it; may be empty.
    """

    title: str
    source: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
