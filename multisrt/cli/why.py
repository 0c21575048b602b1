"""`multisrt why`: explain a robot's decisions."""

from __future__ import annotations

from pathlib import Path

import click

from multisrt.cli.imports import import_all, import_option
from multisrt.cli.recordings import recording_in


@click.command()
@click.argument("recording", metavar="RECORDING", type=click.Path(path_type=Path))
@click.option("--robot", default=0, show_default=True, help="Index of the robot, from 0.")
@click.option(
    "--time",
    "time_s",
    type=float,
    help="Time (s); its last decision up to then is explained.  [default: end of the run]",
)
@click.option("--all", "everything", is_flag=True, help="List all of its decisions, one per line.")
@import_option
def why(
    recording: Path, robot: int, time_s: float | None, everything: bool, imports: tuple[str, ...]
) -> None:
    """Explain what a robot knew and decided.

    RECORDING is the folder that 'multisrt explore' wrote, or the file recording.jsonl in it.

    \b
    Examples:
      multisrt why runs/office-srt-radial-0
      multisrt why out --robot 2 --time 31.5
      multisrt why out/recording.jsonl --robot 2 --all
    """
    from multisrt.explain.srt import explain, explain_all
    from multisrt.recording import Recording
    from multisrt.terminal import LiveLine

    if everything and time_s is not None:
        raise click.UsageError("--all lists all decisions: leave out --time")
    import_all(imports)
    path = recording_in(recording)
    with LiveLine(True, "reading", str(path)):
        loaded = Recording.load(path)
        text = explain_all(loaded, robot) if everything else explain(loaded, robot, time_s)
    click.echo(text, nl=False)
