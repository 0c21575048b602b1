"""Strategies by reference: files, modules, and what is wrong with them."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

import multisrt as ms
from multisrt.robots import registry
from multisrt.robots.loading import import_reference, is_reference, load_strategy
from multisrt.robots.user_modules import outdated

MINE = '''"""Strategies for tests."""
from multisrt.robots.explorer import Done

class Mine:
    """Ends at once."""

    def __init__(self, me):
        pass

    def run(self):
        yield Done(complete=False, reason="{reason}")
'''


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, forgotten: None) -> Path:
    """The working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(path: str, text: str = MINE, **said: str) -> Path:
    file = Path(path)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text.replace("{reason}", said.get("reason", "stays")))
    return file


def reason_of(reference: str) -> str:
    made = load_strategy(reference)
    built = made.explorer(None, made.options())  # type: ignore[arg-type]
    return str(next(built.run()).reason)  # type: ignore[union-attr]


def refused(reference: str) -> str:
    with pytest.raises(ms.InvalidInputError) as error:
        load_strategy(reference)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("reference", ["mine.py:Mine", "mine.py", "mine:Mine", "mine"])
def test_a_class_is_loaded_from_a_file_or_a_module(reference: str) -> None:
    write("mine.py")
    made = load_strategy(reference)
    assert (made.name, made.summary) == ("mine", "Ends at once")


def test_a_class_in_a_package_is_loaded_by_its_module() -> None:
    write("lab/__init__.py", "")
    write("lab/deep.py")
    assert load_strategy("lab.deep:Mine").name == "mine"


def test_a_strategy_goes_before_the_classes_of_its_file() -> None:
    write("mine.py", MINE + "\nimport multisrt as ms\nOWN = ms.Strategy.of(Mine, name='own')\n")
    assert load_strategy("mine.py").name == "own"
    assert load_strategy("mine.py:Mine").name == "mine"


def test_one_of_several_must_be_named() -> None:
    write("mine.py", MINE + "\nclass Other(Mine):\n    pass\n")
    told = refused("mine.py")
    assert told == "mine.py has several strategies; name one: mine.py:Mine, mine.py:Other"


def test_a_file_can_import_what_is_beside_it() -> None:
    write("far/beside.py", "REASON = 'from beside'\n")
    write("far/mine.py", "import beside\n" + MINE, reason="{x}")
    write("far/mine.py", "import beside\n" + MINE.replace('"{reason}"', "beside.REASON"))
    assert reason_of("far/mine.py") == "from beside"


def test_files_of_the_same_stem_do_not_mix() -> None:
    write("a/mine.py", reason="a")
    write("b/mine.py", reason="b")
    assert [reason_of("a/mine.py"), reason_of("b/mine.py"), reason_of("a/mine.py")] == list("aba")


def test_a_file_does_not_shadow_a_library() -> None:
    write("json.py", reason="mine")
    write("wave.py", reason="mine, too")
    assert [reason_of("json.py"), reason_of("wave.py")] == ["mine", "mine, too"]
    import wave

    assert hasattr(wave, "open")


def test_a_file_is_imported_again_only_if_it_changed() -> None:
    write("mine.py", reason="old")
    first = load_strategy("mine.py")
    assert load_strategy("./mine.py").explorer.__wrapped__ is first.explorer.__wrapped__  # type: ignore[attr-defined]
    write("mine.py", reason="new")
    assert reason_of("mine.py") == "new"


def test_a_file_that_is_imported_otherwise_is_not_outdated() -> None:
    write("mine.py", reason="old")
    load_strategy("mine.py")
    module = sys.modules["mine"]
    assert not outdated(module)
    write("mine.py", reason="new, and longer")
    assert outdated(module) == "mine.py has changed since it was imported here"
    assert not outdated(importlib.reload(module))


def test_a_file_is_imported_again_with_what_changed_beside_it() -> None:
    text = "import beside\n" + MINE.replace('"{reason}"', "beside.REASON")
    write("far/mine.py", text)
    write("far/other.py", text.replace("import beside", "import apart\nfrom apart import beside"))
    write("far/apart.py", "import beside\n")
    for reason in ("one", "two", "six"):  # of one size, within a second
        write("far/beside.py", f"REASON = {reason!r}\n")
        assert [reason_of("far/mine.py"), reason_of("far/other.py")] == [reason, reason]
    kept = sys.modules["apart"], sys.modules["beside"]
    write("far/other.py", text)
    assert reason_of("far/other.py") == "six"
    assert (sys.modules["apart"], sys.modules["beside"]) == kept


def test_a_module_in_a_package_is_imported_again() -> None:
    write("lab/__init__.py", "")
    write("mine.py", "from lab import deep\n" + MINE.replace('"{reason}"', "deep.REASON"))
    for reason in ("one", "two"):
        write("lab/deep.py", f"REASON = {reason!r}\n")
        assert reason_of("mine.py") == reason


def test_what_an_explorer_imports_late_is_imported_again() -> None:
    text = MINE.replace("        yield", "        import beside\n        yield")
    write("mine.py", text.replace('"{reason}"', "beside.REASON"))
    for reason in ("one", "two"):
        write("beside.py", f"REASON = {reason!r}\n")
        assert reason_of("mine.py") == reason


