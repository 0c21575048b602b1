import json
import math
from typing import Any

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.kinematics import Differential, Holonomic
from multisrt.simulation.random_streams import random_stream
from multisrt.simulation.worlds import build_environment, environment_spec, inline
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    DriveSpec,
    FileEnvironment,
    InlineEnvironment,
    LateStart,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

positive = st.floats(min_value=1e-6, max_value=1e6)
finite = st.floats(allow_nan=False, allow_infinity=False)
# TOML cannot represent some control characters, which names and paths do not have.
words = st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), max_size=12)
whole = st.integers(-(2**53), 2**53)
scalars = st.one_of(st.booleans(), whole, finite, words)
values = st.dictionaries(words, scalars, max_size=3)

environments = st.one_of(
    st.builds(
        CatalogEnvironment,
        name=words,
        parameters=values,
        seed=st.none() | st.integers(0, 2**53),
    ),
    st.builds(
        FileEnvironment,
        path=words,
        resolution_m=st.none() | finite,
        threshold=st.none() | finite,
        starts_from=st.none() | words,
    ),
    st.builds(
        InlineEnvironment, name=words, wkt=words, starts=st.tuples(st.tuples(finite, finite))
    ),
)
robots = st.builds(
    RobotSpec,
    start=st.none() | st.tuples(finite, finite) | st.tuples(finite, finite, finite),
    footprint=st.sampled_from(["disc:0.25", "box:0.5x0.3", "polygon:-1,-1 2,0 -1,1"]),
    drive=st.builds(
        DriveSpec,
        kind=st.sampled_from(["differential", "holonomic"]),
        speed_m_s=positive,
        turn_rate_rad_s=positive,
    ),
    range_finder=st.builds(
        RangeFinderSpec, range_m=st.floats(3.0, 1e6), beams=st.none() | st.integers(40, 5000)
    ),
)
specs = st.builds(
    RunSpec,
    environment=environments,
    strategy=words,
    options=values,
    robots=st.lists(robots, min_size=1, max_size=3).map(tuple),
    stop=st.builds(StopRule, max_time_s=positive),
    seed=st.integers(0, 2**53),
)


@given(specs)
def test_json_there_and_back(spec):
    assert RunSpec.from_json(spec.to_json()) == spec
    assert RunSpec.from_json(spec.to_json().encode()) == spec


@given(specs)
def test_toml_there_and_back(spec):
    assert RunSpec.from_toml(spec.to_toml()) == spec


@given(specs)
def test_dictionaries_are_plain_and_say_the_same(spec):
    assert RunSpec.from_json(json.dumps(spec.to_dict())) == spec


def test_a_spec_by_hand():
    text = """
    strategy = "srt-star"
    seed = 7
    [environment]
    from = "catalog"
    name = "office"
    parameters = {doors = 2}
    [options]
    cones = 8
    [[robots]]
    start = [1.0, 2.0, 0.5]
    footprint = "box:0.5x0.3"
    drive = {kind = "holonomic", speed_m_s = 1.5}
    [stop]
    max_time_s = 600.0
    """
    assert RunSpec.from_toml(text) == RunSpec(
        environment=CatalogEnvironment(name="office", parameters={"doors": 2}),
        strategy="srt-star",
        options={"cones": 8},
        robots=(
            RobotSpec(
                start=(1.0, 2.0, 0.5),
                footprint="box:0.5x0.3",
                drive=DriveSpec(kind="holonomic", speed_m_s=1.5),
            ),
        ),
        stop=StopRule(max_time_s=600.0),
        seed=7,
    )


def test_defaults_are_not_written():
    spec = RunSpec(environment=CatalogEnvironment(name="open"))
    assert spec.to_dict() == {"environment": {"from": "catalog", "name": "open"}}


