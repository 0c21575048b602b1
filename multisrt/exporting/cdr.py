"""Messages as bytes in CDR, the encoding of ROS 2: little-endian, aligned by size."""

from __future__ import annotations

from struct import Struct
from typing import Final

import numpy as np

HEADER: Final = b"\x00\x01\x00\x00"
"""Header of plain CDR in little-endian order. Alignment counts from its end."""

_UINT32 = Struct("<I")


class CdrWriter:
    """Writer of the fields of one message, in their order.

    Examples
    --------
    >>> message = CdrWriter()
    >>> message.text("map")
    >>> message.numbers(Struct("<d"), 8, 1.0)
    >>> message.bytes().hex(" ", -4)
    '00010000 04000000 6d617000 00000000 0000f03f'
    """

    __slots__ = ("_written",)

    def __init__(self) -> None:
        self._written = bytearray(HEADER)

    def numbers(self, form: Struct, size: int, *values: float) -> None:
        """Write numbers that follow one another without gaps.

        Parameters
        ----------
        form : struct.Struct
            Their types; begins with ``<``.
        size : int
            Size in bytes of the first number, which must not be smaller than the others.
        *values : number
            The numbers.
        """
        self._align(size)
        self._written += form.pack(*values)

    def text(self, text: str) -> None:
        """Write a string; null characters, which would end it, are left out."""
        encoded = text.replace("\0", "").encode(errors="replace")
        self.count(len(encoded) + 1)
        self._written += encoded + b"\0"

    def count(self, number: int) -> None:
        """Write the number of elements of the sequence that follows, or any uint32."""
        self._align(4)
        self._written += _UINT32.pack(number)

    def array(self, values: np.ndarray) -> None:
        """Write the elements of an array of numbers, without their count."""
        if values.size:
            self._align(values.dtype.itemsize)
            ordered = values.astype(values.dtype.newbyteorder("<"), copy=False)
            self._written += ordered.tobytes()

    def bytes(self) -> bytes:
        """Return the message."""
        return bytes(self._written)

    def _align(self, size: int) -> None:
        self._written += bytes(-(len(self._written) - len(HEADER)) % size)
