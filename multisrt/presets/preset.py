"""The structure of a preset: the experiment of a paper and the reading of its results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from multisrt.experiments.results import Results
from multisrt.experiments.spec import ExperimentSpec
from multisrt.presets.ablations import Ablations
from multisrt.reporting.claims import Claim, PrintedTable


@dataclass(frozen=True, slots=True, kw_only=True)
class Preset:
    """The experiment of a paper.

    Attributes
    ----------
    name : str
        Name on the command line.
    about : str
        What the experiment compares, in one sentence.
    paper : str
        Authors and title of the paper.
    experiment : callable
        ``experiment(quick)`` returns the `ExperimentSpec`, if `quick` a smaller one of the same
        kind.
    claims : callable
        ``claims(results)`` returns the judged claims of the paper, a list of `Claim`.
    tables : callable
        ``tables(results)`` returns the results beside the printed figures of the paper and the
        comparisons behind the claims, a list of `PrintedTable`.
    deviations : tuple of str
        Where the experiment differs from that of the paper, or the paper leaves it open.
    ablations : Ablations or None
        Changes of the experiment that show what differences do, or why a claim does not hold.

    Examples
    --------
    >>> from multisrt.presets import PRESETS
    >>> for name, preset in PRESETS.items():
    ...     print(name, preset.experiment(True).repetitions)
    multi-srt 10
    sbx-r 6
    minpos 8
    alvarez 7
    """

    name: str
    about: str
    paper: str
    experiment: Callable[[bool], ExperimentSpec]
    claims: Callable[[Results], list[Claim]]
    tables: Callable[[Results], list[PrintedTable]]
    deviations: tuple[str, ...]
    ablations: Ablations | None = None
