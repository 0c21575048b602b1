import pytest

import multisrt as ms
from multisrt.explain.conditions import conditions, deaths
from multisrt.replay.labels import with_labels
from multisrt.replay.payload import payload
from multisrt.spec import Death, DriveSpec, LateStart, RangeFinderSpec, Silence, StopRule
from tests.multisrt.replay.staged import staged

WORLD = ms.CatalogEnvironment(name="open")
TWO = (ms.RobotSpec(), ms.RobotSpec())


def test_what_differs_between_robots_is_told_by_robot():
    car = ms.RobotSpec(
        footprint="box:0.5x0.3",
        drive=DriveSpec(kind="dubins", turning_radius_m=0.4),
        range_finder=RangeFinderSpec(range_m=6.0, beams=181),
    )
    assert conditions(ms.RunSpec(environment=WORLD, robots=(*TWO, car))) == [
        "3 robots",
        "scattered starts",
        "radio unlimited",
        "range finder 4 m (robots 0, 1); range finder 6 m, 181 beams (robot 2)",
        "body disc:0.25 (robots 0, 1); body box:0.5x0.3 (robot 2)",
        "differential drive, 0.5 m/s (robots 0, 1); "
        "dubins drive, 0.5 m/s, turning radius 0.4 m (robot 2)",
    ]


@pytest.mark.parametrize(
    ("radio", "said"),
    [
        (ms.RadioSpec(range_m=12.5, walls="block"), "radio 12.5 m, walls block it"),
        (ms.RadioSpec(range_m=9.0, walls="weaken"), "radio 9 m, walls weaken its signal"),
        (
            ms.RadioSpec(multi_hop=False, latency_s=0.5, jitter_s=0.1, loss=0.25),
            "radio unlimited, no relays, latency 0.5 s, jitter 0.1 s, loss 25 %",
        ),
    ],
)
def test_the_radio_in_words(radio, said):
    assert conditions(ms.RunSpec(environment=WORLD, robots=TWO, radio=radio))[2] == said


def test_options_faults_and_limits_in_words():
    spec = ms.RunSpec(
        environment=WORLD,
        strategy="srt-radial",
        options={"no_place_after": 3},
        robots=TWO,
        faults=(
            Death(robot=1, time_s=60.0, when="moving"),
            Silence(robot=0, time_s=20.0, duration_s=30.0),
            LateStart(robot=1, time_s=5.0),
        ),
        stop=StopRule(max_time_s=90.0),
    )
    assert conditions(spec)[-5:] == [
        "no_place_after = 3",
        "robot 1 starts at 5 s",
        "the radio of robot 0 fails at 20 s for 30 s",
        "robot 1 dies at 60 s while it moves",
        "at most 90 s",
    ]


def test_deaths_that_happened():
    assert deaths(staged()) == ["robot 2 died at 20.0 s"]


def packed(title, *given):
    return {"title": title, "conditions": list(given)}


def test_labels_have_what_differs():
    runs = [
        packed("minpos", "2 robots", "radio 8 m"),
        packed("closest", "3 robots", "radio 8 m"),
        packed("minpos", "2 robots", "radio 12 m", "x = 1"),
    ]
    labels = [run["label"] for run in with_labels(runs)]
    assert labels == ["minpos, radio 8 m", "closest", "minpos, radio 12 m, x = 1"]


def test_labels_of_equal_runs_are_numbered():
    runs = [packed("minpos", "a"), packed("minpos", "a", "b"), packed("minpos", "a")]
    labels = [run["label"] for run in with_labels(runs)]
    assert labels == ["minpos, run 1", "minpos, b", "minpos, run 3"]
    both = payload([staged()] * 2)["runs"]
    assert [run["label"].rsplit(", ", 1)[1] for run in both] == ["run 1", "run 2"]
