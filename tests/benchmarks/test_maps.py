"""The table of maps: what is read, with which body and scale, and what the page says of it."""

import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from benchmarks import maps
from multisrt.experiments.store import Store

ROOM = "POLYGON ((0 0, 6 0, 6 4, 0 4, 0 0))"
NARROW = "POLYGON ((0 0, 6 0, 6 0.4, 0 0.4, 0 0))"


@pytest.fixture
def folder(tmp_path):
    found = tmp_path / "maps"
    (found / "plans").mkdir(parents=True)
    (found / "README.md").write_text("# Maps\n")
    (found / "room.wkt").write_text(ROOM)
    (found / "plans" / "narrow.wkt").write_text(NARROW)
    (found / "plans" / "room.wkt").write_text(ROOM)
    (found / "open.wkt").write_text("POLYGON ((0 0, 6 0, 6 4))")
    pixels = np.full((60, 80), 255, np.uint8)
    pixels[[0, -1], :] = pixels[:, [0, -1]] = 0
    Image.fromarray(pixels).save(found / "scan.png")
    return found


def test_files_are_read_or_refused(folder):
    subjects, refused = maps.read_all(folder)
    by_label = {subject.label: subject for subject in subjects}
    assert list(by_label) == ["plans/narrow.wkt", "plans/room.wkt", "room.wkt", "scan.png"]
    assert list(refused) == ["open.wkt"]
    assert refused["open.wkt"].startswith("open.wkt")
    assert by_label["scan.png"].world.area_m2 == pytest.approx(78 * 58 * 0.05**2)
    assert by_label["room.wkt"].body == "disc:0.25"
    # The default body does not fit: half of 0.4 m, less 0.1 m.
    assert by_label["plans/narrow.wkt"].body == "disc:0.1"


def test_a_team_file_is_read_with_its_image(tmp_path):
    pixels = np.full((60, 80), 255, np.uint8)
    pixels[[0, -1], :] = pixels[:, [0, -1]] = 0
    Image.fromarray(pixels).save(tmp_path / "rooms.png")
    line = "{0} robot{0} {1} 20 0 100 100 1000 Explorer 1 1\n"
    (tmp_path / "team_2rooms.txt").write_text(line.format(1, 20) + line.format(2, 60))
    subjects, refused = maps.read_all(tmp_path)
    assert not refused
    assert [subject.format for subject in subjects] == ["image", "image and team"]
    assert subjects[1].starts == "suggested"


@pytest.mark.slow
def test_the_page_has_a_row_for_each_map(folder, tmp_path, monkeypatch, capsys):
    out = tmp_path / "out"
    words = ["maps", str(folder), "--out", str(out), "--workers", "1"]
    monkeypatch.setattr(sys, "argv", words)
    maps.main()
    page = (out / "maps.md").read_text()
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| `")]
    assert [row[0] for row in rows] == [
        "| `plans/narrow.wkt`",
        "| `plans/room.wkt`",
        "| `room.wkt`",
        "| `scan.png`",
    ]
    # One room in two files is explored once.
    assert "6 of 6 runs ended complete" in page
    assert rows[1][1:] == rows[2][1:]
    assert "`open.wkt`: open.wkt" in page
    with Store.open(out / "maps.sqlite") as store:
        results = store.results()
    coverage = {
        (result.condition.environment, result.condition.strategy): result.metrics.coverage
        for result in results
        if result.metrics is not None
    }
    assert rows[1][6] == f"{coverage['plans/room.wkt', 'srt-radial']:.3f}"
    drawn = ET.parse(out / "maps.svg").getroot()
    assert len(drawn.findall("{http://www.w3.org/2000/svg}svg")) == 4
