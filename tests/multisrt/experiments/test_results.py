"""Success, horizons of integrals, and what results say of themselves."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

import multisrt as ms
from multisrt.analysis.metrics import Metrics
from multisrt.experiments.crossing import Condition, runs
from multisrt.experiments.measures import MEASURES, measure_named
from multisrt.experiments.mission import make_run
from multisrt.experiments.provenance import provenance
from multisrt.experiments.results import Result, Results, Status
from multisrt.experiments.spec import ExperimentSpec, Limits
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.experiments.results import metrics_of
from tests.multisrt.experiments.small import experiment


@pytest.fixture(scope="module")
def measured() -> Metrics:
    return ms.explore("open", strategy="closest").metrics


def result(
    measured: Metrics, strategy: str = "a", status: Status = "complete", **metrics: object
) -> Result:
    return Result(
        key=f"{strategy}-{metrics}",
        condition=Condition(environment="w", strategy=strategy, robots=1),
        repetition=0,
        status=status,
        reason="done",
        metrics=msgspec.structs.replace(measured, **metrics),
    )


def judged(*found: Result, **said: object) -> list[Result]:
    return list(Results(experiment(**said), found, len(found), provenance()))


# Success -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("status", "coverage", "collisions", "success"),
    [
        ("complete", 0.95, 0, True),
        ("complete", 0.94, 0, False),
        ("stalled", 0.96, 0, True),
        ("out_of_time", 0.96, 0, True),
        ("complete", 1.0, 1, False),
    ],
)
def test_success_is_what_was_covered(measured, status, coverage, collisions, success):
    made = result(measured, "a", status, coverage=coverage, collisions=collisions)
    assert (made.success, made.failed) == (success, not success)
    for measure in MEASURES:
        if measure.lower_is_better and measure.of(made) is not None:
            (value,) = measure.values([made])
            assert value == (measure.of(made) if success else float("inf"))


def test_the_experiment_sets_the_threshold(measured):
    made = result(measured, coverage=0.9)
    assert [each.success for each in judged(made)] == [False]
    assert [each.success for each in judged(made, success_coverage=0.9)] == [True]
    assert measure_named("success").values(judged(made, success_coverage=0.9)) == [1.0]


def test_a_run_that_was_not_measured_is_no_success(measured):
    made = msgspec.structs.replace(result(measured, "a", "crashed"), metrics=None)
    assert not made.success
    assert made.account == "done"
    assert measure_named("success").values([made]) == [0.0]


def test_what_is_no_success_says_what_it_left(measured):
    left = {"not reachable": 2.0, "too narrow": 3.25}
    made = result(measured, coverage=0.5, seen=0.625, given_up_m2=left)
    told = "covered 50.0 %, seen 62.5 %; left: 2.0 m2 not reachable, 3.2 m2 too narrow; done"
    assert made.account == told
    assert measure_named("given_up_m2").of(made) == 5.25
    assert result(measured).account == "done"
    assert result(measured, collisions=1).account == "collided: done"


# Horizons ------------------------------------------------------------------------------------


def test_integrals_of_a_setting_run_to_its_longest_run(measured):
    # After 10 s half is left: 10 s more add 5 s, and 3 m2 that one robot knows add 30 m2 s.
    short = result(
        measured,
        makespan_s=10.0,
        coverage=0.5,
        coverage_integral_s=7.0,
        known_to_one_m2=3.0,
        known_to_one_m2s=11.0,
    )
    long = result(measured, "b", makespan_s=20.0, coverage=1.0, coverage_integral_s=9.0)
    elsewhere = msgspec.structs.replace(
        result(measured, makespan_s=90.0),
        condition=Condition(environment="v", strategy="a", robots=1),
    )
    one, two, other = judged(short, long, elsewhere)
    assert [each.horizon_s for each in (one, two, other)] == [20.0, 20.0, 90.0]
    assert metrics_of(one).coverage_integral_s == pytest.approx(12.0)
    assert metrics_of(one).known_to_one_m2s == pytest.approx(41.0)
    assert metrics_of(two).coverage_integral_s == 9.0
    # The order or a second time makes no difference.
    assert judged(one, two, other) == [one, two, other]


def test_a_horizon_is_the_same_for_all_settings(measured):
    made = result(measured, makespan_s=10.0, coverage=0.75, coverage_integral_s=7.0)
    (later,) = judged(made, horizon_s=50.0)
    assert later.horizon_s == 50.0
    assert metrics_of(later).coverage_integral_s == pytest.approx(17.0)
    with pytest.raises(InvalidInputError, match="measure it with that horizon"):
        judged(made, horizon_s=5.0)


@given(st.floats(0.0, 1e4), st.floats(0.0, 1e4))
def test_horizons_can_be_moved_there_and_back(measured, first_s, second_s):
    made = result(
        measured, makespan_s=10.0, coverage=0.25, coverage_integral_s=8.0, known_to_one_m2=2.0
    )
    there = made.to_horizon(10.0 + first_s)
    again = there.to_horizon(10.0 + second_s)
    straight = made.to_horizon(10.0 + second_s)
    assert again.horizon_s == straight.horizon_s
    for name in ("coverage_integral_s", "known_to_one_m2s"):
        value = getattr(metrics_of(straight), name)
        assert getattr(metrics_of(again), name) == pytest.approx(value)


@pytest.mark.parametrize("horizon_s", [100.0, 500.0])
def test_a_horizon_is_measured_from_the_recording(horizon_s):
    # Before the end of the run it is measured; after it, it agrees with the continuation.
    spec = ExperimentSpec(name="x", environments=("open",), strategies=("closest",))
    run = runs(spec)[0]
    to_its_end = make_run(run, Limits())
    made = make_run(run, Limits(), horizon_s=horizon_s)
    assert made.horizon_s == horizon_s
    own, cut = metrics_of(to_its_end), metrics_of(made)
    assert 100.0 < own.makespan_s < 500.0
    if horizon_s > own.makespan_s:
        cut_off = metrics_of(to_its_end.to_horizon(horizon_s))
        assert cut.coverage_integral_s == pytest.approx(cut_off.coverage_integral_s)
        assert cut.known_to_one_m2s == pytest.approx(cut_off.known_to_one_m2s)
    else:
        assert 0.0 < cut.coverage_integral_s < own.coverage_integral_s
        # At most everything was left all the time.
        assert cut.coverage_integral_s < horizon_s


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("success_coverage", 1.5),
        ("success_coverage", 0.0),
        ("success_coverage", float("nan")),
        ("horizon_s", -1.0),
        ("horizon_s", 0.0),
        ("horizon_s", float("nan")),
        ("horizon_s", float("inf")),
        ("horizon_s", 1e6),
    ],
)
def test_thresholds_and_horizons_are_checked(field, value):
    for build in (
        lambda: ExperimentSpec(name="x", **{field: value}),
        lambda: ExperimentSpec.from_toml(f'name = "x"\n{field} = {value}'),
        lambda: ms.compare("open", "closest", **{field: value}),
    ):
        with pytest.raises(InvalidInputError, match=f"^(not an exp.*)?{field} is ") as error:
            build()
        told = str(error.value)
        assert f", not {value:g}" in told
        assert "\n" not in told
