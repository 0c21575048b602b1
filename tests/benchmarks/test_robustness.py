import pytest

from benchmarks.robustness import kind_of

BOXED_IN = "boxed in by others, which do not give way"
IN_THE_WAY = "others, which do not answer, stand in the way to some m of frontier"


@pytest.mark.parametrize(
    ("reason", "kind"),
    [
        ("robot 0: boxed in by robot 2, which does not give way", BOXED_IN),
        ("all robots: boxed in by robots 0, 1 and 12, which do not give way", BOXED_IN),
        (
            "all others: boxed in by robot 2, which does not give way; robot 2 died",
            f"{BOXED_IN}; others died",
        ),
        (
            "robot 2: robot 1, which does not answer, stands in the way to 1.5 m of frontier",
            IN_THE_WAY,
        ),
        (
            "robot 1: robots 0 and 2, which do not answer, stand in the way to 3.0 m of frontier",
            IN_THE_WAY,
        ),
        (
            "robot 2: boxed in by robot 0, which does not give way; "
            "robot 3: boxed in by robots 0 and 2, which do not give way",
            BOXED_IN,
        ),
    ],
)
def test_reasons_are_counted_without_numbers_and_robots(reason, kind):
    assert kind_of(reason) == kind
