import errno
import hashlib
import json
import os
from pathlib import Path

import msgspec
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Died, Ended, GoalChosen, Learned, Motion, NodeAdded
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import FORMAT, Header, Recorder, Recording, atomic_write, header_of
from multisrt.recording.lines import WITHOUT_BASE
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RunSpec

WORLD = Environment(
    "two rooms",
    shapely.box(0, 0, 9, 5).difference(shapely.box(4, 0, 4.2, 3.5)),
    starts=[(1.0, 1.0)],
)
SPEC = RunSpec(environment=inline(WORLD), seed=1)


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate(SPEC, WORLD)


@pytest.fixture
def lines(recording, tmp_path) -> list[bytes]:
    recording.save(tmp_path / "whole.jsonl")
    return (tmp_path / "whole.jsonl").read_bytes().splitlines(keepends=True)


def load(folder: Path, *parts: list[bytes]) -> Recording:
    path = folder / "changed.jsonl"
    path.write_bytes(b"".join(line for part in parts for line in part))
    return Recording.load(path)


def signed(lines: list[bytes]) -> list[bytes]:
    """Return the lines with their digest, computed as documented."""
    head, *events, last = lines
    header = msgspec.json.decode(head, type=Header)
    about = header.spec, header.free, header.starts
    parts = [msgspec.json.encode(part) + b"\n" for part in about]
    digest = hashlib.sha256(b"".join([*parts, *events])).hexdigest()
    return [head, *events, changed(last, digest=digest)]


def changed(line: bytes, **fields) -> bytes:
    return json.dumps(json.loads(line) | fields).encode() + b"\n"


def test_a_saved_recording_is_loaded_again(recording, tmp_path):
    recording.save(tmp_path / "run.jsonl")
    again = Recording.load(tmp_path / "run.jsonl")
    assert again.header == recording.header
    assert again.events == recording.events
    assert again.footer == recording.footer
    assert again.spec == SPEC
    assert again.starts == recording.starts == ((1.0, 1.0, 0.0),)
    assert again.environment().free.equals(WORLD.free)
    again.save(tmp_path / "again.jsonl")
    assert (tmp_path / "again.jsonl").read_bytes() == (tmp_path / "run.jsonl").read_bytes()


def test_there_is_every_kind_of_line(recording):
    kinds = {type(event).__name__ for event in recording.events}
    assert kinds >= {"NodeAdded", "Decision", "Motion", "MapComplete", "Ended"}
    assert recording.header.format == FORMAT
    assert recording.header.format_version == WITHOUT_BASE
    versions = recording.header.versions
    assert {"multisrt", "numpy", "numba", "shapely", "geos", "python", "architecture"} <= set(
        versions
    )


def test_events_of_a_kind_come_in_order(recording):
    for kind in (Motion, NodeAdded, Ended):
        assert list(recording.of(kind)) == [e for e in recording.events if type(e) is kind]
    assert len(recording.of(Motion)) > 1
    assert list(recording.of(Died)) == []


def test_metrics_of_a_reloaded_recording_are_the_same(recording, tmp_path):
    recording.save(tmp_path / "run.jsonl")
    again = Recording.load(tmp_path / "run.jsonl")
    assert measure(again) == measure(recording, WORLD)


def test_a_recording_is_written_as_the_run_goes(tmp_path, recording):
    path = tmp_path / "run.jsonl"
    part = tmp_path / "run.jsonl.part"
    seen = []

    def watch(event):
        assert part.exists()
        assert not path.exists()
        seen.append(event)

    simulate(SPEC, WORLD, path=path, watch=watch)
    assert os.listdir(tmp_path) == ["run.jsonl"]
    assert Recording.load(path).events == tuple(seen) == recording.events


def test_equal_places_and_names_are_held_once():
    # Tuples of values that are not known when the test is compiled are different objects.
    def goal(robot: int) -> GoalChosen:
        frontiers = tuple((float(x), 2.0) for x in range(3 + robot))
        return GoalChosen(time_s=1.0, robot=robot, rule="r", because="b", goal=None,
                          frontiers=frontiers)  # fmt: skip

    def learned(robot: int) -> Learned:
        return Learned(time_s=2.0, robot=robot, nodes=tuple((n, 7) for n in range(2)))

    recorder = Recorder(header_of(SPEC, WORLD, (Configuration(1.0, 1.0),)))
    said: list[AnyEvent] = [goal(0), goal(1), learned(0), learned(1)]
    for event in said:
        recorder.record(event)
    assert recorder.events == said
    first, second = (e.frontiers for e in recorder.events if isinstance(e, GoalChosen))
    assert all(a is b for a, b in zip(first, second, strict=False))
    one, other = (e.nodes for e in recorder.events if isinstance(e, Learned))
    assert one is other


