import itertools
import math
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import msgspec
import pytest
import shapely

from multisrt.analysis.measuring import measure, measure_with_curves
from multisrt.environments.catalog import environment
from multisrt.events import NodeAdded
from multisrt.experiments import limits as limits_module
from multisrt.experiments.crossing import PlannedRun, runs
from multisrt.experiments.mission import make_run, world_of
from multisrt.experiments.spec import ExperimentSpec, Limits, StartsChoice
from multisrt.experiments.store_rows import COLUMNS, result_of, row_of
from multisrt.experiments.worker import THREADS
from multisrt.recording import Recording
from multisrt.robots.registry import _registry
from multisrt.robots.strategy import Strategy
from multisrt.simulation.simulate import simulate
from multisrt.spec import BaseSpec
from tests.multisrt.experiments.results import metrics_of

ENOUGH = Limits(computing_s=60.0, memory_mb=2000)


class NoOptions(msgspec.Struct, frozen=True):
    pass


@pytest.fixture
def register(monkeypatch):
    """Register a strategy that calls a function instead of exploring, for one test."""

    def add(does):
        strategy = Strategy(
            name="probe", summary="", options=NoOptions, explorer=lambda me, options: does()
        )
        monkeypatch.setitem(_registry(), "probe", strategy)
        return planned(strategies=("probe",))

    return add


def planned(**fields: Any) -> PlannedRun:
    given: dict[str, Any] = {
        "name": "test",
        "environments": ("open",),
        "strategies": ("srt-radial",),
    } | fields
    return runs(ExperimentSpec(**given))[0]


# Results -------------------------------------------------------------------------------------


def test_a_run_equals_simulate_and_measure():
    run = planned(robots=(2,), first_seed=3)
    result = make_run(run, ENOUGH)
    recording = simulate(run.spec)
    assert (result.key, result.condition, result.repetition) == (run.key, run.condition, 0)
    assert (result.status, result.reason) == ("complete", recording.footer.reason)
    assert result.digest == recording.footer.digest
    assert result.metrics == measure(recording)
    assert result.computing_s > 0.0
    assert result.wall_s > 0.0
    assert result.memory_mb > 20.0


def test_the_curve_holds_the_time_of_each_percent():
    run = planned(environments=("rooms",), robots=(2,))
    recording = simulate(run.spec)
    metrics, (curve, at_base) = measure_with_curves(recording)
    assert at_base == ()
    assert len(curve) == 101
    assert curve[0] == 0.0
    nodes = recording.of(NodeAdded)
    for percent in (20, 50, 80, 95):
        time = curve[percent]
        assert time is not None
        until, before = (
            shapely.union_all([shapely.Polygon(n.boundary) for n in nodes if reached(n.time_s)])
            for reached in (time.__ge__, time.__gt__)
        )
        share_m2 = percent / 100 * metrics.explorable_area_m2
        tolerance_m2 = 1e-4 * metrics.explorable_area_m2
        assert before.area - tolerance_m2 <= share_m2 <= until.area + tolerance_m2
    assert (curve[90], curve[95], curve[99]) == (
        metrics.time_to_90_s,
        metrics.time_to_95_s,
        metrics.time_to_99_s,
    )
    times = [time for time in curve if time is not None]
    assert all(a <= b for a, b in itertools.pairwise(times))
    assert curve[100] is None or metrics.coverage == 1.0


def test_the_curve_of_a_stopped_run_ends_early():
    run = planned(
        environments=("rooms",),
        stop=msgspec.convert({"max_time_s": 60.0}, type(planned().spec.stop)),
    )
    result = make_run(run, ENOUGH)
    assert result.status == "out_of_time"
    coverage = metrics_of(result).coverage
    assert coverage is not None
    assert 0.0 < coverage < 0.9
    last = math.floor(coverage * 100)
    assert result.covered_at_s[last] is not None
    assert set(result.covered_at_s[last + 1 :]) == {None}


def test_an_environment_is_built_once():
    run = planned(environments=("rooms",))
    assert world_of(run.spec.environment) is world_of(
        planned(environments=("rooms",)).spec.environment
    )


def test_a_run_contains_the_environment_of_a_file(tmp_path):
    path = tmp_path / "hall.wkt"
    path.write_text("POLYGON ((0 0, 7.1 0, 7.1 5.3, 3 5.3, 3 4, 0 4, 0 0), (2 1, 3 1, 3 2, 2 1))")
    run = planned(environments=(str(path),))
    there = make_run(run, ENOUGH)
    path.unlink()
    assert make_run(run, ENOUGH).digest == there.digest != ""


