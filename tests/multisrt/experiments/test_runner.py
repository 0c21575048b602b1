import ctypes
import os
import re
import signal
import sys
import textwrap
import threading
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

import msgspec
import pytest

from multisrt.experiments.crossing import runs
from multisrt.experiments.job import Compiled, Compiling
from multisrt.experiments.mission import make_run
from multisrt.experiments.provenance import provenance
from multisrt.experiments.results import Result
from multisrt.experiments.runner import Progress, cores, job_of, run_experiment
from multisrt.experiments.spec import ExperimentSpec, Limits
from multisrt.experiments.store import Store
from multisrt.experiments.threads import StoppedError
from multisrt.experiments.under_way import JobsUnderWay
from multisrt.experiments.worker import Worker
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.robots.registry import _registry

SPEC = ExperimentSpec(
    name="small", environments=("open",), strategies=("srt-radial",), robots=(1, 2), repetitions=3
)

MISCHIEF = """
    import ctypes, os, re, signal, sys, time
    from pathlib import Path
    import msgspec
    from multisrt.robots.registry import register, strategy
    from multisrt.robots.strategy import Strategy

    class NoOptions(msgspec.Struct, frozen=True):
        pass

    kept = []

    def as_usual(me):
        return strategy("srt-radial").explorer(me, strategy("srt-radial").options())

    def hang(me, options):
        while True:
            pass

    def hang_in_c(me, options):
        re.match("(a*)*b", "a" * 60)

    def eat(me, options):
        kept = []
        while True:
            kept.append(bytearray(1_000_000))

    def crash(me, options):
        ctypes.string_at(0)

    def leave(me, options):
        os._exit(3)

    def die(me, options):
        os.kill(os.getpid(), signal.SIGKILL)

    def die_once(me, options):
        if not Path("died").exists():
            Path("died").touch()
            os.kill(os.getpid(), signal.SIGTERM)
        return as_usual(me)

    def chat(me, options):
        print("something", flush=True)
        os.write(1, b"more\\n")
        sys.__stdout__.write("and more")
        os.write(2, b"x" * 300_000)
        assert sys.stdin.read() == ""
        return as_usual(me)

    def litter(me, options):
        garbage = [bytearray(120_000_000)]
        garbage.append(garbage)
        return as_usual(me)

    def scatter(me, options):
        blocks = [bytearray(60_000) for _ in range(11_000)]
        kept.append(blocks[-1])
        return as_usual(me)

    def compile_one(me, options):
        from uncompiled import double
        assert double(2.0) == 4.0
        return as_usual(me)

    def sleep(me, options):
        Path("asleep").touch()
        time.sleep(1e6)

    odd = (hang, hang_in_c, eat, crash, leave, die, die_once, chat, litter, scatter, sleep)
    for does in (*odd, compile_one):
        name = does.__name__.replace("_", "-")
        register(Strategy(name=name, summary="", options=NoOptions, explorer=does))
"""


@pytest.fixture
def mischief(tmp_path, monkeypatch):
    """Name of a module whose strategies misbehave."""
    (tmp_path / "mischief.py").write_text(textwrap.dedent(MISCHIEF))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    before = set(_registry())
    yield import_module("mischief").__name__
    del sys.modules["mischief"]
    for name in set(_registry()) - before:
        del _registry()[name]


def job(strategy="srt-radial", **limits):
    spec = msgspec.structs.replace(SPEC, strategies=(strategy,), limits=Limits(**limits))
    return job_of(runs(spec)[0], spec)


def but_for_the_computer(result: Result) -> Result:
    return msgspec.structs.replace(result, computing_s=0.0, wall_s=0.0, memory_mb=0.0)