OPEN = '"environment": {"from": "catalog", "name": "open"}'


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "not a run spec"),
        ("[]", "not a run spec"),
        ("{}", "environment"),
        ("{" + OPEN + ', "colour": "red"}', "colour"),
        ('{"environment": {"from": "catalog", "name": "open", "size": 3}}', "size"),
        ('{"environment": {"from": "moon", "name": "open"}}', "moon"),
        ('{"environment": {"name": "open"}}', "from"),
        ("{" + OPEN + ', "seed": -1}', "seed"),
        ("{" + OPEN + ', "seed": 1.5}', "seed"),
        ("{" + OPEN + ', "seed": "1"}', "seed"),
        ("{" + OPEN + ', "robots": []}', "at least one robot"),
        ("{" + OPEN + ', "robots": [{"wheels": 4}]}', "wheels"),
        ("{" + OPEN + ', "robots": [{"start": [1]}]}', "start"),
        ("{" + OPEN + ', "robots": [{"start": [1, 2, 3, 4]}]}', "start"),
        ("{" + OPEN + ', "robots": [{"footprint": "ball:1"}]}', "ball:1"),
        ("{" + OPEN + ', "robots": [{"drive": {"kind": "sail"}}]}', "sail"),
        ("{" + OPEN + ', "robots": [{"drive": {"speed_m_s": 0}}]}', "speed_m_s"),
        ("{" + OPEN + ', "robots": [{"range_finder": {"range_m": -4}}]}', "range"),
        ("{" + OPEN + ', "robots": [{"range_finder": {"beams": 2}}]}', "beams"),
        ("{" + OPEN + ', "stop": {"max_time_s": 0}}', "max_time_s"),
        ("{" + OPEN + ', "options": {"alpha": [1]}}', "options"),
        ("{" + OPEN + ', "options": {"alpha": null}}', "options"),
        ("{" + OPEN + ', "seed": NaN}', "not a run spec"),
        ("{" + OPEN + ', "stop": {"max_time_s": 1e999}}', "max_time_s"),
        (b"\xff\xfe", "not a run spec"),
    ],
)
def test_bad_json_is_refused_by_name(text, named):
    with pytest.raises(InvalidInputError, match=named):
        RunSpec.from_json(text)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("strategy =", "not a run spec"),
        ('strategy = "a"\nstrategy = "b"', "not a run spec"),
        ('strategy = "a"', "environment"),
        ('environment = {from = "catalog", name = "open"}\ncolour = 1', "colour"),
        (
            'environment = {from = "catalog", name = "open"}\nstrategies = "srt-star"',
            r"no field 'strategies' \(did you mean 'strategy'\?\)",
        ),
        (
            'environment = {from = "catalog", name = "open"}\nrobots = [{drive = {kind = "sail"}}]',
            r"robots\[0\].drive.kind: unknown value 'sail'; allowed: 'differential'",
        ),
        (
            'environment = {from = "moon"}',
            "environment.from: unknown value 'moon'; allowed: 'catalog', 'suite', 'file', 'wkt'",
        ),
        (
            'environment = {from = "catalog", name = "open"}\nstop = {max_time_s = nan}',
            "max_time_s",
        ),
        (
            'environment = {from = "catalog", name = "open"}\nstop = {max_time_s = inf}',
            "max_time_s",
        ),
        (
            'environment = {from = "catalog", name = "open"}\nrobots = [{start = [nan, 1.0]}]',
            "start",
        ),
        ("x = " + "[" * 100_000, "not a run spec"),
    ],
)
def test_bad_toml_is_refused_by_name(text, named):
    with pytest.raises(InvalidInputError, match=named):
        RunSpec.from_toml(text)


@pytest.mark.parametrize("bad", [math.nan, math.inf, 0.0, -1.0])
@pytest.mark.parametrize(
    ("build", "field", "named"),
    [
        (RangeFinderSpec, "range_m", "range"),
        (DriveSpec, "speed_m_s", "speed_m_s"),
        (DriveSpec, "turn_rate_rad_s", "turn_rate_rad_s"),
        (StopRule, "max_time_s", "max_time_s"),
    ],
)
def test_lengths_rates_and_times_are_positive_and_finite(build, field, named, bad):
    with pytest.raises(InvalidInputError, match=named):
        build(**{field: bad})


@pytest.mark.parametrize("start", [(math.nan, 1.0), (1.0, math.inf), (1.0,), (1.0, 2.0, 3.0, 4.0)])
def test_starts_are_two_or_three_finite_numbers(start):
    with pytest.raises(InvalidInputError, match="start"):
        RobotSpec(start=start)


