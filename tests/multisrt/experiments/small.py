"""Small experiments: of one run, except where a test gives more."""

from pathlib import Path
from typing import Any

import pytest

from multisrt.experiments.crossing import runs
from multisrt.experiments.spec import ExperimentSpec
from multisrt.geometry.errors import InvalidInputError

ROOM = "POLYGON ((0 0, 6 0, 6 5, 0 5, 0 0))"
HALL = "POLYGON ((0 0, 9 0, 9 6, 0 6, 0 0))"


def experiment(**said: Any) -> ExperimentSpec:
    """Return an experiment of given choices; by default of one run."""
    usual: dict[str, Any] = {
        "name": "x",
        "environments": ["open"],
        "strategies": ["srt-star"],
        "repetitions": 1,
    }
    return ExperimentSpec.from_dict(usual | said)


def refused(spec: ExperimentSpec, folder: Path | None = None) -> str:
    """Return the message with which an experiment is refused."""
    with pytest.raises(InvalidInputError) as error:
        runs(spec, folder)
    message = str(error.value)
    assert "\n" not in message
    return message
