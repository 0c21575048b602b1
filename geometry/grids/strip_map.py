"""A plane of labels on thin parallel strips, and the area with each label; see `strips`."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multisrt.geometry.grids.strips import Number, Runs, Strips
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel, unsigned

SAME_PLACE_M: Final = 1e-9
"""Ends of intervals that are at most this far apart are one, in metres."""

OUTSIDE: Final = 0
"""The label of all that no region has given another one."""

Labels = NDArray[np.int16]


class _Part(NamedTuple):
    # Intervals one after the other on a strip: where each begins, and its label. The first begins
    # at -inf, the last one has no end.
    begins: FloatArray
    labels: Labels


class _Span(NamedTuple):
    # A part of a line: its ends in metres, and the first and the last interval that it touches.
    begin: float
    end: float
    first: int
    last: int


class StripMap:
    """A plane whose every point has a label, on strips; at first all is `OUTSIDE`.

    Parameters
    ----------
    cut : Strips
        The strips.
    labels : int
        Number of labels; they count from 0.

    Attributes
    ----------
    cut : Strips
        The strips.
    areas_m2 : (labels,) array
        Area with each label in square metres; that of `OUTSIDE` is 0 less all others.

    Examples
    --------
    Two squares of 2 x 2 m that overlap by 1 x 1 m; what lies in both gets label 2:

    >>> from multisrt.geometry.grids.strips import runs_of, strips
    >>> cut = strips(np.array([(0.0, 0.0, 0.0, 3.0)]), 0.5)
    >>> square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    >>> plane = StripMap(cut, 3)
    >>> history = plane.relabel(runs_of(cut, [square, square + 1.0]), [[1, 2, 2]])
    >>> history[:, 1:].tolist()
    [[4.0, 0.0], [6.0, 1.0]]
    """

    def __init__(self, cut: Strips, labels: int) -> None:
        self.cut = cut
        self.areas_m2: FloatArray = np.zeros(labels)
        rows = len(cut.middles)
        self._counts: IntArray = np.ones(rows, np.int64)
        self._begins: FloatArray = np.full((rows, 8), -np.inf)
        self._labels: Labels = np.zeros((rows, 8), np.int16)

    def copy(self) -> StripMap:
        """Return an independent copy."""
        labels = len(self.areas_m2)
        return self.mapped(np.arange(labels), labels)

    def mapped(self, table: ArrayLike, labels: int) -> StripMap:
        """Return an independent copy with other labels everywhere.

        Parameters
        ----------
        table : (old labels,) array_like of int
            The new label of every old one; that of `OUTSIDE` is `OUTSIDE`.
        labels : int
            Number of new labels.

        Examples
        --------
        >>> from multisrt.geometry.grids.strips import runs_of, strips
        >>> cut = strips(np.array([(0.0, 0.0, 0.0, 3.0)]), 0.5)
        >>> plane = StripMap(cut, 3)
        >>> square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
        >>> _ = plane.relabel(runs_of(cut, [square, square + 1.0]), [[1, 2, 2]])
        >>> float(plane.mapped([OUTSIDE, 1, 1], 2).areas_m2[1])
        7.0
        """
        new = np.asarray(table, np.int16)
        twin = StripMap(self.cut, labels)
        np.add.at(twin.areas_m2, new, self.areas_m2)
        twin._counts, twin._begins = self._counts.copy(), self._begins.copy()
        twin._labels = self._labels.copy()
        _map(twin._counts, twin._begins, twin._labels, new)
        return twin

    def relabel(
        self,
        runs: Runs,
        tables: ArrayLike,
        regions: ArrayLike | None = None,
        which: ArrayLike | None = None,
    ) -> FloatArray:
        """Give the points of regions new labels, one region after the other.

        Parameters
        ----------
        runs : Runs
            Intervals of regions, on the same strips.
        tables : (t, labels) array_like of int
            For each table the new label of every old one.
        regions : (n,) array_like of int, optional
            The regions, in the order in which they are relabelled; default: each once.
        which : (n,) array_like of int, optional
            The table of each; default: the first.

        Returns
        -------
        (n, labels) array
            The areas with each label after every region, in square metres.
        """
        order = np.arange(len(runs.starts) - 1) if regions is None else np.asarray(regions)
        table = np.zeros(len(order)) if which is None else np.asarray(which)
        history = np.empty((len(order), len(self.areas_m2)))
        self._counts, self._begins, self._labels = _relabel(
            (self._counts, self._begins, self._labels),
            runs,
            (order.astype(np.int64), table.astype(np.int64)),
            np.asarray(tables, np.int16),
            self.cut.heights,
            self.areas_m2,
            history,
        )
        return history

    def runs(self, label: int) -> Runs:
        """Return all that has a label as one region."""
        return Runs(*_runs_with(label, self._counts, self._begins, self._labels))


@kernel
def _runs_with(
    label: int, counts: IntArray, begins: FloatArray, labels: Labels
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    room = 0
    for row in range(counts.shape[0]):
        for k in range(counts[row]):
            room += labels[row, k] == label
    strip, begin, end = np.empty(room, np.int64), np.empty(room), np.empty(room)
    n = 0
    for row in range(counts.shape[0]):
        for k in range(counts[row]):
            if labels[row, k] == label:
                strip[n], begin[n] = row, begins[row, k]
                end[n] = begins[row, k + 1] if k + 1 < counts[row] else np.inf
                n += 1
    return np.array([0, room]), strip, begin, end


@kernel
def _relabel(
    held: tuple[IntArray, FloatArray, Labels],
    runs: Runs,
    order: tuple[IntArray, IntArray],
    tables: Labels,
    heights: FloatArray,
    areas: FloatArray,
    history: FloatArray,
) -> tuple[IntArray, FloatArray, Labels]:
    counts, begins, labels = held
    regions, which = order
    room = begins.shape[1]
    for step in range(regions.shape[0]):
        table, region = tables[which[step]], regions[step]
        for run in range(unsigned(runs.starts[region]), unsigned(runs.starts[region + 1])):
            row = unsigned(runs.strip[run])
            a, b = runs.begin[run], runs.end[run]
            count = counts[row]
            # The intervals in which the run begins and ends.
            first, beyond = 0, count
            while beyond - first > 1:
                middle = (first + beyond) // 2
                if begins[row, unsigned(middle)] <= a + SAME_PLACE_M:
                    first = middle
                else:
                    beyond = middle
            last = first
            label = labels[row, unsigned(first)]
            changes = table[label] != label
            while last + 1 < count and begins[row, unsigned(last + 1)] < b - SAME_PLACE_M:
                last += 1
                label = labels[row, unsigned(last)]
                changes |= table[label] != label
            if changes:
                if count + 2 > room:
                    room *= 2
                    begins, labels = _wider(begins, room), _wider(labels, room)
                line = _Part(begins[row], labels[row])
                span = _Span(a, b, first, last)
                counts[row] = _relabel_span(line, count, span, table, heights[row], areas)
        history[step] = areas
    return counts, begins, labels


@kernel
def _relabel_span(
    line: _Part, count: int, span: _Span, table: Labels, height: float, areas: FloatArray
) -> int:
    # Gives the points of a span new labels; returns how many intervals the line has then.
    first, last = span.first, span.last
    part = _Part(np.empty(last - first + 3), np.empty(last - first + 3, np.int16))
    # What takes the place of intervals `first` to `last`, neighbours of one label joined.
    n = 0
    if line.begins[first] < span.begin - SAME_PLACE_M:
        part.begins[0], part.labels[0] = line.begins[first], line.labels[first]
        n = 1
    for k in range(first, last + 1):
        begin = span.begin if k == first and n else line.begins[k]
        end = line.begins[k + 1] if k + 1 < count else np.inf
        end = end if end <= span.end + SAME_PLACE_M else span.end
        before = line.labels[k]
        after = table[before]
        if after != before:
            areas[before] -= (end - begin) * height
            areas[after] += (end - begin) * height
        if n == 0 or part.labels[n - 1] != after:
            part.begins[n], part.labels[n] = begin, after
            n += 1
    remainder = line.labels[last]
    goes_on = last + 1 == count or line.begins[last + 1] > span.end + SAME_PLACE_M
    if goes_on and part.labels[n - 1] != remainder:
        part.begins[n], part.labels[n] = span.end, remainder
        n += 1
    return _spliced(line, count, (first, last + 1), part, n)


@kernel
def _spliced(line: _Part, count: int, cut: tuple[int, int], part: _Part, n: int) -> int:
    # Puts the first n intervals of a part in the place of some of a line; returns their number.
    first, beyond = cut
    if beyond < count and line.labels[beyond] == part.labels[n - 1]:
        beyond += 1
    skip = 1 if first > 0 and line.labels[first - 1] == part.labels[0] else 0
    shift = first + n - skip - beyond
    if shift > 0:
        for k in range(count - 1, beyond - 1, -1):
            line.begins[k + shift], line.labels[k + shift] = line.begins[k], line.labels[k]
    elif shift < 0:
        for k in range(beyond, count):
            line.begins[k + shift], line.labels[k + shift] = line.begins[k], line.labels[k]
    for k in range(skip, n):
        line.begins[first + k - skip] = part.begins[k]
        line.labels[first + k - skip] = part.labels[k]
    return count + shift


@kernel
def _map(counts: IntArray, begins: FloatArray, labels: Labels, table: Labels) -> None:
    # Gives all intervals new labels, and joins neighbours of one label.
    for row in range(counts.shape[0]):
        n = 0
        for k in range(counts[row]):
            label = table[labels[row, k]]
            if n == 0 or labels[row, n - 1] != label:
                begins[row, n], labels[row, n] = begins[row, k], label
                n += 1
        counts[row] = n


@kernel
def _wider(values: NDArray[Number], room: int) -> NDArray[Number]:
    wider = np.empty((values.shape[0], room), values.dtype)
    wider[:, : values.shape[1]] = values
    return wider
