"""Settings and fixtures for all tests."""

import gc
import importlib.util
import os
import signal
import sys
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
