"""`multisrt export`: a run, or a part of it, as a file for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from multisrt.cli.layers import without_option
from multisrt.cli.output_options import (
    EXPORT_NAME,
    force_option,
    height_option,
    out_file,
    quiet_option,
)
from multisrt.cli.outputs import require_place
from multisrt.cli.recordings import recording_in

if TYPE_CHECKING:
    from multisrt.exporting.whats import What
    from multisrt.recording import Recording
    from multisrt.terminal import LiveLine

# Importing them would delay the help; a test compares these words with `multisrt.exporting.whats`.
WHATS: Final = ("run", "trajectories", "map", "tree", "world")

OPTIONS: Final = {
    "time_s": "--at",
    "robot": "--robot",
    "rate_hz": "--rate",
    "map_interval_s": "--map-interval",
    "cell_m": "--cell",
    "height_m": "--height",
    "without": "--without",
}
"""Options by the names of their parameters."""


@click.command()
@click.argument("recording", metavar="RECORDING", type=click.Path(path_type=Path))
@out_file("the export, whose suffix determines the format", EXPORT_NAME)
@force_option()
@click.option(
    "--what",
    type=click.Choice(WHATS),
    metavar="WHAT",
    help="What to write: run, trajectories, map, tree or world.  [default: by the suffix]",
)
@click.option(
    "--at",
    "time_s",
    type=float,
    metavar="S",
    help="Time of a map or tree (s).  [default: the end of the run]",
)
@click.option(
    "--robot",
    type=int,
    metavar="N",
    help="Robot of a map, tree or trajectory, from 0.  [default: the whole team]",
)
@click.option(
    "--rate",
    "rate_hz",
    type=float,
    metavar="HZ",
    help="Poses of a moving robot per second, in addition to its waypoints.  "
    "[default: 10 in a run, waypoints only in trajectories]",
)
@click.option(
    "--map-interval",
    "map_interval_s",
    type=float,
    metavar="S",
    help="Time between two maps of a robot in a run (s).  [default: 5]",
)
@click.option(
    "--cell",
    "cell_m",
    type=float,
    metavar="M",
    help="Width of a cell of maps (m).  [default: 0.1 in a run, 0.05 in .yaml, wider in large "
    "worlds]",
)
@height_option()
@without_option("export", "  Of .stl and .glb: paths, edges.")
@quiet_option()
def export(
    recording: Path,
    out: Path | None,
    *,
    force: bool,
    what: What | None,
    quiet: bool,
    **given: Any,
) -> None:
    """Write a run, or a part of it, as a file for other programs.

    RECORDING is the folder that 'multisrt explore' wrote, or the file recording.jsonl in it.

    \b
    What is written, by suffix (without --what the first that has the suffix):
      run           .mcap for Foxglove and ROS 2, .rrd for rerun: the whole run
      trajectories  .csv, .json, .tum, .txt: poses of the robots; in the
                    format of TUM (.tum, .txt) one file for each robot
      map           .yaml and .pgm for ROS, .geojson, .wkt, .svg, .dxf, .stl,
                    .glb: what a robot or the team knew
      tree          .graphml, .geojson: nodes and edges
      world         the true world, in the formats of a map

    \b
    Examples:
      multisrt export runs/office-srt-radial-0
      multisrt export out --out out.mcap --rate 30 --map-interval 1 --force
      multisrt export out --out map.yaml --cell 0.1
      multisrt export out --out known.geojson --robot 1 --at 30
      multisrt export out --out tree.graphml
      multisrt export out --out tree.geojson --what tree --robot 0
      multisrt export out --out poses.csv --rate 10
      multisrt export out --out run.glb --what world --without paths
    """
    from multisrt.exporting.whats import what_of
    from multisrt.geometry.errors import InvalidInputError
    from multisrt.recording import Recording
    from multisrt.terminal import LiveLine

    chosen = {name: value for name, value in given.items() if value not in ((), None)}
    if out is None and what not in (None, "run"):
        raise InvalidInputError(
            f"--what {what} needs a file whose suffix determines the format: --out"
        )
    what = what_of(Path(EXPORT_NAME) if out is None else out, what)
    path = recording_in(recording)
    out = path.with_name(EXPORT_NAME) if out is None else out
    _require_use(out, what, chosen)
    with LiveLine(not quiet, "reading", str(path)) as live:
        loaded = Recording.load(path)
        files = _files(loaded, out, what, chosen)
        for file in files:
            require_place(file, force=force)
        live.update(description="exporting", note=str(out))
        _write(loaded, out, what, chosen, force, live)
    if quiet:
        return
    for file in files:
        size = file.stat().st_size
        shown = f"{size / 1e6:.1f} MB" if size >= 1e5 or what == "run" else f"{size / 1e3:.1f} kB"
        length = f"{loaded.footer.time_s:.1f} s, " if what == "run" else ""
        click.echo(f"{file}: {length}{shown}")


def _require_use(out: Path, what: What, given: dict[str, Any]) -> None:
    from multisrt.exporting.whats import options_of
    from multisrt.geometry.errors import InvalidInputError

    used = options_of(out, what)
    for name in given:
        if name not in used:
            has = [option for value, option in OPTIONS.items() if value in used]
            takes = f"it takes {', '.join(has)}" if has else "it takes none of these options"
            raise InvalidInputError(
                f"{OPTIONS[name]} has no meaning for {what} as {out.suffix.lower()}; {takes}"
            )


def _files(recording: Recording, out: Path, what: What, given: dict[str, Any]) -> list[Path]:
    from multisrt.exporting.trajectories import trajectory_files
    from multisrt.exporting.worlds import map_files

    if what == "trajectories":
        return trajectory_files(recording, out, given.get("robot"))
    return map_files(out) if what in ("map", "world") else [out]


def _write(
    recording: Recording,
    out: Path,
    what: What,
    given: dict[str, Any],
    force: bool,
    live: LiveLine,
) -> None:
    from multisrt.exporting import (
        ExportOptions,
        MapOptions,
        export_run,
        save_map,
        save_trajectories,
        save_trees,
        save_world,
    )

    if what == "run":
        live.update(total=1.0, completed=0.0)
        options = ExportOptions(**given)
        export_run(
            recording, out, options=options, progress=lambda share: live.update(completed=share)
        )
    elif what == "trajectories":
        save_trajectories(recording, out, **given, overwrite=force)
    elif what == "tree":
        save_trees(recording, out, **given, overwrite=force)
    else:
        sizes = MapOptions(
            **{name: given.pop(name) for name in ("cell_m", "height_m") if name in given}
        )
        write = save_map if what == "map" else save_world
        write(recording, out, **given, options=sizes, overwrite=force)
