"""Threads that each wait for a process of their own, and their results in the order they come."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from typing import Generic, TypeVar

Item = TypeVar("Item")


class StoppedError(Exception):
    """A process was stopped by another thread while it was at a job."""


class Shared(Generic[Item]):
    """An iterator that several threads take from.

    Examples
    --------
    >>> jobs = Shared(iter("ab"))
    >>> list(jobs), list(jobs)
    (['a', 'b'], [])
    """

    def __init__(self, items: Iterator[Item]) -> None:
        self._items = items
        self._lock = threading.Lock()

    def __iter__(self) -> Iterator[Item]:
        return self

    def __next__(self) -> Item:
        with self._lock:
            return next(self._items)


def from_threads(
    sources: Sequence[Iterator[Item]], stop: Callable[[], None]
) -> Generator[Item, None, None]:
    """Yield what several iterators yield, as it comes; each is read in a thread of its own.

    Parameters
    ----------
    sources : sequence of iterator
        The iterators. One that raises `StoppedError` has ended; any other error is raised here.
    stop : callable
        Makes the sources end soon. Called if the caller wants no more, or one of them failed.

    Yields
    ------
    Item
        What they yield.

    Examples
    --------
    >>> sorted(from_threads([iter("ac"), iter("b")], stop=lambda: None))
    ['a', 'b', 'c']
    """
    answers: queue.SimpleQueue[tuple[Item] | BaseException | None] = queue.SimpleQueue()

    def read(source: Iterator[Item]) -> None:
        try:
            for item in source:
                answers.put((item,))
            answers.put(None)
        except StoppedError:
            pass  # what it yields is no longer wanted
        except BaseException as error:
            answers.put(error)

    threads = [threading.Thread(target=read, args=(source,), daemon=True) for source in sources]
    busy = len(threads)
    try:
        for thread in threads:
            thread.start()
        while busy:
            answer = answers.get()
            if isinstance(answer, BaseException):
                raise answer
            if answer is None:
                busy -= 1
            else:
                yield answer[0]
    finally:
        if busy:
            stop()
        # An interrupt may have come before all were started.
        for thread in threads:
            if thread.is_alive():
                thread.join()
