"""A graph of places and the paths between them."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Generic, TypeVar

Place = TypeVar("Place", bound=Hashable)


class Roadmap(Generic[Place]):
    """An undirected graph of places, whose edges are paths of known length.

    Places are any hashable objects.

    Examples
    --------
    >>> roadmap = Roadmap()
    >>> roadmap.connect("door", "hall", 3.0)
    >>> roadmap.connect("hall", "desk", 2.0)
    >>> roadmap.path("door", "desk")
    ['door', 'hall', 'desk']
    >>> roadmap.lengths(["door"])
    {'door': 0.0, 'hall': 3.0, 'desk': 5.0}
    """

    def __init__(self) -> None:
        self._edges: dict[Place, dict[Place, float]] = {}

    def add(self, place: Place) -> None:
        """Add a place without paths; a known place is left as it is."""
        self._edges.setdefault(place, {})

    def connect(self, a: Place, b: Place, length_m: float) -> None:
        """Connect two places in both directions by an edge of `length_m` metres; add new places."""
        self._edges.setdefault(a, {})[b] = length_m
        self._edges.setdefault(b, {})[a] = length_m

    def neighbours(self, place: Place) -> tuple[Place, ...]:
        """Return the neighbours of a place in the order of their connection; none if unknown."""
        return tuple(self._edges.get(place, ()))

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
        Dijkstra's algorithm, stopped at the first destination: the cost depends on its distance,
        not on the size of the roadmap. Of equally near places the one connected first wins.
        """
        came_from: dict[Place, Place] = {}
        distance = {start: 0.0}
        settled: set[Place] = set()
        order = 0
        queue: list[tuple[float, int, Place]] = [(0.0, order, start)]
        while queue:
            travelled, _, place = heapq.heappop(queue)
            if place in settled:
                continue
            settled.add(place)
            if wanted(place):
                path = [place]
                while path[-1] != start:
                    path.append(came_from[path[-1]])
                return path[::-1]
            for neighbour, length in self._edges.get(place, {}).items():
                reach = travelled + length
                if (
                    neighbour not in settled
                    and reach < distance.get(neighbour, math.inf)
                    and (passable is None or passable(place, neighbour))
                ):
                    distance[neighbour] = reach
                    came_from[neighbour] = place
                    order += 1
                    heapq.heappush(queue, (reach, order, neighbour))
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
        >>> roadmap.connect("hall", "desk", 2.0)
        >>> roadmap.tree({"hall": 1.0, "desk": 5.0})
        ({'hall': 1.0, 'desk': 3.0}, {'desk': 'hall'})
        """
        queue: list[tuple[float, int, Place, Place | None]] = [
            (length, order, start, None) for order, (start, length) in enumerate(starts.items())
        ]
        heapq.heapify(queue)
        order = len(queue)
        lengths: dict[Place, float] = {}
        before: dict[Place, Place] = {}
        while queue:
            length, _, place, last = heapq.heappop(queue)
            if place in lengths:
                continue
            lengths[place] = length
            if last is not None:
                before[place] = last
            for neighbour, more in self._edges.get(place, {}).items():
                if neighbour not in lengths and (passable is None or passable(place, neighbour)):
                    order += 1
                    heapq.heappush(queue, (length + more, order, neighbour, place))
        return lengths, before
