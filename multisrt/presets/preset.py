"""The structure of a preset: the experiment of a paper and the reading of its results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import msgspec

from multisrt.experiments.results import Results
from multisrt.experiments.spec import EnvironmentChoice, ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
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
    map_label : str
        Label of a map of the user's own, where `map_replaces` is not empty.
    map_replaces : tuple of str
        Labels of the environments for which such a map stands; see `on_map`.

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
    map_label: str = ""
    map_replaces: tuple[str, ...] = ()

    def on_map(self, experiment: ExperimentSpec, given: EnvironmentChoice) -> ExperimentSpec:
        """Return an experiment of this preset on a map that a user has.

        Parameters
        ----------
        experiment : ExperimentSpec
            An experiment of the preset.
        given : EnvironmentChoice
            The map; its label becomes `map_label`.

        Returns
        -------
        ExperimentSpec
            The experiment with the map in the place of the environments in `map_replaces`. Blocks
            that run nothing but those are left out.

        Raises
        ------
        InvalidInputError
            If the experiment of the paper has no map for which another could stand.
        """
        if not self.map_replaces:
            raise InvalidInputError(f"no map can stand for those of {self.name}: leave out --map")
        given = msgspec.structs.replace(given, label=self.map_label)
        # A variant of the strategy that is run on one map only is about that map.
        blocks = tuple(block for block in experiment.blocks if block.environments is None)
        return msgspec.structs.replace(
            experiment,
            environments=self._placed(experiment.environments, given),
            blocks=blocks,
        )

    def _placed(
        self, choices: tuple[str | EnvironmentChoice, ...], given: EnvironmentChoice
    ) -> tuple[str | EnvironmentChoice, ...]:
        def label(one: str | EnvironmentChoice) -> str:
            return one if isinstance(one, str) else one.label or one.name

        return (*(one for one in choices if label(one) not in self.map_replaces), given)
