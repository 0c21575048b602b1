import hypothesis.extra.numpy as arrays
import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.gain import LazyCosts, ValueParameters, gain
from multisrt.planners.assignment.gain_tours import MAX_STOPS, gain_on_tours

INF = np.inf


def on_a_line(robots, targets):
    """Costs of robots to targets, and distances between these, on a line."""
    places = np.array(targets)
    return np.abs(np.array(robots)[:, None] - places), np.abs(places[:, None] - places)


def chosen(robots, targets, areas, robot=0, **options):
    costs, distances = on_a_line(robots, targets)
    return gain_on_tours(
        costs,
        areas,
        distances,
        distances,
        robot,
        **({"parameters": ValueParameters(4.0)} | options),
    )


def test_a_scrap_is_not_left_behind_for_a_larger_area():
    # The robot at 0 is 3 m from a scrap of 2 m2 and 4 m from a hall of 45 m2 on the other side.
    # Factors: (50.3 / 7) ** 0.25 = 1.64 and (50.3 / 50) ** 0.25 = 1.0; so the scrap counts as 5.7 m
    # and the hall as 4.5 m. Tours: 3 + 7 and 0.7 m for leaving the scrap, 4 + 7 and 3.4 m for
    # leaving the hall: 3.6 m more. The hall is chosen by weights below 0.33.
    for weight, expected in ((0.3, 1), (0.4, 0), (2.0, 0)):
        found = chosen([0.0], [-3.0, 4.0], [2.0, 45.0], tour_weight=weight)
        assert found.choice == expected
        assert found.rounds[-1][:2] == (0, expected)


def test_by_value_alone_the_larger_area_is_chosen():
    costs, distances = on_a_line([0.0], [-3.0, 4.0])
    assert gain(costs, [7.0, 50.0], distances, 0, range_m=4.0).choice == 1


def test_robots_choose_among_what_they_take():
    # Each robot takes the two targets on its side, and goes to the nearer one first.
    targets, areas = [-6.0, -3.0, 23.0, 26.0], [9.0] * 4
    for robot, expected in ((0, 1), (1, 2)):
        assert chosen([0.0, 20.0], targets, areas, robot).choice == expected


def test_searching_a_large_area_leaves_others_to_others():
    # Robot 0 takes the target at 2 m. The other one is 4 m behind it: 6 m for robot 0 and 7 m for
    # robot 1. Searching a hall of 40 m2 takes 6 m, so that robot 1 is nearer; a room of 1 m2, 0.2.
    for area, expected in ((40.0, 1), (1.0, None)):
        found = chosen([0.0, 13.0], [2.0, 6.0], [area, 1.0], 1)
        assert found.choice == expected


def test_a_robot_to_which_nothing_is_left_has_no_choice():
    found = chosen([0.0, 0.5], [0.2], [9.0], 1)
    assert (found.choice, found.rounds) == (None, ())
    nothing = gain_on_tours([[INF]], [1.0], [[0.0]], [[0.0]], 0, parameters=ValueParameters(4.0))
    assert nothing.choice is None


def test_targets_worth_nothing_can_be_chosen():
    assert (
        chosen([0.0], [3.0], [0.0], parameters=ValueParameters(4.0, return_area_m2=0.0)).choice == 0
    )


def test_only_the_best_targets_are_stops():
    # One more than there are stops; the farthest one is left out.
    targets = [float(k) for k in range(1, MAX_STOPS + 2)]
    assert chosen([0.0], targets, [1.0] * len(targets)).choice == 0


def test_preferred_targets_come_first():
    # By value and tour it is the target at 2 m; of those beyond 10 m the nearer one.
    targets, areas = [2.0, 12.0, 15.0], [9.0] * 3
    preferred = np.array([False, True, True])
    assert chosen([0.0], targets, areas).choice == 0
    assert chosen([0.0], targets, areas, preferred=preferred).choice == 1
    assert chosen([0.0], targets, areas, preferred=~preferred).choice == 0


