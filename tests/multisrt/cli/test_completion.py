import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from multisrt import cli
from multisrt.cli.completion import SHELLS, WHERE, Bash, Fish, Zsh
from multisrt.environments.catalog import names
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from tests.multisrt.experiments.results import result_of

ROOT = Path(__file__).parents[3]


def completed(shell, line, monkeypatch):
    """Return what a shell is told when the tab key is pressed at the end of a line."""
    words = line.split(" ")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", words[-1] if shell is Fish else str(len(words) - 1))
    monkeypatch.setenv("COMP_WORDBREAKS", " \t\n\"'><=;|&(:")
    return shell(cli.cli, {}, "multisrt", "_MULTISRT_COMPLETE").complete().splitlines()


@pytest.mark.parametrize(
    ("line", "values"),
    [
        ("multisrt wh", ["why"]),
        ("multisrt explore mu", ["museum"]),
        ("multisrt explore o", ["office", "open"]),
        ("multisrt environments show ho", ["hospital"]),
        ("multisrt explore mazes-30/2", [f"mazes-30/{number}" for number in range(20, 30)]),
        ("multisrt explore office --strategy srt-r", ["srt-radial"]),
        ("multisrt explore office --strategy minpos --strategy mi", []),
        ("multisrt strategies mi", ["minpos"]),
        ("multisrt explore office --stra", ["--strategy"]),
        ("multisrt explore office --drive re", ["reeds-shepp"]),
        ("multisrt explore office --option alp", ["alpha="]),
        ("multisrt explore office --strategy minpos --option sha", ["shape="]),
        ("multisrt explore office --strategy minpos --strategy srt-star --option sha", []),
        ("multisrt explore office --strategy minpos --option shape=s", ["star"]),
        ("multisrt explore office --option approach=", ["true", "false"]),
        ("multisrt explore office --option=approach=f", ["false"]),
        ("multisrt explore office --option d_min_m=n", ["none"]),
        ("multisrt explore office --set wid", ["width_m="]),
        ("multisrt explore office --set fur", ["furnished="]),
        ("multisrt explore office --set furnished=", ["true", "false"]),
        ("multisrt explore office --set=furnished=f", ["false"]),
        ("multisrt explore office --set d", ["door_m=", "difficulty="]),
        ("multisrt explore office --set door_m=1 --set d", ["difficulty="]),
        ("multisrt explore office --set width_m=", []),
        ("multisrt explore open --set ", ["size_m=", "columns=", "seed="]),
        ("multisrt explore dungeon --set diff", ["difficulty="]),
        ("multisrt explore museum --set ", []),
        ("multisrt explore --set ", []),
        ("multisrt environments show maze --set ce", ["cells="]),
        ("multisrt environments check maze --set se", ["seed="]),
        ("multisrt explore office --robot sp", ["speed="]),
        ("multisrt explore office --robot speed=1,dr", ["1,drive="]),
        ("multisrt explore office --robot drive=du", ["dubins"]),
        ("multisrt explore office --fault si", ["silence:"]),
        ("multisrt reproduce al", ["alvarez"]),
        ("multisrt experiment new a.toml --like al", ["alvarez"]),
        ("multisrt completion f", ["fish"]),
        ("multisrt check srt-s", ["srt-star"]),
        ("multisrt check minpos --world mu", ["museum"]),
        ("multisrt check minpos --option sha", ["shape="]),
        ("multisrt check minpos --option shape=s", ["star"]),
    ],
)
def test_bash_completes_the_word_after_its_breaks(monkeypatch, folder, line, values):
    found = completed(Bash, line, monkeypatch)
    plain = [text.removeprefix("plain,") for text in found if text.startswith("plain,")]
    assert plain == values


def test_every_world_is_completed(monkeypatch, folder):
    found = completed(Bash, "multisrt explore ", monkeypatch)
    assert found == [f"plain,{name}" for name in names()]


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        ("multisrt explore ./ro", "file"),
        ("multisrt explore office --spec sp", "file"),
        ("multisrt why ru", "file"),
        ("multisrt explore office --out ru", "dir"),
        ("multisrt report results.sqlite --out re", "dir"),
    ],
)
def test_files_and_folders_are_left_to_the_shell(monkeypatch, folder, line, kind):
    (found,) = completed(Bash, line, monkeypatch)
    assert found.partition(",")[0] == kind


@pytest.mark.parametrize(
    ("line", "values"),
    [
        ("multisrt check m", ["minpos", "mine.py", "more/"]),
        ("multisrt check mine.py:", ["Mine", "Other"]),
        ("multisrt explore mine.py:M", ["Mine"]),
        ("multisrt explore office --strategy more/", ["more/one.py"]),
        ("multisrt explore office --strategy mine.py:O", ["Other"]),
        ("multisrt explore office --import mi", ["mine.py"]),
        ("multisrt explore office --import mine.py:O", ["Other"]),
        ("multisrt report mine.sqlite --import ", ["mine.py", "more/"]),
        ("multisrt explore none.py:", []),
        ("multisrt experiment run m", ["mine.toml", "more/"]),
        ("multisrt report m", ["mine.sqlite", "more/"]),
    ],
)
def test_files_are_completed_by_what_is_in_them(monkeypatch, folder, line, values):
    (folder / "more").mkdir()
    for name in ("mine.toml", "mine.sqlite", "more/one.py", "more/one.txt"):
        (folder / name).touch()
    (folder / "mine.py").write_text(
        "raise SystemExit\nclass _Own: ...\nclass Options(Struct): ...\nclass Mine:\n"
        "    def run(self): ...\nclass Other(Mine): ...\n"
    )
    assert completed(Bash, line, monkeypatch) == [f"plain,{value}" for value in values]


