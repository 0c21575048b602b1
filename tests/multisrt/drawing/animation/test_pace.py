"""Animation time and run time."""

import math

import pytest

from multisrt.drawing.animation.pace import HOLD_S, Pace
from multisrt.geometry.errors import InvalidInputError


def pace(run_s: float = 100.0, **given) -> Pace:
    return Pace.of(run_s, **{"duration_s": None, "speed": None, "fps": 10.0} | given)


def test_a_run_takes_24_s_or_as_long_as_it_is():
    assert pace().duration_s == 24.0
    assert pace(7.0).duration_s == 7.0
    assert pace(7.0).speed == 1.0


def test_speed_and_duration_are_two_ways_to_say_it():
    assert pace(speed=20.0) == pace(duration_s=5.0)
    with pytest.raises(InvalidInputError, match="not both"):
        pace(speed=20.0, duration_s=5.0)


def test_pictures_count_from_the_start_to_the_end_and_stay():
    found = pace(duration_s=5.0)
    assert (found.last, found.pictures, found.total_s) == (50, 50 + 20 + 1, 5.0 + HOLD_S)
    assert [found.time_s(k) for k in (0, 25, 50, 70)] == [0.0, 50.0, 100.0, 100.0]


def test_what_happens_appears_in_the_next_picture():
    found = pace(duration_s=5.0)  # a picture every 2 s of the run
    assert [found.picture_after(t) for t in (0.0, 0.1, 2.0, 2.1, 100.0, 101.0)] == [
        0, 1, 1, 2, 50, 50,
    ]  # fmt: skip
    assert found.share(50.0) == found.share_of(25) == 2.5 / 7.0


def test_times_of_pictures_are_those_of_pictures_in_spite_of_rounding():
    found = pace(523.73, duration_s=24.0, fps=25.0)
    assert [found.picture_after(found.time_s(k)) for k in range(found.last + 1)] == list(
        range(found.last + 1)
    )


def test_a_run_of_no_duration_is_one_picture():
    found = pace(0.0)
    assert (found.duration_s, found.speed) == (0.5, 0.0)
    assert (found.time_s(3), found.picture_after(0.0), found.share(0.0)) == (0.0, 0, 0.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"duration_s": 0.4}, "duration .* is 0.4; give a number from 0.5 to 600"),
        ({"duration_s": math.nan}, "duration .* is nan"),
        ({"duration_s": math.inf}, "duration .* is inf"),
        ({"speed": 0.0}, "the speed is 0.0; give a positive number"),
        ({"speed": math.nan}, "the speed is nan"),
        ({"speed": 1000.0}, "give a speed from 0.167 to 200"),
        ({"fps": 0.0}, "pictures a second is 0.0; give a number from 1 to 60"),
        ({"fps": 61.0}, "pictures a second is 61.0"),
    ],
)
def test_numbers_out_of_range_are_refused(given, said):
    with pytest.raises(InvalidInputError, match=said):
        pace(**given)