@pytest.mark.parametrize(
    ("footprint", "range_m", "beams", "shown"),
    [
        ("disc:0.3", 0.3, None, "range finder with a range of 0.3 m .* only 0.3 m"),
        ("box:0.8x0.6", 0.49, None, "only 0.49 m around"),
        ("disc:0.25", 5.0, 8, "laser of 8 beams .* only .*the body disc:0.25 .* or more beams$"),
        ("polygon:-0.215,-0.188 0.397,0.000 -0.215,0.188", 0.875, 14, "only 0.383 m"),
    ],
)
def test_a_range_finder_that_shows_less_than_the_body_takes_is_refused(
    footprint, range_m, beams, shown
):
    with pytest.raises(InvalidInputError, match=shown):
        RobotSpec(footprint=footprint, range_finder=RangeFinderSpec(range_m=range_m, beams=beams))
    range_finder = RangeFinderSpec(range_m=range_m + 0.05, beams=None if beams is None else 16)
    RobotSpec(footprint=footprint, range_finder=range_finder)


RUN_OF_A_MINUTE: dict[str, Any] = {
    "environment": CatalogEnvironment(name="open"),
    "robots": (RobotSpec(),) * 2,
    "stop": StopRule(max_time_s=60.0),
}


@pytest.mark.parametrize("time_s", [60.0, 1e9, math.inf, math.nan, -1.0])
@pytest.mark.parametrize(
    ("build", "what"),
    [
        (lambda time_s: Death(robot=1, time_s=time_s), "death"),
        (lambda time_s: Silence(robot=1, time_s=time_s, duration_s=5.0), "silence"),
        (lambda time_s: LateStart(robot=1, time_s=time_s), "late start"),
    ],
)
def test_a_fault_that_is_not_within_the_run_is_refused(build, what, time_s):
    before = Death(robot=0, time_s=59.9)
    with pytest.raises(InvalidInputError) as error:
        RunSpec(**RUN_OF_A_MINUTE, faults=(before, build(time_s)))
    assert str(error.value) == (
        f"fault 2 ({what} of robot 1): at {time_s:g} s, which is not within the run; "
        "it ends at 60 s (stop.max_time_s)"
    )


@pytest.mark.parametrize("robot", [-1, 2])
def test_a_fault_of_no_robot_is_refused(robot):
    with pytest.raises(InvalidInputError, match="there is no such robot; the team has 2 robots"):
        RunSpec(**RUN_OF_A_MINUTE, faults=(LateStart(robot=robot, time_s=1.0),))


@pytest.mark.parametrize(("kind", "named"), [(Death, "death"), (LateStart, "late_start")])
def test_no_robot_dies_or_starts_late_twice(kind, named):
    faults = tuple(kind(robot=1, time_s=time_s) for time_s in (1.0, 2.0))
    with pytest.raises(InvalidInputError, match=f"robot 1 has more than one fault {named}"):
        RunSpec(**RUN_OF_A_MINUTE, faults=faults)


def test_a_holonomic_drive_has_finite_limits_too():
    # Its turn rate is not used, but must be writable.
    with pytest.raises(InvalidInputError, match="turn_rate_rad_s"):
        DriveSpec(kind="holonomic", turn_rate_rad_s=math.nan)


def test_kinematics():
    assert DriveSpec(kind="holonomic", speed_m_s=2.0).kinematics() == Holonomic(speed_m_s=2.0)
    assert DriveSpec(speed_m_s=2.0, turn_rate_rad_s=0.1).kinematics() == Differential(
        speed_m_s=2.0, turn_rate_rad_s=0.1
    )


def test_a_name_of_the_catalogue_means_that(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "office").write_text("a file")
    assert environment_spec("office") == CatalogEnvironment(name="office")
    assert environment_spec("./office") == FileEnvironment(path="./office")


def test_a_suffix_a_folder_or_an_existing_path_means_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plan").write_text("a file")
    for text in ("plan", "plan.png", "maps/plan", str(tmp_path / "plan")):
        options: dict[str, Any] = {"resolution_m": 0.1, "threshold": 0.5, "starts_from": "t.txt"}
        assert environment_spec(text, **options) == FileEnvironment(path=text, **options)


