"""What a preset is: a paper's experiment, and what is to be read out of its results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from multisrt.experiments.description import ExperimentSpec
from multisrt.experiments.results import Results
from multisrt.reporting.claims import Claim, PrintedTable


@dataclass(frozen=True, slots=True, kw_only=True)
class Preset:
    """A paper's experiment.

    Attributes
    ----------
    name : str
        What the command line calls it.
    about : str
        What it compares, in a sentence.
    paper : str
        Authors and title.
    experiment : callable
        Describes the runs: ``experiment(quick)``; quick ones are of the same kind, but fewer.
    claims : callable
        Judges the paper's claims by the results.
    tables : callable
        Puts the results beside the paper's printed figures, and lists the comparisons behind the
        claims.
    deviations : tuple of str
        Where the experiment is not the paper's, or the paper leaves it open.
    """

    name: str
    about: str
    paper: str
    experiment: Callable[[bool], ExperimentSpec]
    claims: Callable[[Results], list[Claim]]
    tables: Callable[[Results], list[PrintedTable]]
    deviations: tuple[str, ...]
