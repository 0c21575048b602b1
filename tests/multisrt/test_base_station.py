"""Where base stations are given, and where they are shown."""

import json
import re
import xml.etree.ElementTree as ET
from typing import Any, cast

import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.cli.run_options import spec_of_options
from multisrt.cli.summary import print_summary
from multisrt.drawing import tree_svg
from multisrt.drawing.animation.moving_svg import moving_svg
from multisrt.drawing.animation.pace import Pace
from multisrt.drawing.animation.painter import Painter
from multisrt.drawing.animation.scene import scene_of
from multisrt.drawing.colours import INK
from multisrt.environments.own_pictures import LINES_TO_STARTS
from multisrt.events import BaseLearned, NodeAdded, Sent
from multisrt.experiments.crossing import runs
from multisrt.experiments.from_keywords import from_keywords
from multisrt.experiments.measures import MEASURES, measure_named
from multisrt.explain.conditions import conditions
from multisrt.explain.moments import moments
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.replay.payload import payload
from multisrt.spec.keywords import base_of
from tests.multisrt.drawing.pictures import SVG, layers, lines, paths, texts

BASE = (6.0, 4.0)


@pytest.fixture(scope="module", params=["minpos", "srt-radial"])
def run(request) -> ms.Run:
    """Two robots in the apartment with a base station, until they are stopped."""
    return ms.explore(
        "apartment",
        strategy=request.param,
        robots=2,
        starts=[(4.0, 4.0), (7.0, 6.0)],
        radio_range_m=12.0,
        base=BASE,
        seed=1,
        max_time_s=30.0,
    )


# The doors ---------------------------------------------------------------------------------------


def test_a_base_is_a_pair_or_a_spec():
    base = ms.BaseSpec(x=1.0, y=2.0)
    assert base_of((1, 2.0)) == base_of(base) == base
    for wrong in ((1.0,), (1.0, 2.0, 3.0), 3.0, "xy"):
        with pytest.raises(ms.InvalidInputError, match="given as its place"):
            base_of(cast(Any, wrong))


def test_the_keyword_makes_the_spec(run):
    assert run.spec.base == ms.BaseSpec(x=BASE[0], y=BASE[1])
    with pytest.raises(ms.InvalidInputError, match=r"base station.*nearest place in free space"):
        ms.explore("apartment", base=(-5.0, 0.0))


def options(**given: object) -> dict[str, object]:
    names = (
        *("options", "start", "robot", "faults", "parameters"),
        *("robots", "starts", "seed", "max_time", "radio_range", "latency", "jitter", "loss"),
        *("walls", "footprint", "range_m", "beams", "drive", "speed", "turning_radius"),
        *("resolution", "threshold", "starts_from", "base", "no_multi_hop"),
    )
    empty = dict.fromkeys(names) | dict.fromkeys(names[:5], ()) | {"no_multi_hop": False}
    return empty | given


def test_the_option_makes_the_spec():
    assert spec_of_options("office", None, options(base="2,3.5")).base == ms.BaseSpec(x=2.0, y=3.5)
    assert spec_of_options("office", None, options()).base is None


@pytest.mark.parametrize("text", ["2", "2,3,4", "a,b", ""])
def test_a_wrong_option_is_told(text):
    with pytest.raises(Exception, match=rf"'{text}' is not X,Y"):
        spec_of_options("office", None, options(base=text))


def test_a_single_robot_with_a_base_has_use_for_a_radio():
    spec = spec_of_options("office", None, options(base="2,3", radio_range=5.0))
    assert spec.radio.range_m == 5.0
    with pytest.raises(ms.InvalidInputError, match="--radio-range is for teams"):
        spec_of_options("office", None, options(radio_range=5.0))
    with pytest.raises(ms.InvalidInputError, match="--starts is for teams"):
        spec_of_options("office", None, options(base="2,3", starts="clustered"))


def test_an_experiment_gives_its_base_to_all_runs():
    spec = from_keywords({"environments": "open", "strategies": "minpos", "base": (2, 3)})
    assert {planned.spec.base for planned in runs(spec)} == {ms.BaseSpec(x=2.0, y=3.0)}
    assert ms.ExperimentSpec.from_toml(spec.to_toml()) == spec
    without = from_keywords({"environments": "open", "strategies": "minpos"})
    assert all(planned.spec.base is None for planned in runs(without))
    assert "base" not in without.to_toml()


def test_measures_have_the_names_of_metrics(run):
    names = [m.name for m in MEASURES if m.name.startswith(("delivered", "delivery", "carrying"))]
    assert len(names) == 6
    assert all(hasattr(run.metrics, name) for name in names)
    assert not measure_named("delivered_coverage").lower_is_better


# What is shown -----------------------------------------------------------------------------------


def test_the_summary_has_rows_of_a_base(run, capsys, tmp_path):
    print_summary([run], [tmp_path])
    said = capsys.readouterr().out
    share = f"{100.0 * run.metrics.delivered_coverage:.2f} %"
    assert any("delivered to the base" in line and share in line for line in said.splitlines())
    assert "mean delivery delay to the base" in said


