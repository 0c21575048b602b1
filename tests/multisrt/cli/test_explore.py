import json
import os
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from multisrt.informed import reference
from multisrt.recording import Recording
from tests.multisrt.cli.commands import everything

FILES = ["recording.jsonl", "run.json", "spec.toml", "tree.svg"]


def test_explore_writes_its_files(call, folder):
    code, out, err = call("explore", "room.wkt", "--seed", "3")
    assert (code, err) == (0, "")
    assert "srt-radial in room, seed 3: complete" in out
    assert re.search(r"success \(95 % covered\) +yes", out)
    assert re.search(r"map known complete at +[\d.]+ s", out)
    assert re.search(r"\bended at \(makespan\) +[\d.]+ s", out)
    results = folder / "runs" / "room-srt-radial-3"
    assert sorted(os.listdir(results)) == FILES
    summary = json.loads((results / "run.json").read_text())
    recording = Recording.load(results / "recording.jsonl")
    assert summary["outcome"] == "complete"
    assert summary["digest"] == recording.footer.digest
    assert summary["spec"] == json.loads(recording.spec.to_json())
    assert summary["metrics"]["coverage"] > 0.99
    assert ET.parse(results / "tree.svg").getroot().tag.endswith("svg")
    for name in FILES:
        assert str(Path("runs") / "room-srt-radial-3" / name) in out


