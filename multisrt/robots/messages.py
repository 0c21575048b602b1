"""The base class of messages between robots: typed, immutable, and with a size."""

from __future__ import annotations

from typing import Any, ClassVar

import msgspec
import numpy as np

from multisrt.geometry.numerics.arrays import builtin


class Message(msgspec.Struct, frozen=True, kw_only=True):
    """A message from one robot to others; derive a class for every kind of message.

    Fields may be numbers (also those of numpy), strings, tuples, other structures, immutable
    dataclasses and read-only numpy arrays. A message is not copied when it is sent, so nothing in
    it may change.

    Attributes
    ----------
    sender : int
        Number of the robot that sends it.

    Examples
    --------
    >>> class Hello(Message, frozen=True, kw_only=True):
    ...     kind = "hello"
    ...     text: str
    >>> Hello(sender=0, text="here I am").size_bytes
    24
    """

    sender: int

    kind: ClassVar[str] = "message"
    """Name of this kind of message in recordings."""

    @property
    def wakes(self) -> bool:
        """Whether a robot that listens while it moves receives it at once."""
        return False

    @property
    def size_bytes(self) -> int:
        """Size on the air in bytes: that of its MessagePack encoding."""
        return len(_ENCODER.encode(self))


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tobytes()
    return builtin(value)


_ENCODER = msgspec.msgpack.Encoder(enc_hook=_plain)
