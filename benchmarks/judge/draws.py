"""Runs to judge: drawn over strategies, bodies, drives, range finders, radios, faults, worlds."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from numpy.random import Generator

from multisrt.environments.environment import Environment
from multisrt.robots.registry import strategies
from multisrt.simulation.worlds import build_environment
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    DriveSpec,
    FileEnvironment,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)
from multisrt.spec.environments import EnvironmentSpec
from multisrt.spec.faults import Fault

MAPS: Final = Path(os.environ.get("MULTISRT_MAPS", "maps"))
"""Folder of published maps; those that are missing are left out."""

SMALL: Final[tuple[EnvironmentSpec, ...]] = (
    CatalogEnvironment(name="open", parameters={"size_m": 8.0}),
    CatalogEnvironment(name="open", parameters={"size_m": 12.0, "columns": 6}, seed=2),
    CatalogEnvironment(name="garden", parameters={"size_m": 15.0, "plots": 2}, seed=1),
    CatalogEnvironment(
        name="clutter", parameters={"size_m": 12.0, "obstacle_m": 1.5, "cover": 0.05}, seed=3
    ),
    CatalogEnvironment(name="rooms", parameters={"size_m": 14.0, "rooms_per_side": 2}, seed=4),
    CatalogEnvironment(name="office", parameters={"width_m": 18.0, "height_m": 14.0}, seed=5),
    CatalogEnvironment(name="maze", parameters={"size_m": 10.0, "cells": 5}, seed=6),
    CatalogEnvironment(name="maze", parameters={"size_m": 12.0, "cells": 5, "loops": 0.5}, seed=7),
)
"""Worlds of generators, small enough to be explored in short runs."""

BUNDLED: Final[tuple[EnvironmentSpec, ...]] = tuple(
    CatalogEnvironment(name=name)
    for name in ("museum", "apartment", "workshop", "library", "clinic", "cave")
)

PUBLISHED: Final = (
    ("explore_bench/corner.yaml", None, None),
    ("explore_bench/corridor.yaml", None, None),
    ("navigation_tutorials/lse_arena.yaml", None, None),
    ("maes/map.pgm", 0.2, None),
    ("ir2_dungeon/test_hybrid_1.png", 0.04, 0.6),
    ("ir2_dungeon/train_easy_img_2.png", 0.04, 0.6),
    ("movingai/room-32-32-4.map", 0.5, None),
    ("movingai/arena.map", 0.4, None),
    ("mresim/rooms.png", 0.03, None),
    ("stage/simple_rooms.png", 0.05, None),
    ("stage/cave_filled.png", 0.032, None),
    ("trivis_imr/potholes.txt", None, None),
)
"""Files of `MAPS` with metres per pixel and the lightness from which a pixel is free."""

DISCS: Final = ("disc:0.25", "disc:0.15", "disc:0.2")
POLYGONS: Final = (
    "box:0.5x0.3",
    "box:0.4x0.4",
    "polygon:-0.2,-0.15 0.3,0 -0.2,0.15",
    "polygon:-0.25,-0.2 0.25,-0.2 0.25,0.2 0.1,0.2 0.1,0.1 -0.1,0.1 -0.1,0.2 -0.25,0.2",
)
RANGES_M: Final = (2.5, 4.0, 4.0, 6.0)
BEAMS: Final = (None, None, None, 180, 360)
RADIOS_M: Final = (None, None, 20.0, 12.0)
TEAMS: Final = (1, 2, 2, 3, 3, 4, 4, 5, 6, 8)

MIN_SHARE_M2: Final = 8.0
"""Minimum free area for each robot of a team."""

ROBOT_TIME_S: Final = {"srt": 700.0, "bids": 200.0}
"""Time of all robots together after which a run is stopped: bidding robots scan all the time."""


def worlds() -> list[EnvironmentSpec]:
    """Return all worlds, those of `MAPS` last."""
    files = [
        FileEnvironment(path=str(MAPS / path), resolution_m=cell_m, threshold=lightness)
        for path, cell_m, lightness in PUBLISHED
        if (MAPS / path).is_file()
    ]
    return [*SMALL, *BUNDLED, *files]


def draw(rng: Generator, number: int, where: EnvironmentSpec, world: Environment) -> RunSpec:
    """Return a run in a world; its number says which strategy, so that all have their turn."""
    names = [strategy.name for strategy in strategies()]
    name = names[number % len(names)]
    is_srt = name.startswith("srt")
    team = int(rng.choice(TEAMS))
    team = max(1, min(team, int(world.area_m2 / MIN_SHARE_M2)))
    alike = bool(rng.random() < 0.6)
    robots = [_robot(rng, is_srt, name) for _ in range(1 if alike else team)]
    robots *= team if alike else 1
    radio = _radio(rng, is_srt, robots)
    time_s = max(25.0, ROBOT_TIME_S["srt" if is_srt else "bids"] / team)
    return RunSpec(
        environment=where,
        strategy=name,
        robots=tuple(robots),
        starts="clustered" if rng.random() < 0.5 else "scattered",
        radio=radio,
        faults=_faults(rng, team, time_s) if rng.random() < 0.4 else (),
        stop=StopRule(max_time_s=round(time_s, 1)),
        seed=number,
    )


def _robot(rng: Generator, is_srt: bool, name: str) -> RobotSpec:
    bodies = DISCS if rng.random() < 0.6 else POLYGONS
    kinds = ["differential", "differential", "holonomic"]
    # By default these drive by the nearness diagram, which cars cannot.
    if name != "self-bidding":
        kinds.append("reeds-shepp")
    kind = str(rng.choice(kinds))
    turning = {"turning_radius_m": 0.4} if kind == "reeds-shepp" else {}
    drive = DriveSpec(
        kind=kind,  # type: ignore[arg-type]
        speed_m_s=float(rng.choice([0.4, 0.5, 0.8])),
        **turning,
    )
    beams = BEAMS[rng.integers(len(BEAMS))]
    finder = RangeFinderSpec(range_m=float(rng.choice(RANGES_M)), beams=beams)
    return RobotSpec(footprint=str(rng.choice(bodies)), drive=drive, range_finder=finder)


def _radio(rng: Generator, is_srt: bool, robots: list[RobotSpec]) -> RadioSpec:
    range_m = RADIOS_M[rng.integers(len(RADIOS_M))]
    if is_srt and range_m is not None:
        # Robots that may meet have to hear one another before: three times as far as they see.
        range_m = max(range_m, 3.0 * max(robot.range_finder.range_m for robot in robots))
    walls = str(rng.choice(["pass", "pass", "block", "weaken"]))
    if walls == "weaken" and range_m is None:
        walls = "block"
    return RadioSpec(
        range_m=range_m,
        multi_hop=bool(rng.random() < 0.7),
        walls=walls,  # type: ignore[arg-type]
        latency_s=float(rng.choice([0.0, 0.0, 0.2])),
        jitter_s=float(rng.choice([0.0, 0.5])),
        loss=float(rng.choice([0.0, 0.0, 0.2])),
    )


def _faults(rng: Generator, team: int, time_s: float) -> tuple[Fault, ...]:
    # One robot at least has no fault.
    faults: list[Fault] = []
    for robot in range(1, team):
        begin_s = round(float(rng.uniform(0.1, 0.6)) * time_s, 1)
        match int(rng.integers(4)):
            case 0:
                faults.append(Death(robot=robot, time_s=begin_s))
            case 1:
                faults.append(Silence(robot=robot, time_s=begin_s, duration_s=0.3 * time_s))
            case 2:
                faults.append(LateStart(robot=robot, time_s=begin_s))
    return tuple(faults)


def built(where: EnvironmentSpec) -> Environment:
    """Return a world, built from its spec."""
    return build_environment(where)
