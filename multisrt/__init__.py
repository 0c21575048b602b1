"""Multi-robot exploration of unknown planar environments.

>>> import multisrt as ms
>>> run = ms.explore("open", strategy="srt-radial", seed=1)
>>> run.outcome
'complete'
>>> team = ms.explore("museum", robots=4, starts="clustered", seed=1)  # doctest: +SKIP
>>> team.save_svg("trees.svg")  # doctest: +SKIP
>>> print(team.why(robot=2, time_s=31.5))  # doctest: +SKIP
>>> ms.compare("garden", ["srt-star", "srt-radial"], robots=[1, 2, 4], seeds=20)  # doctest: +SKIP

Names are imported when they are first used, so that ``import multisrt`` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multisrt.analysis.isolation import isolation
    from multisrt.analysis.known_area import area_known_to_one
    from multisrt.analysis.measuring import measure
    from multisrt.analysis.metrics import Metrics
    from multisrt.comparison import Comparison, compare
    from multisrt.driving.driver import drive
    from multisrt.environments import suites as suites
    from multisrt.environments.catalog import catalog, environment
    from multisrt.environments.environment import Environment
    from multisrt.environments.formats import read_environment
    from multisrt.experiments.frames import load_results
    from multisrt.experiments.results import Result, Results
    from multisrt.experiments.spec import ExperimentSpec, StrategyChoice
    from multisrt.exporting import save_environment
    from multisrt.finished_run import Run
    from multisrt.geometry.bodies.footprint import Footprint
    from multisrt.geometry.errors import InvalidInputError, MultiSrtError
    from multisrt.recording import Recording
    from multisrt.robots.registry import register, strategies
    from multisrt.robots.strategy import Strategy
    from multisrt.run import explore
    from multisrt.simulation.simulate import simulate
    from multisrt.spec import (
        BaseSpec,
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
        SuiteEnvironment,
    )
    from multisrt.stepper import Stepper

_HOMES = {
    "BaseSpec": "spec",
    "CatalogEnvironment": "spec",
    "Comparison": "comparison",
    "Death": "spec",
    "DriveSpec": "spec",
    "Environment": "environments.environment",
    "ExperimentSpec": "experiments.spec",
    "FileEnvironment": "spec",
    "Footprint": "geometry.bodies.footprint",
    "InlineEnvironment": "spec",
    "InvalidInputError": "geometry.errors",
    "LateStart": "spec",
    "Metrics": "analysis.metrics",
    "MultiSrtError": "geometry.errors",
    "RadioSpec": "spec",
    "RangeFinderSpec": "spec",
    "Recording": "recording",
    "Result": "experiments.results",
    "Results": "experiments.results",
    "RobotSpec": "spec",
    "Run": "finished_run",
    "RunSpec": "spec",
    "Silence": "spec",
    "Stepper": "stepper",
    "StopRule": "spec",
    "Strategy": "robots.strategy",
    "StrategyChoice": "experiments.spec",
    "SuiteEnvironment": "spec",
    "area_known_to_one": "analysis.known_area",
    "catalog": "environments.catalog",
    "compare": "comparison",
    "drive": "driving.driver",
    "environment": "environments.catalog",
    "explore": "run",
    "isolation": "analysis.isolation",
    "load_results": "experiments.frames",
    "measure": "analysis.measuring",
    "read_environment": "environments.formats",
    "register": "robots.registry",
    "save_environment": "exporting",
    "simulate": "simulation.simulate",
    "strategies": "robots.registry",
}

_MODULES = {"suites": "environments.suites"}

__all__ = [
    "BaseSpec",
    "CatalogEnvironment",
    "Comparison",
    "Death",
    "DriveSpec",
    "Environment",
    "ExperimentSpec",
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
    "Result",
    "Results",
    "RobotSpec",
    "Run",
    "RunSpec",
    "Silence",
    "Stepper",
    "StopRule",
    "Strategy",
    "StrategyChoice",
    "SuiteEnvironment",
    "area_known_to_one",
    "catalog",
    "compare",
    "drive",
    "environment",
    "explore",
    "isolation",
    "load_results",
    "measure",
    "read_environment",
    "register",
    "save_environment",
    "simulate",
    "strategies",
    "suites",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(f"{__name__}.{_MODULES[name]}")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
