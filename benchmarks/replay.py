"""The replay of a very large run: size of the page, and what frames and jumps take in a browser.

The run is made of a real one: 16 teams of four, each in its own field, as one team of 64. Its
nodes, motions, messages and decisions are those of the real run, turned and moved; robots of
different fields never talk.
"""

from __future__ import annotations

import importlib.util
import math
import shutil
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import shapely

from benchmarks.harness import Benchmark, Claim, skipped
from benchmarks.team import RADIO_RANGE_M, TILE_M, field
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Decision, NodeAdded, Supports
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording, header_of
from multisrt.replay import replay_html
from multisrt.replay.page import MAX_BYTES
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RadioSpec, RangeFinderSpec, RobotSpec, RunSpec, StopRule

if TYPE_CHECKING:
    from playwright.sync_api import Page

TEAM, SIDE = 4, 4
"""Robots of the real run, and how many fields stand side by side in each direction."""

NODES = 10_000
"""Nodes of the run that is shown."""

MAX_TIME_S = 1400.0
"""Simulated time after which the real run is stopped."""

RANGE_M = 2.0
"""Range of the range finders: short, so that there are many nodes."""

MAX_FRAME_MS = 33.0
"""Processor time that the page may take for a frame: 30 of them in a second (ms)."""

MAX_JUMP_MS = 1500.0
"""Processor time that it may take to go to another time (ms)."""

WATCHED_S = 10
"""How long frames are counted."""

DRAWN = "replay.player.isComplete && !replay.player.isWaiting"
"""Whether the page has drawn all there is."""

BOXES = "document.querySelectorAll('#layers input')"
ALL_LAYERS = f"{BOXES}.forEach((box) => replay.player.layers.add(box.name))"
"""Shows all layers."""


def large() -> Iterator[Claim | str]:
    """Measure the page of 64 robots and 10,000 nodes."""
    recording = multiplied(real())
    begin = time.perf_counter()
    page = replay_html(recording)
    yield (
        f"a replay of {len(recording.starts)} robots, {len(recording.of(NodeAdded)):,} nodes, "
        f"{len(recording.events):,} events: made in {time.perf_counter() - begin:.0f} s"
    )
    yield Claim(
        text="size of the page: 20 MB",
        ours=len(page.encode()) / 1e6,
        theirs=MAX_BYTES / 1e6,
        unit="MB",
        at_most=1.0,
    )
    text = f"processor time of a frame while it plays: {MAX_FRAME_MS:g} ms"
    browser = shutil.which("chromium")
    if browser is None or importlib.util.find_spec("playwright") is None:
        yield skipped(text, "chromium or playwright")
        return
    with shown(page, browser) as watched:
        yield Claim(
            text=f"processor time of a jump to the end: {MAX_JUMP_MS:g} ms",
            ours=watched.jump_ms("replay.player.end"),
            theirs=MAX_JUMP_MS,
            unit="ms",
            at_most=1.0,
            note="from the beginning, with nothing prepared",
        )
        for where, time_s in (("from the beginning", 0.0), ("the last part", 600.0)):
            watched.jump_ms(str(time_s))
            frame_ms, rates = watched.play()
            yield Claim(
                text=f"{text}, {where}",
                ours=frame_ms,
                theirs=MAX_FRAME_MS,
                unit="ms",
                at_most=1.0,
                note=f"software rendering, 1280 x 800; {min(rates)} to {max(rates)} frames/s",
            )


BENCHMARKS: dict[str, Benchmark] = {"replay of a large run": large}


