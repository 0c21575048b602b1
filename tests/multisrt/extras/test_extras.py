"""One rule for packages that are not installed."""

import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import multisrt as ms
from multisrt.extras import EXTRAS, MODULES, MissingExtraError, extra

ROOT = Path(__file__).parents[3]
OPTIONAL = [MODULES.get(package, package) for packages in EXTRAS.values() for package in packages]


@pytest.fixture
def bare(monkeypatch):
    """An installation without any extra."""
    loaded = [name for name in sys.modules if name.partition(".")[0] in OPTIONAL]
    for name in (*OPTIONAL, *loaded):
        monkeypatch.setitem(sys.modules, name, None)


@pytest.fixture(scope="module")
def run() -> ms.Run:
    return ms.explore("open", seed=1, max_time_s=10.0)


def names(requirements: list[str]) -> tuple[str, ...]:
    return tuple(re.split(r"[^\w-]", one)[0] for one in requirements)


def test_the_extras_are_those_of_the_package():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for name, packages in EXTRAS.items():
        assert names(declared["optional-dependencies"][name]) == packages
    assert not set(names(declared["dependencies"])) & set(OPTIONAL)


def test_every_extra_is_described():
    page = (ROOT / "docs" / "installing.md").read_text()
    for name, packages in EXTRAS.items():
        assert f"| `{name}` | {', '.join(packages)} |" in page


def test_another_missing_package_is_not_taken_for_the_extra():
    with pytest.raises(ModuleNotFoundError, match="no_such_package") as error, extra("plots", "x"):
        import_module("no_such_package")
    assert not isinstance(error.value, MissingExtraError)


@pytest.mark.parametrize(
    ("what", "needs"),
    [
        (lambda run: run.plot(), "a plot needs matplotlib"),
        (lambda run: run.plot_coverage(), "a plot needs matplotlib"),
        (lambda run: run.environment.plot(), "a plot needs matplotlib"),
        (lambda run: run.animate("a.mp4"), "an animation as MP4 or GIF needs imageio-ffmpeg"),
        (lambda run: run.trajectories(), "a data frame needs pandas"),
        (lambda run: run.events(frame="polars"), "a data frame needs polars"),
    ],
)
def test_what_needs_an_extra_names_it(what, needs, run, bare):
    with pytest.raises(MissingExtraError, match=rf"^{needs}, which .*: pip install 'multisrt\["):
        what(run)


def test_figures_and_reports_name_the_extra(bare, load_module):
    with pytest.raises(MissingExtraError, match=r"'multisrt\[plots\]'"):
        load_module(ROOT / "multisrt" / "reporting" / "style.py")


def test_pictures_and_tables_need_no_extra(run, bare, tmp_path):
    run.save_svg(tmp_path / "tree.svg")
    assert "<svg" in (tmp_path / "tree.svg").read_text()
    assert "<img" in run._repr_html_()
    assert "<svg" in run.environment._repr_svg_()


@pytest.mark.slow
def test_comparisons_print_and_show_without_any_extra(tmp_path):
    code = (
        "import sys\n"
        f"sys.modules.update(dict.fromkeys({OPTIONAL}))\n"
        "import multisrt as ms\n"
        "found = ms.compare('open', 'closest', seeds=1, workers=0, progress=False)\n"
        "print(found, len(found._repr_html_()) > 100)\n"
        "try:\n    found.report('report')\n"
        "except ms.MultiSrtError as error:\n    print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert "1 of 1 runs succeeded" in done.stdout
    assert done.stdout.endswith("not installed: pip install 'multisrt[plots]'\n")
    assert not (tmp_path / "report").exists()


def test_a_package_of_polars_is_taken_where_pandas_is_missing(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    assert type(run.events()).__module__.startswith("polars")
