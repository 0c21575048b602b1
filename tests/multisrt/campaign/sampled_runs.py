"""Small runs of all strategies, bodies, drives, radios, faults and base stations, drawn by seed."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.random import Generator

from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import build_environment
from multisrt.spec import (
    BaseSpec,
    CatalogEnvironment,
    Death,
    DriveSpec,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)
from multisrt.spec.faults import Fault

STRATEGIES = (
    "srt-ball",
    "srt-star",
    "srt-radial",
    "closest",
    "greedy",
    "minpos",
    "utility",
    "self-bidding",
    "rules",
    "gain",
    "routes",
)

WORLDS = (
    CatalogEnvironment(name="open", parameters={"size_m": 8.0}),
    CatalogEnvironment(name="open", parameters={"size_m": 11.0, "columns": 5}, seed=2),
    CatalogEnvironment(name="clutter", parameters={"size_m": 10.0, "obstacle_m": 1.5}, seed=3),
    CatalogEnvironment(name="rooms", parameters={"size_m": 12.0, "rooms_per_side": 2}, seed=4),
    CatalogEnvironment(name="maze", parameters={"size_m": 8.0, "cells": 4}, seed=6),
    CatalogEnvironment(name="maze", parameters={"size_m": 10.0, "cells": 4, "loops": 0.5}, seed=7),
    CatalogEnvironment(name="office", parameters={"width_m": 16.0, "height_m": 10.0}, seed=5),
    CatalogEnvironment(name="apartment"),
)

BODIES = ("disc:0.25", "disc:0.15", "box:0.5x0.3", "polygon:-0.2,-0.15 0.3,0 -0.2,0.15")


@cache
def world(number: int) -> Environment:
    """Return one of the worlds, built."""
    return build_environment(WORLDS[number])


def run(seed: int, number: int) -> tuple[Recording, Environment]:
    """Return the run of a number, and its world; draws that are refused are drawn again."""
    for attempt in range(20):
        rng = np.random.default_rng([seed, number, attempt])
        where = int(rng.integers(len(WORLDS)))
        try:
            return simulate(drawn(rng, number, where), world(where)), world(where)
        except InvalidInputError:
            continue
    raise AssertionError(f"no draw of run {number} of seed {seed} was accepted")


def drawn(rng: Generator, number: int, where: int) -> RunSpec:
    """Return a run in a world; its number says which strategy, so that all have their turn."""
    name = STRATEGIES[number % len(STRATEGIES)]
    is_srt = name.startswith("srt")
    team = int(rng.choice([1, 2, 2, 3, 3, 4, 5]))
    alike = bool(rng.random() < 0.6)
    robots = [robot(rng, name) for _ in range(1 if alike else team)]
    robots *= team if alike else 1
    radio = radio_of(rng, is_srt, robots)
    time_s = float(rng.choice([20.0, 60.0, 200.0, 600.0]))
    base, options = None, dict[str, Any]()
    if rng.random() < 0.35:
        x, y = world(where).free.representative_point().coords[0]
        base = BaseSpec(x=x, y=y)
        homes = ["in-time", "worth"] if is_srt else ["in-time", "worth", "relays", "chain"]
        options["home"] = str(rng.choice(homes))
    if is_srt and rng.random() < 0.3:
        options["sense"] = "moving"
    if not is_srt and rng.random() < 0.2:
        options["shape"] = str(rng.choice(["star", "ball"]))
    if not is_srt and team > 1 and radio.range_m is not None and rng.random() < 0.2:
        options["pursue"] = True
    return RunSpec(
        environment=WORLDS[where],
        strategy=name,
        options=options,
        robots=tuple(robots),
        starts="clustered" if rng.random() < 0.5 else "scattered",
        radio=radio,
        base=base,
        faults=faults(rng, team, time_s) if rng.random() < 0.4 else (),
        stop=StopRule(max_time_s=time_s),
        seed=number,
    )


def robot(rng: Generator, name: str) -> RobotSpec:
    """Return a robot; those that steer by the nearness diagram are no cars."""
    kinds = ["differential", "differential", "holonomic"]
    if name != "self-bidding":
        kinds += ["reeds-shepp", "dubins"]
    kind = str(rng.choice(kinds))
    turning = {"turning_radius_m": 0.4} if kind in ("reeds-shepp", "dubins") else {}
    return RobotSpec(
        footprint=str(rng.choice(BODIES)),
        drive=DriveSpec(
            kind=kind,  # type: ignore[arg-type]
            speed_m_s=float(rng.choice([0.4, 0.5, 1.0])),
            **turning,
        ),
        range_finder=RangeFinderSpec(
            range_m=float(rng.choice([2.5, 4.0, 4.0, 6.0])),
            beams=[None, None, None, 180, 360][rng.integers(5)],
        ),
    )


def radio_of(rng: Generator, is_srt: bool, robots: list[RobotSpec]) -> RadioSpec:
    """Return a radio; with SRT it reaches three times as far as robots see."""
    range_m = [None, None, 8.0, 3.0][rng.integers(4)]
    if is_srt and range_m is not None:
        range_m = max(range_m, 3.0 * max(one.range_finder.range_m for one in robots))
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


def faults(rng: Generator, team: int, time_s: float) -> tuple[Fault, ...]:
    """Return faults of some robots; one robot at least has none."""
    found: list[Fault] = []
    for number in range(1, team):
        begin_s = round(float(rng.uniform(0.05, 0.6)) * min(time_s, 100.0), 1)
        match int(rng.integers(4)):
            case 0:
                when = str(rng.choice(["any", "moving", "waiting"]))
                found.append(Death(robot=number, time_s=begin_s, when=when))  # type: ignore[arg-type]
            case 1:
                found.append(Silence(robot=number, time_s=begin_s, duration_s=0.3 * time_s))
            case 2:
                found.append(LateStart(robot=number, time_s=begin_s))
    return tuple(found)
