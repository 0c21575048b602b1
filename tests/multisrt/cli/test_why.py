import pytest

from multisrt.recording import Recording


def test_why_explains_decisions(call, folder):
    call("explore", "pillar.wkt", "--out", "out", "--quiet")
    recording = "out/recording.jsonl"
    code, out, err = call("why", recording, "--robot", "0", "--time", "0")
    assert (code, err) == (0, "")
    assert "Robot 0 at 0.00 s: its last decision was at 0.00 s." in out
    assert "at node 0" in out
    code, out, _ = call("why", recording)
    assert code == 0
    assert "it chose end" in out
    code, out, _ = call("why", recording, "--all")
    decisions = [e for e in Recording.load(recording).events if type(e).__name__ == "Decision"]
    assert code == 0
    assert len(out.splitlines()) == 1 + len(decisions)


def test_a_robot_that_was_told_its_route_decides_nothing(call):
    call("explore", "room.wkt", "--strategy", "informed", "--out", "out", "--quiet")
    code, out, err = call("why", "out/recording.jsonl")
    assert (code, err) == (0, "")
    assert "a route that was planned on the true map" in out
    assert call("why", "out/recording.jsonl", "--all")[0] == 0


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["out/recording.jsonl", "--robot", "1"], "no robot 1: the team has one robot, number 0"),
        (["out/recording.jsonl", "--robot", "-1"], "there is no robot -1"),
        (["out/recording.jsonl", "--robot", "1", "--all"], "there is no robot 1"),
        (["out/recording.jsonl", "--time", "1e6"], "not within the run"),
        (["out/recording.jsonl", "--time", "-1"], "not within the run"),
        (["out/recording.jsonl", "--time", "nan"], "not within the run"),
        (["none.jsonl"], "none.jsonl does not exist: name the folder of a run"),
        (["room.wkt"], "room.wkt is not a recording"),
    ],
)
def test_why_refuses_bad_input(call, folder, words, named):
    call("explore", "room.wkt", "--out", "out", "--quiet")
    code, out, err = call("why", *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert named in err


def test_why_finds_the_recording_in_a_folder(call, folder):
    call("explore", "room.wkt", "--out", "one", "--quiet")
    words = "--strategy", "closest", "--strategy", "srt-star", "--out", "two", "--quiet"
    call("explore", "room.wkt", *words)
    assert call("why", "one") == call("why", "one/recording.jsonl")
    assert call("why", "two/closest") == call("why", "two/closest/recording.jsonl")
    assert call("why", "two")[2] == (
        "error: two holds 2 runs: name one of two/closest, two/srt-star\n"
    )
    assert call("why", "one/run.json")[2] == (
        "error: one/run.json is not a recording; the recording of the run is one/recording.jsonl\n"
    )
    (folder / "none").mkdir()
    assert call("why", "none")[2] == (
        "error: none holds no run: there is no recording.jsonl in it\n"
    )
