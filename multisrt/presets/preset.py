"""The structure of a preset: the experiment of a paper and the reading of its results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from multisrt.experiments.results import Results
from multisrt.experiments.spec import EnvironmentChoice, ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
from multisrt.presets.ablations import Ablations
from multisrt.reporting.claims import Claim, PrintedTable

WORLD = "World:"


@dataclass(frozen=True, slots=True)
class Deviation:
    """Where an experiment differs from that of the paper, or the paper leaves it open.

    Attributes
    ----------
    text : str
        The difference. One that begins with `WORLD` describes the worlds.
    ablations : tuple of str
        Changes of the preset's ablations that measure what it does; empty if none does.
    """

    text: str
    ablations: tuple[str, ...] = ()


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
    deviations : tuple of Deviation
        Where the experiment differs from that of the paper.
    run_s, quick_run_s : float or None
        Computing time of a run, on average over the experiment and over the quick one, in seconds
        of one core; None if it is not known.
    on_map : callable, optional
        ``on_map(experiment, world)`` returns an `ExperimentSpec` as one in another world, an
        `EnvironmentChoice`; `in_world` is such a function. None: the preset has no such experiment.
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
    deviations: tuple[Deviation, ...]
    run_s: float | None = None
    quick_run_s: float | None = None
    on_map: Callable[[ExperimentSpec, EnvironmentChoice], ExperimentSpec] | None = None
    ablations: Ablations | None = None

    def with_map(
        self, path: Path, resolution_m: float | None = None, starts_from: str | None = None
    ) -> Preset:
        """Return the preset with a map of one's own instead of its worlds.

        It keeps the ablations in worlds that the map does not replace.

        Parameters
        ----------
        path : Path
            The map file.
        resolution_m : float, optional
            Metres per pixel of an image without its own resolution.
        starts_from : str, optional
            A team file of MRESim that gives an image its suggested starts.

        Returns
        -------
        Preset

        Raises
        ------
        InvalidInputError
            If the preset cannot be run on another map.

        Examples
        --------
        >>> from multisrt.presets import PRESETS
        >>> preset = PRESETS["sbx-r"].with_map(Path("plans/floor.geojson"))
        >>> preset.experiment(True).environments[0].label
        'floor'
        """
        on_map = self.on_map
        if on_map is None:
            raise InvalidInputError(f"{self.name} cannot be run on another map; leave out --map")
        # A name without a folder could be that of an environment of the catalogue.
        name = str(path) if path.parent != Path() else f"./{path}"
        world = EnvironmentChoice(
            name=name, label=path.stem, resolution_m=resolution_m, starts_from=starts_from
        )
        own, given = self.experiment(False), on_map(self.experiment(False), world)
        replaced = ", ".join(
            one if isinstance(one, str) else one.label or one.name
            for one in own.environments
            if one not in given.environments
        )
        told = Deviation(f"{WORLD} the map {path.name}, in the place of {replaced}.")
        others = (one for one in self.deviations if not one.text.startswith(WORLD))
        return replace(
            self,
            experiment=lambda quick: on_map(self.experiment(quick), world),
            deviations=(told, *others),
            ablations=None if self.ablations is None else self.ablations.in_worlds_of(given),
        )


def in_world(experiment: ExperimentSpec, world: EnvironmentChoice) -> ExperimentSpec:
    """Return an experiment with all its runs in one world; see `Preset.on_map`."""
    blocks = tuple(msgspec.structs.replace(block, environments=None) for block in experiment.blocks)
    return msgspec.structs.replace(
        experiment,
        name=f"{experiment.name} on {world.label}",
        environments=(world,),
        blocks=blocks,
    )
