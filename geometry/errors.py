"""The exceptions that multisrt raises, under one root."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Final

MAX_CITED: Final = 60
"""Upper bound of the length of a value or a name from a file in a message, in characters."""

MAX_REASON: Final = 200
"""Upper bound of the length of a parser's or the system's reason in a message, in characters."""


class MultiSrtError(Exception):
    """Base class of all exceptions that multisrt raises.

    Examples
    --------
    >>> import multisrt as ms
    >>> try:
    ...     ms.explore("open", robots=0)
    ... except ms.MultiSrtError as error:
    ...     print(error)
    a team has at least one robot, not 0
    """


class InvalidInputError(MultiSrtError, ValueError):
    """An argument or input is invalid; the message states the value, the place and the remedy.

    Examples
    --------
    >>> import multisrt as ms
    >>> try:
    ...     ms.environment("officee")
    ... except ms.InvalidInputError as error:
    ...     print(str(error).partition(";")[0])
    no environment is called 'officee' (did you mean 'office'?)
    >>> issubclass(ms.InvalidInputError, ValueError)
    True
    """


class MapFormatError(InvalidInputError):
    r"""A map file cannot be read; the message names the file, the place in it and the remedy.

    Messages quote files, which may contain any characters: those that a terminal would not show or
    would interpret are escaped, so a message is a single line of text.

    Parameters
    ----------
    message : str
        The error, its place and the remedy.

    Examples
    --------
    >>> print(MapFormatError("hall.yaml names the image \x1b[2J\n"))
    hall.yaml names the image \x1b[2J\n
    """

    def __init__(self, message: str) -> None:
        super().__init__(escaped(message))


class ClearanceError(InvalidInputError):
    """A body or a viewpoint is too close to an obstacle.

    Parameters
    ----------
    message : str
        The message.
    clearance_m : float
        Distance to the nearest obstacle in metres; negative or zero inside one.

    Attributes
    ----------
    clearance_m : float
        As given.
    """

    def __init__(self, message: str, clearance_m: float) -> None:
        # Both become arguments of the exception, so that it can be copied and pickled.
        super().__init__(message, clearance_m)
        self.clearance_m = clearance_m

    def __str__(self) -> str:
        return str(self.args[0])


def escaped(text: str) -> str:
    r"""Return a text with characters that are not printable as escapes of Python.

    Parameters
    ----------
    text : str
        A text that cites a file.

    Examples
    --------
    >>> print(escaped("a door\tof 9 \u20ac\n"))
    a door\tof 9 €\n
    """
    if text.isprintable():
        return text
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text
    )


def shortened(text: str, length: int = MAX_CITED) -> str:
    """Return a text from a file for a message: cut if it is long, its characters printable.

    Parameters
    ----------
    text : str
        The text; it may be of any length.
    length : int
        Upper bound of the length of the result, in characters.

    Examples
    --------
    >>> shortened("hall"), shortened("ha" * 1000, 10)
    ('hall', 'hahahah...')
    """
    text = escaped(text[: length + 1])
    return text if len(text) <= length else f"{text[: length - 3]}..."


def shown(value: object) -> str:
    """Return a value from a file as short text for a message; text is in quotes.

    Examples
    --------
    >>> shown("hall"), shown([1, 2]), len(shown("ha" * 1000))
    ("'hall'", 'a list of 2', 60)
    """
    if isinstance(value, list | tuple | dict | set):
        return f"a {type(value).__name__} of {len(value)}"
    if isinstance(value, int) and value.bit_length() > 10_000:
        return f"a whole number of {value.bit_length():,} bits"  # Python limits the digits
    return shortened(repr(value[: MAX_CITED + 1] if isinstance(value, str) else value))


def reason_of(error: BaseException) -> str:
    r"""Return the words of an error that a parser or the system raised, short and on one line.

    Parameters
    ----------
    error : BaseException
        The error; it may cite a whole file.

    Returns
    -------
    str
        At most `MAX_REASON` characters. Of errors of the system, without the name of the file; the
        type of an error that has no words.

    Examples
    --------
    >>> reason_of(ValueError("found a tab\nin line 3")), reason_of(ValueError())
    ('found a tab in line 3', 'ValueError')
    >>> reason_of(FileNotFoundError(2, "No such file or directory", "hall.png"))
    'No such file or directory'
    """
    words = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    # A line of a long text may be long, and its beginning is enough.
    words = " ".join(words[: 2 * MAX_REASON].split()).rstrip(".")
    return shortened(words, MAX_REASON) or type(error).__name__


def counted(number: int, one: str, several: str = "") -> str:
    """Return a number of things as text.

    Parameters
    ----------
    number : int
        How many.
    one : str
        What one of them is called.
    several : str, optional
        What several are called; by default `one` with an s.

    Examples
    --------
    >>> counted(1, "start"), counted(1200, "robot"), counted(0, "vertex", "vertices")
    ('1 start', '1,200 robots', '0 vertices')
    """
    return f"{number:,} {one if number == 1 else several or one + 's'}"


def did_you_mean(word: object, known: Iterable[object]) -> str:
    """Return a hint at the known word closest to an unknown one, for the end of a message.

    Parameters
    ----------
    word : object
        The unknown word.
    known : iterable of object
        The words that are allowed.

    Returns
    -------
    str
        Begins with a space; empty if no known word is similar.

    Examples
    --------
    >>> did_you_mean("clotest", ["closest", "minpos"])
    " (did you mean 'closest'?)"
    >>> did_you_mean("xyz", ["closest", "minpos"])
    ''
    """
    close = difflib.get_close_matches(str(word), list(map(str, known)), n=1)
    return f" (did you mean {shown(close[0])}?)" if close else ""