def test_the_size_of_the_world_is_told_where_progress_is_shown(call, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    code, _, err = call("explore", "room.wkt", "--max-time", "1")
    assert code == 3
    assert err.count("room: 6 x 5 m, 30 m2 free\n") == 1
    assert "6 x 5 m" not in call("explore", "room.wkt", "--max-time", "1", "--quiet")[2]


def test_explore_with_many_options(call, folder):
    code, _, err = call(
        *("explore", "pillar.wkt", "--strategy", "srt-star", "--seed", "1", "--out", "a/b"),
        *("--start", "1.5,1.5,0.5", "--range", "3", "--beams", "360", "--footprint", "box:0.5x0.3"),
        *("--drive", "holonomic", "--speed", "1", "--max-time", "5000", "--option", "cones=12"),
        *("--option", "backtrack=nearest_open", "--quiet"),
    )
    assert (code, err) == (0, "")
    spec = Recording.load(folder / "a" / "b" / "recording.jsonl").spec
    assert spec.strategy == "srt-star"
    assert spec.options == {"cones": "12", "backtrack": "nearest_open"}
    assert spec.robots[0].start == (1.5, 1.5, 0.5)
    assert spec.robots[0].range_finder.beams == 360
    assert spec.robots[0].drive.kind == "holonomic"
    assert spec.stop.max_time_s == 5000.0


def test_quiet_prints_nothing(call):
    assert call("explore", "room.wkt", "--quiet") == (0, "", "")


def test_a_run_is_replaced_only_by_force(call, folder):
    call("explore", "pillar.wkt", "--out", "out", "--quiet")
    (folder / "out" / "notes.txt").write_text("mine")
    before = everything(folder)
    code, out, err = call("explore", "pillar.wkt", "--out", "out", "--seed", "1")
    assert (code, out) == (2, "")
    assert err == (
        "error: out holds a run already: name another folder (--out), or replace the run with "
        "--force\n"
    )
    assert everything(folder) == before
    assert call("explore", "pillar.wkt", "--out", "out", "--quiet", "--force") == (0, "", "")
    assert everything(folder) == before


def test_runs_without_out_get_folders_of_their_own(call, folder):
    for _ in range(2):
        assert call("explore", "room.wkt", "--quiet") == (0, "", "")
    first, last = (Path("runs") / name for name in ("room-srt-radial-0", "room-srt-radial-0-3"))
    assert call("explore", "room.wkt")[1].endswith(
        f"{first} is there already: this is in {last}\n"
        "all measures: in run.json, or here with --details\n"
        f"next: multisrt view {last}\nnext: multisrt why {last} --robot 0\n"
    )
    names = ["room-srt-radial-0", "room-srt-radial-0-2", "room-srt-radial-0-3"]
    assert sorted(os.listdir(folder / "runs")) == names
    for _ in range(2):
        call("explore", "room.wkt", "--strategy", "closest", "--strategy", "minpos", "--quiet")
    assert sorted(os.listdir(folder / "runs" / "room-0-2")) == ["closest", "minpos"]


def test_no_strategy_runs_if_a_run_of_one_is_there(call, folder):
    call("explore", "room.wkt", "--strategy", "minpos", "--out", "both/minpos", "--quiet")
    before = everything(folder)
    words = "--strategy", "closest", "--strategy", "minpos", "--out", "both"
    code, _, err = call("explore", "room.wkt", *words)
    assert (code, err.partition(" already")[0]) == (2, "error: both/minpos holds a run")
    assert everything(folder) == before


def test_many_strategies_fit_and_the_best_is_marked(call, monkeypatch):
    names = ("closest", "greedy", "minpos", "utility", "srt-radial", "srt-star", "srt-ball")
    words = [word for name in names for word in ("--strategy", name)]
    monkeypatch.setattr("multisrt.terminal.WIDTH", 80)
    code, out, _ = call("explore", "room.wkt", "--robots", "2", *words)
    assert code == 0
    assert "…" not in out
    assert max(map(len, out.splitlines())) <= 80
    told = out.rpartition(" strategy ")[2]
    assert re.match(r" +success +covered +95 % \(s\) +known \(s\) +done \(s\) +driven \(m\)", told)
    assert len(out.splitlines()) < 50
    assert all(re.search(rf"^ {name} +yes +\d", told, re.M) for name in names)
    assert told.count("* ") >= 5
    code, out, _ = call("explore", "room.wkt", "--robots", "2", "--details", *words)
    assert code == 0
    assert max(map(len, out.splitlines())) <= 80
    assert len(re.findall(r"^ smallest clearance to walls ", out, re.M)) > 1


@pytest.mark.slow
def test_out_of_time_is_exit_code_3(call, folder):
    code, out, err = call("explore", "pillar.wkt", "--range", "2", "--max-time", "5", "--out", "o")
    assert (code, err) == (3, "")
    assert "out of time, but only" in out
    assert (folder / "o" / "tree.svg").exists()


def test_stalled_is_exit_code_3(call):
    code, out, _ = call(
        *("explore", "office", "--seed", "1"),
        *("--option", "approach=false", "--option", "complete=false"),
    )
    assert code == 3
    assert "stalled" in out


def test_a_body_too_wide_for_a_door_is_reported(call):
    code, out, err = call("explore", "narrow.wkt", "--start", "1,1", "--range", "3", "--details")
    assert err == ""
    # The door is too narrow to pass; the other room is seen as far as the range allows.
    assert code == 0
    (explorable,) = re.findall(r"covered .* of ([\d.]+) m2 explorable", out)
    (free,) = re.findall(r"free space +([\d.]+) m2", out)
    assert float(free) == pytest.approx(60.1, abs=0.1)
    assert 30.0 < float(explorable) < 45.0
    assert re.search(r"body disc:0\.25 only [\d.]+ of 60\.1 m2 of free space", out)
    assert re.search(r"too narrow|not reachable|seen from near", out)


def test_a_spec_repeats_its_run(call, folder):
    code, first, _ = call("explore", "pillar.wkt", "--seed", "5", "--out", "a")
    assert code == 0
    again = call("explore", "--spec", "a/spec.toml", "--out", "b")
    assert again == (0, re.sub(r"\ba(?=/| --|$)", "b", first, flags=re.M), "")
    for name in FILES:
        assert (folder / "a" / name).read_bytes() == (folder / "b" / name).read_bytes()
    (folder / "spec.json").write_text(Recording.load("a/recording.jsonl").spec.to_json())
    assert call("explore", "--spec", "spec.json", "--quiet") == (0, "", "")
    assert sorted(os.listdir(folder / "runs" / "spec-srt-radial-5")) == FILES


def test_two_strategies_side_by_side(call, folder):
    code, out, err = call(
        *("explore", "pillar.wkt", "--strategy", "srt-radial", "--strategy", "srt-star"),
        *("--out", "both"),
    )
    assert (code, err) == (0, "")
    assert sorted(os.listdir(folder / "both")) == ["srt-radial", "srt-star"]
    assert re.search(r"measure +srt-radial +srt-star", out)
    distances = []
    assert "and beside each run.json, spec.toml and recording.jsonl" in out
    for name in ("srt-radial", "srt-star"):
        assert sorted(os.listdir(folder / "both" / name)) == FILES
        assert f"both/{name}/tree.svg" in out
        assert f"{name} in pillar, seed 0: complete" in out
        metrics = json.loads((folder / "both" / name / "run.json").read_text())["metrics"]
        distances.append(f"{metrics['total_distance_m']:.1f} m")
    assert re.search(rf"distance +{distances[0]} +{distances[1]} *\n", out)
    assert max(map(len, out.splitlines())) <= 100


def test_one_incomplete_run_of_two_is_exit_code_3(call):
    words = "--strategy", "srt-radial", "--strategy", "srt-star", "--max-time", "3"
    code, out, _ = call("explore", "pillar.wkt", "--range", "2", *words)
    assert code == 3
    assert "runs/pillar-0/srt-star/tree.svg" in out


def test_an_interrupted_run_leaves_no_files(call, folder, monkeypatch):
    def interrupted(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("multisrt.simulation.sensing.take_scan", interrupted)
    before = everything(folder)
    code, out, err = call("explore", "room.wkt", "--out", "new/results")
    assert (code, out, err.strip()) == (130, "", "interrupted")
    assert everything(folder) == before


@pytest.mark.slow
def test_summary_of_a_bidding_team(call, folder):
    words = ("room.wkt", "--strategy", "minpos", "--robots", "2", "--radio-range", "15")
    code, out, _ = call("explore", *words, "--out", "bids", "--details")
    assert code == 0
    assert re.search(r"informative scans +\d+", out)
    assert re.search(r"some robot isolated for +0\.0 s\b", out)
    assert re.search(r"longest isolation +0\.0 s\b", out)
    assert re.search(r"known to one robot only, over time +\d+ m2 s\b", out)
    assert re.search(r"known to one robot only, at the end +0\.0 m2\b", out)
    assert "nodes" not in out
    code, out, _ = call("why", "bids/recording.jsonl", "--robot", "1", "--time", "0")
    assert code == 0
    assert "How it chose: minpos" in out
    assert "> robot 1" in out


def test_regret_is_printed_as_multiples(call, monkeypatch, tmp_path):
    monkeypatch.setattr(reference, "_folder", lambda: tmp_path / "cache")
    code, out, err = call("explore", "pillar.wkt", "--range", "3", "--regret")
    assert (code, err) == (0, "")
    for name in ("time to 99 % / informed", "makespan / informed", "makespan / lower bound"):
        found = re.search(rf"{name} +(\d+\.\d\d)", out)
        assert found is not None
        assert float(found[1]) >= 1.0


def test_a_spec_names_its_missing_map(call, folder):
    (folder / "runs").mkdir()
    spec = folder / "runs" / "spec.toml"
    spec.write_text('[environment]\nfrom = "file"\npath = "gone.wkt"\n')
    words = ("explore", "--spec", "runs/spec.toml", "--out", "again")
    code, out, err = call(*words)
    assert (code, out) == (2, "")
    assert err == (
        f"error: runs/spec.toml names the file gone.wkt, relative to the working folder: "
        f"{folder}/gone.wkt does not exist, and neither does runs/gone.wkt; run the command in the "
        "folder to which the name is relative, or correct 'path' in the spec\n"
    )
    (folder / "room.wkt").rename(folder / "runs" / "gone.wkt")
    code, _, err = call(*words)
    assert code == 2
    assert "gone.wkt does not exist, but runs/gone.wkt does; run the command in" in err
    spec.write_text(f'[environment]\nfrom = "file"\npath = "{folder}/gone.wkt"\n')
    assert f"names the file {folder}/gone.wkt, which does not exist; restore" in call(*words)[2]
    assert not (folder / "again").exists()
