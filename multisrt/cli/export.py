"""`multisrt export`: a run as a file for Foxglove, ROS 2 or rerun."""

from __future__ import annotations

from pathlib import Path

import click

from multisrt.cli.layers import without_option
from multisrt.cli.outputs import require_no_file
from multisrt.cli.recordings import recording_in


@click.command()
@click.argument("recording", metavar="RECORDING", type=click.Path(path_type=Path))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    metavar="FILE",
    help="The file to write: .mcap for Foxglove and ROS 2, .rrd for rerun.",
)
@click.option("--force", is_flag=True, help="Replace the file if it exists.")
@click.option(
    "--rate",
    "rate_hz",
    type=float,
    default=10.0,
    show_default=True,
    metavar="HZ",
    help="Poses of a moving robot per second, besides its waypoints.",
)
@click.option(
    "--map-interval",
    "map_interval_s",
    type=float,
    default=5.0,
    show_default=True,
    metavar="S",
    help="Time between two maps of a robot (s).",
)
@click.option(
    "--cell",
    "cell_m",
    type=float,
    metavar="M",
    help="Width of a cell of the maps (m).  [default: 0.1, wider in large worlds]",
)
@without_option("export")
@click.option("--quiet", is_flag=True, help="Print errors only.")
def export(
    recording: Path,
    out: Path,
    *,
    force: bool,
    rate_hz: float,
    map_interval_s: float,
    cell_m: float | None,
    without: tuple[str, ...],
    quiet: bool,
) -> None:
    """Write a run as a file for other programs.

    RECORDING is the folder that 'multisrt explore' wrote, or the file recording.jsonl in it. The
    file holds the true map, the map, poses, path, tree and frontier of every robot, radio links,
    decisions in words, and the coverage, all in simulated time.

    \b
    Examples:
      multisrt export runs/office-srt-radial-0 --out office.mcap
      multisrt export out --out out.rrd --without maps
      multisrt export out --out out.mcap --rate 30 --map-interval 1 --force
    """
    from multisrt.exporting import ExportOptions, export_run
    from multisrt.exporting.export import require_format
    from multisrt.recording import Recording
    from multisrt.terminal import LiveLine

    options = ExportOptions(
        rate_hz=rate_hz, map_interval_s=map_interval_s, cell_m=cell_m, without=without
    )
    require_format(out)
    require_no_file(out, force=force)
    path = recording_in(recording)
    with LiveLine(not quiet, "reading", str(path)) as live:
        loaded = Recording.load(path)
        live.update(description="exporting", note=str(out), total=1.0, completed=0.0)
        export_run(
            loaded, out, options=options, progress=lambda share: live.update(completed=share)
        )
    if not quiet:
        size_mb = out.stat().st_size / 1e6
        click.echo(f"{out}: {loaded.footer.time_s:.1f} s, {size_mb:.1f} MB")
