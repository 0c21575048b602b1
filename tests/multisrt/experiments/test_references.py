"""Informed plans of experiments: who shares one, where there is none, and where they are kept."""

import msgspec
import pytest

from multisrt.experiments.crossing import runs
from multisrt.experiments.provenance import provenance
from multisrt.experiments.references import MissingPlans, place_of
from multisrt.experiments.results import Result, Results
from multisrt.experiments.runner import Progress, run_experiment
from multisrt.experiments.store import Store
from multisrt.informed import reference
from multisrt.informed.reference import Reference
from multisrt.run import explore
from tests.multisrt.experiments.results import metrics_of, result_of
from tests.multisrt.experiments.small import HALL, experiment

WORLD = [{"name": "hall", "wkt": HALL}]
SPEC = experiment(
    environments=WORLD,
    strategies=["minpos", "closest"],
    radios=["unlimited", {"range_m": 30.0}],
    starts=[{"places": [[1.0, 1.0, 0.0]]}],
    repetitions=2,
    reference="informed",
)
PLAN = Reference(
    time_to_90_s=10.0,
    time_to_95_s=15.0,
    time_to_99_s=20.0,
    makespan_s=20.0,
    distance_m=8.0,
    coverage=0.995,
)


@pytest.fixture(scope="module")
def measured():
    return msgspec.structs.replace(explore("open", seed=1).metrics, time_to_99_s=30.0)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr(reference, "_folder", lambda: tmp_path / "informed")
    return tmp_path / "informed"


def filled(path, spec, metrics):
    """Return a store in which every run has these metrics."""
    store = Store.create_or_open(path, spec)
    for run in store.missing():
        store.add(result_of(run, metrics=metrics))
    return store


def results_with(plans, metrics, spec=SPEC):
    """Return results of which each has the plan at its place."""
    made = [
        msgspec.structs.replace(result_of(run, metrics=metrics), reference=plan)
        for run, plan in zip(runs(spec), plans, strict=True)
    ]
    return Results(spec, made, len(made), provenance())


def test_runs_from_one_place_share_a_plan(path, measured, cache):
    with filled(path, SPEC, measured) as store:
        plans = MissingPlans(store)
        (job,) = plans.jobs
        assert job.spec.strategy == "informed"
        assert job.spec.robots[0].start == (1.0, 1.0, 0.0)
        plans.add(result_of(job, metrics=msgspec.structs.replace(measured, time_to_99_s=20.0)))
        assert MissingPlans(store).jobs == []
        found = store.results()
        assert [result.over_informed for result in found] == [1.5] * 8
        assert found.unreferenced == {}
    assert len(list(cache.iterdir())) == 1


def test_a_plan_is_kept_for_other_experiments(path, measured):
    with filled(path, SPEC, measured) as store:
        plans = MissingPlans(store)
        plans.add(result_of(plans.jobs[0], metrics=measured))
    with filled(path.with_name("other.sqlite"), SPEC, measured) as store:
        assert MissingPlans(store).jobs == []
        assert {result.over_informed for result in store.results()} == {1.0}


def test_drawn_starts_have_a_plan_each(path, measured):
    spec = experiment(
        environments=WORLD, starts=[{"first": "drawn"}], repetitions=3, reference="informed"
    )
    with filled(path, spec, measured) as store:
        assert len(MissingPlans(store).jobs) == 3 == len({place_of(run.spec) for run in runs(spec)})


def test_cars_and_deaths_have_no_plan(path, measured):
    spec = experiment(
        environments=WORLD,
        robots=[2],
        bodies=["disc:0.25", {"footprint": "disc:0.2", "drive": {"kind": "reeds-shepp"}}],
        faults=["none", {"label": "dies", "faults": [{"fault": "death", "robot": 0, "time_s": 9}]}],
        reference="informed",
    )
    with filled(path, spec, measured) as store:
        (job,) = MissingPlans(store).jobs
        assert job.condition.faults == "none"
        told = {(s.body, s.faults): why for s, why in store.results().unreferenced.items()}
    assert told["disc:0.25", "none"] == "not planned yet"
    assert "survive" in told["disc:0.25", "dies"]
    assert "car" in told["disc:0.2", "none"]
    assert "car" in told["disc:0.2", "dies"]


def test_a_plan_that_fails_is_told_and_made_again_on_request(path, measured):
    with filled(path, SPEC, measured) as store:
        plans = MissingPlans(store)
        plans.add(result_of(plans.jobs[0], "over_time", "too long"))
        assert set(store.results().unreferenced.values()) == {"no informed plan: too long"}
        assert MissingPlans(store).jobs == []
        store.forget()
        assert len(MissingPlans(store).jobs) == 1


def test_plans_are_read_back(path, measured):
    with filled(path, SPEC, measured) as store:
        keys = [run.key for run in store.runs()]
        store.plans.add(keys[:7], PLAN)
        store.plans.add(keys[7:], "why not")
    with Store.open(path) as store:
        assert store.plans.read() == dict.fromkeys(keys[:7], PLAN) | {keys[7]: "why not"}
        assert store.plans.missing() == set()


def test_a_store_without_plans_has_no_references(path, measured):
    with filled(path, msgspec.structs.replace(SPEC, reference="none"), measured):
        pass
    with Store.open(path) as store:
        found = store.results()
        assert found.unreferenced == {}
        assert {result.over_informed for result in found} == {None}
    with Store.create_or_open(path, SPEC) as store:
        assert len(store.plans.missing()) == 8


@pytest.mark.parametrize(
    ("plan", "why"),
    [
        (None, "not planned yet"),
        (msgspec.structs.replace(PLAN, time_to_99_s=None, coverage=0.98), "98.0 %"),
        (msgspec.structs.replace(PLAN, time_to_99_s=0.0), "seen from the starts"),
    ],
)
def test_a_setting_is_compared_with_all_its_plans_or_none(plan, why, measured):
    # The runs of the second setting are those with a radio of 30 m.
    plans = [plan if k == 1 else PLAN for k in range(8)]
    found = results_with(plans, measured)
    (setting,) = found.unreferenced
    assert why in found.unreferenced[setting]
    lacking = found.results[1].condition.radio
    assert setting.radio == lacking
    for result in found:
        assert result.over_informed == (None if result.condition.radio == lacking else 1.5)


def test_a_run_that_never_covered_99_percent_has_no_multiple(measured):
    found = results_with([PLAN] * 8, msgspec.structs.replace(measured, time_to_99_s=None))
    assert {result.over_informed for result in found} == {None}
    assert found.unreferenced == {}


@pytest.mark.slow
def test_an_experiment_makes_runs_and_then_plans(path):
    told: list[Progress] = []
    plain = msgspec.structs.replace(SPEC, radios=("unlimited",), reference="none")
    with Store.create_or_open(path, plain) as store:
        run_experiment(store, workers=0)
        digests = [result.digest for result in store.results()]
    asked = msgspec.structs.replace(plain, reference="informed")
    with Store.create_or_open(path, asked) as store:
        run_experiment(store, workers=1, progress=told.append)
        found = store.results()
    assert [result.digest for result in found] == digests
    assert [(now.what, now.done, now.total) for now in told[-2:]] == [
        ("informed plans", 0, 1),
        ("informed plans", 1, 1),
    ]
    for result in found:
        assert isinstance(result, Result)
        assert result.reference is not None
        assert result.reference.time_to_99_s is not None
        expected = metrics_of(result).time_to_99_s
        assert expected is not None
        assert result.over_informed is not None
        assert result.over_informed * result.reference.time_to_99_s == pytest.approx(expected)
        assert result.over_informed > 1.0
