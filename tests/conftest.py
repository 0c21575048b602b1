"""Settings and fixtures for all tests."""

import gc
import importlib.util
import os
import signal
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import settings

from tests.browser import launched

# The same examples in every run and no deadlines: failures are reproducible.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")

# Shells let background processes ignore interrupts; tests interrupt the processes they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Processes that tests start, in whatever folder, find the package where the tests do: numba keeps
# compiled kernels for each path of a source, and would compile those of an installation anew.
_PATHS = str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH")
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, _PATHS))


KERNELS_OF_RUNS, KERNELS_OF_GEOMETRY = "tests/golden/", "tests/geometry/"
"""What the first two processes begin with: neither repeats what the other compiles."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Let processes that share the tests take files in a good order (`make test`).

    Each takes the next file when it is done with one. What compiles most kernels comes first, then
    files by their number of slow tests: those that are left at the end are short.
    """
    if not hasattr(config, "workerinput"):
        return
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))

    def place(item: pytest.Item) -> tuple[bool, bool, int]:
        within = item.nodeid.startswith
        return (not within(KERNELS_OF_RUNS), not within(KERNELS_OF_GEOMETRY), -slow[item.path])

    # Files with as many slow tests stay in the order of their names.
    items.sort(key=place)


def pytest_collection_finish() -> None:
    """Take what stays to the end out of garbage collections, which would look through it."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _registry_as_before() -> Iterator[None]:
    """Take back what a test registers: the next one finds the strategies of the package."""
    registry = sys.modules.get("multisrt.robots.registry")
    before = None if registry is None else dict(registry._registry())
    yield
    registry = sys.modules.get("multisrt.robots.registry")
    if registry is None:
        return
    if before is None:
        registry._registry.cache_clear()
    else:
        known = registry._registry()
        known.clear()
        known.update(before)


def load(path: Path) -> ModuleType:
    """Return a new module from a file that cannot be imported by a name."""
    name = f"multisrt_test_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def load_module() -> Callable[[Path], ModuleType]:
    """The function `load`."""
    return load


@pytest.fixture(scope="session")
def worlds() -> ModuleType:
    """The module tests/geometry/worlds.py, which cannot be imported in importlib mode."""
    return load(Path(__file__).parent / "geometry" / "worlds.py")


@pytest.fixture(scope="session")
def browser():
    """Chromium, without a window; see tests/browser.py."""
    with launched() as found:
        yield found
