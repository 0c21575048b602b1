import importlib

import msgspec
import pytest

from multisrt.cli.source import strategies_in
from multisrt.robots.loading import candidates_in
from multisrt.robots.strategy import as_strategy
from multisrt.validation_errors import allowed_words, written

OPTIONS = """
from typing import Literal, Optional
import msgspec

Kind = Literal["near", "far"]

class Options(msgspec.Struct, frozen=True):
    kind: Kind = "near"
    limit: "float | None" = None
    fast: bool = True
    count: int
"""
OF_OPTIONS = {
    "kind": ("near", ("near", "far")),
    "limit": ("none", ("none",)),
    "fast": ("true", ("true", "false")),
    "count": ("", ()),
}


@pytest.fixture
def written_as(tmp_path):
    """A function that writes files, and returns what is read of the last."""

    def write(**files):
        for name, text in files.items():
            path = tmp_path / f"{name}.py"
            path.write_text(f"raise SystemExit\n{text}")
        return strategies_in(str(path))

    return write


@pytest.mark.parametrize(
    "module",
    [
        "multisrt.robots.toolkit.templates.rule",
        "multisrt.robots.toolkit.templates.planner",
        "multisrt.robots.toolkit.templates.explorer",
        "multisrt.informed.registration",
    ],
)
def test_what_is_read_is_what_importing_would_give(module):
    known = {
        name: as_strategy(value)
        for name, value in candidates_in(importlib.import_module(module)).items()
    }
    read = strategies_in(module)
    assert {name: own.name for name, own in read.items()} == {
        name: strategy.name for name, strategy in known.items()
    }
    for name, strategy in known.items():
        options = {
            key: (option.default, sorted(option.words))
            for key, option in read[name].options.items()
        }
        assert options == {
            field.name: (written(field.default), sorted(allowed_words(field.type)))
            for field in msgspec.structs.fields(strategy.options)
        }


@pytest.mark.parametrize(
    "code",
    [
        "class Mine:\n def __init__(self, me, options: Options): ...\n def run(self): ...",
        "class Mine:\n def __init__(self, me, options: 'Options'): ...\n def run(self): ...",
        "class Mine:\n Options = Options\n def run(self): ...",
        "class _Base:\n def __init__(self, me, o: Options): ...\n"
        "class Mine(_Base):\n def run(self): ...",
        "from multisrt import Strategy\ndef make(me, o: Options): ...\nMine = Strategy.of(make)",
        "import multisrt as ms\nMine = ms.Strategy(name='m', options=Options, explorer=print)",
        "import multisrt as ms\ndef make(me, o): ...\nMine = ms.Strategy.of(make, options=Options)",
    ],
)
@pytest.mark.parametrize("at", ["here", "beside", "beside, in a package"])
def test_options_are_found_as_strategies_find_them(written_as, code, at):
    if at == "here":
        read = written_as(mine=f"{OPTIONS}\n{code}")
    elif at == "beside":
        read = written_as(base=OPTIONS, mine=f"from base import Options\n{code}")
    else:
        read = written_as(base=OPTIONS, mine=f"from .base import Options as O\nOptions = O\n{code}")
    assert list(read) == ["Mine"]
    assert read["Mine"].options == OF_OPTIONS


@pytest.mark.parametrize(
    ("code", "name"),
    [
        ("class NearestFirst:\n def run(self): ...", "nearest-first"),
        ("from multisrt.robots import toolkit\n@toolkit.assignment\ndef my_rule(): ...", "my-rule"),
        ("import multisrt as ms\nmade = ms.Strategy.of(Some, name='other-name')", "other-name"),
        ("import multisrt as ms\nNAME = 'far'\nmade = ms.Strategy.of(Some, name=NAME)", "far"),
        ("import multisrt as ms\nmade = ms.Strategy.of(Some, name=NAME.lower())", ""),
        ("import multisrt as ms, b\nmade = ms.Strategy.of(b.SomeOther)", "some-other"),
        ("import multisrt as ms\nmade = ms.Strategy.of(SomeOther)", "some-other"),
        ("from multisrt.envs import policy_strategy as p\nmade = p('learned', None)", "learned"),
    ],
)
def test_strategies_have_the_names_that_they_would_have(written_as, code, name):
    assert [own.name for own in written_as(mine=code).values()] == [name]


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ("class Mine(", []),
        (
            "A = A | None\nclass O(O): a: A = 1\n"
            "class Mine(Mine):\n Options = O\n def run(self): ...",
            [],
        ),
        ("class Mine:\n __init__ = object.__init__\n def run(self): ...", ["mine"]),
        ("import multisrt as ms\nMine = ms.Strategy.of(Mine)", []),
        ("import multisrt as ms\nMine = ms.Strategy.of()", [""]),
        ("from mine import Mine as Mine\nfrom mine import Options\nclass Other(Mine): ...", []),
        ("\0", []),
    ],
)
def test_files_that_make_no_sense_are_read_to_no_end(written_as, code, names):
    read = written_as(mine=code)
    assert [own.name for own in read.values()] == names
    assert all(own.options.keys() <= {"a"} for own in read.values())


def test_a_path_is_of_the_folder_that_is_current(tmp_path, monkeypatch):
    for name in ("First", "Second"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mine.py").write_text(f"class {name}:\n def run(self): ...")
        monkeypatch.chdir(tmp_path / name)
        assert list(strategies_in("mine.py")) == [name]


def test_what_is_no_strategy_is_not_offered(written_as):
    code = (
        "import enum\nclass Kind(enum.Enum): A = 1\nclass _Own:\n def run(self): ...\ndef f(): ..."
    )
    assert written_as(mine=f"{OPTIONS}\n{code}\nx = 5") == {}
    assert strategies_in("none.py") == strategies_in("no_module_of_this_name") == {}
