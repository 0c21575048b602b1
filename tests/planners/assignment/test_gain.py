import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.gain import GainChoice, gain

INF = np.inf


def naive(costs, areas, distances, overlap_m, power, offset_m, goes_on):
    # The notes of `gain` with loops: which robot takes which target, in order.
    robots, targets = range(len(costs)), range(len(areas))
    left = [list(areas) for _ in robots]
    lengths = [list(row) for row in costs]
    taken: list[tuple[int, int]] = []
    while True:
        able = [
            (left[i][j] * (lengths[i][j] + offset_m) ** -power, -lengths[i][j], -i, -j)
            for i in robots
            for j in targets
            if costs[i][j] < INF
            and (j not in [t for _, t in taken] if goes_on else i not in [r for r, _ in taken])
        ]
        if not able:
            return taken
        *_, i, j = max(able)
        taken.append((-i, -j))
        for other in robots:
            if other != -i:
                near = [min(1.0, distances[-j][k] / overlap_m) for k in targets]
                left[other] = [one * share for one, share in zip(left[other], near, strict=True)]
        if goes_on:
            onward = [distances[-j][k] for k in targets]
            lengths[-i] = [lengths[-i][-j] + length for length in onward]


@st.composite
def situations(draw):
    robots, targets = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    lengths = st.sampled_from([0.0, 1.0, 2.5, 4.0, 7.3, 9.0, INF])
    costs = draw(arrays(float, (robots, targets), elements=lengths))
    areas = draw(arrays(float, targets, elements=st.sampled_from([0.0, 0.5, 3.0, 20.0])))
    places = draw(arrays(float, (targets, 2), elements=st.integers(0, 12)))
    return costs, areas, np.hypot(*(places[:, None] - places).transpose(2, 0, 1))


def choices(costs, areas, distances, **options) -> list[GainChoice]:
    return [
        gain(costs, areas, distances, robot, range_m=4.0, **options) for robot in range(len(costs))
    ]


def test_a_large_area_is_worth_a_higher_cost():
    # (1 + 0.5) ** -2 = 0.444 and (4 + 0.5) ** -2 = 0.0494: 9 times the area is needed.
    costs, distances = [[1.0, 4.0]], [[0.0, 9.0], [9.0, 0.0]]
    for area, expected in ((8.9, 0), (9.1, 1)):
        [chosen] = choices(costs, [1.0, area], distances, power=2.0)
        assert chosen.choice == expected
        value = max(1.0 / 1.5**2, area / 4.5**2)
        assert chosen.rounds[0] == pytest.approx((0, expected, (1.0, area)[expected], value))


def test_a_target_near_a_taken_one_has_less_left():
    # Robot 0 takes target 0. Of target 1, 1 m from it, a quarter of 20 m2 is left: 5 / 2.5 ** 2 is
    # 0.8, less than 0.96 at target 2, which is as large and farther away.
    costs = [[1.0, 2.0, INF], [2.0, 2.0, 4.06]]
    distances = [[0.0, 1.0, 9.0], [1.0, 0.0, 9.0], [9.0, 9.0, 0.0]]
    first, second = choices(costs, [20.0, 20.0, 20.0], distances, power=2.0)
    assert first.choice == 0
    assert second.choice == 2
    assert second.rounds[0] == first.rounds[0]
    # Alone it would have gone to the nearer ones.
    [alone] = choices(costs[1:], [20.0, 20.0, 20.0], distances, power=2.0)
    assert alone.choice == 0


def test_robots_share_the_only_target():
    assert [one.choice for one in choices([[3.0], [1.0]], [5.0], [[0.0]])] == [0, 0]


def test_robots_for_which_nothing_is_left_go_to_the_nearest():
    # Both targets are taken by robots 0 and 1: nothing is left there. Target 1 is nearer.
    costs = [[1.0, 9.0], [9.0, 1.0], [6.0, 5.0]]
    chosen = choices(costs, [5.0, 5.0], [[0.0, 8.0], [8.0, 0.0]])
    assert [one.choice for one in chosen] == [0, 1, 1]
    assert chosen[2].rounds[-1] == (2, 1, 0.0, 0.0)


