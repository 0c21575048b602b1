"""Strategies of one's own in experiments: what workers import, and what guards their results."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from importlib import import_module, reload
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import multisrt as ms
from multisrt.experiments.modules import named, worker_references
from multisrt.experiments.provenance import provenance
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from multisrt.experiments.user_source import source_digest
from multisrt.robots.explorer import Done
from multisrt.robots.registry import register, strategy
from multisrt.robots.strategy import Strategy

MINE = '''
    """Strategies for tests."""
    import multisrt as ms
    from multisrt.robots.explorer import Done, Sense

    class Mine:
        """Scans once."""

        def __init__(self, me):
            pass

        def run(self):
            yield Sense()
            yield Done(complete=False, reason="enough")
'''


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, forgotten: None) -> Path:
    """The working directory, from which modules can be imported."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def write(path: str, *parts: str) -> Path:
    file = Path(path)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("".join(textwrap.dedent(part) for part in parts))
    return file


def write_module() -> str:
    write("written.py", MINE)
    return "written"


def of(*strategies: Any) -> ExperimentSpec:
    names = named(list(strategies))
    return ExperimentSpec(
        name="x", environments=("open",), strategies=tuple(names), repetitions=2, recordings="none"
    )


# What workers import -------------------------------------------------------------------------


def test_a_class_is_imported_from_its_file(folder: Path) -> None:
    write("mine.py", MINE)
    assert worker_references(of(import_module("mine").Mine)) == (f"{folder}/mine.py:Mine",)


def test_a_class_in_a_package_is_imported_by_its_module() -> None:
    write("lab/__init__.py", MINE)
    write("lab/deep.py", MINE)
    assert worker_references(of(import_module("lab.deep").Mine)) == ("lab.deep:Mine",)
    assert worker_references(of(import_module("lab").Mine)) == ("lab:Mine",)


def test_a_strategy_is_imported_by_the_name_it_is_bound_to(folder: Path) -> None:
    write("mine.py", MINE, "OWN = ms.Strategy.of(Mine, name='own')\n")
    module = import_module("mine")
    register(module.OWN)
    assert worker_references(of("own", "minpos")) == (f"{folder}/mine.py:OWN",)


def test_a_class_under_another_name_keeps_it_in_workers(folder: Path) -> None:
    write("mine.py", MINE)
    spec = of(Strategy.of(import_module("mine").Mine, name="other"))
    assert worker_references(spec) == (f"{folder}/mine.py:Mine=other",)


def test_what_the_user_names_comes_first(folder: Path) -> None:
    write("mine.py", MINE)
    write("beside.py", "")
    references = worker_references(of(import_module("mine").Mine), ["beside.py", "json"])
    assert references == (f"{folder}/beside.py", "json", f"{folder}/mine.py:Mine")


def test_a_cluster_imports_by_the_names_of_modules() -> None:
    write("mine.py", MINE)
    spec = of(import_module("mine").Mine)
    assert worker_references(spec, by_name=True) == ("mine:Mine",)
    with pytest.raises(ms.InvalidInputError, match=r"workers of a cluster have no mine\.py"):
        worker_references(spec, ["mine.py"], by_name=True)


def test_a_class_within_a_function_cannot_be_imported() -> None:
    class Inside:
        def __init__(self, me: object) -> None:
            pass

        def run(self) -> Any:
            yield Done(complete=False, reason="enough")

    with pytest.raises(ms.InvalidInputError, match=r"defined within a function; .*workers=0"):
        worker_references(of(Inside))


def test_two_strategies_of_one_name_are_told_apart() -> None:
    write("a/__init__.py", MINE)
    write("b/__init__.py", MINE)
    with pytest.raises(ms.InvalidInputError, match="two strategies are called 'mine'"):
        named([import_module("a").Mine, import_module("b").Mine])


def test_python_takes_references_to_files(folder: Path) -> None:
    write("mine.py", MINE)
    assert named(["mine.py:Mine", "mine.py:Mine=other", "minpos"]) == ["mine", "other", "minpos"]
    run = ms.explore("open", strategy="mine.py:Mine", seed=1)
    assert run.spec.strategy == "mine"
    with pytest.raises(ms.InvalidInputError, match="there is no such file"):
        ms.explore("open", strategy="none.py:Mine")


def test_what_explore_registered_may_be_registered() -> None:
    own = import_module(write_module())
    ms.explore("open", strategy=own.Mine, seed=1)
    register(own.Mine)
    assert strategy("mine") == Strategy.of(own.Mine)


