"""`multisrt why`: what a robot knew and decided."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--robot", default=0, show_default=True, help="Which robot, from 0.")
@click.option(
    "--time", "time_s", type=float, help="When (s): its last decision by then.  [default: the end]"
)
@click.option("--all", "everything", is_flag=True, help="All of its decisions, one line each.")
def why(recording: Path, robot: int, time_s: float | None, everything: bool) -> None:
    """Tell what a robot knew and decided, in plain words, from a RECORDING.

    \b
    Examples:
      multisrt why out/recording.jsonl --robot 2 --time 31.5
      multisrt why out/recording.jsonl --robot 2 --all
    """
    from multisrt.explain.srt import explain, explain_all
    from multisrt.recording import Recording

    if everything and time_s is not None:
        raise click.UsageError("--all tells all decisions: leave out --time")
    loaded = Recording.load(recording)
    text = explain_all(loaded, robot) if everything else explain(loaded, robot, time_s)
    click.echo(text, nl=False)