# Running -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_results_do_not_depend_on_the_workers(path, undisturbed):
    one, two = path.with_name("one.sqlite"), path.with_name("two.sqlite")
    for file, workers in ((one, 1), (two, 2)):
        with Store.create_or_open(file, SPEC) as store:
            run_experiment(store, workers=workers)
    with Store.open(one) as first, Store.open(two) as second:
        by_one = [but_for_the_computer(result) for result in first.results()]
        by_two = [but_for_the_computer(result) for result in second.results()]
    assert by_one == by_two
    assert {result.key: result.digest for result in by_one} == undisturbed


@pytest.mark.slow
def test_progress_is_reported_and_stored_runs_skipped(path, undisturbed):
    smaller = msgspec.structs.replace(SPEC, repetitions=2)
    with Store.create_or_open(path, smaller) as store:
        for run in store.missing():
            store.add(make_run(run, SPEC.limits))
    told: list[Progress] = []
    with Store.create_or_open(path, SPEC) as store:
        run_experiment(store, workers=1, progress=told.append)
        assert {result.key: result.digest for result in store.results()} == undisturbed
    assert [(p.done, p.made, p.total, p.failed) for p in told] == [
        (4, 0, 6, 0),
        (5, 1, 6, 0),
        (6, 2, 6, 0),
    ]
    assert (told[0].latest, told[0].per_hour, told[0].left_s) == (None, None, None)
    latest = told[1].latest
    assert latest is not None
    assert latest.condition.robots == 1
    assert told[1].left_s == pytest.approx(told[1].elapsed_s)
    assert told[2].left_s == 0.0


@pytest.mark.slow
@pytest.mark.parametrize(("recordings", "workers"), [("failed", 1), ("none", 0)])
def test_recordings_are_kept_as_specified(path, recordings, workers):
    # With this stop rule two robots finish in time; one robot covers too little until then.
    stop = msgspec.structs.replace(SPEC.stop, max_time_s=200.0)
    spec = msgspec.structs.replace(SPEC, recordings=recordings, stop=stop, repetitions=1)
    with Store.create_or_open(path, spec) as store:
        run_experiment(store, workers=workers)
        one, two = store.results()
        assert (one.status, two.status) == ("out_of_time", "complete")
        wanted = {"failed": [one], "none": []}[recordings]
        files = [store.recording_path(result.key) for result in (one, two)]
    assert [Recording.load(file).footer.digest for file in files if file.exists()] == [
        result.digest for result in wanted
    ]


def test_numbers_of_workers_are_checked(path):
    assert 1 <= cores() <= (os.cpu_count() or 1)
    with Store.create_or_open(path, SPEC) as store:
        with pytest.raises(InvalidInputError, match="at least 0, not -1"):
            run_experiment(store, workers=-1)
        with pytest.raises(InvalidInputError, match="workers or a cluster, not both"):
            run_experiment(store, workers=1, cluster="tcp://localhost:1")


def test_modules_that_cannot_be_imported_are_named(path):
    with (
        Store.create_or_open(path, SPEC) as store,
        pytest.raises(InvalidInputError, match="there is no module 'no_such'"),
    ):
        run_experiment(store, workers=1, modules=["no_such"])


@pytest.mark.slow
def test_an_interrupt_stops_workers_and_keeps_results(path):
    def interrupt(progress):
        if progress.made == 2:
            raise KeyboardInterrupt

    threads = threading.active_count()
    with Store.create_or_open(path, SPEC) as store:
        with pytest.raises(KeyboardInterrupt):
            run_experiment(store, workers=2, progress=interrupt)
        assert store.done == 2
    assert threading.active_count() == threads


@pytest.mark.slow
def test_jobs_contain_environments_from_files(tmp_path):
    hall = tmp_path / "hall.wkt"
    hall.write_text("POLYGON ((0 0, 7.1 0, 7.1 5.3, 3 5.3, 3 4, 0 4, 0 0), (2 1, 3 1, 3 2, 2 1))")
    spec = msgspec.structs.replace(SPEC, environments=("hall.wkt",))
    run = runs(spec, tmp_path)[0]
    here = make_run(run, spec.limits)
    given = job_of(run, spec)
    hall.unlink()
    worker = Worker()
    try:
        assert but_for_the_computer(worker.make(given)) == but_for_the_computer(here)
    finally:
        worker.stop()
    assert here.status == "complete"


