"""One rule for packages that are not installed."""

import re
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import multisrt as ms
from multisrt.extras import EXTRAS, MissingExtraError, extra

ROOT = Path(__file__).parents[3]
OPTIONAL = [package for packages in EXTRAS.values() for package in packages]


@pytest.fixture
def bare(monkeypatch):
    """An installation without any extra."""
    for name in list(sys.modules):
        if name.partition(".")[0] in OPTIONAL or name.startswith("multisrt.reporting"):
            monkeypatch.delitem(sys.modules, name)
    for package in OPTIONAL:
        monkeypatch.setitem(sys.modules, package, None)


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
        (lambda run: run.trajectories(), "a data frame needs pandas"),
        (lambda run: run.events(frame="polars"), "a data frame needs polars"),
    ],
)
def test_what_needs_an_extra_names_it(what, needs, run, bare):
    with pytest.raises(MissingExtraError, match=rf"^{needs}, which .*: pip install 'multisrt\["):
        what(run)


def test_figures_and_reports_name_the_extra(bare):
    with pytest.raises(MissingExtraError, match=r"'multisrt\[plots\]'"):
        import multisrt.reporting.page  # noqa: F401


def test_pictures_and_tables_need_no_extra(run, bare, tmp_path):
    run.save_svg(tmp_path / "tree.svg")
    assert "<svg" in (tmp_path / "tree.svg").read_text()
    assert "<img" in run._repr_html_()
    assert "<svg" in run.environment._repr_svg_()
    from multisrt.reporting.layout import Cell, Table

    rows = ((Cell(text="maze"), Cell(text="1.0")),)
    assert "maze" in Table(name="t", title="T", columns=("World", "s"), rows=rows).text()


def test_a_package_of_polars_is_taken_where_pandas_is_missing(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    assert type(run.events()).__module__.startswith("polars")
