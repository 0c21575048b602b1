"""Worlds by name, and the maps that come with the package."""

import inspect
import re
import subprocess
import sys
from collections.abc import Callable

import pytest
import shapely

from multisrt.environments.catalog import MAPS, catalog, environment, names
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError

GENERATORS = [entry.name for entry in catalog() if entry.kind == "generator"]
BUNDLED = [entry.name for entry in catalog() if entry.kind == "map"]


def test_the_catalog_lists_every_name_once_and_in_order() -> None:
    assert tuple(entry.name for entry in catalog()) == names()
    assert len(set(names())) == len(names())
    assert len(GENERATORS) == 12
    assert len(BUNDLED) >= 5


def test_entries_describe_the_worlds() -> None:
    for entry in catalog():
        world = environment(entry.name)
        x0, y0, x1, y1 = world.bounds
        assert world.name == entry.name
        assert (entry.width_m, entry.height_m, entry.area_m2) == (x1 - x0, y1 - y0, world.area_m2)
        assert entry.summary
        assert "\n" not in entry.summary


@pytest.mark.parametrize("name", GENERATORS)
def test_listed_parameters_are_those_that_give_the_default(name: str) -> None:
    (entry,) = (entry for entry in catalog() if entry.name == name)
    parameters = dict(entry.parameters)
    world = environment(name, seed=0, **parameters)
    assert world == environment(name)
    # A switch is named where it is off.
    told = [*((key, value) for key, value in parameters.items() if value is not True), ("seed", 0)]
    written = ", ".join(f"{key}={value:g}" for key, value in told)
    assert world.origin == f"{name}({written})"


def test_origins_can_be_repeated() -> None:
    world = environment("garden", size_m=40, plots=5, seed=3)
    assert world.origin == "garden(size_m=40, plots=5, path_m=1.4, seed=3)"
    assert world == environment("garden", seed=3, size_m=40, plots=5, path_m=1.4)


def test_every_generator_takes_keywords_only_and_a_seed() -> None:
    from multisrt.environments import catalog as listing
    from multisrt.environments.generators import (
        cavern,
        city,
        clutter,
        dungeon,
        forest,
        garden,
        hospital,
        maze,
        office,
        rooms,
        warehouse,
    )
    from multisrt.environments.generators import open as hall

    assert len(listing()) == len(names())
    functions: list[Callable[..., Environment]] = [
        garden.garden,
        clutter.clutter,
        rooms.rooms,
        office.office,
        maze.maze,
        hospital.hospital,
        hall.open_hall,
        warehouse.warehouse,
        city.city,
        forest.forest,
        cavern.cavern,
        dungeon.dungeon,
    ]
    for function in functions:
        parameters = inspect.signature(function).parameters.values()
        assert {parameter.kind for parameter in parameters} == {inspect.Parameter.KEYWORD_ONLY}
        assert "seed" in inspect.signature(function).parameters


def test_unknown_names_are_answered_with_close_ones_and_all() -> None:
    with pytest.raises(InvalidInputError, match="did you mean 'garden'") as caught:
        environment("gardn")
    assert all(name in str(caught.value) for name in names())
    with pytest.raises(InvalidInputError, match="no environment is called 'qqq'; the names are"):
        environment("qqq")


def test_unknown_parameters_are_answered_with_those_there_are() -> None:
    with pytest.raises(InvalidInputError, match=r"maze has no parameter 'cels'.*cells=12"):
        environment("maze", cels=3)


@pytest.mark.parametrize("name", BUNDLED)
def test_bundled_maps_are_fixed(name: str) -> None:
    with pytest.raises(InvalidInputError, match=f"{name!r} is fixed.*leave out seed"):
        environment(name, seed=0)
    with pytest.raises(InvalidInputError, match=f"{name!r} is fixed.*leave out size_m"):
        environment(name, size_m=3.0)


@pytest.mark.parametrize("name", BUNDLED)
def test_bundled_maps_are_worth_exploring(name: str) -> None:
    world = environment(name)
    assert 200.0 <= world.area_m2 <= 900.0
    assert world.origin
    assert len(world.free.geoms) == 1
    for radius in (0.25, 0.42):
        eroded = shapely.get_parts(world.free.buffer(-radius))
        assert (shapely.area(eroded) > 0.05).sum() == 1
    assert all(world.clearance(x, y) > 0.5 for x, y in world.starts)
    assert environment(name) == world


def test_the_folder_of_maps_has_the_maps_of_the_catalog() -> None:
    stems = {path.stem for path in MAPS.iterdir()}
    assert stems == set(BUNDLED)
    assert max(path.stat().st_size for path in MAPS.iterdir()) < 300_000


def run(code: str) -> str:
    """Run a fresh interpreter; give what it prints."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_the_names_of_worlds_load_no_geometry() -> None:
    printed = run(
        "import sys; from multisrt.environments.catalog import names; names(); "
        "print([name for name in ('shapely', 'numpy', 'numba') if name in sys.modules])"
    )
    assert printed == "[]"


@pytest.mark.slow
@pytest.mark.parametrize(
    "before",
    [
        "",
        "import multisrt.environments.environment, multisrt.environments.catalog",
        "from multisrt.environments.environment import Environment",
        "from multisrt.environments.catalog import names",
    ],
)
def test_the_package_exports_functions_after_any_imports(before: str) -> None:
    printed = run(
        f"{before}\n"
        "from multisrt.environments import Environment, catalog, environment, read_environment\n"
        "print(type(environment('open')) is Environment, callable(catalog), "
        "read_environment.__module__)"
    )
    assert re.fullmatch(r"True True multisrt\.environments\.formats[\w.]*", printed)


def test_the_package_has_no_other_names() -> None:
    import multisrt.environments as package

    assert {"Environment", "catalog", "environment", "read_environment"} <= set(dir(package))
    with pytest.raises(AttributeError, match="'nothing'"):
        package.nothing  # type: ignore[attr-defined]  # noqa: B018
