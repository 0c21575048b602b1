"""The file that `multisrt experiment new` writes, which explains every field."""

from __future__ import annotations

import json
from pathlib import Path

from multisrt.experiments.schema import schema
from multisrt.experiments.spec import ExperimentSpec
from multisrt.geometry.errors import InvalidInputError

SCHEMA_NAME = "experiment.schema.json"

TEMPLATE = """\
# An experiment: the runs that are made and compared.
#   multisrt experiment check THIS_FILE    lists the conditions and estimates the duration
#   multisrt experiment run THIS_FILE      executes the runs; after an interruption it continues
# Commented lines show what else is possible.

name = "Star against Radial"
about = "Does a radial safe region explore faster than a star, and does a larger team gain by it?"

# Environments: names ('multisrt environments'), map files beside this one, or tables.
environments = [
  "garden",
  "clutter",
  # "indoor-30",                          # a suite: thirty worlds, thirty conditions
  # "outdoor-30/07",                      # one world of a suite
  # "maps/floor.yaml",
  # { name = "plan.png", resolution_m = 0.05 },
  # { name = "rooms", seed = "repetition" },                  # another world for each repetition
  # { name = "maze", seeds = "0-9", parameters = { loops = 0.2 } },   # ten worlds, ten conditions
]

# Strategies: names ('multisrt strategies'), or tables with options. Your own are named as
# any other; 'multisrt experiment run THIS_FILE --import mine.py' has them.
strategies = [
  "srt-star",
  "srt-radial",
  # { name = "srt-star", label = "star of 12", options = { cones = 12 } },
]

# Team sizes, or teams whose robots differ.
robots = [1, 2, 4, 8]
# robots = [4, { label = "two kinds", members = [{}, { footprint = "box:0.6x0.4" }] }]

# Repetitions have the seeds first_seed, first_seed + 1, ... In the same repetition all strategies
# meet the same worlds, starts, faults and draws of the radio.
repetitions = 20
first_seed = 0

# Starts: "scattered" far apart, "clustered" close together, "random", "suggested", "base" (around
# the base station), or tables.
starts = ["scattered"]
# starts = [{ how = "clustered", first = "drawn" }]    # around a start drawn in each repetition
# starts = [{ label = "door", places = [[1, 1], [2, 1], [3, 1], [4, 1]] }]

# Radios. SRT needs a range of at least three times that of the range finder.
radios = ["unlimited"]
# radios = ["unlimited", { range_m = 15.0, walls = "block", loss = 0.1 }]

# Bodies: discs, boxes or polygons (m), or tables.
bodies = ["disc:0.25"]
# bodies = ["disc:0.25", { footprint = "box:0.6x0.4", drive = { kind = "reeds-shepp" } }]

# Faults: "none", or tables; robots and times are drawn in each repetition.
faults = ["none"]
# faults = ["none", { label = "one dies", deaths = 1, between_s = [10, 60] }]

# Share of the explorable area that a run must cover to be a success.
success_coverage = 0.95

# Time to which integrals run (s); by default that of the longest run of each setting.
# horizon_s = 600.0

# Also report times as multiples of those of a team that knows the map: "none" or "informed". It
# takes one plan for each world, team and starts, of up to a minute.
# reference = "informed"

# Recordings to keep beside the results: "none", "failed" (of unsuccessful runs) or "all".
recordings = "failed"

# Conditions to leave out, by their labels in tables; any number of these tables.
# [[exclude]]
# robots = 1
# faults = "one dies"

# Parts that are crossed separately, instead of all choices above.
# [[blocks]]
# environments = ["garden"]
# robots = [1, 2, 4, 8]

# Drive of bodies without one of their own: "differential", "holonomic", "reeds-shepp" or "dubins"
# (the last two are cars).
[drive]
kind = "differential"
speed_m_s = 0.5

# Range finder of bodies without one of their own; without 'beams' it is exact.
[range_finder]
range_m = 4.0
# beams = 360

# A base station, which robots reach by radio: where it is (m). Measures tell what it knows.
# [base]
# x = 2.0
# y = 3.0

# Simulated time at which a run is stopped, and in which something has to happen: a robot moves,
# scans at another place, adds a node or learns one (s).
[stop]
max_time_s = 86400.0
max_idle_s = 3600.0

# Limits of a run: computing time (s of one core) and memory (MB).
[limits]
computing_s = 900.0
memory_mb = 4096
"""

_LIKE = """\
# {name}, as 'multisrt reproduce' runs it.
#   multisrt experiment check THIS_FILE    lists the conditions and estimates the duration
#   multisrt experiment run THIS_FILE      executes the runs; after an interruption it continues

"""


def write_new(
    path: Path, *, like: ExperimentSpec | None = None, with_schema: bool = True
) -> list[Path]:
    """Write an experiment to start from, and the schema that editors use.

    Parameters
    ----------
    path : Path
        The file, which must not exist.
    like : ExperimentSpec, optional
        Experiment to write; by default a commented template.
    with_schema : bool
        Whether to write the schema beside the file, and name it in the file.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InvalidInputError
        If the file exists or cannot be written.
    """
    text = TEMPLATE if like is None else _LIKE.format(name=like.name) + like.to_toml()
    beside = path.with_name(SCHEMA_NAME)
    if with_schema:
        # Editors read the path of the schema from this line.
        text = f"#:schema ./{SCHEMA_NAME}\n\n{text}"
        _require_ours(beside)
    text = text.replace("THIS_FILE", path.name)
    if path.exists():
        raise InvalidInputError(f"{path} exists already; choose another name")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
        if with_schema:
            beside.write_text(json.dumps(schema(), indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise InvalidInputError(f"cannot write {path}: {error.strerror or error}") from None
    return [path, beside] if with_schema else [path]


def _require_ours(path: Path) -> None:
    """Raise InvalidInputError if a file is there that is not a schema of experiments."""
    try:
        there = path.read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError):
        return
    except (OSError, UnicodeDecodeError):
        there = ""
    try:
        title = json.loads(there).get("title")
    except (ValueError, AttributeError):
        title = None
    if title != ExperimentSpec.__name__:
        raise InvalidInputError(
            f"{path} exists already and is no schema of experiments; move it away, or write "
            "without one (--no-schema)"
        )
