"""A graph of places in the plane and the paths between them."""

from __future__ import annotations

import heapq
import math
from array import array
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from typing import Generic, TypeVar

Place = TypeVar("Place", bound=Hashable)


class Roadmap(Generic[Place]):
    """An undirected graph of places in the plane, whose edges are straight paths.

    Places are any hashable objects. Methods raise `KeyError` for places that were not added.

    Examples
    --------
    >>> roadmap = Roadmap()
    >>> roadmap.add("door", 0.0, 0.0)
    >>> roadmap.add("hall", 3.0, 0.0)
    >>> roadmap.add("desk", 3.0, 2.0)
    >>> roadmap.connect("door", "hall")
    >>> roadmap.connect("hall", "desk")
    >>> roadmap.path("door", "desk")
    ['door', 'hall', 'desk']
    >>> roadmap.lengths(["door"])
    {'door': 0.0, 'hall': 3.0, 'desk': 5.0}
    """

    def __init__(self) -> None:
        # Large teams have millions of edges: places are numbered, each has the numbers of its
        # neighbours, and the lengths of edges are computed anew.
        self._places: list[Place] = []
        self._numbers: dict[Place, int] = {}
        self._xs = array("d")
        self._ys = array("d")
        self._neighbours: list[array[int]] = []

    def add(self, place: Place, x: float, y: float) -> None:
        """Add a place without edges, at x and y in metres; a known place is left as it is."""
        number = self._numbers.setdefault(place, len(self._places))
        if number == len(self._places):
            self._places.append(place)
            self._xs.append(x)
            self._ys.append(y)
            self._neighbours.append(array("i"))

    def connect(self, a: Place, b: Place) -> None:
        """Connect two places by an edge, unless there is one."""
        first, second = self._numbers[a], self._numbers[b]
        for one, other in ((first, second), (second, first)):
            if other not in self._neighbours[one]:
                self._neighbours[one].append(other)

    def joins(self, a: Place, b: Place) -> bool:
        """Return whether there is an edge between two places."""
        first, second = self._numbers.get(a), self._numbers.get(b)
        return first is not None and second is not None and second in self._neighbours[first]

    def path_to_nearest(
        self,
        start: Place,
        wanted: Callable[[Place], bool],
        passable: Callable[[Place, Place], bool] | None = None,
    ) -> list[Place] | None:
        """Return the shortest path to the nearest of the wanted places.

        Parameters
        ----------
        start : Place
            Where the path begins.
        wanted : callable
            Whether a place is a destination.
        passable : callable, optional
            Whether the path from a place to a neighbour is free at present. Default: all are.

        Returns
        -------
        list of Place or None
            The places from `start` to the destination; None if none can be reached.

        Notes
        -----
        The search of `nearest_first`, stopped at the first destination. Of equally near places
        the one connected first wins.
        """
        came_from: dict[Place, Place] = {}
        for place, _, before in self.nearest_first({start: 0.0}, passable):
            if before is not None:
                came_from[place] = before
            if wanted(place):
                path = [place]
                while path[-1] != start:
                    path.append(came_from[path[-1]])
                return path[::-1]
        return None

    def path(
        self,
        start: Place,
        end: Place,
        passable: Callable[[Place, Place], bool] | None = None,
    ) -> list[Place] | None:
        """Return the shortest path between two places.

        Parameters
        ----------
        start, end : Place
            The ends of the path.
        passable : callable, optional
            As in `path_to_nearest`.

        Returns
        -------
        list of Place or None
            The places from `start` to `end`; None if no path leads there.
        """
        return self.path_to_nearest(start, lambda place: place == end, passable)

    def lengths(
        self, starts: Iterable[Place], passable: Callable[[Place, Place], bool] | None = None
    ) -> dict[Place, float]:
        """Return the lengths of the shortest paths from the nearest start.

        Parameters
        ----------
        starts : iterable of Place
            Where paths begin.
        passable : callable, optional
            As in `path_to_nearest`.

        Returns
        -------
        dict of Place to float
            Lengths in metres, the nearest place first. Unreachable places are missing.
        """
        return self.tree(dict.fromkeys(starts, 0.0), passable)[0]

    def tree(
        self,
        starts: Mapping[Place, float],
        passable: Callable[[Place, Place], bool] | None = None,
    ) -> tuple[dict[Place, float], dict[Place, Place]]:
        """Return the shortest paths from several starts to all places.

        Parameters
        ----------
        starts : mapping of Place to float
            Where paths begin, with the length in metres that each has behind it there.
        passable : callable, optional
            As in `path_to_nearest`.

        Returns
        -------
        lengths : dict of Place to float
            Lengths in metres, the nearest place first. Unreachable places are missing.
        before : dict of Place to Place
            The place before each on its way; starts from which paths begin are missing.

        Examples
        --------
        >>> roadmap = Roadmap()
        >>> roadmap.add("hall", 3.0, 0.0)
        >>> roadmap.add("desk", 3.0, 2.0)
        >>> roadmap.connect("hall", "desk")
        >>> roadmap.tree({"hall": 1.0, "desk": 5.0})
        ({'hall': 1.0, 'desk': 3.0}, {'desk': 'hall'})
        """
        lengths: dict[Place, float] = {}
        before: dict[Place, Place] = {}
        for place, length, last in self.nearest_first(starts, passable):
            lengths[place] = length
            if last is not None:
                before[place] = last
        return lengths, before

    def nearest_first(
        self,
        starts: Mapping[Place, float],
        passable: Callable[[Place, Place], bool] | None = None,
    ) -> Iterator[tuple[Place, float, Place | None]]:
        """Yield all places that can be reached, by the lengths of the shortest paths to them.

        Parameters
        ----------
        starts, passable
            As for `tree`.

        Yields
        ------
        place : Place
            A place.
        length : float
            Length in metres.
        before : Place or None
            The place before it on its way; None for a start from which a path begins.

        Notes
        -----
        Dijkstra's algorithm, which goes on only as far as places are asked for: the cost depends
        on their distance, not on the size of the roadmap. Whether an edge is free is asked only
        when it would be the last of a shortest path.

        Examples
        --------
        >>> roadmap = Roadmap()
        >>> roadmap.add("hall", 3.0, 0.0)
        >>> roadmap.add("desk", 3.0, 2.0)
        >>> roadmap.connect("hall", "desk")
        >>> list(roadmap.nearest_first({"hall": 1.0}))
        [('hall', 1.0, None), ('desk', 3.0, 'hall')]
        """
        places, xs, ys, none = self._places, self._xs, self._ys, -1
        queue: list[tuple[float, int, int, int]] = [
            (length, order, self._numbers[start], none)
            for order, (start, length) in enumerate(starts.items())
        ]
        heapq.heapify(queue)
        order = len(queue)
        settled: set[int] = set()
        shortest: dict[int, float] = {}
        while queue:
            length, _, number, last = heapq.heappop(queue)
            if number in settled:
                continue
            place = places[number]
            before = None if last == none else places[last]
            if before is not None and passable is not None and not passable(before, place):
                continue
            settled.add(number)
            yield place, length, before
            x, y = xs[number], ys[number]
            for neighbour in self._neighbours[number]:
                if neighbour in settled:
                    continue
                reach = length + math.hypot(xs[neighbour] - x, ys[neighbour] - y)
                # A longer path is of use only where the edge of the shortest may not be free.
                if passable is None:
                    if reach >= shortest.get(neighbour, math.inf):
                        continue
                    shortest[neighbour] = reach
                order += 1
                heapq.heappush(queue, (reach, order, neighbour, number))
