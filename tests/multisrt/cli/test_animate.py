"""`multisrt animate`."""

import xml.etree.ElementTree as ET

import pytest


@pytest.fixture
def run(call):
    """A run in the folder out."""
    call("explore", "pillar.wkt", "--out", "out", "--quiet")


def test_a_run_becomes_a_document_beside_its_recording(call, folder, run):
    assert call("animate", "out") == (0, "out/animation.svg\n", "")
    root = ET.parse(folder / "out" / "animation.svg").getroot()
    assert root.get("width") == "960"
    assert call("animate", "out/recording.jsonl")[0] == 2
    before = (folder / "out" / "animation.svg").read_bytes()
    assert call("animate", "out/tree.svg", "--force")[0] == 2
    assert call("animate", "out/recording.jsonl", "--force")[0] == 0
    assert (folder / "out" / "animation.svg").read_bytes() == before


def test_options_reach_the_animation(call, folder, run):
    words = "--out", "a.svg", "--size", "300x200", "--speed", "10", "--fps", "2"
    assert call("animate", "out", *words, "--without", "areas", "--without", "caption")[0] == 0
    root = ET.parse(folder / "a.svg").getroot()
    assert (root.get("width"), root.get("height")) == ("300", "200")
    groups = {e.get("id"): e for e in root.iter() if e.get("id")}
    assert not list(groups["areas"])
    assert "time" not in groups
    call("animate", "out", "--out", "b.svg", "--duration", "5")
    durations = {e.get("dur") for e in ET.parse(folder / "b.svg").getroot().iter()} - {None}
    assert durations == {"7s"}


@pytest.mark.slow
def test_films_are_written_by_their_suffix(call, folder, run):
    for name, begins in (("a.gif", b"GIF89a"), ("b.MP4", b"\0\0\0")):
        words = "--out", name, "--duration", "1", "--fps", "5", "--size", "240"
        assert call("animate", "out", *words) == (0, f"{name}\n", "")
        assert (folder / name).read_bytes().startswith(begins)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["out", "--out", "a.webm"],
            "animations are files of the formats .mp4, .gif, .svg; a.webm",
        ),
        (["out", "--out", "none/a.svg"], "none/a.svg"),
        (["out", "--size", "960x"], "--size '960x' is not a size; give a width (960)"),
        (["out", "--size", "9"], "width of the animation is 9 pixels; give 200 to 4096"),
        (["out", "--duration", "0"], "give a number from 0.5 to 600"),
        (["out", "--duration", "5", "--speed", "5"], "give one of them"),
        (["out", "--speed", "nan"], "the speed is nan"),
        (["out", "--fps", "0", "--out", "a.gif"], "pictures a second is 0.0"),
        (["out", "--without", "walls"], "'walls' is not one of"),
        (["out", "--without", "outlines"], "'outlines' is not one of areas, paths, edges"),
        (["none"], "none does not exist: name the folder of a run"),
        (["none", "--out", "a.webm"], "animations are files of the formats"),
        (["."], "holds no run"),
    ],
)
def test_bad_input_is_one_line(call, folder, run, words, said):
    if words == ["."]:
        (folder / "out" / "recording.jsonl").unlink()
    code, out, err = call("animate", *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert said in err
    assert not list(folder.rglob("*.part"))
    assert not list(folder.rglob("animation.svg"))
