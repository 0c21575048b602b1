"""What messages of any kind tell of the knowledge of their senders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from multisrt.robots.knowledge import Closing, Counts, Entry, Node
from multisrt.robots.messages import Message

MAX_DEPTH = 6
"""How deep messages are looked into."""


def entries_in(message: Message) -> tuple[Entry, ...]:
    """Return the nodes and closings that a message carries.

    Parameters
    ----------
    message : Message
        A message of any kind.

    Returns
    -------
    tuple of Node or Closing
        Those of its field `entries`, if that holds nothing else; else those in any of its fields,
        in their order.

    Examples
    --------
    >>> class Hello(Message):
    ...     text: str
    >>> entries_in(Hello("here I am", sender=0))
    ()
    """
    entries = getattr(message, "entries", None)
    if isinstance(entries, tuple) and all(isinstance(one, Node | Closing) for one in entries):
        return entries
    return tuple(_entries(message, 0))


def counts_in(message: Message) -> Counts:
    """Return how many nodes and closings of each robot the sender of a message has.

    Parameters
    ----------
    message : Message
        A message of any kind.

    Returns
    -------
    tuple of (robot, nodes, closings)
        Its field `have`; empty if it has none that is made of such counts.

    Examples
    --------
    >>> from multisrt.robots.knowledge import WantMessage
    >>> counts_in(WantMessage(sender=1, have=((0, 7, 1),)))
    ((0, 7, 1),)
    """
    have = getattr(message, "have", ())
    if isinstance(have, tuple) and all(map(_is_count, have)):
        return have
    return ()


def _is_count(line: object) -> bool:
    return (
        isinstance(line, tuple) and len(line) == 3 and all(isinstance(part, int) for part in line)
    )


def _entries(value: object, depth: int) -> Iterator[Entry]:
    if isinstance(value, Node | Closing):
        yield value
    elif depth <= MAX_DEPTH:
        for part in _parts(value):
            yield from _entries(part, depth + 1)


def _parts(value: object) -> list[object]:
    if isinstance(value, msgspec.Struct):
        return [getattr(value, field) for field in value.__struct_fields__]
    if isinstance(value, Mapping):
        return list(value.values())
    if isinstance(value, tuple | list | set | frozenset):
        return list(value)
    return []
