"""The document that moves by itself: parsed, and in a browser."""

import base64
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from msgspec import structs

from multisrt.drawing.animation import save_animation
from multisrt.drawing.animation.looks import title_texts
from multisrt.drawing.animation.moving_svg import moving_svg
from multisrt.drawing.animation.pace import Pace
from multisrt.drawing.animation.scene import Scene, scene_of
from multisrt.drawing.layers import PICTURES
from multisrt.drawing.svg import text_width
from tests.browser import ARGUMENTS, chromium

SVG = "{http://www.w3.org/2000/svg}"
ANIMATED = (f"{SVG}animate", f"{SVG}animateTransform")


def scene(recording, **given) -> Scene:
    pace = Pace.of(recording.footer.time_s, duration_s=4.0, speed=None, fps=5.0)
    return scene_of(recording, recording.environment(), pace, width=960, **given)


@pytest.fixture(scope="module")
def hall(told) -> Scene:
    return scene(told)


@pytest.fixture(scope="module")
def document(hall) -> ET.Element:
    return ET.fromstring(moving_svg(hall, "described"))


def by_id(root: ET.Element, name: str) -> ET.Element:
    [found] = [element for element in root.iter() if element.get("id") == name]
    return found


def test_equal_runs_give_equal_bytes(told, hall):
    assert moving_svg(hall, "d") == moving_svg(scene(told), "d")


def test_the_document_has_a_title_and_no_script(document):
    assert document[0].tag == f"{SVG}title"
    assert "in hall, 3 robots" in document[0].text
    assert document[1].text == "described"
    tags = {element.tag.removeprefix(SVG) for element in document.iter()}
    assert not tags & {"script", "foreignObject", "image", "use", "a"}
    assert not [name for e in document.iter() for name in e.attrib if name.startswith("on")]


def test_everything_is_there_once(document, hall):
    areas, trees = by_id(document, "areas"), by_id(document, "trees")
    assert len(list(areas.iter(f"{SVG}path"))) == len(hall.pieces)
    # An edge and its node appear together; all but the first step have an animation.
    assert [len(step.findall(f"{SVG}path")) for step in trees] == [2, 1, 2]
    assert [len(step.findall(f"{SVG}animate")) for step in trees] == [0, 1, 1]
    assert len(by_id(document, "paths")) == 1
    assert len(by_id(document, "goals")) == 1
    assert len(by_id(document, "bodies")) == len(by_id(document, "bodies-at-the-end")) == 3
    assert len(list(by_id(document, "time").iter(f"{SVG}text"))) == len(hall.captions)
    listed = by_id(document, "robots").iter(f"{SVG}text")
    assert len(list(listed)) == sum(len(actor.activities) for actor in hall.actors)


@pytest.mark.parametrize("name", ["told", "trees", "bidding"])
def test_times_are_in_order_and_within_the_animation(request, name):
    document = ET.fromstring(moving_svg(scene(request.getfixturevalue(name)), ""))
    found = [element for element in document.iter() if element.tag in ANIMATED]
    assert len(found) > 20
    for element in found:
        times = [float(time) for time in element.get("keyTimes", "").split(";")]
        assert len(times) == len(element.get("values", "").split(";"))
        assert times[0] == 0.0
        assert times == sorted(times)
        assert times[-1] <= 1.0
        if element.get("calcMode") != "discrete":
            assert times[-1] == 1.0
        assert (element.get("dur"), element.get("repeatCount")) == ("6s", "indefinite")


def test_without_animations_the_end_is_shown(document):
    for layer in ("areas", "trees"):
        assert not [e for e in by_id(document, layer).iter() if e.get("visibility")]
    visible = [text.text for text in by_id(document, "time") if text.get("visibility") != "hidden"]
    assert [text for text in visible if text] == ["40 s, 7.9 % covered"]
    body = by_id(document, "robot-0")
    assert body.get("transform") == "translate(13 3)"
    listed = [
        text.text
        for text in by_id(document, "robots").iter(f"{SVG}text")
        if text.get("visibility") != "hidden"
    ]
    assert listed == ["0: done", "1: waits", "2: dead"]


@pytest.mark.parametrize("layer", PICTURES["animation"])
def test_layers_that_are_left_out_are_not_in_the_document(told, layer):
    whole = ET.fromstring(moving_svg(scene(told), ""))
    document = ET.fromstring(moving_svg(scene(told, without=[layer]), ""))
    drawn = {
        name: any(e.get("id") == name and len(e) for e in document.iter())
        for name in ("areas", "paths", "trees", "goals", "bodies", "time", "robots")
    }
    # The run has no base station.
    gone = {"caption": {"time", "robots"}, "edges": set(), "nodes": set(), "base": set()}.get(
        layer, {layer}
    )
    assert {name for name, there in drawn.items() if not there} == gone
    lines = [
        [path.get("fill") == "none" for path in by_id(found, "trees").iter(f"{SVG}path")]
        for found in (whole, document)
    ]
    left = {
        "edges": [one for one in lines[0] if not one],
        "nodes": [one for one in lines[0] if one],
    }
    assert lines[1] == left.get(layer, lines[0])


@pytest.mark.parametrize("width", [200, 320, 480, 640, 960])
def test_texts_beside_each_other_do_not_overlap(told, width):
    pace = Pace.of(told.footer.time_s, duration_s=4.0, speed=None, fps=5.0)
    found = scene_of(told, told.environment(), pace, width=width)
    document = ET.fromstring(moving_svg(found, ""))
    (title, *speed) = by_id(document, "title").findall(f"{SVG}text")
    begin, size = float(title.get("x", "")), float(title.get("font-size", ""))
    end = begin + text_width(title.text or "", size)
    for text in speed:
        wide = text_width(text.text or "", float(text.get("font-size", "")))
        assert end < float(text.get("x", "")) - wide
    assert end <= width
    assert speed or width < 480


