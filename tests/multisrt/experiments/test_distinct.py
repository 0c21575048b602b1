"""Repetitions that are one run: made once, stored for each."""

import msgspec
import pytest

from multisrt.experiments.crossing import runs
from multisrt.experiments.distinct import Twins, copied, twin_key
from multisrt.experiments.mission import make_run
from multisrt.experiments.runner import Progress, run_experiment
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.experiments.results import result_of
from tests.multisrt.experiments.small import experiment

# One robot starts where the environment suggests, and `closest` draws nothing.
SPEC = ExperimentSpec(
    name="small", environments=("open",), strategies=("closest", "srt-radial"), repetitions=5
)


def test_twins_differ_by_their_seed_alone():
    once = {twin_key(run) for run in runs(experiment(repetitions=3))}
    assert len(once) == 1
    for said in (
        {"environments": [{"name": "rooms", "seed": "repetition"}]},
        {"starts": [{"first": "drawn"}]},
        {"robots": [2], "faults": [{"label": "one", "deaths": 1}]},
    ):
        assert len({twin_key(run) for run in runs(experiment(repetitions=3, **said))}) == 3


def test_of_twins_the_first_is_made_first(path):
    with Store.create_or_open(path, SPEC) as store:
        twins = Twins(store)
        assert twins.copies() == []
        first = twins.next_batch()
        assert [(run.condition.strategy, run.repetition) for run in first] == [
            ("closest", 0),
            ("srt-radial", 0),
        ]
        for run in first:
            store.add(result_of(run, chance=run.condition.strategy != "closest"))
        copies = twins.copies()
        assert [(c.condition.strategy, c.repetition, c.same_as) for c in copies] == [
            ("closest", k, 0) for k in range(1, 5)
        ]
        for copy in copies:
            store.add(copy)
        rest = twins.next_batch()
        assert [(run.condition.strategy, run.repetition) for run in rest] == [
            ("srt-radial", k) for k in range(1, 5)
        ]


def test_runs_that_cannot_have_twins_do_not_wait(path):
    spec = experiment(environments=[{"name": "rooms", "seed": "repetition"}], repetitions=4)
    with Store.create_or_open(path, spec) as store:
        assert len(Twins(store).next_batch()) == 4


def test_a_crash_says_nothing_of_its_twins(path):
    with Store.create_or_open(path, experiment(repetitions=4)) as store:
        twins = Twins(store)
        (first,) = twins.next_batch()
        store.add(result_of(first, "crashed"))
        assert twins.copies() == []
        assert len(store.missing()) == 3
        # The next one is made alone: it may crash as well, or decide what the others are.
        (second,) = twins.next_batch()
        assert (first.repetition, second.repetition) == (0, 1)
        store.add(result_of(second, "over_memory"))
        (third,) = twins.next_batch()
        store.add(result_of(third, chance=False))
        assert [(copy.repetition, copy.same_as) for copy in twins.copies()] == [(3, 2)]


def test_after_a_crash_twins_by_chance_do_not_wait_again(path):
    with Store.create_or_open(path, experiment(repetitions=5)) as store:
        first, second, third, *_ = store.runs()
        store.add(result_of(first, "crashed"))
        assert [run.repetition for run in Twins(store).next_batch()] == [1]
        store.add(result_of(second, chance=True))
        assert [run.repetition for run in Twins(store).next_batch()] == [2, 3, 4]
        store.add(result_of(third, "crashed"))
        assert [run.repetition for run in Twins(store).next_batch()] == [3, 4]


@pytest.mark.slow
def test_a_run_without_chance_is_made_once(path):
    told: list[Progress] = []
    with Store.create_or_open(path, SPEC) as store:
        run_experiment(store, workers=2, progress=told.append)
        assert (store.done, store.failed, store.missing()) == (10, 0, [])
        results = store.results()
    same = [result for result in results if result.condition.strategy == "closest"]
    drawn = [result for result in results if result.condition.strategy == "srt-radial"]
    assert [result.same_as for result in same] == [None, 0, 0, 0, 0]
    assert [result.same_as for result in drawn] == [None] * 5
    assert len({result.key for result in results}) == 10
    assert len({result.digest for result in same}) == 1
    assert len({result.digest for result in drawn}) == 5
    assert all(result.metrics == same[0].metrics for result in same)
    assert [result.computing_s > 0.0 for result in same] == [True, False, False, False, False]
    assert (told[-1].done, told[-1].made, told[-1].failed) == (10, 6, 0)
    # The program says the same of another seed, but for the digest, which includes the seed.
    run = next(run for run in runs(SPEC) if run.key == same[3].key)
    again = make_run(run, SPEC.limits)
    assert again.metrics is not None
    assert again.to_horizon(same[3].horizon_s or 0.0).metrics == same[3].metrics


@pytest.mark.slow
def test_later_repetitions_are_copies_too(path):
    with Store.create_or_open(path, msgspec.structs.replace(SPEC, repetitions=1)) as store:
        for run in store.missing():
            store.add(make_run(run, SPEC.limits))
    told: list[Progress] = []
    spec = msgspec.structs.replace(SPEC, repetitions=3)
    with Store.create_or_open(path, spec) as store:
        run_experiment(store, workers=0, progress=told.append)
        assert told[-1].made == 2
        found = [r for r in store.results() if r.condition.strategy == "closest"]
    assert [(r.repetition, r.same_as) for r in found] == [(0, None), (1, 0), (2, 0)]


def test_copies_follow_a_new_first_seed(path):
    late = experiment(repetitions=2, first_seed=3)
    with Store.create_or_open(path, late) as store:
        first, second = store.runs()
        made = result_of(first, chance=False, horizon_s=7.5)
        store.add(made)
        store.add(copied(made, second))
        assert [r.same_as for r in store.results()] == [None, 0]
    with Store.create_or_open(path, experiment(repetitions=5, first_seed=0)) as store:
        assert [(r.repetition, r.same_as) for r in store.results()] == [(3, None), (4, 3)]
        assert [r.chance for r in store.results()] == [False, False]


def test_a_horizon_that_cannot_be_reached_is_refused(path):
    spec = experiment(strategies=["closest"], horizon_s=50.0)
    with Store.create_or_open(path, spec) as store:
        store.add(make_run(store.missing()[0], spec.limits, horizon_s=50.0))
        (found,) = store.results()
        assert found.horizon_s == 50.0
    with pytest.raises(InvalidInputError, match=r"integrals of 1 .* from horizon_s = 50.0 to None"):
        Store.create_or_open(path, experiment(strategies=["closest"]))
    with Store.create_or_open(path, spec) as store:
        assert store.done == 1


def test_a_horizon_may_be_added_after_the_end(path):
    spec = experiment(strategies=["closest"])
    with Store.create_or_open(path, spec) as store:
        store.add(make_run(store.missing()[0], spec.limits))
    for horizon_s in (1000.0, 2000.0, None):
        said = {} if horizon_s is None else {"horizon_s": horizon_s}
        with Store.create_or_open(path, experiment(strategies=["closest"], **said)) as store:
            (found,) = store.results()
            assert found.metrics is not None
            assert found.horizon_s == (horizon_s or found.metrics.makespan_s)