def test_an_explorer_that_is_built_is_refused() -> None:
    own = import_module(write_module())
    for use in (
        lambda: ms.explore("open", strategy=own.Mine(None)),
        lambda: ms.compare("open", [own.Mine(None), "minpos"]),
    ):
        with pytest.raises(ms.InvalidInputError, match="give Mine, not one that is built already"):
            use()


def test_a_built_in_name_is_refused() -> None:
    write("mine.py", MINE.replace("Mine", "Closest"))
    with pytest.raises(ms.InvalidInputError, match=r"'closest' already.*Strategy.of\(..., name="):
        named([import_module("mine").Closest])


# The digest of their source ------------------------------------------------------------------


def imported_anew(name: str) -> ModuleType:
    """Return a module, as a new process would import it."""
    for known in list(sys.modules):
        if known.partition(".")[0] in (name.partition(".")[0], "apart"):
            del sys.modules[known]
    return import_module(name)


def digest() -> str:
    register(imported_anew("lab.mine").Mine, replace=True)
    return source_digest(strategy("mine"))


def test_the_digest_follows_what_is_imported_from_own_files() -> None:
    write("lab/__init__.py", "")
    write("lab/mine.py", "from . import beside\nimport numpy\n", MINE)
    write("lab/beside.py", "def f():\n    import apart\n")
    write("apart.py", "X = 1\n")
    write("stranger.py", "X = 1\n")
    first = digest()
    for file in ("lab/beside.py", "apart.py", "lab/mine.py"):
        before = Path(file).read_text()
        write(file, before, "\nY = 2\n")
        assert digest() != first, file
        write(file, before)
    write("stranger.py", "X = 2\n")
    assert digest() == first


def test_comments_docstrings_and_places_do_not_count(folder: Path) -> None:
    write("lab/__init__.py", "")
    write("lab/mine.py", MINE)
    first = digest()
    write("lab/mine.py", "# A comment.\n", MINE.replace("Scans once", "Looks around"))
    assert digest() == first
    write("elsewhere.py", MINE)
    assert source_digest(Strategy.of(import_module("elsewhere").Mine)) == first


def test_results_of_a_changed_strategy_are_not_mixed() -> None:
    write("mine.py", MINE)
    spec = of(import_module("mine").Mine, "closest")
    found = ms.compare(spec, store="x.sqlite", workers=0, progress=False)
    own = {result.reason for result in found.results if result.condition.strategy == "mine"}
    assert own == {"robot 0: enough"}
    write("mine.py", MINE.replace('"enough"', '"quite enough"'))
    register(imported_anew("mine").Mine, replace=True)
    with pytest.raises(ms.InvalidInputError, match="source of 'mine' has changed since 2 of these"):
        Store.create_or_open("x.sqlite", spec)
    with Store.create_or_open("x.sqlite", spec, remake=True) as store:
        assert {run.condition.strategy for run in store.missing()} == {"mine"}
    with Store.create_or_open("x.sqlite", spec) as store:
        assert len(store.missing()) == 2


def test_a_file_that_changed_since_its_import_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    write("mine.py", "import beside\n", MINE)
    write("beside.py", "X = 1\n")
    spec = of(import_module("mine").Mine)
    write("beside.py", "X = 1000\n")
    with pytest.raises(ms.InvalidInputError, match=r"beside\.py has changed since it was imported"):
        Store.create_or_open("x.sqlite", spec)
    assert not Path("x.sqlite").exists()


