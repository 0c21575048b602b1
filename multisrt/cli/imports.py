"""User-defined strategies on the command line: the option --import, and references."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from multisrt.cli import candidates
from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    from multisrt.robots.strategy import Strategy


def import_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the option --import to a command.

    Parameters
    ----------
    command : callable
        The command, which takes a keyword `imports`, a tuple of str, for `import_all`.

    Returns
    -------
    callable
        The command with the option.
    """
    return click.option(
        "--import",
        "imports",
        multiple=True,
        metavar="MODULE|FILE.py",
        shell_complete=candidates.references,
        help="Import a module or file with strategies of your own; FILE.py:NAME for one of "
        "several; repeatable.",
    )(command)


def imports_again(imports: tuple[str, ...]) -> str:
    """Return the options --import of the command that comes next, as a shell reads them.

    Parameters
    ----------
    imports : tuple of str
        What this command imports.

    Returns
    -------
    str
        Each option with a space before it; empty if there is none.

    Examples
    --------
    >>> imports_again(("mine.py", "my rules.py:Far"))
    " --import mine.py --import 'my rules.py:Far'"
    """
    return "".join(f" --import {shlex.quote(reference)}" for reference in imports)


def import_all(imports: tuple[str, ...]) -> None:
    """Import what --import names, so that its strategies are known by their names.

    Parameters
    ----------
    imports : tuple of str
        Modules and files, as `multisrt.robots.loading.import_reference` takes them.

    Raises
    ------
    InvalidInputError
        If one cannot be imported.
    """
    if imports:
        from multisrt.robots.loading import import_reference

        for reference in imports:
            import_reference(reference)


def named_strategy(text: str) -> Strategy:
    """Return the strategy of a name, or of a reference such as ``mine.py:Mine``.

    A strategy that is given by a reference is registered.

    Parameters
    ----------
    text : str
        The name or reference.

    Returns
    -------
    Strategy
        The strategy.

    Raises
    ------
    InvalidInputError
        If there is none; the message says what there is.
    """
    from multisrt.robots.loading import is_reference, name_of
    from multisrt.robots.registry import is_known, strategy

    if not is_reference(text):
        file = _file_of(text)
        if file.is_file() and not is_known(text):
            raise InvalidInputError(f"there is no strategy {text!r} (did you mean {str(file)!r}?)")
    return strategy(name_of(text))


@contextmanager
def named_check(strategy: str) -> Iterator[None]:
    """Name the command that checks a strategy in the message about a defect of its explorer.

    Parameters
    ----------
    strategy : str
        Name of the strategy.

    Raises
    ------
    InvalidInputError
        For an `ExplorerDefect` in the block.
    """
    from multisrt.robots.defects import ExplorerDefect

    try:
        yield
    except ExplorerDefect as defect:
        from multisrt.reporting.custom_strategies import imported

        reference = imported(strategy, Path.cwd()) or strategy
        command = f"multisrt check {shlex.quote(reference)}"
        text = str(defect).replace("multisrt check FILE", command)
        more = "" if command in text else f"\nnext: {command}"
        raise InvalidInputError(f"{text}{more}") from None


def require_known(name: str, file: Path) -> None:
    """Check that the strategy of a spec is known here.

    Parameters
    ----------
    name : str
        The strategy.
    file : Path
        The file of the spec.

    Raises
    ------
    InvalidInputError
        If it is not known; the message says how to import it.
    """
    from multisrt.robots.registry import broken_strategies, is_known

    if not is_known(name) and name not in broken_strategies():
        own = _file_of(name)
        raise InvalidInputError(
            f"{file}: the strategy {name!r} is not known here: import the file that has it, "
            f"--import {own if own.is_file() else 'FILE.py'}"
        )


def _file_of(name: str) -> Path:
    return Path(f"{name.replace('-', '_')}.py")