def test_preferred_targets_that_others_take_are_left_to_them():
    targets, areas = [2.0, 12.0], [9.0] * 2
    preferred = np.array([False, True])
    assert chosen([0.0, 13.0], targets, areas, preferred=preferred).choice == 0
    assert chosen([0.0, 13.0], targets, areas, 1, preferred=preferred).choice == 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"path_lengths": [[0.0]]}, "path_lengths has the shape"),
        ({"areas": [1.0]}, "areas has the shape"),
        ({"tour_weight": 0.0}, "tour_weight is 0.0; it must be positive"),
        ({"parameters": ValueParameters(0.0)}, "range_m is 0.0"),
        (
            {"parameters": ValueParameters(4.0, return_area_m2=-1.0)},
            "return_area_m2 is -1.0; it must be 0 or more",
        ),
        ({"preferred": np.array([True])}, "preferred is bool of shape"),
        ({"preferred": np.array([0, 1])}, "preferred is int64 of shape"),
    ],
)
def test_bad_values_are_refused(changes, message):
    distances = [[0.0, 1.0], [1.0, 0.0]]
    sound = {
        "costs": [[1.0, 2.0]],
        "areas": [1.0, 1.0],
        "distances": distances,
        "path_lengths": distances,
        "robot": 0,
        "parameters": ValueParameters(4.0),
    }
    with pytest.raises(InvalidInputError, match=message):
        gain_on_tours(**(sound | changes))


def test_paths_between_targets_are_finite():
    distances = [[0.0, 3.0], [3.0, 0.0]]
    with pytest.raises(InvalidInputError, match="infinite"):
        gain_on_tours(
            [[1.0, 1.0]],
            [5.0, 5.0],
            distances,
            [[0.0, np.inf], [np.inf, 0.0]],
            0,
            parameters=ValueParameters(4.0),
        )


@st.composite
def teams(draw):
    """Costs, lower bounds of them, areas, and distances; values are often equal."""
    n, m = draw(st.integers(1, 5)), draw(st.integers(1, 8))
    tenths = st.integers(0, 40).map(lambda k: k / 10.0)
    costs = draw(arrays.arrays(np.float64, (n, m), elements=tenths))
    shares = draw(arrays.arrays(np.float64, (n, m), elements=st.sampled_from([0.0, 0.5, 1.0])))
    areas = draw(arrays.arrays(np.float64, m, elements=st.sampled_from([0.0, 2.0, 9.0])))
    distances = draw(arrays.arrays(np.float64, (m, m), elements=tenths))
    distances = np.triu(distances, 1) + np.triu(distances, 1).T
    robot = draw(st.integers(0, n - 1))
    is_shut_in = np.array([draw(st.booleans()) if row != robot else False for row in range(n)])
    bounds = shares * costs
    bounds[robot] = costs[robot]
    costs[is_shut_in] = INF
    return costs, bounds, areas, distances, robot


def lazy(bounds, costs):
    """Return costs that are computed when asked for, and the list of those that were."""
    asked = []

    def cost_of(row, target):
        asked.append((row, target))
        return costs[row, target]

    return LazyCosts(bounds, cost_of), asked


@given(teams())
def test_lazy_costs_give_the_same_choice(team):
    costs, bounds, areas, distances, robot = team
    known, asked = lazy(bounds, costs)
    whole = gain_on_tours(
        costs, areas, distances, distances, robot, parameters=ValueParameters(4.0)
    )
    found = gain_on_tours(
        known, areas, distances, distances, robot, parameters=ValueParameters(4.0)
    )
    assert (found.choice, found.rounds) == (whole.choice, whole.rounds)
    assert len(set(asked)) == len(asked)
    assert robot not in {row for row, _ in asked}


def test_costs_that_a_choice_does_not_depend_on_are_not_computed():
    # The other robot takes the two targets at its side; those at this robot's are too far.
    costs, distances = on_a_line([0.0, 20.0], [-6.0, -3.0, 23.0, 26.0])
    known, asked = lazy(np.vstack([costs[0], 0.9 * costs[1]]), costs)
    gain_on_tours(known, [9.0] * 4, distances, distances, 0, parameters=ValueParameters(4.0))
    assert asked == [(1, 2)]