def test_a_run_that_fails_leaves_nothing(tmp_path):
    def watch(event):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        simulate(SPEC, WORLD, path=tmp_path / "run.jsonl", watch=watch)
    assert os.listdir(tmp_path) == []


def test_an_earlier_recording_stays_when_a_run_fails(tmp_path):
    path = tmp_path / "run.jsonl"
    path.write_text("precious")

    def watch(event):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(SPEC, WORLD, path=path, watch=watch)
    assert path.read_text() == "precious"
    assert os.listdir(tmp_path) == ["run.jsonl"]


def test_a_recording_that_was_cut_off(tmp_path, lines):
    with pytest.raises(InvalidInputError, match="cut off"):
        load(tmp_path, lines[:-1])
    with pytest.raises(InvalidInputError, match="cut off"):
        load(tmp_path, lines[:1])
    with pytest.raises(InvalidInputError, match=f"line {len(lines)}"):
        load(tmp_path, lines[:-1], [lines[-1][:20]])


def test_an_empty_file_is_no_recording(tmp_path):
    with pytest.raises(InvalidInputError, match="no header"):
        load(tmp_path, [])


@pytest.mark.parametrize(
    "garbage",
    [
        b"\n",
        b"not json\n",
        b"{}\n",
        b"[1, 2]\n",
        b"\xff\xfe\x00\n",
        b'{"event":"teleport","time_s":0,"robot":0}\n',
        b'{"event":"motion","time_s":0,"robot":0}\n',
        b'{"event":"motion","time_s":"now","robot":0,"waypoints":[[0,0,0,0]]}\n',
        b'{"event":"motion","time_s":NaN,"robot":0,"waypoints":[[0,0,0,0]]}\n',
        b'{"event":"motion","time_s":0,"robot":0,"waypoints":[[0,Infinity,0,0]]}\n',
        b'{"event":"motion","time_s":0,"robot":0,"waypoints":[[0,1e999,0,0]]}\n',
        b'{"event":"motion","time_s":0,"robot":0,"waypoints":[[0,0,0]]}\n',
        b'{"event":"motion","time_s":0,"robot":0,"waypoints":[]}\n',
        b'{"event":"motion","time_s":0,"robot":1,"waypoints":[[0,0,0,0]]}\n',
        b'{"event":"motion","time_s":0,"robot":-1,"waypoints":[[0,0,0,0]]}\n',
        b'{"event":"motion","x":' + b"[" * 100_000 + b"\n",
    ],
)
def test_an_invalid_line_is_named(tmp_path, lines, garbage):
    with pytest.raises(InvalidInputError, match=r"changed\.jsonl, line 3: "):
        load(tmp_path, lines[:2], [garbage], lines[2:])


NODE = '"time_s":0,"robot":0'


@pytest.mark.parametrize(
    ("event", "said"),
    [
        ('"motion",$,"waypoints":[[2,0,0,0],[1,1,0,0]]', "never fall"),
        ('"motion",$,"waypoints":[[0,0,0,0],[1,0,-2e9,0]]', r"none lies farther than 1e\+09 m"),
        ('"motion",$,"waypoints":[[0,0,0,0],[1,0,0,-13]]', "turns by more than"),
        (
            '"node",$,"serial":99,"parent":null,"configuration":[1e19,0,0],"stage":"draw",'
            '"boundary":[[0,0],[1,0],[1,1]],"tags":"000"',
            "none lies farther",
        ),
        (
            '"node",$,"serial":99,"parent":null,"configuration":[0,0,0],"stage":"draw",'
            '"boundary":[[0,0],[1,0],[1,1e19]],"tags":"000"',
            r"reaches 1e\+19 m, but robot 0 sees",
        ),
        ('"decision",$,"node":[0,99],"frontier_m":1,"choice":"end","target":null', "node 99"),
        ('"decision",$,"node":[1,0],"frontier_m":1,"choice":"end","target":null', "node 0 of"),
        ('"decision",$,"node":0,"frontier_m":1,"choice":"end","target":null', "node"),
        (
            '"decision",$,"node":[0,0],"frontier_m":1,"choice":"end","target":null,"ger":[0,3]',
            "robot 3",
        ),
        ('"arc_closed",$,"node":[0,99],"reason":"too narrow","arc":[]', "node 99"),
        ('"arc_reopened",$,"node":[0,99],"arc":[]', "node 99"),
        ('"learned",$,"nodes":[[0,0],[0,99]]', "node 99"),
        ('"sent",$,"kind":"map","size_bytes":9,"reached":[7]', "robot 7"),
        ('"sent",$,"kind":"map","size_bytes":9,"lost":[-1]', "robot -1"),
        ('"taken_as_lost",$,"other":4', "robot 4"),
        ('"blocked",$,"by":1,"configuration":[0,0,0]', "robot 1"),
        (
            '"supports",$,"tree":2,"open_frontier_m":{},"active_robots":{},"candidates":[]',
            "robot 2",
        ),
        (
            '"supports",$,"tree":null,"open_frontier_m":{"6":1},"active_robots":{},"candidates":[]',
            "robot 6",
        ),
        (
            '"organized",$,"feasible":[],"unfeasible":[],"before":{"5":[0,0]},"after":{},'
            '"orders":{},"conflicts":[]',
            "robot 5",
        ),
        (
            '"organized",$,"feasible":[],"unfeasible":[],"before":{},"after":{},"orders":{},'
            '"conflicts":[[0,8]]',
            "robot 8",
        ),
        (
            '"coordinated",$,"ger":[0],"master":9,"feasible":[],"unfeasible":[],"target":[0,0],'
            '"order":"wait","new_target":[0,0]',
            "robot 9",
        ),
    ],
)
def test_impossible_events_are_refused(tmp_path, lines, event, said):
    line = b'{"event":' + event.replace("$", NODE).encode() + b"}\n"
    with pytest.raises(InvalidInputError, match=rf"changed\.jsonl, line 3: .*{said}"):
        load(tmp_path, signed([*lines[:2], line, *lines[2:]]))


