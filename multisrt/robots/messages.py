"""Messages between robots: typed, immutable, and with a size."""

from __future__ import annotations

from typing import Any, ClassVar

import msgspec
import numpy as np


class Message(msgspec.Struct, frozen=True, kw_only=True):
    """What one robot says to others; derive a class for every type of message.

    Fields are numbers, strings, tuples, other structures, immutable dataclasses and read-only
    numpy arrays. A message is not copied when it is sent: nothing in it may be changed.

    Attributes
    ----------
    sender : int
        Who says it.
    """

    sender: int

    kind: ClassVar[str] = "message"
    """What recordings call this type."""

    @property
    def wakes(self) -> bool:
        """Whether a robot that moves and listens is told at once."""
        return False

    @property
    def size_bytes(self) -> int:
        """Size on the air: that of its MessagePack encoding."""
        return len(_ENCODER.encode(self))


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tobytes()
    raise TypeError(f"a message cannot hold a {type(value).__name__}")


_ENCODER = msgspec.msgpack.Encoder(enc_hook=_plain)
