"""`multisrt export`: a run as a file for Foxglove, ROS 2 or rerun."""

from __future__ import annotations

from pathlib import Path

import click

from multisrt.cli.layers import without_option
from multisrt.cli.output_options import EXPORT_NAME, force_option, out_file, quiet_option
from multisrt.cli.outputs import require_place
from multisrt.cli.recordings import recording_in


@click.command()
@click.argument("recording", metavar="RECORDING", type=click.Path(path_type=Path))
@out_file("the run: .mcap for Foxglove and ROS 2, .rrd for rerun", EXPORT_NAME)
@force_option()
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
@quiet_option()
def export(
    recording: Path,
    out: Path | None,
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
      multisrt export runs/office-srt-radial-0
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
    if out is not None:
        require_format(out)
    path = recording_in(recording)
    out = path.with_name(EXPORT_NAME) if out is None else out
    require_place(out, force=force)
    with LiveLine(not quiet, "reading", str(path)) as live:
        loaded = Recording.load(path)
        live.update(description="exporting", note=str(out), total=1.0, completed=0.0)
        export_run(
            loaded, out, options=options, progress=lambda share: live.update(completed=share)
        )
    if not quiet:
        size_mb = out.stat().st_size / 1e6
        click.echo(f"{out}: {loaded.footer.time_s:.1f} s, {size_mb:.1f} MB")
