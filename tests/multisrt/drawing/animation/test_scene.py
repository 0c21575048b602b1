"""What is shown when."""

import pytest

from multisrt.drawing.animation.pace import Pace
from multisrt.drawing.animation.scene import Scene, Span, scene_of
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording

PACE = Pace.of(40.0, duration_s=4.0, speed=None, fps=10.0)  # a picture for each second


def scene(recording: Recording, **given) -> Scene:
    return scene_of(recording, recording.environment(), PACE, **{"width": 960} | given)


@pytest.fixture(scope="module")
def hall(told) -> Scene:
    return scene(told)


def test_trees_grow_with_their_nodes(hall):
    assert [(dot.picture, dot.robot, dot.marker) for dot in hall.dots] == [
        (0, 0, "square"),
        (0, 2, "square"),
        (12, 1, "square"),
        (20, 0, "disc"),
    ]
    [edge] = hall.edges
    assert (edge.picture, edge.robot, edge.ends) == (20, 0, ((3.0, 3.0), (13.0, 3.0)))


def test_robots_do_what_the_events_say(hall):
    assert [actor.activities for actor in hall.actors] == [
        [Span(0, 10, "waits"), Span(10, 20, "moves"), Span(20, 30, "waits"), Span(30, 40, "done")],
        [
            Span(0, 12, "not started"),
            Span(12, 20, "waits"),
            Span(20, 30, "moves"),
            Span(30, 32, "waits"),
            Span(32, 36, "cut off"),
            Span(36, 40, "waits"),
        ],
        [Span(0, 16, "waits"), Span(16, 40, "dead")],
    ]


def test_goals_end_with_the_robot(hall):
    assert [actor.goals for actor in hall.actors] == [[], [], [(8, (16.0, 5.0)), (16, None)]]


def test_captions_say_time_and_coverage(hall, told):
    assert hall.captions[0].shown.startswith("0 s, ")
    assert hall.captions[-1].shown.startswith("40 s, ")
    assert [span.begin for span in hall.captions] == list(range(41))
    shares = [float(span.shown.split(", ")[1].split(" ")[0]) for span in hall.captions]
    assert shares == sorted(shares)
    assert 0.0 < shares[0] <= shares[-1] <= 100.0


def test_small_bodies_are_enlarged(told):
    discs = [abs(scene(told, width=width).actors[0].outline).max() for width in (200, 960, 2000)]
    # 7 pixels of 960 in a hall of 20 m are 0.15 m: less than the radius of 0.25 m.
    assert discs == pytest.approx([0.25] * 3, rel=0.01)
    box = scene(told).actors[1].outline
    assert box.tolist() == [[-0.4, -0.2], [0.4, -0.2], [0.4, 0.2], [-0.4, 0.2]]


@pytest.mark.parametrize("layer", ["areas", "edges", "nodes", "caption"])
def test_layers_can_be_left_out(told, layer):
    found = scene(told, without=[layer])
    shown = {
        "areas": found.pieces,
        "edges": found.edges,
        "nodes": found.dots,
        "caption": found.captions,
    }
    assert [name for name, things in shown.items() if not things] == [layer]


def test_unknown_layers_are_refused(told):
    with pytest.raises(InvalidInputError, match=r"no layer 'xyz'; .* areas, paths, edges"):
        scene(told, without=["xyz"])
    with pytest.raises(
        InvalidInputError, match=r"an animation has no layer 'outlines'; its layers"
    ):
        scene(told, without=["outlines"])


def test_short_activities_give_way_to_longer_ones(bidding):
    coarse = Pace.of(bidding.footer.time_s, duration_s=1.0, speed=None, fps=5.0)
    found = scene_of(bidding, bidding.environment(), coarse, width=400)
    for actor in found.actors:
        assert [span.begin for span in actor.activities[1:]] == [
            span.end for span in actor.activities[:-1]
        ]
        assert actor.activities[0].begin == 0
        assert actor.activities[-1].end == coarse.last
