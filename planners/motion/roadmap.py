"""A graph of places and the ways between them, searched outwards from where a robot is."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterable
from typing import Generic, TypeVar

Place = TypeVar("Place", bound=Hashable)


class Roadmap(Generic[Place]):
    """Places joined by ways of known length; ways lead in both directions."""

    def __init__(self) -> None:
        self._ways: dict[Place, dict[Place, float]] = {}

    def add(self, place: Place) -> None:
        """Add a place without ways; one that is known already stays as it is."""
        self._ways.setdefault(place, {})

    def connect(self, a: Place, b: Place, length_m: float) -> None:
        """Join two places."""
        self._ways.setdefault(a, {})[b] = length_m
        self._ways.setdefault(b, {})[a] = length_m

    def neighbours(self, place: Place) -> tuple[Place, ...]:
        """Give the places that are joined to one, in the order in which they were joined."""
        return tuple(self._ways.get(place, ()))

    def way_to_nearest(
        self,
        start: Place,
        wanted: Callable[[Place], bool],
        passable: Callable[[Place, Place], bool] | None = None,
    ) -> list[Place] | None:
        """Find the shortest way to the nearest of the wanted places.

        Dijkstra's search, ended at the first wanted place: its cost depends on how far that is,
        not on the size of the roadmap. Ties go to the place that was joined first.

        Parameters
        ----------
        start : Place
            Where the way begins.
        wanted : callable
            Whether a place is one of those looked for.
        passable : callable, optional
            Whether the way from one place to a neighbour can be gone at present.

        Returns
        -------
        list of places from `start` to the place found, or None if none can be reached.
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
                way = [place]
                while way[-1] != start:
                    way.append(came_from[way[-1]])
                return way[::-1]
            for neighbour, length in self._ways.get(place, {}).items():
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

    def way(
        self,
        start: Place,
        end: Place,
        passable: Callable[[Place, Place], bool] | None = None,
    ) -> list[Place] | None:
        """Find the shortest way between two places."""
        return self.way_to_nearest(start, lambda place: place == end, passable)

    def lengths(
        self, starts: Iterable[Place], passable: Callable[[Place, Place], bool] | None = None
    ) -> dict[Place, float]:
        """Give the lengths of the shortest ways from the nearest start to all places that have one.

        Parameters
        ----------
        starts : iterable of places
            Where ways begin.
        passable : callable, optional
            Whether the way from one place to a neighbour can be gone at present.

        Returns
        -------
        dict
            Lengths in metres by place, the nearest place first.
        """
        queue = [(0.0, order, start) for order, start in enumerate(starts)]
        order = len(queue)
        lengths: dict[Place, float] = {}
        while queue:
            length, _, place = heapq.heappop(queue)
            if place in lengths:
                continue
            lengths[place] = length
            for neighbour, more in self._ways.get(place, {}).items():
                if neighbour not in lengths and (passable is None or passable(place, neighbour)):
                    order += 1
                    heapq.heappush(queue, (length + more, order, neighbour))
        return lengths