def test_a_recording_that_was_changed_after_the_run(tmp_path, lines):
    assert json.loads(signed(lines)[-1]) == json.loads(lines[-1])
    k = next(k for k, line in enumerate(lines) if b'"event":"motion"' in line)
    later = changed(lines[k], purpose="home")
    spec = json.loads(lines[0])["spec"] | {"seed": 2}
    for other in (
        [*lines[:k], later, *lines[k + 1 :]],
        [*lines[:k], *lines[k + 1 :]],
        [changed(lines[0], spec=spec), *lines[1:]],
        [*lines[:-1], changed(lines[-1], digest="0" * 64)],
    ):
        with pytest.raises(InvalidInputError, match=r"digest .* changed after the run"):
            load(tmp_path, other)


def test_line_ends_of_another_system_change_nothing(tmp_path, lines):
    again = load(tmp_path, [line.replace(b"\n", b"\r\n") for line in lines])
    assert again.footer.digest == json.loads(lines[-1])["digest"]


@pytest.mark.parametrize(
    "fields",
    [{"tags": "0"}, {"tags": "9999"}, {"boundary": [[0, 0], [1, 1]], "tags": "00"}],
)
def test_a_region_that_is_none(tmp_path, lines, fields):
    k, line = next((k, t) for k, t in enumerate(lines) if b'"event":"node"' in t)
    with pytest.raises(InvalidInputError, match=f"line {k + 1}: "):
        load(tmp_path, lines[:k], [changed(line, **fields)], lines[k + 1 :])


def test_another_format_or_version(tmp_path, lines):
    with pytest.raises(InvalidInputError, match="no header"):
        load(tmp_path, [changed(lines[0], format="music")], lines[1:])
    for version in (2, 99):
        told = f"version {version}; this program reads 3, 4, 5, 6: repeat the run"
        with pytest.raises(InvalidInputError, match=told):
            load(tmp_path, [changed(lines[0], format_version=version)], lines[1:])


@pytest.mark.parametrize("version", [3, 4])
def test_versions_before_are_read(tmp_path, lines, version):
    older = load(tmp_path, [changed(lines[0], format_version=version)], lines[1:])
    assert older.header.format_version == version
    assert older.events == load(tmp_path, lines).events


def test_a_decision_far_away_is_refused(tmp_path, lines):
    fields = {"event": "decided", "time_s": 0.0, "robot": 0, "text": "", "goal": [1e12, 0.0]}
    with pytest.raises(InvalidInputError, match="line 2: a place at"):
        load(tmp_path, lines[:1], [json.dumps(fields).encode() + b"\n"], lines[1:])


def test_lines_out_of_their_place(tmp_path, lines):
    with pytest.raises(InvalidInputError, match="no header"):
        load(tmp_path, lines[1:])
    for stray in (lines[0], lines[-1]):
        with pytest.raises(InvalidInputError, match="among the events"):
            load(tmp_path, lines[:2], [stray], lines[2:])


