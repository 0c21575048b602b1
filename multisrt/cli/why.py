"""`multisrt why`: explain a robot's decisions."""

from __future__ import annotations

from pathlib import Path

import click

from multisrt.cli.imports import import_all, import_option


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

    RECORDING is the file recording.jsonl that 'multisrt explore' writes.

    \b
    Examples:
      multisrt why runs/office-srt-radial-0/recording.jsonl
      multisrt why out/recording.jsonl --robot 2 --time 31.5
      multisrt why out/recording.jsonl --robot 2 --all
    """
    from multisrt.explain.srt import explain, explain_all
    from multisrt.recording import Recording

    if everything and time_s is not None:
        raise click.UsageError("--all lists all decisions: leave out --time")
    import_all(imports)
    loaded = Recording.load(recording)
    text = explain_all(loaded, robot) if everything else explain(loaded, robot, time_s)
    click.echo(text, nl=False)
