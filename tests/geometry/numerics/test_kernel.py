"""The cache of kernels: never older than what a kernel calls."""

import ast
import os
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from multisrt.geometry.numerics.kernel_cache import imported_files

ROOT = Path(__file__).parents[3]

IS_CLEAR = """
import numpy as np
from multisrt.geometry.regions.edge_index import EdgeIndex, no_edge_within
walls = EdgeIndex(np.array([[0.0, 0.0, 1.0, 0.0]]), 1.0)
print(no_edge_within(0.5, 0.3, 0.6, 0.3, 0.2, walls.grid))
"""


@pytest.fixture
def package(tmp_path):
    """A copy of the package without compiled kernels."""
    ignored = shutil.ignore_patterns("__pycache__")
    return Path(shutil.copytree(ROOT / "multisrt", tmp_path / "multisrt", ignore=ignored))


def answer(package: Path, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", IS_CLEAR],
        cwd=package.parent,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def break_the_callee(package: Path) -> None:
    file = package / "geometry" / "numerics" / "segments.py"
    right = "return area * area / squared\n"
    text = file.read_text()
    assert text.count(right) == 1
    # An installer, too, keeps the time at which a file was packed.
    times = file.stat().st_atime, file.stat().st_mtime
    file.write_text(text.replace(right, "return 0.0\n"))
    os.utime(file, times)


@pytest.mark.slow
def test_a_kernel_follows_a_callee_of_another_file(package):
    assert answer(package) == "True"
    cached = set(package.rglob("no_edge_within*.nbc"))
    assert answer(package) == "True"
    assert cached == set(package.rglob("no_edge_within*.nbc"))
    break_the_callee(package)
    assert answer(package) == "False"


@pytest.mark.slow
def test_kernels_of_older_sources_are_removed(package):
    answer(package)
    old = set((package / "geometry" / "regions" / "__pycache__").glob("edge_index-*"))
    break_the_callee(package)
    answer(package)
    new = set((package / "geometry" / "regions" / "__pycache__").glob("edge_index-*"))
    assert len(old) == len(new) == 1
    assert old != new


@pytest.mark.slow
def test_a_cache_chosen_by_the_user_is_used(package, tmp_path):
    mine = tmp_path / "mine"
    assert answer(package, NUMBA_CACHE_DIR=str(mine)) == "True"
    break_the_callee(package)
    assert answer(package, NUMBA_CACHE_DIR=str(mine)) == "False"
    assert len(list(mine.glob("edge_index-*"))) == 2
    assert not list(package.rglob("*.nbc"))


def test_a_cache_that_cannot_be_written_is_reported(package, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(subprocess.CalledProcessError) as error:
        answer(package, NUMBA_CACHE_DIR=str(tmp_path / "file"))
    assert "set NUMBA_CACHE_DIR to a folder" in error.value.stderr


def files_with_kernels() -> list[str]:
    """Return the names of the modules that declare kernels."""
    package = ROOT / "multisrt"
    found = []
    for room in (package, *(package / link for link in ("geometry", "planners", "environments"))):
        for file in room.resolve().rglob("*.py"):
            if "\n@kernel\n" in file.read_text():
                inner = file.relative_to(room.resolve()).with_suffix("").parts
                top = () if room == package else (room.name,)
                found.append(".".join(("multisrt", *top, *inner)))
    return sorted(found)


def modules_imported(tree: ast.Module) -> set[str]:
    found = set()
    for node in tree.body:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            found |= {str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)}
    return {name for name in found if name.split(".")[0] == "multisrt"} & set(sys.modules)


@pytest.mark.parametrize("module", files_with_kernels())
def test_all_files_that_a_kernel_may_call_are_found(module):
    import_module(module)
    files = imported_files(module)
    assert module in files
    for file in files.values():
        assert modules_imported(ast.parse(file.read_text())) <= files.keys()


def test_there_are_kernels_to_look_at():
    assert len(files_with_kernels()) > 20
