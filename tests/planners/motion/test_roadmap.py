import math
from itertools import pairwise, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import lil_array
from scipy.sparse.csgraph import csgraph_from_dense, dijkstra

from multisrt.planners.motion.roadmap import Roadmap


def roadmap(edges: dict[tuple[str, str], float]) -> Roadmap[str]:
    result: Roadmap[str] = Roadmap()
    for (a, b), length in edges.items():
        result.connect(a, b, length)
    return result


DETOUR = roadmap(
    {("a", "b"): 1.0, ("b", "c"): 1.0, ("c", "d"): 1.0, ("a", "d"): 4.0, ("e", "f"): 1.0}
)


def test_three_short_paths_beat_a_long_one():
    assert DETOUR.path("a", "d") == ["a", "b", "c", "d"]
    assert DETOUR.path("d", "a") == ["d", "c", "b", "a"]


def test_the_path_to_the_start_is_the_start():
    assert DETOUR.path("a", "a") == ["a"]
    assert DETOUR.path_to_nearest("a", lambda place: True) == ["a"]


def test_unreachable_places_have_no_path():
    assert DETOUR.path("a", "f") is None
    assert DETOUR.path_to_nearest("a", lambda place: False) is None


def test_the_nearest_of_several_places_is_found():
    assert DETOUR.path_to_nearest("a", lambda place: place in "cd") == ["a", "b", "c"]


def test_a_place_without_paths():
    lonely: Roadmap[int] = Roadmap()
    lonely.add(7)
    lonely.add(7)
    assert lonely.path(7, 7) == [7]
    assert lonely.path_to_nearest(7, lambda place: place == 8) is None


def test_adding_a_known_place_keeps_its_paths():
    again = roadmap({("a", "b"): 1.0})
    again.add("a")
    assert again.path("a", "b") == ["a", "b"]


def test_ties_go_to_the_place_connected_first():
    assert roadmap({("s", "b"): 1.0, ("s", "a"): 1.0}).path_to_nearest(
        "s", lambda place: place != "s"
    ) == ["s", "b"]


def test_search_ends_at_the_first_wanted_place():
    line: Roadmap[int] = Roadmap()
    for place in range(1000):
        line.connect(place, place + 1, 1.0)
    asked = []

    def wanted(place: int) -> bool:
        asked.append(place)
        return place == 3

    line.path_to_nearest(0, wanted)
    assert asked == [0, 1, 2, 3]


graphs = st.integers(2, 7).flatmap(
    lambda n: st.tuples(
        st.just(n),
        st.dictionaries(
            st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)).filter(lambda p: p[0] < p[1]),
            st.integers(1, 50).map(float),
        ),
    )
)


@given(graphs)
def test_paths_agree_with_scipy_and_exhaustive_search(graph):
    n, edges = graph
    matrix = lil_array((n, n))
    ours: Roadmap[int] = Roadmap()
    for place in range(n):
        ours.add(place)
    for (a, b), length in edges.items():
        matrix[a, b] = length
        ours.connect(a, b, length)
    lengths = edges | {(b, a): length for (a, b), length in edges.items()}
    theirs = dijkstra(matrix.tocsr(), directed=False, indices=[0])[0]
    for goal in range(1, n):
        path = ours.path(0, goal)
        every_way = (
            (0, *middle, goal)
            for count in range(n - 1)
            for middle in permutations([p for p in range(1, n) if p != goal], count)
        )
        shortest = min(
            (
                sum(lengths[step] for step in pairwise(tried))
                for tried in every_way
                if all(step in lengths for step in pairwise(tried))
            ),
            default=math.inf,
        )
        assert theirs[goal] == shortest
        if path is None:
            assert shortest == math.inf
        else:
            assert path[0] == 0
            assert path[-1] == goal
            assert sum(lengths[step] for step in pairwise(path)) == shortest
    nearest = ours.path_to_nearest(0, lambda place: place % 2 == 1)
    odd = theirs[1::2]
    assert (nearest is None) == bool(np.isinf(odd).all())
    if nearest is not None:
        assert nearest[-1] % 2 == 1
        assert theirs[nearest[-1]] == odd.min()


@given(
    st.dictionaries(
        st.tuples(st.integers(0, 12), st.integers(0, 12)), st.floats(0.1, 9.0), max_size=40
    ),
    st.sets(st.integers(0, 12), min_size=1, max_size=3),
)
def test_lengths_are_those_of_scipy(edges, starts):
    joined: Roadmap[int] = Roadmap()
    lengths = np.full((13, 13), np.inf)
    for (a, b), length in edges.items():
        joined.connect(a, b, length)
        lengths[a, b] = lengths[b, a] = length
    np.fill_diagonal(lengths, np.inf)
    expected = dijkstra(csgraph_from_dense(lengths, null_value=np.inf), indices=[*starts])
    found = joined.lengths(starts)
    nearest = expected.min(axis=0)
    assert {*found} == {k for k in range(13) if nearest[k] < np.inf}
    assert all(found[k] == pytest.approx(nearest[k]) for k in found)
    assert [*found.values()] == sorted(found.values())


def test_lengths_of_the_ways_that_can_be_gone():
    joined: Roadmap[str] = Roadmap()
    joined.connect("a", "b", 1.0)
    joined.connect("b", "c", 1.0)
    assert joined.lengths(["a"], lambda _, b: b != "c") == {"a": 0.0, "b": 1.0}
    assert joined.lengths([]) == {}
