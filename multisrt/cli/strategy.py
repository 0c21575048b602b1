"""`multisrt strategy`: create a strategy from a template."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from multisrt.cli.mistakes import CommandGroup
from multisrt.cli.output_options import force_option
from multisrt.cli.outputs import require_no_file

SIZES = ("rule", "planner", "explorer")
"""As in `multisrt.robots.toolkit.templates`, which help pages do without."""


@click.group(cls=CommandGroup)
def strategy() -> None:
    """Create a strategy of your own.

    'multisrt strategies' lists the existing strategies.

    \b
    Examples:
      multisrt strategy new mine.py
      multisrt strategy new doors.py --size rule --name nearest-door
    """


@strategy.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.option(
    "--size",
    type=click.Choice(SIZES),
    default="planner",
    show_default=True,
    help="How much of a strategy to write yourself.",
)
@click.option("--name", metavar="NAME", help="Name of the strategy.  [default: that of FILE]")
@force_option()
def new(file: Path, size: str, name: str | None, force: bool) -> None:
    """Write a working strategy to start from.

    FILE (.py) receives a commented strategy, in one of three sizes:

    \b
      rule      which frontier a robot goes to: a function of path lengths
      planner   the next place, chosen in a map of local safe regions
      explorer  everything that a robot does: scan, map, drive, send, end

    \b
    Examples:
      multisrt strategy new mine.py
      multisrt strategy new doors.py --size rule --name nearest-door
    """
    from multisrt.geometry.errors import InvalidInputError
    from multisrt.recording import atomic_write
    from multisrt.robots.toolkit.templates import template

    if file.suffix != ".py":
        raise click.BadParameter(f"{file} must have the suffix .py", param_hint="FILE")
    _require_own_name(file)
    shown = shlex.quote(str(file))
    text = template(size, file.stem if name is None else name, shown)
    require_no_file(file, force=force)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInputError(f"cannot write {file}: {error.strerror or error}") from None
    with atomic_write(file) as opened:
        opened.write(text.encode())
    click.echo(file)
    click.echo(f"next: multisrt check {shown}")
    click.echo(f"      multisrt explore museum --strategy {shown} --robots 3")


def _require_own_name(file: Path) -> None:
    """Check that a file hides no module of Python or of a library from scripts beside it."""
    import importlib.util

    from multisrt.geometry.errors import InvalidInputError

    try:
        spec = importlib.util.find_spec(file.stem) if file.stem.isidentifier() else None
    except (ImportError, ValueError):  # a module that was not imported from a file
        spec = None
    if spec is None or spec.origin is None:  # nothing, or a folder of that name
        return
    beside = (Path.cwd(), file.parent.resolve())
    if not (spec.has_location and Path(spec.origin).resolve().parent in beside):
        raise InvalidInputError(
            f"{file} would hide the module {file.stem!r} from scripts beside it: choose another "
            f"name, such as {file.with_stem(f'my_{file.stem}')}"
        )
