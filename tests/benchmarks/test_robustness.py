import pandas as pd
import pytest

from benchmarks.robustness import is_right, kind_of, latest, page

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


def results(*, delivered, status="complete"):
    row = {
        "environment": "open",
        "strategy": "relays",
        "status": status,
        "reason": "robot 1: boxed in by robot 2, which does not give way",
        "collisions": 0,
        "min_distance_between_robots_m": 0.125,
        "coverage": 0.75,
        "lost_area_m2": 2.0,
        "delivered_coverage": delivered,
    }
    return pd.DataFrame([row, row])


def test_what_is_delivered_is_told_where_there_is_a_base_station():
    lines = "\n".join(page(results(delivered=0.5), "robustness_returning")).splitlines()
    assert lines[0].startswith("# Teams that return data")
    assert "examples/robustness_returning.toml" in lines[2]
    [row] = [line for line in lines if line.startswith("| relays")]
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert cells == ["relays", "2", "2", "0", "0", "0", "0.125", *["0.750"] * 3, "0.500", "2.0"]
    assert lines[-1] == "None."
    plain = page(results(delivered=float("nan")), "robustness")
    assert "elivered" not in "".join(plain)


def test_runs_that_do_not_end_are_not_right():
    assert is_right(results(delivered=0.5, status="stalled"))
    assert not is_right(results(delivered=0.5, status="out_of_time"))
    reasons = page(results(delivered=0.5, status="out_of_time"), "robustness")
    assert f"| relays | out_of_time | {BOXED_IN} | 2 |" in reasons[-1]


def test_of_a_strategy_in_several_tables_the_last_counts():
    old, new = results(delivered=0.5), results(delivered=0.25)
    other = results(delivered=1.0).assign(strategy="worth")
    found = latest([pd.concat([old, other]), new])
    assert found["strategy"].tolist() == ["relays", "relays", "worth", "worth"]
    assert found["delivered_coverage"].tolist() == [0.25, 0.25, 1.0, 1.0]
