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

CALLER = """
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.numerics.segments import squared_distance


@kernel
def is_clear(x: float, y: float) -> bool:
    return squared_distance(x, y, x, -y) > 0.01
"""

IS_CLEAR = "from multisrt.geometry.caller import is_clear; print(is_clear(0.2, 0.3))"


@pytest.fixture
def package(tmp_path):
    """A copy of the package without compiled kernels, with one more file of them."""
    ignored = shutil.ignore_patterns("__pycache__")
    copy = Path(shutil.copytree(ROOT / "multisrt", tmp_path / "multisrt", ignore=ignored))
    (copy / "geometry" / "caller.py").write_text(CALLER)
    return copy


def answer(package: Path, **environment: str) -> str:
    inherited = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", IS_CLEAR],
        cwd=package.parent,
        env=inherited | {"PYTHONPATH": "."} | environment,
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
def test_a_kernel_follows_a_callee_of_another_file_and_older_ones_are_removed(package):
    assert answer(package) == "True"
    old = set(package.rglob("*.nbc"))
    assert {file.name.split("-")[0] for file in old} == {
        "caller.is_clear",
        "segments.squared_distance",
    }
    written = {file: file.stat().st_mtime_ns for file in old}
    assert answer(package) == "True"
    assert {file: file.stat().st_mtime_ns for file in package.rglob("*.nbc")} == written
    break_the_callee(package)
    assert answer(package) == "False"
    folders = list((package / "geometry" / "__pycache__").glob("caller-*"))
    assert len(folders) == 1
    assert not old & set(package.rglob("*.nbc"))


@pytest.mark.slow
def test_a_cache_chosen_by_the_user_is_used(package, tmp_path):
    mine = tmp_path / "mine"
    assert answer(package, NUMBA_CACHE_DIR=str(mine)) == "True"
    break_the_callee(package)
    assert answer(package, NUMBA_CACHE_DIR=str(mine)) == "False"
    assert len(list(mine.glob("caller-*"))) == 2
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