def real() -> Recording:
    """Return a run of four robots in one field."""
    spec = RunSpec(
        environment=inline(field(TEAM)),
        robots=(RobotSpec(range_finder=RangeFinderSpec(range_m=RANGE_M)),) * TEAM,
        radio=RadioSpec(range_m=RADIO_RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
        seed=1,
    )
    return simulate(spec, field(TEAM))


def multiplied(run: Recording) -> Recording:
    """Return the run of a team that is made of copies of a run, with `NODES` nodes at most."""
    step = 1.5 * TILE_M
    copies = [
        Copy(TEAM * number, 2.0 * math.pi * number / SIDE**2, step * (number % SIDE), step * row)
        for number in range(SIDE**2)
        for row in [number // SIDE]
    ]
    free = run.environment().free
    parts = [shapely.transform(part, copy.points) for copy in copies for part in free.geoms]
    world = Environment("16 fields", shapely.MultiPolygon(parts))
    spec = msgspec.structs.replace(
        run.spec, environment=inline(world), robots=run.spec.robots * len(copies)
    )
    starts = tuple(Configuration(*copy.place(start)) for copy in copies for start in run.starts)
    events = tuple(_limited(copy.event(event) for event in run.events for copy in copies))
    footer = msgspec.structs.replace(run.footer, time_s=max(event.time_s for event in events))
    return Recording(header=header_of(spec, world, starts), events=events, footer=footer)


def _limited(events: Iterable[AnyEvent]) -> Iterator[AnyEvent]:
    # Up to the last of the wanted nodes; of the copies of the last events some are left out.
    nodes = 0
    for event in events:
        nodes += isinstance(event, NodeAdded)
        if nodes > NODES:
            return
        yield event


class Copy:
    """What becomes of the events of a field that is turned and moved, with robots from `first` on.

    Angles differ, so that no numbers of two copies are alike, which would be packed as one.
    """

    def __init__(self, first: int, angle: float, x: float, y: float) -> None:
        self.first, self.angle, self.x, self.y = first, angle, x, y
        self.cos, self.sin = math.cos(angle), math.sin(angle)
        self.fields = (
            dict.fromkeys(("configuration", "target", "new_target"), self.place)
            | dict.fromkeys(("node", "parent"), self.name)
            | dict.fromkeys(("by", "master", "tree", "other"), self.robot)
            | dict.fromkeys(("gpr", "ger", "feasible", "unfeasible", "reached", "lost"), self.all)
            | dict.fromkeys(("open_frontier_m", "active_robots", "orders"), self.keys)
            | dict.fromkeys(("before", "after"), self.places_of)
            | dict.fromkeys(("arc", "frontier"), self.segments)
            | {
                "robot": self.robot,
                "boundary": lambda places: tuple(map(self.place, places)),
                "waypoints": lambda way: tuple((t, *self.place(pose)) for t, *pose in way),
                "nodes": lambda nodes: tuple(map(self.name, nodes)),
                "conflicts": lambda pairs: tuple(map(self.all, pairs)),
            }
        )

    def event(self, event: AnyEvent) -> AnyEvent:
        """Return an event of the copy."""
        fields = msgspec.structs.asdict(event)
        new = {key: self.fields[key](value) for key, value in fields.items() if key in self.fields}
        if isinstance(event, Decision):
            new["candidates"] = tuple((*self.place((x, y)), why) for x, y, why in event.candidates)
        elif isinstance(event, Supports):
            new["candidates"] = self.all(event.candidates)
        return msgspec.structs.replace(event, **new)

    def points(self, points: FloatArray) -> FloatArray:
        """Return points of the copy."""
        return np.array([self.place(point) for point in points.tolist()])

    def place(self, place: Any) -> Any:
        """Return a position or a pose of the copy; None for None."""
        if place is None:
            return None
        x, y = place[0] - TILE_M / 2.0, place[1] - TILE_M / 2.0
        turned = (self.cos * x - self.sin * y + self.x, self.sin * x + self.cos * y + self.y)
        return (*turned, *(heading + self.angle for heading in place[2:]))

    def robot(self, robot: Any) -> Any:
        """Return the number of a robot; None for None."""
        return None if robot is None else robot + self.first

    def name(self, node: Any) -> Any:
        """Return the name of a node; None for None."""
        return None if node is None else (node[0] + self.first, node[1])

    def all(self, robots: Any) -> Any:
        """Return numbers of robots."""
        return tuple(map(self.robot, robots))

    def keys(self, values: Any) -> Any:
        """Return values by robot."""
        return {robot + self.first: value for robot, value in values.items()}

    def places_of(self, places: Any) -> Any:
        """Return places by robot."""
        return self.keys({robot: self.place(place) for robot, place in places.items()})

    def segments(self, segments: Any) -> Any:
        """Return segments."""
        return tuple((*self.place((a, b)), *self.place((c, d))) for a, b, c, d in segments)


class Watched:
    """A page in a browser, and the processor time of its main thread."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.protocol = page.context.new_cdp_session(page)
        self.protocol.send("Performance.enable", {"timeDomain": "threadTicks"})

    def spent_ms(self) -> float:
        """Return the processor time up to now."""
        metrics = self.protocol.send("Performance.getMetrics")["metrics"]
        return 1e3 * float(next(m["value"] for m in metrics if m["name"] == "TaskDuration"))

    def jump_ms(self, time_s: str) -> float:
        """Go to a time, and return the processor time until all of it is drawn."""
        before = self.spent_ms()
        self.page.evaluate(f"replay.player.seek({time_s})")
        while not self.page.evaluate(DRAWN):
            self.page.wait_for_timeout(20)
        return self.spent_ms() - before

    def play(self) -> tuple[float, list[int]]:
        """Play, and return the processor time of a frame, and the frames of each second."""
        self.page.evaluate("replay.player.showRate(true)")
        self.page.keyboard.press(" ")
        self.page.wait_for_timeout(2000)
        before, rates = self.spent_ms(), []
        for _ in range(WATCHED_S):
            self.page.wait_for_timeout(1000)
            rates.append(int(str(self.page.text_content("#rate")).split()[0]))
        spent = self.spent_ms() - before
        self.page.keyboard.press(" ")
        return spent / max(1, sum(rates)), rates


@contextmanager
def shown(page: str, browser: str) -> Iterator[Watched]:
    """Open a page at its beginning."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = Path(folder) / "replay.html"
        file.write_text(page, encoding="utf-8")
        launched = playwright.chromium.launch(
            executable_path=browser, args=["--no-sandbox", "--disable-gpu"]
        )
        opened = launched.new_page(viewport={"width": 1280, "height": 800})
        opened.set_default_timeout(120_000)
        # Without the frontier, which is found ahead of time while the page is idle.
        opened.goto(f"{file.as_uri()}#t=0&speed=10&layers=truth")
        while not opened.evaluate(f"!!window.replay && {DRAWN}"):
            opened.wait_for_timeout(200)
        opened.evaluate(ALL_LAYERS)
        yield Watched(opened)
        launched.close()