def test_unknown_environments_are_refused_with_a_suggestion():
    with pytest.raises(InvalidInputError, match=r"'offise' \(did you mean 'office'\?\)") as error:
        environment_spec("offise")
    assert "garden, clutter, rooms" in str(error.value)
    with pytest.raises(InvalidInputError, match=r"no environment 'zzz' and no file"):
        environment_spec("zzz")
    with pytest.raises(InvalidInputError, match="no file of that name"):
        environment_spec("a" * 5000)


def test_a_path_that_cannot_be_looked_up_is_no_file(monkeypatch):
    def denied(path):
        raise PermissionError

    monkeypatch.setattr("pathlib.Path.exists", denied)
    with pytest.raises(InvalidInputError, match="no file of that name"):
        environment_spec("secret")


def test_options_of_images_are_for_images():
    for options in ({"resolution_m": 0.1}, {"threshold": 0.5}, {"starts_from": "team.txt"}):
        with pytest.raises(InvalidInputError, match="images"):
            environment_spec("office", **options)


def test_an_environment_written_out_is_the_same():
    free = shapely.box(0, 0, 7.3, 1 / 3).difference(shapely.box(2, 0.1, 2.5, 0.2))
    world = Environment("odd", free, starts=[(0.1, 0.1)])
    again = build_environment(inline(world))
    assert again == world
    assert again.starts == world.starts


@pytest.mark.parametrize(
    "wkt",
    [
        "",
        "POLYGON",
        "POLYGON EMPTY",
        "POINT (1 1)",
        "POLYGON ((0 0, 1 0, 1 1))",
        "POLYGON ((0 0, 2 2, 2 0, 0 2, 0 0))",
        "POLYGON ((0 0, nan 0, 1 1, 0 0))",
        "POLYGON ((0 0, 1e300 0, 1 1, 0 0))",
    ],
)
def test_a_world_that_cannot_be_built_is_refused_by_name(wkt):
    with pytest.raises(InvalidInputError, match="'broken'"):
        build_environment(InlineEnvironment(name="broken", wkt=wkt))


def test_worlds_of_the_catalogue_and_of_files(tmp_path):
    small = CatalogEnvironment(name="open", parameters={"size_m": 12}, seed=3)
    assert build_environment(small).area_m2 == 144.0
    (tmp_path / "room.wkt").write_text("POLYGON ((0 0, 6 0, 6 5, 0 5, 0 0))")
    assert build_environment(FileEnvironment(path=str(tmp_path / "room.wkt"))).area_m2 == 30.0
    with pytest.raises(InvalidInputError, match="'nowhere'"):
        build_environment(CatalogEnvironment(name="nowhere"))
    with pytest.raises(InvalidInputError, match="'bogus'"):
        build_environment(CatalogEnvironment(name="open", parameters={"bogus": 1}))
    room = FileEnvironment(path=str(tmp_path / "room.wkt"), digest="0" * 64)
    with pytest.raises(InvalidInputError, match=r"room\.wkt holds another world than when"):
        build_environment(room)
    assert "digest" not in RunSpec(environment=FileEnvironment(path="room.wkt")).to_toml()
    with pytest.raises(InvalidInputError, match="a field beside them: seed = 3"):
        build_environment(CatalogEnvironment(name="open", parameters={"seed": 3}))


def test_each_part_of_a_run_has_its_own_random_stream():
    streams = [("starts", 0), ("starts", 1), ("radio", 0), ("faults", 0), ("robots", 0)]
    first = {random_stream(7, *key).random() for key in streams}
    assert len(first) == len(streams)
    assert random_stream(7, "robots", 1).random() == random_stream(7, "robots", 1).random()
    assert random_stream(7, "robots").random() != random_stream(8, "robots").random()


def test_only_a_car_has_a_turning_radius():
    assert DriveSpec(kind="dubins", turning_radius_m=0.5).is_car
    for kind in ("differential", "holonomic"):
        with pytest.raises(InvalidInputError, match=f"a {kind} drive has no turning radius"):
            DriveSpec(kind=kind, turning_radius_m=0.5)
