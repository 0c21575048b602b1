"""The command line.

Each command imports what it needs when it runs, so that help pages appear at once.
"""

from __future__ import annotations

from collections.abc import Sequence

import click

from multisrt.cli.animate import animate
from multisrt.cli.campaign import campaign
from multisrt.cli.check import check
from multisrt.cli.compete import compete
from multisrt.cli.completion import PROGRAM, VARIABLE, completion
from multisrt.cli.ending import BY_SIGNAL, Terminations, fail, standard_streams
from multisrt.cli.environments import environments
from multisrt.cli.experiment import experiment
from multisrt.cli.explore import explore
from multisrt.cli.export import export
from multisrt.cli.figure import figure
from multisrt.cli.mistakes import CommandGroup, is_world, usage_message
from multisrt.cli.report import report
from multisrt.cli.reproduce import reproduce
from multisrt.cli.strategies import strategies
from multisrt.cli.strategy import strategy
from multisrt.cli.view import view
from multisrt.cli.why import why

COMPLETE, BAD_INPUT, INTERRUPTED = 0, 2, 130
"""Exit codes of all commands; some have another for runs that are not complete."""


def _meant(words: Sequence[str]) -> Sequence[str]:
    if words[0] == "compare":
        return ("experiment", "new", "FILE.toml")
    return ("explore", *words) if is_world(words[0]) else ()


@click.group(
    cls=CommandGroup,
    meant=_meant,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="multisrt")
def cli() -> None:
    """Simulate and compare multi-robot exploration of unknown planar environments.

    \b
    Examples:
      multisrt explore office
      multisrt explore museum --robots 4 --strategy srt-radial --strategy srt-star
      multisrt view runs/office-srt-radial-0
      multisrt why runs/office-srt-radial-0 --robot 0 --time 31.5
      multisrt animate runs/office-srt-radial-0 --out office.mp4
      multisrt export runs/office-srt-radial-0 --out office.mcap
      multisrt figure maps runs/office-srt-radial-0
      multisrt check mine.py
      multisrt compete iec
      multisrt campaign run --missions 100
      multisrt experiment new star.toml
      multisrt environments
      multisrt strategies
      multisrt completion bash

    'multisrt COMMAND --help' describes a command.
    """


for command in (
    *(
        explore,
        view,
        why,
        export,
        animate,
        figure,
        environments,
        strategies,
        strategy,
        check,
        compete,
        experiment,
        report,
        reproduce,
        campaign,
    ),
    completion,
):
    cli.add_command(command)


def main() -> None:
    """Run the command line; print an error as one line and exit with its code."""
    from multisrt.geometry.errors import MultiSrtError

    with standard_streams(), Terminations() as terminations:
        try:
            result = cli.main(prog_name=PROGRAM, complete_var=VARIABLE, standalone_mode=False)
        except (Exception, KeyboardInterrupt) as error:
            # After an interrupt any error comes of it.
            if (signal := terminations.received) is not None:
                fail(f"interrupted by {signal.name}", BY_SIGNAL + signal)
            is_interrupt = isinstance(error, click.exceptions.Abort | KeyboardInterrupt)
            if is_interrupt or terminations.is_interrupted:
                fail("interrupted", INTERRUPTED)
            match error:
                case click.exceptions.NoArgsIsHelpError():
                    fail(error.format_message(), BAD_INPUT)
                case click.ClickException():
                    fail(f"error: {usage_message(error)}", error.exit_code)
                case MultiSrtError():
                    fail(f"error: {error}", BAD_INPUT)
            raise
        raise SystemExit(result if isinstance(result, int) else COMPLETE)