def test_a_change_is_told_without_a_store_and_compiled_files(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    write("mine.py", "from beside import X\n", MINE)
    write("beside.py", "X = 1\n")
    mine = import_module("mine")
    ms.compare("open", mine.Mine, seeds=1, workers=0, progress=False)
    write("beside.py", "X = 2\n")
    for workers in (0, 1):
        with pytest.raises(ms.InvalidInputError, match=r"beside\.py has changed since it was"):
            ms.compare("open", mine.Mine, seeds=1, workers=workers, progress=False)
    reload(import_module("beside"))
    with pytest.raises(ms.InvalidInputError, match=r"beside was imported again since mine\.py"):
        ms.compare("open", mine.Mine, seeds=1, workers=0, progress=False)
    old = mine.Mine
    reload(mine)
    ms.compare("open", mine.Mine, seeds=1, workers=0, progress=False)
    with pytest.raises(
        ms.InvalidInputError, match="'mine', is of an earlier import of mine: import"
    ):
        ms.compare("open", old, seeds=1, workers=0, progress=False)


def test_classes_that_are_made_in_a_loop_are_of_one_import() -> None:
    made = textwrap.indent(textwrap.dedent(MINE).partition("import multisrt as ms\n")[2], "    ")
    write("mine.py", f"OWN = []\nfor _ in range(2):\n{made}    OWN += [Mine]\n")
    first, second = import_module("mine").OWN
    assert source_digest(Strategy.of(first)) == source_digest(Strategy.of(second))


@pytest.mark.slow
def test_a_comparison_does_not_differ_by_workers() -> None:
    write("mine.py", "import beside\n", MINE.replace('"enough"', "beside.REASON"))
    for reason in ("one", "two"):
        write("beside.py", f"REASON = {reason!r}\n")
        for workers in (0, 1):
            found = ms.compare("open", "mine.py", seeds=1, workers=workers, progress=False)
            assert [result.reason for result in found.results] == [f"robot 0: {reason}"]


def test_a_store_needs_strategies_from_files(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = ModuleType("cell")
    monkeypatch.setitem(sys.modules, "cell", cell)
    exec(textwrap.dedent(MINE), vars(cell))
    with pytest.raises(ms.InvalidInputError, match="'mine' is in no file, and results in a store"):
        ms.compare("open", cell.Mine, store="x.sqlite")
    assert not list(Path().glob("x.sqlite*"))


# Runs ----------------------------------------------------------------------------------------


def test_this_process_makes_runs_of_any_strategy() -> None:
    class Inside:
        def __init__(self, me: object) -> None:
            pass

        def run(self) -> Any:
            yield Done(complete=False, reason="enough of it")

    found = ms.compare("open", Inside, seeds=2, workers=0, progress=False)
    assert ["enough of it" in result.reason for result in found.results] == [True, True]


def test_an_imported_module_makes_no_runs() -> None:
    write("mine.py", MINE, "ms.compare('open', Mine, seeds=1)\n")
    with pytest.raises(ms.InvalidInputError, match="mine runs an experiment when it"):
        ms.compare("open", "minpos", imports=["mine"], progress=False)


def run(script: str, folder: Path) -> tuple[str, str]:
    """Return what a script prints, started in another folder, and its last line of errors."""
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, cwd=folder, check=False
    )
    return done.stdout, (done.stderr.strip().splitlines() or [""])[-1]


@pytest.mark.slow
def test_workers_import_what_a_script_and_its_neighbour_define(folder: Path) -> None:
    write("far/mine.py", MINE)
    local = MINE.replace("Mine", "Local").replace("enough", "local")
    compare = (
        "found = ms.compare('open', [Local, Mine], seeds=1, workers=1)\n"
        "    print(*(result.reason for result in found.results))"
    )
    guarded = f"if __name__ == '__main__':\n    {compare}\n"
    script = str(write("far/script.py", "from mine import Mine\n", local, guarded).resolve())
    out, err = run(script, folder)
    assert (out, err) == ("robot 0: local robot 0: enough\n", "")
    write("far/script.py", "from mine import Mine\n", local, f"if True:\n    {compare}\n")
    out, err = run(script, folder)
    assert out == ""
    assert "'local' cannot be imported by worker processes: it is defined in script.py" in err


@pytest.mark.slow
def test_workers_say_what_they_do_not_know() -> None:
    write("mine.py", MINE, "def build(me, options):\n    return Mine(me)\n")
    module = import_module("mine")
    register(
        Strategy(
            name="odd",
            summary="Is bound to no name",
            options=strategy("closest").options,
            explorer=module.build,
        )
    )
    with pytest.raises(ms.InvalidInputError, match=r"a worker has no strategy 'odd' after import"):
        ms.compare("open", "odd", seeds=1, workers=1, progress=False)

    class Inside:
        def __init__(self, me: object) -> None:
            pass

        def run(self) -> Any:
            yield Done(complete=False, reason="enough")

    told = r"'inside' after importing json; .* cannot be imported .*: Inside is defined within a f"
    told = told.replace("Inside", r"\S*Inside")
    with pytest.raises(ms.InvalidInputError, match=told):
        ms.compare("open", Inside, seeds=1, workers=1, imports=["json"], progress=False)


def test_a_provenance_without_own_strategies_stays_readable() -> None:
    assert provenance().strategies == {}