OWN = """
raise SystemExit("nothing of it may run")
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.toolkit import assignment

class Options(FrontierOptions, frozen=True, kw_only=True):
    weight: float = 2.0
    pick: Literal["near", "far"] | None = None

@assignment
def nearest(costs, robot): ...

weighted = assignment(nearest, name="by-weight", options=Options)
"""


@pytest.mark.parametrize(
    ("line", "values"),
    [
        ("explore office --strategy own.py:", ["nearest", "weighted"]),
        ("explore office --strategy own.py:weighted --option wei", ["weight="]),
        ("explore office --strategy own.py:weighted --option pick=", ["near", "far", "none"]),
        ("explore office --strategy own.py:weighted --option sha", ["shape="]),
        ("explore office --strategy own.py:nearest --option wei", []),
        ("explore office --strategy own.py:nearest --option shape=b", ["ball"]),
        ("explore own.py:weighted --option wei", ["weight="]),
        ("check own.py:weighted=mine --option wei", ["weight="]),
        ("explore office --import own.py --strategy by-", ["by-weight"]),
        ("explore office --import own.py --strategy by-weight --option wei", ["weight="]),
        ("explore office --strategy minpos --strategy own.py:weighted --option wei", []),
        # Several are in the file: none is meant.
        ("explore office --strategy own.py --option wei", []),
        ("explore office --strategy none.py --option wei", []),
    ],
)
def test_options_of_own_files_are_completed(monkeypatch, folder, line, values):
    (folder / "own.py").write_text(OWN)
    found = completed(Bash, f"multisrt {line}", monkeypatch)
    assert [text.removeprefix("plain,") for text in found] == values


def test_the_baseline_of_a_report_is_one_of_its_strategies(monkeypatch, folder):
    spec = ExperimentSpec(
        name="x", environments=("open",), strategies=("minpos", "greedy"), repetitions=1
    )
    with Store.create_or_open("x.sqlite", spec) as store:
        for run in (store.runs()[0], store.runs()[-1]):
            store.add(result_of(run, "crashed"))
    before = sorted(folder.iterdir())
    line = "multisrt report x.sqlite --baseline "
    assert completed(Bash, line, monkeypatch) == ["plain,minpos", "plain,greedy"]
    assert completed(Bash, line.replace("x.", "y."), monkeypatch) == []
    assert sorted(folder.iterdir()) == before


def test_own_maps_are_completed_beside_worlds(monkeypatch, folder):
    (folder / "office.yaml").write_text("image: office.png")
    found = completed(Bash, "multisrt explore off", monkeypatch)
    assert found == ["plain,office", "plain,office.yaml"]


def test_zsh_and_fish_are_told_whole_words_and_summaries(monkeypatch, folder):
    line = "multisrt explore office --option=approach=f"
    assert completed(Zsh, line, monkeypatch) == ["plain", "--option=approach=false", "_"]
    assert completed(Fish, line, monkeypatch) == ["plain,--option=approach=false"]
    line = "multisrt explore --strategy minp"
    summary = "Each robot goes to the frontier to which the fewest others are nearer"
    assert completed(Zsh, line, monkeypatch) == ["plain", "minpos", summary]
    assert completed(Fish, line, monkeypatch) == [f"plain,minpos\t{summary}"]


@pytest.mark.parametrize("shell", SHELLS)
def test_scripts_say_where_they_belong(call, shell):
    code, out, err = call("completion", shell)
    assert (code, err) == (0, "")
    assert out.startswith(WHERE[shell])
    assert f"multisrt completion {shell}" in WHERE[shell]
    assert f"_MULTISRT_COMPLETE={shell}_complete" in out
    assert "%(" not in out
    if (program := shutil.which(shell)) is not None:
        subprocess.run([program, "-n"], input=out, text=True, check=True)


@pytest.mark.slow
def test_completion_imports_no_kernels():
    code = (
        "import sys; from multisrt import cli\n"
        "from multisrt.cli.completion import Bash\n"
        "made = Bash(cli.cli, {}, 'multisrt', '_MULTISRT_COMPLETE')\n"
        "print('KEY' in made.complete(), {'numba', 'scipy', 'numpy'} & set(sys.modules))"
    )
    for line, key in (
        ("multisrt explore office --strategy srt-ball --option al", "alpha="),
        ("multisrt explore office --set wi", "width_m="),
    ):
        done = subprocess.run(
            [sys.executable, "-c", code.replace("KEY", key)],
            cwd=ROOT,
            env=os.environ | {"COMP_WORDS": line},
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout == "True set()\n"


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_bash_itself_completes(call, folder):
    _, script, _ = call("completion", "bash")
    program = folder / "multisrt"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m multisrt "$@"\n')
    program.chmod(0o755)
    ask = (
        "compopt() { :; }\n"
        'COMP_LINE="multisrt explore office --option approach=f" COMP_POINT=43\n'
        f'_multisrt_completion {program}\necho "${{COMPREPLY[@]}}"\n'
    )
    done = subprocess.run(
        ["bash", "--norc", "-c", script + ask],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "false\n"
