import pytest
import shapely

import multisrt
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.run import Run, explore
from multisrt.simulation.worlds import inline
from multisrt.spec import Death, DriveSpec, RadioSpec, RangeFinderSpec, RobotSpec, RunSpec

ROOM = Environment("room", shapely.box(0, 0, 6, 5), starts=[(1.0, 1.0)])


class Enough(Exception):
    """Stops before the run."""


@pytest.fixture
def spec_of(monkeypatch):
    """The spec that the door makes of what it is given."""

    def asked(*args, **kwargs) -> RunSpec:
        given = None

        def kept(spec, *_, **__):
            nonlocal given
            given = spec
            raise Enough

        with monkeypatch.context() as patch:
            patch.setattr("multisrt.run.simulate", kept)
            with pytest.raises(Enough):
                explore(*args, **kwargs)
        assert given is not None
        return given

    return asked


@pytest.fixture(scope="module")
def run() -> Run:
    return explore(ROOM, seed=1, start=(1.0, 1.0))


def test_a_single_robot(spec_of):
    assert spec_of(ROOM, start=(2, 3)).robots == (RobotSpec(start=(2.0, 3.0)),)
    assert spec_of(ROOM, starts=[(2, 3)]).robots == (RobotSpec(start=(2.0, 3.0)),)
    assert spec_of(ROOM) == RunSpec(environment=inline(ROOM))


def test_a_team(spec_of):
    faults = (Death(robot=3, time_s=10.0),)
    spec = spec_of(
        ROOM,
        robots=4,
        starts="clustered",
        radio_range_m=15.0,
        faults=list(faults),
        range_m=6.0,
        drive=DriveSpec(kind="holonomic"),
    )
    robot = RobotSpec(range_finder=RangeFinderSpec(range_m=6.0), drive=DriveSpec(kind="holonomic"))
    assert spec.robots == (robot,) * 4
    assert spec.starts == "clustered"
    assert spec.radio == RadioSpec(range_m=15.0)
    assert spec.faults == faults
    assert spec_of(ROOM, robots=2).starts == "scattered"


def test_a_team_at_given_places(spec_of):
    places = (1, 1), (2, 2, 0.5)
    for given in ({"starts": places}, {"starts": list(places), "robots": 2}):
        assert [robot.start for robot in spec_of(ROOM, **given).robots] == [
            (1.0, 1.0),
            (2.0, 2.0, 0.5),
        ]


def test_a_radio_in_full(spec_of):
    radio = RadioSpec(range_m=15.0, loss=0.25, walls="block")
    assert spec_of(ROOM, robots=2, radio=radio).radio == radio


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"robots": 0}, "at least one robot, not 0"),
        ({"robots": 2, "start": (1, 1)}, "give starts"),
        ({"robots": 2, "starts": [(1, 1)] * 3}, "3 starts for 2 robots"),
        ({"starts": []}, "0 starts for 1 robots"),
        ({"start": (1, 1), "starts": [(1, 1)]}, "not both"),
        ({"starts": "anywhere"}, "anywhere"),
        ({"radio_range_m": 3.0, "radio": RadioSpec()}, "radio_range_m alone"),
        ({"radio_range_m": -3.0}, "range_m of a radio"),
        ({"faults": [Death(robot=1, time_s=1.0)]}, "there is no such robot"),
    ],
)
def test_what_cannot_be_explored(given, said):
    with pytest.raises(InvalidInputError, match=said):
        explore(ROOM, **given)


@pytest.mark.parametrize(
    "given",
    [{"robots": 2}, {"starts": "clustered"}, {"radio": RadioSpec()}, {"faults": [1]}, {"seed": 1}],
)
def test_a_spec_says_everything(given):
    with pytest.raises(InvalidInputError, match="a RunSpec says everything"):
        explore(RunSpec(environment=inline(ROOM)), **given)


def test_a_saved_spec_repeats_the_run(run, tmp_path):
    run.save_spec(tmp_path / "spec.toml")
    spec = RunSpec.from_toml((tmp_path / "spec.toml").read_text())
    assert spec == run.spec
    assert explore(spec).digest == run.digest


def test_why(run):
    assert "its last decision was at 0.00 s" in run.why(0, 0.0)
    assert run.why(0) == run.why(0, run.metrics.makespan_s)
    with pytest.raises(InvalidInputError, match="there is no robot 1"):
        run.why(1)


def test_all_names_of_the_package_are_there():
    assert all(getattr(multisrt, name) is not None for name in multisrt.__all__)
    assert {"RadioSpec", "Death", "Silence", "LateStart"} <= set(multisrt.__all__)