# Failures ------------------------------------------------------------------------------------


def test_impossible_specs_are_refused():
    result = make_run(planned(starts=(StartsChoice(places=((500.0, 500.0),)),)), ENOUGH)
    assert result.status == "refused"
    assert "(500, 500)" in result.reason
    assert (result.metrics, result.digest, result.covered_at_s) == (None, "", ())


def test_exceptions_are_reported_with_their_place(register):
    def fail():
        raise RuntimeError("no such luck")

    result = make_run(register(fail), ENOUGH)
    assert result.status == "error"
    line = fail.__code__.co_firstlineno + 1
    assert result.reason == f"RuntimeError: no such luck (test_mission.py:{line})"


def test_sys_exit_in_a_strategy_is_an_error(register):
    result = make_run(register(lambda: exec("raise SystemExit(4)")), ENOUGH)
    assert result.status == "error"
    assert result.reason.startswith("SystemExit: 4 (")


def test_messages_of_exceptions_become_one_line(register):
    def fail():
        raise RuntimeError("first\n\tsecond \udcff" + "x" * 5000)

    reason = make_run(register(fail), ENOUGH).reason
    assert reason.startswith("RuntimeError: first second ?xxx")
    assert reason.endswith("xxx...")
    assert len(reason) == 1000


def test_metrics_that_are_no_json_are_an_error(monkeypatch):
    def measured(recording, environment, *, horizon_s):
        metrics, curves = measure_with_curves(recording, environment, horizon_s=horizon_s)
        return msgspec.structs.replace(metrics, min_clearance_m=math.inf), curves

    monkeypatch.setattr("multisrt.experiments.mission.measure_with_curves", measured)
    result = make_run(planned(), ENOUGH)
    assert (result.status, result.metrics, result.covered_at_s) == ("error", None, ())
    assert "min_clearance_m" in result.reason


def test_an_interrupt_is_no_failure_of_the_run(register):
    run = register(lambda: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        make_run(run, ENOUGH)


def hang():
    while True:
        try:
            while True:
                math.sqrt(2.0)
        except Exception:
            pass


def test_runs_over_their_time_are_given_up(register):
    result = make_run(register(hang), Limits(computing_s=0.3))
    assert (result.status, result.reason) == ("over_time", "not done after 0.3 s of computing")
    assert 0.25 < result.computing_s < 5.0


def test_a_suppressed_time_limit_is_raised_again(register, monkeypatch):
    monkeypatch.setattr(limits_module, "REPEAT_S", 0.1)
    told = []

    def stubborn():
        try:
            hang()
        except BaseException as error:
            told.append(error)
        hang()

    assert make_run(register(stubborn), Limits(computing_s=0.2)).status == "over_time"
    assert len(told) == 1


@pytest.mark.slow
def test_runs_that_sleep_are_given_up(register, monkeypatch):
    monkeypatch.setattr(limits_module, "MIN_INTERVAL_S", 0.2)
    result = make_run(register(lambda: time.sleep(1e6)), Limits(computing_s=0.2))
    assert (result.status, result.reason) == ("over_time", "did nothing for 0.4 s")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="Linux only")
@pytest.mark.parametrize("wrapped", [False, True])
def test_runs_over_their_memory_are_given_up(register, wrapped):
    def eat():
        kept = []
        try:
            while True:
                kept.append(bytearray(1_000_000))
        except MemoryError as error:
            if not wrapped:
                raise
            raise RuntimeError("something failed") from error

    result = make_run(register(eat), Limits(memory_mb=100))
    assert (result.status, result.reason) == ("over_memory", "wants more than 100 MB")


@pytest.mark.skipif(sys.platform != "linux", reason="a clock of Linux")
def test_the_kernels_limit_is_set_by_the_clock_that_it_counts(monkeypatch):
    soft: dict[int, int] = {}
    monkeypatch.setattr(limits_module, "_set_soft", soft.__setitem__)
    monkeypatch.setattr(limits_module, "charged_s", lambda: 5000.0)  # far ahead of the exact one
    with limits_module.within(Limits(computing_s=2.5)):
        pass
    assert soft[resource.RLIMIT_CPU] == 5000 + 3 + limits_module.GRACE_S