def test_a_robot_that_reaches_nothing_has_no_choice():
    costs = [[INF, INF], [1.0, INF]]
    cut_off, other = choices(costs, [5.0, 5.0], [[0.0, 8.0], [8.0, 0.0]])
    assert (cut_off.choice, cut_off.rounds) == (None, ())
    assert other.choice == 0
    assert gain(np.empty((1, 0)), [], np.empty((0, 0)), 0, range_m=4.0).choice is None


def test_a_robot_leaves_to_another_what_that_one_comes_by():
    # Target 1 is 3 m behind target 0, which robot 0 takes. Robot 1 is 10 m from both. Target 2 is
    # taken last: it is 12 m from robot 1, and 19 m from robot 0 over targets 0 and 1.
    costs = [[2.0, 5.0, 14.0], [10.0, 10.0, 12.0]]
    distances = [[0.0, 3.0, 12.0], [3.0, 0.0, 14.0], [12.0, 14.0, 0.0]]
    first, second = choices(costs, [5.0, 5.0, 5.0], distances)
    assert (first.choice, second.choice) == (0, 2)
    assert [pair[:2] for pair in second.rounds] == [(0, 0), (0, 1), (1, 2)]


def test_a_robot_that_is_left_nothing_shares_a_target():
    # Robot 0 takes both targets, 2 m and then 3 m away. In the second round it takes target 0 only,
    # and robot 1 target 1: half of its area is left, 2.5 / 10.5 ** 4 against 1.25 / 10.5 ** 4.
    costs, distances = [[2.0, 5.0], [10.0, 10.0]], [[0.0, 2.0], [2.0, 0.0]]
    first, second = choices(costs, [1.25 / 0.5, 5.0], distances)
    assert first.rounds == pytest.approx(np.array([(0, 0, 2.5, 2.5 / 2.5**4)]))
    assert second.rounds[0] == first.rounds[0]
    assert second.rounds[1:] == pytest.approx(np.array([(1, 1, 2.5, 2.5 / 10.5**4)]))


@given(
    situations(),
    st.sampled_from([1.0, 2.0, 4.0]),
    st.sampled_from([0.5, 2.0]),
    st.sampled_from([0.5, 1.0, 2.0]),
)
def test_targets_are_taken_in_order_of_value(situation, power, offset_m, overlap_ranges):
    costs, areas, distances = situation
    tables = costs.tolist(), areas.tolist(), distances.tolist()
    overlap_m = overlap_ranges * 4.0
    on, once = (
        naive(*tables, overlap_m, power, offset_m, goes_on=goes_on) for goes_on in (True, False)
    )
    for robot, chosen in enumerate(
        choices(
            costs,
            areas,
            distances,
            power=power,
            offset_m=offset_m,
            overlap_ranges=overlap_ranges,
        )
    ):
        # All robots see the same order, up to their own turn: equal knowledge, equal plans.
        taken = on if any(pair[0] == robot for pair in on) else once
        turn = next((k for k, pair in enumerate(taken) if pair[0] == robot), None)
        expected = [] if turn is None else taken[: turn + 1]
        assert [pair[:2] for pair in chosen.rounds] == expected
        assert chosen.choice == (expected[-1][1] if expected else None)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"areas": [1.0]}, "areas has the shape"),
        ({"distances": [[0.0]]}, "distances has the shape"),
        ({"areas": [1.0, -1.0]}, "areas"),
        ({"costs": [[1.0, np.nan]]}, "costs"),
        ({"robot": 1}, "robot"),
        ({"range_m": 0.0}, "range_m is 0.0; it must be positive"),
        ({"power": INF}, "power is inf"),
        ({"overlap_ranges": 0.0}, "overlap_ranges is 0.0"),
        ({"offset_m": -1.0}, "offset_m is -1.0"),
    ],
)
def test_bad_tables_are_refused(changes, message):
    sound = {
        "costs": [[1.0, 2.0]],
        "areas": [1.0, 1.0],
        "distances": [[0.0, 1.0], [1.0, 0.0]],
        "robot": 0,
        "range_m": 4.0,
    }
    with pytest.raises(InvalidInputError, match=message):
        gain(**(sound | changes))
