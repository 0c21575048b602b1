"""Calls of what reads the files of strangers that are no maps, as the commands make them."""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any, Final

import msgspec

from multisrt.campaign.failure import FAILURE_NAME, SPEC_NAME, Failure, read_failure
from multisrt.campaign.store import CampaignStore
from multisrt.cli.campaign import show
from multisrt.cli.spec_files import read_experiment, read_run_spec
from multisrt.environments.environment import Environment
from multisrt.environments.formats import read_environment
from multisrt.experiments.crossing import conditions, runs
from multisrt.experiments.frames import export
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from multisrt.experiments.store_file import labels_in
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.reporting.overview import overview_table
from multisrt.reporting.words import totals
from multisrt.simulation.setting_up import set_up
from multisrt.spec import RunSpec

MAX_RUNS: Final = 100
"""Runs of an experiment that are planned; more take the time that they take."""


def of_team(path: Path, **options: Any) -> Environment:
    """Read a team file, with the image that it belongs to."""
    return read_environment(path.parent / "rooms.png", starts_from=path, **options)


def of_recording(path: Path) -> Environment:
    """Read a recording, and return its world."""
    recording = Recording.load(path)
    with naming(path):
        return recording.environment()


def of_run_spec(path: Path) -> RunSpec:
    """Read the spec of a run, and set the run up; `multisrt campaign` judges what comes of it."""
    spec = read_run_spec(path)
    with naming(path):
        return set_up(spec).spec


def of_experiment(path: Path) -> ExperimentSpec:
    """Read an experiment, and plan its runs."""
    spec = read_experiment(path)
    with naming(path):
        planned = len(conditions(spec))
        few = msgspec.structs.replace(spec, repetitions=min(spec.repetitions, 2))
        if planned <= MAX_RUNS:
            runs(few, path.parent)
    return spec


def of_experiment_store(path: Path) -> str:
    """Show, export and continue the results of an experiment; return what is shown."""
    with _alone(path) as own:
        labels_in(own)
        with Store.open(own) as store:
            results = store.results()
            spec = store.experiment
            store.failed, store.ended(), store.of_no_chance()
        export(own, own.with_suffix(".csv"))
        accounts = [result.account for result in results]
        shown = [spec.name, totals(results), overview_table(results).text(100), *accounts]
        with naming(own):
            planned = len(conditions(spec)) * spec.repetitions
        if planned <= MAX_RUNS:
            with Store.open(own) as store, naming(own):
                store.missing()
            with naming(own), Store.create_or_open(own, spec, own.parent) as store:
                store.forget()
                store.plans.missing()
    return "\n".join(shown)


def of_campaign_store(path: Path) -> str:
    """Show and continue the missions of a campaign; return what is shown."""
    with _alone(path) as own, redirect_stdout(io.StringIO()) as shown:
        show.callback(own, None)  # type: ignore[misc]
        with CampaignStore.create_or_open(own) as store:
            store.done()
    return shown.getvalue()


def of_failure(path: Path) -> Failure:
    """Read the folder of a failure, whose spec is beside the file that says what failed."""
    with _alone(path) as own:
        failed = own.rename(own.with_name(FAILURE_NAME))
        shutil.copy(path.with_name(SPEC_NAME), own.parent)
        failure, _ = read_failure(failed)
    return failure


def flaw_of_spec(found: RunSpec | ExperimentSpec) -> str:
    """Return what is wrong with a spec that was read; empty if it can be written and read."""
    again = type(found).from_toml(found.to_toml())
    return "" if again == found else "written and read again it is another"


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Name a file in errors of what it describes, as the file itself has been read."""
    try:
        yield
    except InvalidInputError as error:
        if str(path) in str(error):
            raise
        raise InvalidInputError(f"{path}: {error}") from error


@contextmanager
def _alone(path: Path) -> Iterator[Path]:
    """Return a copy of a file in a folder of its own, with what is written beside it."""
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        yield Path(shutil.copy(path, folder))