def test_whole_details_of_a_title_are_left_out_where_there_is_no_room(told):
    pace = Pace.of(told.footer.time_s, duration_s=4.0, speed=None, fps=5.0)
    whole = scene_of(told, told.environment(), pace, width=960).title
    shown = set()
    for width in range(260, 960, 50):
        title, _ = title_texts(scene_of(told, told.environment(), pace, width=width))
        assert title == whole or title.endswith("…") or whole.startswith(f"{title}, ")
        assert title.count("…") == 0 or ", " not in title
        shown.add(title)
    assert len(shown) > 1


def test_titles_may_hold_any_characters(told):
    header = structs.replace(told.header, world='<b>&"\x00')
    text = moving_svg(scene(replace(told, header=header)), "")
    assert 'in <b>&"' in (ET.fromstring(text)[0].text or "")


# In a browser. ------------------------------------------------------------------------------


@pytest.fixture
def shown(browser, told, tmp_path):
    """Open the animation of the hall, and return a function that asks it at a time."""
    save_animation(told, tmp_path / "hall.svg", duration_s=4.0)
    text = (tmp_path / "hall.svg").read_text()

    def opened(**context):
        page = browser.new_page(**context)
        page.set_content(text[text.index("<svg") :])
        page.evaluate("document.querySelector('svg').pauseAnimations()")

        def at(time_s: float, asked: str):
            page.evaluate("t => document.querySelector('svg').setCurrentTime(t)", time_s)
            # The next frame shows it.
            return page.evaluate(
                f"new Promise(done => requestAnimationFrame(() => requestAnimationFrame("
                f"() => done({asked}))))"
            )

        return at

    return opened


CENTRE = """(() => {
  const box = document.querySelector('#%s circle, #%s path').getBoundingClientRect();
  return [box.x + box.width / 2, box.y + box.height / 2];
})()"""


def visible(layer: str) -> str:
    return (
        f"[...document.querySelectorAll('#{layer} path, #{layer} text')]"
        ".filter(e => getComputedStyle(e).visibility == 'visible').length"
    )


@pytest.mark.slow
def test_a_robot_moves_in_a_browser(shown, hall):
    at = shown()
    ask = CENTRE % ("robot-0 g", "robot-0 g")
    places = [at(time_s, ask) for time_s in (0.5, 1.5, 2.5)]
    # At 5, 15 and 25 s of the run: at x = 3, 8 and 13 m.
    assert places[1][0] - places[0][0] == pytest.approx(5.0 * hall.layout.scale, abs=0.5)
    assert places[2][0] - places[1][0] == pytest.approx(5.0 * hall.layout.scale, abs=0.5)
    assert places[2][1] == pytest.approx(places[0][1], abs=0.5)


@pytest.mark.slow
def test_things_appear_and_pass_in_a_browser(shown):
    at = shown()
    # 12 s and 20 s of the run are at 1.2 and 2 s.
    assert [at(t, visible("areas")) for t in (0.1, 1.3, 2.1, 5.9)] == [2, 3, 4, 4]
    assert [at(t, visible("time")) for t in (0.1, 1.3, 3.9, 5.9)] == [1, 1, 1, 1]
    assert [at(t, visible("robots")) for t in (0.1, 1.3, 3.9, 5.9)] == [3, 3, 3, 3]
    # Of robot 2 from 8 s until it dies.
    assert [at(t, visible("goals")) for t in (0.1, 1.1, 1.9, 5.9)] == [0, 1, 0, 0]
    # It starts again.
    assert at(6.1, visible("areas")) == 2


@pytest.mark.slow
def test_who_prefers_reduced_motion_sees_the_end(shown):
    at = shown(reduced_motion="reduce")
    assert [at(t, visible("areas")) for t in (0.1, 3.0)] == [4, 4]
    assert [at(t, visible("time")) for t in (0.1, 3.0)] == [1, 1]
    assert [at(t, visible("robots")) for t in (0.1, 3.0)] == [3, 3]
    shown_bodies = "getComputedStyle(document.querySelector('#%s')).display"
    assert at(0.1, shown_bodies % "bodies") == "none"
    assert at(0.1, shown_bodies % "bodies-at-the-end") == "inline"
    offset = "parseFloat(getComputedStyle(document.querySelector('#paths path')).strokeDashoffset)"
    assert at(0.1, offset) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("reduced", [False, True])
def test_it_moves_as_an_image_unless_the_reader_prefers_not(browser, told, tmp_path, reduced):
    save_animation(told, tmp_path / "hall.svg", duration_s=4.0, size=400)
    code = base64.b64encode((tmp_path / "hall.svg").read_bytes()).decode()
    # As a setting of the system, which reaches images; that of a page does not.
    arguments = [*ARGUMENTS, *(["--force-prefers-reduced-motion"] if reduced else [])]
    own = browser.browser_type.launch(executable_path=chromium(), args=arguments)
    try:
        page = own.new_page(reduced_motion="null")
        page.set_content(f"<img src='data:image/svg+xml;base64,{code}'>")
        before = page.screenshot()
        page.wait_for_timeout(700.0)
        assert (page.screenshot() == before) == reduced
    finally:
        own.close()