def test_what_others_imported_is_not_imported_again() -> None:
    write("mine.py", "import beside\n" + MINE)
    write("beside.py", "X = 1\n")
    sys.path.append(str(Path.cwd()))
    beside = importlib.import_module("beside")
    load_strategy("mine.py")
    write("beside.py", "X = 2\n")
    assert refused("mine.py").startswith("beside.py has changed since it was imported here: start")
    importlib.reload(beside)
    assert load_strategy("mine.py").name == "mine"


def test_a_failed_import_leaves_nothing_beside_it_imported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    write("beside.py", "REASON = 'one'\n")
    write("mine.py", "import beside\nraise ValueError\n")
    assert "ValueError" in refused("mine.py")
    write("beside.py", "REASON = 'two'\n")
    write("mine.py", "import beside\n" + MINE.replace('"{reason}"', "beside.REASON"))
    assert reason_of("mine.py") == "two"


def test_a_failed_import_leaves_nothing_in_a_known_package(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(str(Path.cwd()))
    Path("lab").mkdir()
    write("lab/__init__.py", "")
    importlib.import_module("lab")
    write("lab/deep.py", "REASON = 'one'\n")
    write("mine.py", "from lab import deep\nraise ValueError\n")
    assert "ValueError" in refused("mine.py")
    write("lab/deep.py", "REASON = 'two'\n")
    write("mine.py", "from lab import deep\n" + MINE.replace('"{reason}"', "deep.REASON"))
    assert reason_of("mine.py") == "two"


def test_a_script_is_imported_without_its_main_part() -> None:
    write("mine.py", MINE + "\nif __name__ == '__main__':\n    raise SystemExit(1)\n")
    assert load_strategy("mine.py").name == "mine"


def test_a_class_gets_another_name_in_a_reference() -> None:
    write("mine.py", MINE + "\nimport multisrt as ms\nOWN = ms.Strategy.of(Mine, name='own')\n")
    assert load_strategy("mine.py:Mine=other-one").name == "other-one"
    assert "is a Strategy and has its own name, 'own'" in refused("mine.py:OWN=other")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("def broken(:\n", "mine.py is not Python: invalid syntax (mine.py:1)"),
        ("\n\nx = unknown\n", "cannot import mine.py: NameError: name 'unknown' is not defined"),
        ("import missing_library\n", "ModuleNotFoundError: No module named 'missing_library' ("),
        ("raise SystemExit('over')\n", "cannot import mine.py: SystemExit: over (mine.py:1)"),
        ("x = 1\n", "mine.py has no strategy: neither a Strategy nor a class with a method 'run'"),
    ],
)
def test_a_file_that_cannot_be_used_is_told_in_a_line(text: str, told: str) -> None:
    write("mine.py", text)
    assert told in refused("mine.py")
    assert "mine" not in sys.modules or "no strategy" in told


def test_the_place_of_an_error_is_told_within_the_file() -> None:
    write("mine.py", "import json\n\njson.loads('{')\n")
    assert refused("mine.py:Mine").endswith("(mine.py:3)")


@pytest.mark.parametrize(
    ("reference", "told"),
    [
        ("none.py:Mine", "none.py: there is no such file"),
        ("mine.py:Mien", "mine.py has no 'Mien' (did you mean 'Mine'?); it has: Mine"),
        ("there.is.none:Mine", "there is no module 'there.is.none' in the working directory"),
        ("folder:Mine", "'folder' is a folder without __init__.py"),
        (":Mine", "'' names no module; a reference is FILE.py"),
    ],
)
def test_a_reference_that_leads_nowhere_is_told(reference: str, told: str) -> None:
    write("mine.py")
    write("folder/readme.txt")
    assert told in refused(reference)


def test_importing_registers_what_does_not_register_itself() -> None:
    write("mine.py")
    write("other.py", MINE.replace("Mine", "Other") + "import multisrt as ms\nms.register(Other)\n")
    assert [each.name for each in import_reference("mine.py")] == ["mine"]
    assert import_reference("other.py") == ()
    assert {"mine", "other"} <= {each.name for each in ms.strategies()}


def test_importing_a_changed_file_replaces_its_strategies() -> None:
    write("mine.py", reason="old")
    import_reference("mine.py")
    write("mine.py", reason="new")
    import_reference("mine.py")
    made = registry.strategy("mine")
    built = made.explorer(None, made.options())  # type: ignore[arg-type]
    assert next(built.run()).reason == "new"  # type: ignore[union-attr]


def test_names_of_strategies_are_no_references() -> None:
    assert not any(is_reference(each.name) for each in ms.strategies())
    assert not is_reference("maps/hall.wkt")
    assert is_reference("a/b.py:Mine")


def test_a_run_without_yield_is_told() -> None:
    write("mine.py", MINE.replace("yield Done", "return Done"))
    assert "Mine.run yields nothing, and is to be a generator" in refused("mine.py")


def test_a_default_of_another_type_is_told() -> None:
    options = """
import msgspec

class Options(msgspec.Struct, frozen=True):
    leg_s: float = "one"
    pause_s: float = 1

"""
    write("mine.py", options + MINE.replace("(self, me)", "(self, me, options: Options)"))
    said = refused("mine.py")
    assert "the default of Options.leg_s is 'one', which is not as declared" in said
    assert "Expected a number, got text" in said