@pytest.mark.skipif(sys.platform != "linux", reason="a clock of Linux")
def test_the_limits_clock_is_that_of_the_profiling_timer():
    def passed(seconds):
        alarms = []
        before = signal.signal(signal.SIGPROF, lambda *_: alarms.append(0))
        begin = limits_module.charged_s()
        signal.setitimer(signal.ITIMER_PROF, seconds)
        while not alarms:
            math.sqrt(2.0)
        signal.signal(signal.SIGPROF, before)
        return limits_module.charged_s() - begin

    assert 0.1 <= passed(0.1) < 0.2


LATE = """
import os, signal
from multisrt.experiments.limits import within
from multisrt.experiments.spec import Limits

late = {signal.SIGPROF, signal.SIGALRM}
signal.pthread_sigmask(signal.SIG_BLOCK, late)
with within(Limits(computing_s=100.0)):
    for number in late:
        os.kill(os.getpid(), number)
    print(signal.sigpending() == late)
signal.pthread_sigmask(signal.SIG_UNBLOCK, late)
print("goes on")
"""
"""Signals that are pending when a run ends, as where a thread that should take them has to wait."""


@pytest.mark.slow
def test_a_signal_that_comes_late_ends_nothing():
    alone = os.environ | dict.fromkeys(THREADS, "1")  # no thread but the one that blocks them
    program = [sys.executable, "-c", LATE]
    ended = subprocess.run(program, env=alone, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout) == (0, "True\ngoes on\n")


def test_limits_end_with_the_run(register):
    def held():
        return (
            [resource.getrlimit(what) for what in (resource.RLIMIT_CPU, resource.RLIMIT_DATA)],
            [signal.getsignal(s) for s in (signal.SIGPROF, signal.SIGALRM, signal.SIGXCPU)],
            [signal.getitimer(t)[0] for t in (signal.ITIMER_PROF, signal.ITIMER_REAL)],
        )

    before = held()
    within = []
    make_run(register(lambda: within.append(held())), ENOUGH)
    make_run(register(hang), Limits(computing_s=0.1))
    assert held() == before
    assert all(a != b for a, b in zip(within[0], before, strict=True))


# Recordings ----------------------------------------------------------------------------------


def test_recordings_are_kept_on_request(tmp_path):
    run, path = planned(), tmp_path / "one.jsonl"
    make_run(run, ENOUGH, path, only_failed=True)
    assert not path.exists()
    result = make_run(run, ENOUGH, path)
    assert Recording.load(path).footer.digest == result.digest


def test_recordings_of_failed_runs_are_kept(tmp_path):
    stop = msgspec.structs.replace(planned().spec.stop, max_time_s=5.0)
    path = tmp_path / "one.jsonl"
    result = make_run(planned(stop=stop), ENOUGH, path, only_failed=True)
    assert result.status == "out_of_time"
    assert Recording.load(path).footer.digest == result.digest


def test_unwritable_recordings_are_an_input_error(tmp_path):
    with pytest.raises(ValueError, match=r"cannot write .*no-such-folder"):
        make_run(planned(), ENOUGH, tmp_path / "no-such-folder" / "one.jsonl")


def test_catalogue_and_mission_build_equal_environments():
    assert world_of(planned().spec.environment) == environment("open")


def test_the_curve_of_what_the_base_station_knew_is_kept():
    run = planned(
        environments=("open",), strategies=("minpos",), robots=(1,), base=BaseSpec(x=3.0, y=3.0)
    )
    result = make_run(run, ENOUGH)
    metrics = result.metrics
    assert metrics is not None
    assert len(result.delivered_at_s) == 101
    assert result.delivered_at_s[90] == metrics.delivered_90_s
    # Nothing is delivered before it was covered.
    for covered, delivered in zip(result.covered_at_s, result.delivered_at_s, strict=True):
        assert delivered is None or (covered is not None and covered <= delivered)
    # A store keeps both; that of a run without a base station looks as before.
    row = row_of(result, 0)
    assert result_of(Path("x"), row, result.success_coverage) == result
    alone = make_run(planned(environments=("open",), strategies=("minpos",), robots=(1,)), ENOUGH)
    assert alone.delivered_at_s == ()
    row = row_of(alone, 0)
    curve = row[COLUMNS.index("covered_at_s")]
    assert msgspec.json.decode(curve, type=tuple[float | None, ...]) == alone.covered_at_s
    assert result_of(Path("x"), row, alone.success_coverage) == alone
