"""A bounded sample, spread over all that comes."""

from __future__ import annotations

from typing import Generic, TypeVar

T = TypeVar("T")


class Sample(Generic[T]):
    """Keeps every item at first, then every second, every fourth, and so on.

    Parameters
    ----------
    size : int
        Number of items after which every second one is dropped.

    Attributes
    ----------
    items : list
        Those that are kept, in the order in which they came.

    Examples
    --------
    >>> sample = Sample[int](4)
    >>> for number in range(10):
    ...     sample.add(number)
    >>> sample.items
    [0, 4, 8]
    """

    def __init__(self, size: int) -> None:
        self.items: list[T] = []
        self._size = size
        self._step = 1
        self._seen = 0

    def add(self, item: T) -> None:
        """Take an item into account."""
        if self._seen % self._step == 0:
            self.items.append(item)
        self._seen += 1
        if len(self.items) == self._size:
            del self.items[1::2]
            self._step *= 2
