"""What `multisrt experiment new` writes: an experiment with every part of it explained."""

from __future__ import annotations

import json
from pathlib import Path

from multisrt.experiments.description import ExperimentSpec, schema
from multisrt.geometry.errors import InvalidInputError

SCHEMA_NAME = "experiment.schema.json"

TEMPLATE = """\
# An experiment: which runs are made and compared.
#   multisrt experiment check THIS_FILE    how many runs these are, which, and how long they take
#   multisrt experiment run THIS_FILE      makes them; interrupted, it goes on where it was
# Lines that begin with "# " and a field show what else could be said.

name = "Star against Radial"
about = "Does a radial safe region explore faster than a star, and does a larger team gain by it?"

# Where: names of the catalogue ('multisrt environments'), map files beside this one, or tables.
environments = [
  "garden",
  "clutter",
  # "maps/floor.yaml",
  # { name = "plan.png", resolution_m = 0.05 },
  # { name = "rooms", seed = "repetition" },                  # another world for each repetition
  # { name = "maze", seeds = "0-9", parameters = { loops = 0.2 } },   # ten worlds, ten conditions
]

# How: names of the registry ('multisrt strategies'), or tables with options.
strategies = [
  "srt-star",
  "srt-radial",
  # { name = "srt-star", label = "star of 12", options = { cones = 12 } },
]

# How many robots; or teams whose robots differ.
robots = [1, 2, 4, 8]
# robots = [4, { label = "two kinds", members = [{}, { footprint = "box:0.6x0.4" }] }]

# Each repetition has a seed: first_seed, first_seed + 1, ... In repetition k all strategies meet
# the same world, the same starts, the same faults and the same draws of the radio.
repetitions = 20
first_seed = 0

# Where teams start: "scattered" far apart, "clustered" together, or tables.
starts = ["scattered"]
# starts = [{ how = "clustered", first = "drawn" }]    # around a place drawn for each repetition
# starts = [{ label = "door", places = [[1, 1], [2, 1], [3, 1], [4, 1]] }]

# How far robots hear one another. SRT needs three times the sensor's range.
radios = ["unlimited"]
# radios = ["unlimited", { range_m = 15.0, walls = "block", loss = 0.1 }]

# What the robots' bodies are: discs, boxes or polygons (m).
bodies = ["disc:0.25"]
# bodies = ["disc:0.25", { footprint = "box:0.6x0.4", drive = { kind = "reeds-shepp" } }]

# What goes wrong. Drawn faults are drawn for each repetition.
faults = ["none"]
# faults = ["none", { label = "one dies", deaths = 1, between_s = [10, 60] }]

# Which recordings are kept beside the results: "none", "failed" or "all".
recordings = "failed"

# Conditions that are left out, by the labels of tables; any number of these.
# [[exclude]]
# robots = 1
# faults = "one dies"

# Instead of crossing all of the above: parts that are crossed each by itself.
# [[blocks]]
# environments = ["garden"]
# robots = [1, 2, 4, 8]

# How bodies move that do not say it themselves: "differential", "holonomic", "reeds-shepp" or
# "dubins" (the last two are cars).
[drive]
kind = "differential"
speed_m_s = 0.5

# What they see with; without 'beams' it is the exact visibility polygon.
[range_finder]
range_m = 4.0
# beams = 360

# When a run ends although its robots would go on (s of its own clock).
[stop]
max_time_s = 86400.0

# What a run may take of the computer: seconds of computing, and megabytes.
[limits]
computing_s = 900.0
memory_mb = 4096
"""

_LIKE = """\
# {name}, as 'multisrt reproduce' runs it; change what you like.
#   multisrt experiment check THIS_FILE    how many runs these are, which, and how long they take
#   multisrt experiment run THIS_FILE      makes them; interrupted, it goes on where it was

"""


def write_new(
    path: Path, *, like: ExperimentSpec | None = None, with_schema: bool = True
) -> list[Path]:
    """Write an experiment to begin with, and the schema by which editors help.

    Parameters
    ----------
    path : Path
        The file to write, which must not be there.
    like : ExperimentSpec, optional
        What to write instead, as 'multisrt reproduce' runs it.
    with_schema : bool
        Whether to write the schema beside it, and name it in the file.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    InvalidInputError
        If the file is there already or cannot be written.
    """
    text = TEMPLATE if like is None else _LIKE.format(name=like.name) + like.to_toml()
    beside = path.with_name(SCHEMA_NAME)
    if with_schema:
        # Editors take this line for the way to the schema, from the file's own folder.
        text = f"#:schema ./{SCHEMA_NAME}\n\n{text}"
        _require_ours(beside)
    text = text.replace("THIS_FILE", path.name)
    if path.exists():
        raise InvalidInputError(f"{path} is there already; choose another name")
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
    # A schema of another version of this program is replaced, and nothing else.
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
            f"{path} is there already and is no schema of experiments; move it away, or write "
            "without one (--no-schema)"
        )
