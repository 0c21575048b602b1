"""The base class of messages between robots: typed, immutable, and with a size."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import msgspec
import numpy as np

from multisrt.geometry.numerics.arrays import builtin


class Message(msgspec.Struct, frozen=True, kw_only=True):
    """A message from one robot to others; derive a class for every kind of message.

    Its content is its fields: numbers (also those of numpy), text, tuples, other structures,
    immutable dataclasses and arrays of numpy. It reaches others as the same object, so nothing in
    it may change: an array in a field is replaced by a copy that cannot be written; in place of
    lists and dictionaries use tuples.

    Its size is that of its encoding in MessagePack, with arrays as their bytes; the radio counts
    it, and sends messages of any size. The receiver finds out by ``isinstance`` what kind of
    message it has got.

    Attributes
    ----------
    sender : int
        Number of the robot that sends it.
    kind : str
        Name of this kind of message in recordings and measures. Default: made of the name of the
        class, such as ``map part`` for ``MapPart`` or ``MapPartMessage``. Set it in the class.
    wakes : bool
        Whether a robot that listens while it moves (``Move(..., listen=True)``) receives it at
        once; otherwise when it stands. Default: False. Set it in the class.

    Examples
    --------
    >>> class Hello(Message):
    ...     wakes = True
    ...     text: str
    ...     places: np.ndarray = np.empty((0, 2))
    >>> hello = Hello("here I am", np.zeros((3, 2)), sender=0)
    >>> hello.kind, hello.wakes, hello.size_bytes
    ('hello', True, 81)
    >>> hello.places.flags.writeable
    False
    """

    sender: int

    kind: ClassVar[str] = "message"

    def __init_subclass__(cls) -> None:
        if cls.kind == Message.kind:
            words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", cls.__name__.removesuffix("Message"))
            cls.kind = words.lower().strip("_ ") or Message.kind

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            value = getattr(self, name)
            if isinstance(value, np.ndarray) and value.flags.writeable:
                copy = value.copy()
                copy.setflags(write=False)
                msgspec.structs.force_setattr(self, name, copy)

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