# Runs that misbehave -------------------------------------------------------------------------


@pytest.mark.slow
def test_failing_runs_do_not_affect_others(path, mischief):
    spec = ExperimentSpec(
        name="mischief",
        environments=("open",),
        strategies=("srt-radial", "hang", "eat", "crash", "leave", "srt-star"),
        repetitions=1,
        limits=Limits(computing_s=3.0, memory_mb=300),
    )
    with Store.create_or_open(path, spec) as store:
        run_experiment(store, workers=2, modules=[mischief])
        found = {result.condition.strategy: result for result in store.results()}
    assert {name: result.status for name, result in found.items()} == {
        "srt-radial": "complete",
        "hang": "over_time",
        "eat": "over_memory",
        "crash": "crashed",
        "leave": "crashed",
        "srt-star": "complete",
    }
    assert found["hang"].reason == "not done after 3 s of computing"
    assert found["eat"].reason == "wants more than 300 MB"
    assert re.fullmatch(
        r"its process was ended by SIGSEGV \(.*\) \(__init__.py:\d+\)", found["crash"].reason
    )
    assert found["leave"].reason == "its process ended with exit code 3"


@pytest.fixture
def worker(mischief):
    worker = Worker([mischief])
    yield worker
    worker.stop()


@pytest.mark.slow
@pytest.mark.parametrize("workers", [0, 1])
def test_kernels_being_compiled_are_known_meanwhile(path, mischief, tmp_path, monkeypatch, workers):
    (tmp_path / "uncompiled.py").write_text(
        "from multisrt.geometry.numerics.kernel import kernel\n\n"
        "@kernel\ndef double(x):\n    return 2.0 * x\n"
    )
    told = []
    making = JobsUnderWay.making

    @contextmanager
    def overheard(self, job):
        with making(self, job) as tell:

            def both(now):
                tell(now)
                told.append((now, self.compiling()))

            yield both

    monkeypatch.setattr(JobsUnderWay, "making", overheard)
    spec = ExperimentSpec(
        name="compiles", environments=("open",), strategies=("compile-one",), repetitions=1
    )
    with Store.create_or_open(path, spec) as store:
        run_experiment(store, workers=workers, modules=[mischief])
        assert [result.status for result in store.results()] == ["complete"]
    sys.modules.pop("uncompiled", None)
    said = [now for now, _ in told]
    assert Compiled() in said
    compiling = [now for now in said if isinstance(now, Compiling)]
    assert [now.done for now in compiling][:2] == [0, 1]
    assert all(seen == (now if now in compiling else None) for now, seen in told)


@pytest.mark.slow
def test_compiled_code_is_ended_by_the_kernel(worker):
    result = worker.make(job("hang-in-c", computing_s=1.0))
    # Regular expressions handle signals in some versions of Python, in others not.
    assert result.status == "over_time"
    assert result.reason in ("not done after 1 s of computing", "not done after 6 s of computing")
    assert worker.make(job()).status == "complete"


@pytest.mark.slow
def test_output_of_strategies_does_not_disturb_answers(worker):
    assert worker.make(job("chat")).status == "complete"
    pid = worker.pid
    assert worker.make(job("chat")).status == "complete"
    assert worker.pid == pid


@pytest.mark.slow
def test_workers_return_memory_after_runs(worker):
    took_mb = [worker.make(job("litter")).memory_mb for _ in range(20)]
    assert took_mb[-1] - took_mb[0] < 2 * 120.0


