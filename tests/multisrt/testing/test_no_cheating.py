"""Robots cannot cheat: nothing that an explorer holds leads to the world."""

import gc
import types

import numpy as np
import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.envs.mission import STRATEGY, Mission
from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import ExactScan, take_scan
from multisrt.recording import Recorder
from multisrt.robots import registry
from multisrt.robots.explorer import Done, Explorer, RobotSelf, Sense
from multisrt.robots.policy import DecisionSpec
from multisrt.robots.registry import strategies
from multisrt.robots.strategy import Strategy
from multisrt.run import explore
from multisrt.simulation import sensing
from multisrt.simulation.clock import Clock
from multisrt.simulation.faults import Faults
from multisrt.simulation.interpreter import Interpreter
from multisrt.simulation.journal import Journal
from multisrt.simulation.mail import Mail
from multisrt.simulation.motions import Motions
from multisrt.simulation.robot import Robot
from multisrt.simulation.setting_up import SetUp
from multisrt.simulation.simulation import Simulation
from multisrt.simulation.traffic import Traffic
from multisrt.simulation.worlds import inline
from multisrt.spec import RunSpec

WORLD = Environment(
    "two rooms", shapely.box(0, 0, 12, 5).difference(shapely.box(6, 0, 6.2, 3.5)), starts=[(1, 1)]
)

TRUTH = (
    Environment,
    CollisionWorld,
    EdgeIndex,
    Recorder,
    Simulation,
    Clock,
    Faults,
    Interpreter,
    Journal,
    Mail,
    Motions,
    Robot,
    sensing.Sensing,
    SetUp,
    Traffic,
)


def reachable(*roots: object) -> list[object]:
    """Return all objects reachable from some, except through modules, classes or functions.

    Those are the program, not what a robot was given: its code may import what it likes, which
    import rules forbid elsewhere. Closures and defaults of functions are followed.
    """
    seen: dict[int, object] = {}
    waiting = list(roots)
    while waiting:
        thing = waiting.pop()
        if id(thing) in seen or isinstance(thing, types.ModuleType | type):
            continue
        seen[id(thing)] = thing
        if isinstance(thing, types.FunctionType):
            waiting += [cell.cell_contents for cell in thing.__closure__ or ()]
            waiting += [*(thing.__defaults__ or ()), *(thing.__kwdefaults__ or {}).values()]
        else:
            waiting += gc.get_referents(thing)
            if isinstance(thing, np.ndarray):
                waiting.append(thing.base)
    return list(seen.values())


def truths(*roots: object) -> list[object]:
    return [thing for thing in reachable(*roots) if isinstance(thing, TRUTH)]


@pytest.fixture
def explorers(monkeypatch) -> list[tuple[Explorer, RobotSelf, object]]:
    """All explorers that are built, each with what it is given."""
    built: list[tuple[Explorer, RobotSelf, object]] = []

    def keeping(strategy):
        def explorer(me, options):
            made = strategy.explorer(me, options)
            built.append((made, me, options))
            return made

        return Strategy(
            name=strategy.name,
            summary=strategy.summary,
            options=strategy.options,
            explorer=explorer,
        )

    known = {s.name: keeping(s) for s in strategies()}
    monkeypatch.setattr(registry, "_registry", lambda: known)
    return built


@pytest.mark.slow
@pytest.mark.parametrize("strategy", [s.name for s in strategies() if not s.sees_truth])
@pytest.mark.parametrize("beams", [None, 360])
def test_nothing_that_an_explorer_holds_leads_to_the_truth(explorers, strategy, beams):
    checks: list[list[object]] = []

    def watch(event):
        # While the run goes on, not only after its end.
        if len(checks) < 20:
            checks.append(truths(*explorers[0]))

    explore(WORLD, strategy=strategy, seed=1, range_m=3.0, beams=beams, watch=watch)
    assert len(checks) == 20
    assert not any(checks)
    assert truths(*explorers[0]) == []


def test_nothing_that_a_robot_for_learning_observes_leads_to_the_truth():
    mission = Mission(
        RunSpec(environment=inline(WORLD), strategy=STRATEGY, seed=1), WORLD, DecisionSpec(), None
    )
    for _ in range(3):
        assert mission.asking == 0
        explorer = mission._steps.explorers[0]
        assert truths(explorer, mission.observation(0)) == []
        mission.step(0)


def test_outcomes_do_not_lead_to_the_truth(monkeypatch):
    told: list[object] = []

    class Curious:
        def __init__(self, me):
            told.append(me)

        def run(self):
            told.append((yield Sense()))
            yield Done(complete=True, reason="")

    strategy = Strategy(
        name="curious",
        summary="",
        options=registry.strategy("srt-star").options,
        explorer=lambda me, options: Curious(me),
    )
    monkeypatch.setitem(registry._registry(), "curious", strategy)
    explore(WORLD, strategy="curious")
    assert len(told) == 2
    assert truths(*told) == []


def test_a_scan_shares_no_memory_with_the_truth(monkeypatch):
    scans: list[tuple[EdgeIndex, ExactScan]] = []

    def taking(index, *rest):
        scan = take_scan(index, *rest)
        assert isinstance(scan, ExactScan)
        scans.append((index, scan))
        return scan

    monkeypatch.setattr(sensing, "take_scan", taking)
    explore(WORLD, seed=1)
    assert scans
    for index, scan in scans:
        theirs = [thing for thing in reachable(index) if isinstance(thing, np.ndarray)]
        assert theirs
        for mine in (scan.boundary, scan.tags):
            assert not any(np.may_share_memory(mine, array) for array in theirs)


def test_the_search_finds_the_hidden_truth():
    class Cheat:
        def __init__(self, world):
            def peek():
                return world

            self.deep = {"pocket": [peek]}

    assert truths(Cheat(WORLD)) == [WORLD]
    assert truths({"index": EdgeIndex(WORLD.edges, 1.0)})


def test_only_the_reference_is_planned_on_the_truth():
    assert [s.name for s in strategies() if s.sees_truth] == ["informed"]