def test_a_spec_that_is_refused(tmp_path, lines):
    spec = json.loads(lines[0])["spec"] | {"seed": -1}
    with pytest.raises(InvalidInputError, match=r"line 1: .*seed"):
        load(tmp_path, [changed(lines[0], spec=spec)], lines[1:])


def test_starts_for_other_robots(tmp_path, lines):
    with pytest.raises(InvalidInputError, match="2 starts for 1 robots"):
        load(tmp_path, [changed(lines[0], starts=[[1, 1, 0], [2, 2, 0]])], lines[1:])


@pytest.mark.parametrize(
    "free",
    [
        [],
        [[]],
        [[[[0, 0], [1, 1]]]],
        [[[[0, 0], [4, 4], [4, 0], [0, 4], [0, 0]]]],
        [[[[0, 0], [4, 0], [4, 4]]]],
    ],
)
def test_a_world_that_is_none(tmp_path, lines, free):
    if free == [[[[0, 0], [4, 0], [4, 4]]]]:
        # A ring that does not close is closed.
        again = load(tmp_path, signed([changed(lines[0], free=free), *lines[1:]]))
        assert again.environment().area_m2 == 8
        return
    with pytest.raises(InvalidInputError, match="two rooms"):
        load(tmp_path, signed([changed(lines[0], free=free), *lines[1:]])).environment()


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InvalidInputError, match=r"nothing\.jsonl: No such file"):
        Recording.load(tmp_path / "nothing.jsonl")
    with pytest.raises(InvalidInputError, match="directory"):
        Recording.load(tmp_path)


def test_a_file_beyond_all_bounds_is_not_read(tmp_path):
    path = tmp_path / "huge.jsonl"
    with path.open("wb") as file:
        file.truncate(2_000_000_001)  # a hole: it takes no space
    with pytest.raises(InvalidInputError, match="larger"):
        Recording.load(path)


@pytest.mark.parametrize("where", ["file/run.jsonl", "none/run.jsonl", "folder", "", "x" * 300])
def test_places_that_cannot_be_written_to(tmp_path, recording, where):
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder").mkdir()
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InvalidInputError, match="cannot write"):
        recording.save(tmp_path / where if where else Path("."))
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_is_read_only(tmp_path, recording):
    tmp_path.chmod(0o500)
    with pytest.raises(InvalidInputError, match="Permission denied"):
        recording.save(tmp_path / "run.jsonl")


class FullDevice:
    """A file on a device that is full after a number of bytes."""

    def __init__(self, file, room: int):
        self.file = file
        self.room = room

    def write(self, data: bytes) -> int:
        self.room -= len(data)
        if self.room < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self.file.write(data)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.file.close()


@pytest.fixture
def full_device(monkeypatch):
    opened = Path.open

    def narrow(path, mode="r", *args, **kwargs):
        file = opened(path, mode, *args, **kwargs)
        return FullDevice(file, 3_000) if "w" in mode else file

    monkeypatch.setattr(Path, "open", narrow)


def test_a_device_that_gets_full_while_saving(tmp_path, recording, full_device):
    with pytest.raises(InvalidInputError, match=r"cannot write .*run\.jsonl: No space left"):
        recording.save(tmp_path / "run.jsonl")
    assert os.listdir(tmp_path) == []


def test_a_device_that_gets_full_while_running(tmp_path, full_device):
    with pytest.raises(InvalidInputError, match=r"cannot write .*run\.jsonl: No space left"):
        simulate(SPEC, WORLD, path=tmp_path / "run.jsonl")
    assert os.listdir(tmp_path) == []


def test_a_device_that_is_full_when_the_file_is_closed(tmp_path):
    def write():
        with atomic_write(tmp_path / "run.jsonl") as file:
            file.write(b"some")
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(InvalidInputError, match="No space left"):
        write()
    assert os.listdir(tmp_path) == []


def test_events_are_distinguished_by_their_names():
    nodes = NodeAdded(
        time_s=0.0,
        robot=0,
        serial=0,
        parent=None,
        configuration=(0.0, 0.0, 0.0),
        stage="root",
        boundary=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),
        tags="012",
    )
    end = Ended(time_s=1.0, robot=0, reason="", complete=True, frontier=())
    motion = Motion(time_s=0.0, robot=0, waypoints=((0.0, 0.0, 0.0, 0.0),))
    for event, name in ((nodes, "node"), (end, "ended"), (motion, "motion")):
        line = msgspec.json.encode(event)
        assert json.loads(line)["event"] == name
        assert msgspec.json.decode(line, type=NodeAdded | Ended | Motion) == event
