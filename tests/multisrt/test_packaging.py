import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from zipfile import ZipFile

import jedi  # type: ignore[import-untyped]
import pytest
from setuptools import find_packages  # type: ignore[import-untyped]

import multisrt
from multisrt.environments.catalog import MAPS

ROOT = Path(__file__).parents[2]
ROOMS = ("geometry", "planners", "environments")
SETUP = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def folders_of_packages() -> set[str]:
    """Return all packages: folders with an __init__.py, linked ones under `multisrt`."""
    found = set()
    for top in ("multisrt", *ROOMS):
        prefix = "" if top == "multisrt" else "multisrt."
        for init in (ROOT / top).rglob("__init__.py"):
            parts = init.parent.relative_to(ROOT).parts
            if not (parts[0] == "multisrt" and len(parts) > 1 and parts[1] in ROOMS):
                found.add(prefix + ".".join(parts))
    return found


def test_every_package_is_installed():
    find = SETUP["packages"]["find"]
    assert SETUP["package-dir"][""] == find["where"][0]
    found = find_packages(str(ROOT / find["where"][0]), include=find["include"])
    assert set(found) == folders_of_packages()


def test_every_folder_with_modules_is_a_package():
    for top in ("multisrt", *ROOMS):
        for module in (ROOT / top).rglob("*.py"):
            assert (module.parent / "__init__.py").exists(), module


def test_the_parts_are_linked_into_the_package():
    for room in ROOMS:
        link = ROOT / "multisrt" / room
        assert link.is_symlink()
        assert os.readlink(link) == f"../{room}"


def test_all_data_files_are_packaged():
    data = SETUP["package-data"]
    assert not SETUP["include-package-data"]
    assert (ROOT / "multisrt" / "py.typed").exists()
    listed = {
        path
        for package, patterns in data.items()
        for pattern in patterns
        for path in (ROOT / Path(*package.split("."))).resolve().glob(pattern)
    }
    code = {".py", ".pyc", ".nbi", ".nbc"}
    present = {
        path
        for top in ("multisrt", *ROOMS)
        for path in (ROOT / top).resolve().rglob("*")
        if path.is_file() and path.suffix not in code
    }
    assert present == listed
    assert {path for path in listed if path.parent == MAPS.resolve()}


def test_an_editable_installation_is_a_path_that_checkers_read(tmp_path):
    # A copy of what the build reads: it writes beside it.
    top = tmp_path / "top"
    top.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, top)
    for name in ("multisrt", *ROOMS):
        (top / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "src", top / "src", symlinks=True)
    code = f"from setuptools.build_meta import build_editable as b; b({str(tmp_path)!r})"
    python(code, cwd=top)
    (wheel,) = tmp_path.glob("*.whl")
    with ZipFile(wheel) as file:
        added = [name for name in file.namelist() if ".dist-info/" not in name]
        assert added == ["__editable__.multisrt-0.1.0.pth"]
        assert file.read(added[0]).decode().strip() == str(top / "src")
    # The folder holds the package and nothing else that could be imported.
    assert [path.name for path in (ROOT / "src").iterdir() if path.suffix != ".egg-info"] == [
        "multisrt"
    ]
    assert os.readlink(ROOT / "src" / "multisrt") == "../multisrt"


def test_completion_shows_the_api_alone():
    names = {found.name for found in jedi.Interpreter("ms.", [{"ms": multisrt}]).complete()}
    assert {name for name in names if not name.startswith("_")} == set(multisrt.__all__)
    (signature,) = jedi.Interpreter("ms.explore(", [{"ms": multisrt}]).get_signatures()
    assert signature.params[0].name == "environment"


def python(code: str, *, cwd: Path) -> str:
    """Return what code prints, run with the package that is installed."""
    installed = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=cwd,
        env=installed,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


def test_no_part_can_be_imported_by_its_bare_name(tmp_path):
    code = (
        "import importlib.util as u\n"
        f"print([name for name in {ROOMS} if u.find_spec(name) is not None])"
    )
    assert python(code, cwd=tmp_path) == "[]\n"


HEAVY = ("numba", "shapely", "scipy", "trimesh", "fcl", "rich", "matplotlib", "numpy", "simpy")


def loaded_by(code: str) -> set[str]:
    check = f"\nimport sys; print('LOADED', *(m for m in {HEAVY} if m in sys.modules))"
    last = python(code + check, cwd=ROOT).splitlines()[-1]
    return set(last.split()[1:])


@pytest.mark.parametrize(
    "code",
    [
        "import multisrt",
        "import multisrt; dir(multisrt)",
        "import multisrt.cli",
        "import multisrt.environments",
        "import multisrt.geometry",
        "import multisrt.planners",
    ],
)
def test_importing_the_package_imports_nothing_heavy(code):
    assert loaded_by(code) == set()


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["explore", "--help"]])
def test_help_imports_nothing_heavy(words):
    code = (
        "import sys, contextlib\n"
        f"sys.argv = {['multisrt', *words]}\n"
        "from multisrt.cli import main\n"
        "with contextlib.suppress(SystemExit): main()"
    )
    assert loaded_by(code) == set()


def test_the_check_for_heavy_imports_can_fail():
    assert "shapely" in loaded_by("import multisrt; multisrt.Environment")


def test_every_public_name_can_be_imported():
    for name in multisrt.__all__:
        assert getattr(multisrt, name) is not None
    assert sorted(multisrt.__all__) == dir(multisrt)
    assert {*multisrt._HOMES, *multisrt._MODULES} == set(multisrt.__all__)
    with pytest.raises(AttributeError, match="'bogus'"):
        multisrt.bogus  # noqa: B018


def test_public_names_are_not_shadowed_by_modules():
    code = (
        "import multisrt.environments.catalog, multisrt.environments.environment\n"
        "import multisrt as ms\n"
        "print(callable(ms.environment), callable(ms.catalog), ms.environment('open').area_m2)"
    )
    assert python(code, cwd=ROOT).startswith("True True ")