def test_the_map_shows_the_base_and_what_it_knows(run):
    svg = tree_svg(run.recording)
    there = layers(svg)
    [house] = lines(paths(there["base"]))
    assert np.allclose((house.min(axis=0) + house.max(axis=0))[0] / 2, BASE[0], atol=0.02)
    assert there["known to the base"].find(f"{SVG}path") is not None
    assert {"base station", "border of what the base knows"} <= set(texts(svg))
    bare = tree_svg(run.recording, without=["base", "delivered"])
    assert not {"base", "known to the base"} & set(layers(bare))
    [told] = [text for text in texts(bare) if "base" in text]
    assert told.endswith("delivered to the base station")


def test_the_border_of_what_the_base_knows_is_not_drawn_along_walls(run):
    border = lines(paths(layers(tree_svg(run.recording))["known to the base"]))
    walls = run.environment.free.boundary
    learned = {tuple(name) for event in run.recording.of(BaseLearned) for name in event.nodes}
    regions = [n.boundary for n in run.recording.of(NodeAdded) if (n.robot, n.serial) in learned]
    known = shapely.union_all([shapely.make_valid(shapely.Polygon(one)) for one in regions])
    for line in map(shapely.LineString, border):
        middle = line.interpolate(0.5, normalized=True)
        assert middle.distance(walls) > 0.02
        assert middle.distance(known.boundary) < 0.05
    lengths_m = sum(shapely.LineString(line).length for line in border)
    assert 0.0 < lengths_m < 0.5 * known.boundary.length


def test_a_picture_tells_what_was_delivered(run):
    share = 100.0 * run.metrics.delivered_coverage
    covered = 100.0 * run.metrics.coverage
    told = f"{covered:.1f} % covered, {share:.1f} % delivered to the base station"
    assert told in texts(tree_svg(run.recording))
    alone = ms.explore("open", strategy="minpos", seed=1, max_time_s=5.0)
    assert not [text for text in texts(tree_svg(alone.recording)) if "delivered" in text]


def house_of(starts: list[tuple[float, float]]) -> tuple[FloatArray, list[str]]:
    run = ms.explore("open", strategy="minpos", starts=starts, base=BASE, max_time_s=5.0)
    svg = tree_svg(run.recording)
    [house] = lines(paths(layers(svg)["base"]))
    return house, list(layers(svg))


def test_the_base_does_not_cover_a_start():
    away, _ = house_of([(9.0, 9.0)])
    here, order = house_of([BASE])
    assert np.allclose(np.ptp(here, axis=0), 1.8 * np.ptp(away, axis=0), atol=0.02)
    assert order.index("base") < order.index("robot 0: start")
    # In a team the number is beside the base station, with a line to the start.
    house, order = house_of([BASE, (9.0, 9.0)])
    assert np.allclose(np.ptp(house, axis=0), np.ptp(away, axis=0), atol=0.02)
    assert order.index("base") < order.index(LINES_TO_STARTS)
    _, order = house_of([(3.0, 3.0), (9.0, 9.0)])
    assert LINES_TO_STARTS not in order


def test_an_animation_shows_the_base(run):
    pace = Pace.of(30.0, duration_s=1.0, speed=None, fps=2.0)

    def scene(**more):
        return scene_of(run.recording, run.environment, pace, width=480, **more)

    ids = [e.get("id") for e in ET.fromstring(moving_svg(scene(), "")).iter()]
    assert ids.count("base") == 1
    ids = [e.get("id") for e in ET.fromstring(moving_svg(scene(without=["base"]), "")).iter()]
    assert "base" not in ids
    # In the middle of the house is ink, where the floor would be.
    found = scene()
    x, y = found.layout.origin
    at = round(x + found.layout.scale * BASE[0]), round(y - found.layout.scale * BASE[1])
    ink = tuple(int(INK[k : k + 2], 16) for k in (1, 3, 5))
    assert Painter(found).picture(0).getpixel(at) == ink
    assert Painter(scene(without=["base"])).picture(0).getpixel(at) != ink
    last = found.captions[-1].shown
    assert re.fullmatch(r"30 s, \d+\.\d % covered, \d+\.\d % at the base", last)


def test_a_replay_holds_the_base(run):
    [data] = payload([run.recording])["runs"]
    assert data["base"] == [6000, 4000]
    json.dumps(data, allow_nan=False)
    assert 2 in data["messages"]["robot"]
    assert 2 in data["links"]["other"]
    assert max(data["log"]["robot"]) < 2
    share = np.cumsum(data["curves"]["coverage"]["delivered"])[-1] / 1e4
    assert share == pytest.approx(run.metrics.delivered_coverage, abs=1e-4)
    assert "base station at (6, 4)" in conditions(run.spec)


def test_explanations_tell_of_deliveries(run):
    told = [line for moment in moments(run.recording, 0) for line in moment.lines]
    delivers = [e for e in run.recording.of(BaseLearned) if e.robot == 0]
    assert delivers
    if run.spec.strategy == "minpos":
        assert any("the base station learned" in line for line in told)
    assert run.why(robot=1, time_s=20.0)


def test_messages_of_a_base_are_on_record(run):
    sent = [event for event in run.recording.of(Sent) if event.robot == 2]
    assert {event.kind for event in sent} <= {"want", "acknowledgement"}
    assert run.metrics.messages_by_kind["acknowledgement"] > 0
    assert run.events().shape[0] == len(run.recording.events)
