"""Strategies of one's own on the command line: references, --import, and what needs neither."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from multisrt.spec import CatalogEnvironment, RunSpec
from tests.multisrt.cli.commands import Call

MINE = '''"""Strategies for tests."""
import msgspec
from multisrt.robots.explorer import Done, Sense


class Options(msgspec.Struct, frozen=True, kw_only=True):
    """How to look.

    Attributes
    ----------
    scans : int
        How often to look.
    """

    scans: int = 1


class Mine:
    """Looks around, and stays."""

    def __init__(self, me, options: Options):
        self.options = options

    def run(self):
        for _ in range(self.options.scans):
            yield Sense()
        yield Done(complete=False, reason="enough")
'''

TINY = """
name = "tiny"
environments = ["pillar.wkt"]
strategies = ["mine", "closest"]
repetitions = 1
recordings = "none"
"""


@pytest.fixture(autouse=True)
def mine(folder: Path, forgotten: None) -> Path:
    """A file with a strategy."""
    file = folder / "mine.py"
    file.write_text(MINE)
    return file


def test_a_strategy_in_place_of_the_environment_explores(call: Call, folder: Path) -> None:
    code, out, _ = call("explore", "mine.py:Mine", "--robots", "2", "--option", "scans=2")
    assert code == 3
    assert out.startswith("no environment is named: apartment is explored; for another: multisrt ")
    assert "explore ENV --strategy mine.py:Mine\nmine in apartment, 2 robots, seed 0" in out
    assert (folder / "runs" / "apartment-mine-0" / "spec.toml").exists()


def test_own_and_built_in_strategies_run_side_by_side(call: Call, folder: Path) -> None:
    words = ("--strategy", "mine.py", "--strategy", "closest", "--out", "o")
    code, out, _ = call("explore", "room.wkt", *words)
    assert code == 3
    assert "no environment" not in out
    assert sorted(path.name for path in (folder / "o").iterdir()) == ["closest", "mine"]
    spec = json.loads((folder / "o" / "mine" / "run.json").read_text())["spec"]
    assert spec["strategy"] == "mine"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["mine.py:Mine", "--strategy", "closest"], "mine.py:Mine is a strategy: name an env"),
        (["room.wkt", "--strategy", "mine.py", "--strategy", "mine:Mine"], "mine is given twice"),
        (["room.wkt", "--strategy", "mine.py:Mien"], "did you mean 'Mine'?"),
        (["room.wkt", "--strategy", "mine"], "'mine' (did you mean 'mine.py'?)"),
        (["room.wkt", "--strategy", "yours"], "is imported by --import FILE.py"),
        (["room.wkt", "--import", "none.py"], "none.py: there is no such file"),
        (["none.py:Mine"], "none.py: there is no such file"),
        (["mine.py:Mine", "--option", "scan=2"], "mine has no option 'scan' (did you mean 'scans'"),
    ],
)
def test_what_is_wrong_is_told_before_anything_is_written(
    call: Call, folder: Path, words: list[str], told: str
) -> None:
    code, out, err = call("explore", *words)
    assert (code, out) == (2, "")
    assert told in err
    assert "Traceback" not in err
    assert not (folder / "runs").exists()


def test_a_run_is_repeated_from_its_spec_with_the_import(call: Call, folder: Path) -> None:
    text = RunSpec(environment=CatalogEnvironment(name="open"), strategy="mine").to_toml()
    (folder / "mine.toml").write_text(text)
    told = "error: mine.toml: the strategy 'mine' is not known here: import the file that has it, "
    assert call("explore", "--spec", "mine.toml") == (2, "", f"{told}--import mine.py\n")
    call("explore", "room.wkt", "--strategy", "mine.py:Mine", "--out", "first", "--quiet")
    words = ("explore", "--spec", "first/spec.toml", "--import", "mine.py", "--out", "again")
    assert call(*words, "--quiet")[0] == 3
    first, again = (
        json.loads((folder / name / "run.json").read_text()) for name in ("first", "again")
    )
    assert first["digest"] == again["digest"]


def test_a_recording_is_explained_with_and_without_the_import(call: Call) -> None:
    call("explore", "room.wkt", "--strategy", "mine.py:Mine", "--out", "o", "--quiet")
    told = call("why", "o/recording.jsonl")
    assert told == call("why", "o/recording.jsonl", "--import", "mine.py")
    assert "Traceback" not in "".join(map(str, told))


def test_options_of_an_own_strategy_are_listed(call: Call) -> None:
    code, out, _ = call("strategies", "mine.py:Mine")
    assert code == 0
    assert out.startswith("mine: Looks around, and stays\n")
    assert re.search(r"scans\s+1\s+How often to look", out)


@pytest.mark.slow
def test_an_experiment_with_an_own_strategy_runs_and_reports(
    call: Call, folder: Path, mine: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "tiny.toml").write_text(TINY)
    run = ("experiment", "run", "tiny.toml", "--workers", "0", "--quiet")
    assert "is imported by --import FILE.py" in call(*run)[2]
    assert call(*run, "--import", "mine.py") == (3, "", "")
    mine.write_text(MINE.replace('"enough"', '"quite enough"'))
    code, _, err = call(*run, "--import", "mine.py")
    assert code == 2
    assert "the source of 'mine' has changed since 1 of these runs were made" in err
    assert call(*run, "--import", "mine.py", "--remake") == (3, "", "")

    assert call("report", "tiny.sqlite", "--quiet", "--import", "mine.py")[0] == 0
    page = (folder / "report" / "index.html").read_text()
    assert len(list((folder / "report" / "gallery").iterdir())) == 2
    command = re.search(r"multisrt (explore --spec \S+ --import \S+) --out again", page)
    assert command is not None
    assert str(folder) not in page
    assert "multisrt experiment run experiment.toml --import mine.py:Mine</code>" in page
    assert re.search(r"<dt>source of mine</dt><dd>[0-9a-f]{16}</dd>", page)
    assert "has changed since" not in page
    mine.write_text(MINE)
    code, out, err = call("report", "tiny.sqlite", "--import", "mine.py")
    assert (code, out) == (0, "report/index.html: 2 of 2 runs\n")
    assert err.startswith("warning: The source of the strategy 'mine' has changed since these ")
    page = (folder / "report" / "index.html").read_text()
    assert "The source of the strategy &#39;mine&#39; has changed since" in page
    assert len(list((folder / "report" / "gallery").iterdir())) == 1
    monkeypatch.chdir(folder / "report")
    assert call(*command[1].split(), "--out", "again", "--quiet")[0] == 3


@pytest.mark.slow
def test_an_unknown_strategy_costs_a_report_its_own_pictures(
    call: Call, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import multisrt as ms
    from multisrt.robots import registry

    spec = ms.ExperimentSpec.from_toml(TINY)
    known = registry._registry()
    ms.compare(spec, store="tiny.sqlite", workers=0, imports=["mine.py"], progress=False)
    del known["mine"]
    code, _, err = call("report", "tiny.sqlite")
    assert code == 0
    assert err.startswith("warning: The strategy 'mine' is not known here, and its runs are not")
    assert [path.suffix for path in (folder / "report" / "gallery").iterdir()] == [".svg"]
    page = (folder / "report" / "index.html").read_text()
    assert "Not drawn:" in page
    assert page.count("there is no strategy &#39;mine&#39;") == 2
    assert "No command repeats it here:" in page
    assert "imported by --import FILE.py" in page


def test_an_explorer_that_raises_is_one_line(call: Call, folder: Path) -> None:
    (folder / "boom.py").write_text(
        "from multisrt.robots.explorer import Sense\n"
        "class Boom:\n"
        "    def __init__(self, me): pass\n"
        "    def run(self):\n"
        "        yield Sense()\n"
        "        raise RuntimeError('boom')\n"
    )
    code, out, err = call("explore", "boom.py:Boom", "--quiet")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "it raised RuntimeError: boom (boom.py:6, in run: raise RuntimeError('boom'))" in err
    assert "see what 'multisrt check boom.py:Boom' says of it" in err


# Folders, and other things in the place of a file -----------------------------------------------


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["check", "adir"],
            "adir is a folder; name the file of the strategy in it, such as adir/m",
        ),
        (["explore", "pillar.wkt", "--strategy", "adir"], "name the file of the strategy in it"),
        (["strategies", "adir"], "adir is a folder; name the file of the strategy in it"),
        (["report", "adir"], "adir is a folder; name the file of results in it (.sqlite)"),
        (["experiment", "run", "adir"], "adir is a folder; name the file in it (.toml)"),
        (["why", "mine.py"], "mine.py is not a recording: its first line is no header; name the"),
        (["strategy", "new", "minpos.py"], "(on the command line --name my-minpos)"),
        (
            ["explore", "pillar.wkt", "--option", "frontier_bais=1"],
            "(did you mean 'frontier_bias'?)",
        ),
        (["explore", "pillar.wkt", "--option", "xyz=1"], "'multisrt strategies srt-radial' lists"),
    ],
)
def test_what_is_given_instead_is_told(call: Call, folder: Path, words: list[str], said: str):
    (folder / "adir").mkdir()
    (folder / "adir" / "mine.py").write_text(MINE)
    code, out, err = call(*words)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


LATE = MINE.replace("import Done, Sense", "import Done, Note, Sense").replace(
    "            yield Sense()\n",
    "            yield Sense()\n            yield Note(MapComplete(time_s=9.0, robot=0))\n",
)


def test_a_defect_names_the_line_and_the_checker(call: Call, folder: Path):
    (folder / "late.py").write_text("from multisrt.events import MapComplete\n" + LATE)
    code, _, err = call("explore", "pillar.wkt", "--strategy", "late.py")
    assert code == 2
    assert "has time_s=9 at 0 s (late.py:" in err
    assert "also TimedOut" in err
    assert err.endswith("next: multisrt check late.py:Mine\n")


def test_a_check_that_is_piped_prints_no_progress(call: Call):
    code, out, err = call("check", "mine.py", "--world", "pillar.wkt", "--robots", "1")
    assert code == 0
    assert "keeps to the contract" in out
    assert err == ""


def test_the_check_of_an_experiment_looks_at_its_results(call: Call, folder: Path):
    (folder / "tiny.toml").write_text(TINY.replace('["mine", "closest"]', '["closest"]'))
    assert call("experiment", "run", "tiny.toml", "--workers", "0", "--quiet")[0] in (0, 3)
    code, out, _ = call("experiment", "check", "tiny.toml", "--seconds", "0")
    assert code == 0
    assert "1 of them are stored in tiny.sqlite" in out
    (folder / "tiny.toml").write_text(TINY.replace('["mine", "closest"]', '["minpos"]'))
    code, _, err = call("experiment", "check", "tiny.toml", "--seconds", "0")
    assert code == 2
    assert "tiny.sqlite: holds another experiment" in err
    assert "choose another file (--store on the command line, store=... in Python)" in err
    other = call("experiment", "check", "tiny.toml", "--seconds", "0", "--store", "other.sqlite")
    assert other[0] == 0
    assert "experiment run tiny.toml --store other.sqlite" in other[1]
