"""Explorers to start from, which `multisrt strategy new` copies: a rule, a planner, an explorer."""

from __future__ import annotations

import keyword
import re
from collections.abc import Mapping
from importlib.resources import files
from types import MappingProxyType
from typing import Final

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.robots.registry import is_built_in
from multisrt.robots.strategy import kebab_case

SIZES: Final[Mapping[str, str]] = MappingProxyType(
    {
        "rule": "a rule of assignment alone: a function from path lengths to a frontier",
        "planner": "the next place in a map of safe regions; driving and messages are provided",
        "explorer": "everything that a robot does, from its first scan to its end",
    }
)
"""The sizes, the smallest first, and what of a strategy each leaves to its author."""


def template(size: str, name: str, file: str) -> str:
    """Return the text of a Python file with a strategy to start from.

    Parameters
    ----------
    size : {"rule", "planner", "explorer"}
        How much of a strategy it is; see `SIZES`.
    name : str
        Name of the strategy, in any spelling: ``nearest-door``, ``nearest_door``, ``NearestDoor``.
    file : str
        The file that it is written to, which the examples in it name.

    Returns
    -------
    str
        The text.

    Raises
    ------
    InvalidInputError
        If there is no such size, no class can have that name, or a strategy that ships has it.

    Examples
    --------
    >>> text = template("explorer", "nearest-door", "doors.py")
    >>> [line for line in text.splitlines() if "NearestDoor" in line or "doors.py" in line][:2]
    ['multisrt check doors.py', 'multisrt explore museum --strategy doors.py --robots 3']
    """
    if size not in SIZES:
        raise InvalidInputError(
            f"there is no size {size!r}{did_you_mean(size, SIZES)}; there are: {', '.join(SIZES)}"
        )
    title = kebab_case(name)
    words = title.split("-")
    snake, camel = "_".join(words), "".join(word.capitalize() for word in words)
    if not re.fullmatch(r"[a-z][a-z0-9-]*", title) or keyword.iskeyword(snake):
        raise InvalidInputError(
            f"a strategy cannot be called {name!r}; give a name of letters, digits and hyphens "
            "that begins with a letter, such as nearest-door"
        )
    if is_built_in(title):
        raise InvalidInputError(
            f"there is a strategy {title!r} already; give another name, such as my-{title} (on the "
            f"command line --name my-{title})"
        )
    text = files(__package__).joinpath(f"{size}.py").read_text(encoding="utf-8")
    spelt = {"mine.py": file, "museum-mine-0": f"museum-{title}-0", "Mine": camel, "mine": snake}
    found = "|".join(map(re.escape, spelt))
    return re.sub(rf"\b({found})\b", lambda match: spelt[match[1]], text)
