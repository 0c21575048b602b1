import ast
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from multisrt.experiments.provenance import _IMPORTS, parts_behind, program_digest

ROOT = Path(__file__).parents[3]
DIGEST = "from multisrt.experiments.provenance import program_digest; print(program_digest())"


@pytest.fixture
def package(tmp_path):
    """A copy of the package."""
    ignored = shutil.ignore_patterns("__pycache__")
    return Path(shutil.copytree(ROOT / "multisrt", tmp_path / "multisrt", ignore=ignored))


def digest(package: Path) -> str:
    command = [sys.executable, "-c", DIGEST]
    done = subprocess.run(command, cwd=package.parent, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def change(package: Path, file: str, old: str, new: str) -> None:
    text = (package / file).read_text()
    assert old in text
    (package / file).write_text(text.replace(old, new, 1))


@pytest.mark.slow
def test_words_keep_the_digest(package):
    change(package, "spec/robots.py", '"""One robot.', '"""A robot of the team.')
    change(package, "simulation/radio.py", "from __future__", "# Why it is so.\n\nfrom __future__")
    change(package, "robots/registry.py", "gives a second strategy", "names another strategy")
    assert digest(package) == program_digest()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("spec/robots.py", "range_m: float = 4.0", "range_m: float = 4.5"),
        ("environments/generators/maze.py", "import", "import sys\nimport"),
        ("geometry/numerics/segments.py", "-(ax * ex + ay * ey)", "-(ax * ex - ay * ey)"),
        ("environments/maps/museum.geojson", "1", "2"),
        ("informed/plan.py", "import", "import sys\nimport"),
    ],
)
def test_changes_of_code_and_maps_change_the_digest(package, file, old, new):
    change(package, file, old, new)
    assert digest(package) != program_digest()


@pytest.mark.slow
@pytest.mark.parametrize("file", ["cli/tables.py", "drawing/svg.py", "analysis/metrics.py"])
def test_analysis_is_not_part_of_the_digest(package, file):
    change(package, file, "import", "import sys\nimport")
    assert digest(package) == program_digest()


@pytest.mark.slow
def test_imports_are_those_that_the_syntax_has():
    # Read as text, since a check of a strategy has no time to parse all files.
    behind = parts_behind("simulation")
    for path in (file for part in behind for file in sources(part)):
        found = {
            name.split(".")[1]
            for node in ast.walk(ast.parse(path.read_bytes()))
            for name in imported(node)
            if name.startswith("multisrt.")
        }
        assert found <= behind
        assert found == {part.decode() for part in _IMPORTS.findall(path.read_bytes())}, path


def sources(part: str) -> list[Path]:
    folder = ROOT / "multisrt" / part
    return list(folder.resolve().rglob("*.py")) if folder.is_dir() else [folder.with_suffix(".py")]


def imported(node: ast.AST) -> list[str]:
    match node:
        case ast.Import():
            return [alias.name for alias in node.names]
        case ast.ImportFrom():
            return [f"{node.module}.{alias.name}" for alias in node.names]
    return []
