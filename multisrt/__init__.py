"""Multi-robot exploration of unknown planar worlds.

>>> import multisrt as ms
>>> run = ms.explore(ms.environment("office"), strategy="srt-radial", seed=1)  # doctest: +SKIP
>>> run.metrics.coverage, run.save_svg("tree.svg")  # doctest: +SKIP
>>> team = ms.explore("museum", robots=4, starts="clustered", seed=1)  # doctest: +SKIP
>>> print(team.why(robot=2, time_s=31.5))  # doctest: +SKIP

Everything is imported when it is first used, so that `import multisrt` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multisrt.environments.catalog import catalog, environment
    from multisrt.environments.environment import Environment
    from multisrt.environments.formats import read_environment
    from multisrt.geometry.errors import InvalidInputError, MultiSrtError
    from multisrt.geometry.footprint import Footprint
    from multisrt.isolation import area_known_to_one, isolation
    from multisrt.metrics import Metrics, measure
    from multisrt.recording import Recording
    from multisrt.registry import Strategy, register, strategies
    from multisrt.run import Run, explore
    from multisrt.simulation import simulate
    from multisrt.spec import (
        CatalogEnvironment,
        Death,
        DriveSpec,
        FileEnvironment,
        InlineEnvironment,
        LateStart,
        RadioSpec,
        RangeFinderSpec,
        RobotSpec,
        RunSpec,
        Silence,
        StopRule,
    )

_HOMES = {
    "CatalogEnvironment": "spec",
    "Death": "spec",
    "DriveSpec": "spec",
    "Environment": "environments.environment",
    "FileEnvironment": "spec",
    "Footprint": "geometry.footprint",
    "InlineEnvironment": "spec",
    "InvalidInputError": "geometry.errors",
    "LateStart": "spec",
    "Metrics": "metrics",
    "MultiSrtError": "geometry.errors",
    "RadioSpec": "spec",
    "RangeFinderSpec": "spec",
    "Recording": "recording",
    "RobotSpec": "spec",
    "Run": "run",
    "RunSpec": "spec",
    "Silence": "spec",
    "StopRule": "spec",
    "Strategy": "registry",
    "area_known_to_one": "isolation",
    "catalog": "environments.catalog",
    "environment": "environments.catalog",
    "explore": "run",
    "isolation": "isolation",
    "measure": "metrics",
    "read_environment": "environments.formats",
    "register": "registry",
    "simulate": "simulation",
    "strategies": "registry",
}

__all__ = [
    "CatalogEnvironment",
    "Death",
    "DriveSpec",
    "Environment",
    "FileEnvironment",
    "Footprint",
    "InlineEnvironment",
    "InvalidInputError",
    "LateStart",
    "Metrics",
    "MultiSrtError",
    "RadioSpec",
    "RangeFinderSpec",
    "Recording",
    "RobotSpec",
    "Run",
    "RunSpec",
    "Silence",
    "StopRule",
    "Strategy",
    "area_known_to_one",
    "catalog",
    "environment",
    "explore",
    "isolation",
    "measure",
    "read_environment",
    "register",
    "simulate",
    "strategies",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