@pytest.mark.slow
@pytest.mark.skipif(
    not hasattr(ctypes.CDLL(None), "malloc_trim"), reason="the C library cannot be told to"
)
def test_workers_trim_fragmented_memory(worker):
    much = worker.make(job("scatter")).memory_mb
    # Memory of the run before is not counted again.
    assert worker.make(job()).memory_mb < much - 500.0


@pytest.mark.slow
def test_a_run_is_repeated_if_its_worker_is_killed(worker):
    first = worker.make(job("die-once"))
    assert Path("died").exists()
    assert first.status == "complete"
    assert but_for_the_computer(worker.make(job("die-once"))) == but_for_the_computer(first)


@pytest.mark.slow
def test_a_run_whose_workers_are_always_killed_crashed(worker):
    result = worker.make(job("die"))
    assert result.status == "crashed"
    assert re.fullmatch(
        r"its process was ended by SIGKILL \(Killed.*\), and when it was repeated, "
        r"was ended by SIGKILL \(Killed.*\)",
        result.reason,
    )


@pytest.mark.slow
def test_a_worker_killed_between_runs_is_replaced(worker):
    first = worker.make(job())
    os.kill(worker.pid, signal.SIGKILL)
    assert but_for_the_computer(worker.make(job())) == but_for_the_computer(first)


@pytest.mark.slow
def test_a_worker_killed_at_its_start_is_restarted(worker, tmp_path):
    (tmp_path / "mischief.py").write_text(
        "import os, signal\nfrom pathlib import Path\n"
        "with open('begun', 'a') as file:\n    file.write('x')\n"
        "if Path('begun').stat().st_size < 2:\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    assert worker.make(job()).status == "complete"
    assert (tmp_path / "begun").read_text() == "xx"


@pytest.mark.slow
def test_a_worker_that_never_starts_is_reported(worker, tmp_path):
    (tmp_path / "mischief.py").write_text("import os\nos._exit(1)\n")
    with pytest.raises(InvalidInputError, match=r"before it was ready: .* exit code 1"):
        worker.make(job())


@pytest.mark.slow
def test_a_worker_can_be_stopped_in_the_middle_of_a_run(worker, tmp_path):
    ended = []

    def serve():
        try:
            worker.make(job("sleep"))
        except StoppedError as error:
            ended.append(error)

    thread = threading.Thread(target=serve)
    thread.start()
    while not (tmp_path / "asleep").exists():
        thread.join(0.02)
        assert thread.is_alive()
    worker.stop()
    thread.join(20.0)
    assert len(ended) == 1
    with pytest.raises(StoppedError):
        worker.make(job())


# Provenance and start of workers -------------------------------------------------------------


@pytest.mark.slow
def test_a_worker_of_another_version_is_refused():
    other = msgspec.structs.replace(provenance(), program="0123")
    worker = Worker(expected=other)
    with pytest.raises(InvalidInputError, match="another source of multisrt, 0123 and"):
        worker.make(job())
    assert worker.pid is None


@pytest.mark.slow
def test_a_worker_reports_why_it_cannot_start():
    worker = Worker(["no_such_module"])
    with pytest.raises(InvalidInputError, match="there is no module 'no_such_module'"):
        worker.make(job())


@pytest.mark.slow
def test_local_files_do_not_shadow_libraries(tmp_path, monkeypatch):
    (tmp_path / "queue.py").write_text("raise RuntimeError")
    monkeypatch.chdir(tmp_path)
    worker = Worker()
    try:
        assert worker.make(job()).status == "complete"
    finally:
        worker.stop()


@pytest.mark.slow
def test_unwritable_recordings_end_the_experiment(path):
    spec = msgspec.structs.replace(SPEC, recordings="all")
    with Store.create_or_open(path, spec) as store:
        folder = Path(f"{path}.recordings")
        folder.rmdir()
        with pytest.raises(InvalidInputError, match=r"cannot write .*No such file"):
            run_experiment(store, workers=1)
        assert store.done == 0
        folder.mkdir()
        run_experiment(store, workers=0)
        assert store.done == 6
