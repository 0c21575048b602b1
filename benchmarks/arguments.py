"""Arguments of the commands of benchmarks: their parser, and numbers within bounds."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any


def parser_of(command: str, description: str, examples: str) -> argparse.ArgumentParser:
    """Return a parser whose help ends with examples.

    Parameters
    ----------
    command : str
        Name of the module, such as ``benchmarks.fuzz``.
    description : str
        What the command does, and how long it takes; lines are kept.
    examples : str
        A call in each line, each without ``python -m`` and the name of the module.

    Examples
    --------
    >>> parser_of("benchmarks.mine", "Do nothing.", "--seed 3").format_help().splitlines()[-2:]
    ['examples:', '  python -m benchmarks.mine --seed 3']
    """
    help_page = help_with(command, description, examples)
    return argparse.ArgumentParser(prog=f"python -m {command}", **help_page)


def help_with(command: str, description: str, examples: str) -> dict[str, Any]:
    """Return the arguments by which the help of a parser, or of a part of it, has examples.

    Parameters
    ----------
    command, description, examples
        As for `parser_of`.

    Examples
    --------
    >>> help_with("benchmarks.mine", "Do nothing.", "add FILE")["epilog"].splitlines()
    ['examples:', '  python -m benchmarks.mine add FILE']
    """
    lines = [f"  python -m {command} {line.strip()}".rstrip() for line in examples.splitlines()]
    return {
        "description": description,
        "epilog": "\n".join(["examples:", *lines]),
        "formatter_class": argparse.RawDescriptionHelpFormatter,
    }


def add_count(
    parser: argparse.ArgumentParser, name: str, metavar: str, default: int, minimum: int, about: str
) -> None:
    """Add an argument that is a whole number, not below a bound; its help tells the default.

    Parameters
    ----------
    parser : ArgumentParser
        Receives the argument.
    name, metavar : str
        The argument and its placeholder, such as ``--workers`` and ``N``.
    default, minimum : int
        Its default and its bound.
    about : str
        The help, without the default.

    Examples
    --------
    >>> parser = parser_of("benchmarks.mine", "Do nothing.", "--seed 3")
    >>> add_count(parser, "--seed", "S", 0, 0, "seed of the campaign")
    >>> parser.parse_args(["--seed", "3"]).seed
    3
    """
    about = f"{about} (default: {default})"
    parser.add_argument(name, type=at_least(minimum), default=default, metavar=metavar, help=about)


def at_least(minimum: int) -> Callable[[str], int]:
    """Return the type of an argument that is a whole number, not below a bound.

    Examples
    --------
    >>> at_least(1)("3")
    3
    >>> at_least(1)("0")
    Traceback (most recent call last):
    argparse.ArgumentTypeError: '0' is not a whole number of at least 1
    """

    def number(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = minimum - 1
        if value < minimum:
            raise argparse.ArgumentTypeError(
                f"{text!r} is not a whole number of at least {minimum}"
            )
        return value

    return number
