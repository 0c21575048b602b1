"""Experiment files: fields, errors, and the schema for editors."""

import json
import math
import tomllib

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from multisrt.experiments.schema import schema
from multisrt.experiments.spec import (
    Block,
    BodyChoice,
    EnvironmentChoice,
    ExperimentSpec,
    FaultsChoice,
    Limits,
    MemberChoice,
    Only,
    RadioChoice,
    StartsChoice,
    StrategyChoice,
    TeamChoice,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import Death, DriveSpec, LateStart, RangeFinderSpec, Silence, StopRule

WHOLE = """
name = "everything"
about = "All that an experiment can say."
environments = [
  "open",
  { name = "garden", label = "park", parameters = { size_m = 20.0 }, seeds = "0-2" },
  { name = "rooms", seed = "repetition" },
  { name = "hall", wkt = "POLYGON ((0 0, 8 0, 8 8, 0 8, 0 0))", starts = [[1.0, 1.0]] },
]
strategies = ["srt-radial", { name = "srt-star", label = "few cones", options = { cones = 6 } }]
robots = [1, 2, { label = "pair", members = [{ start = [1, 2] }, { footprint = "box:0.5x0.3" }] }]
starts = ["clustered", { how = "scattered", first = "drawn" }]
radios = ["unlimited", { range_m = 15.0, loss = 0.1 }]
bodies = ["disc:0.3", { footprint = "box:0.6x0.4", drive = { kind = "holonomic" } }]
faults = ["none", { label = "one dies", deaths = 1 }]
repetitions = 3
first_seed = 5
recordings = "all"
[range_finder]
range_m = 5.0
[stop]
max_time_s = 900.0
[limits]
computing_s = 60.0
[[exclude]]
robots = 1
faults = "one dies"
[[blocks]]
robots = [4]
"""


def test_a_file_with_every_field():
    spec = ExperimentSpec.from_toml(WHOLE)
    assert spec.environments[1] == EnvironmentChoice(
        name="garden", label="park", parameters={"size_m": 20.0}, seeds="0-2"
    )
    strategy, team = spec.strategies[1], spec.robots[2]
    assert isinstance(strategy, StrategyChoice)
    assert strategy.options == {"cones": 6}
    assert isinstance(team, TeamChoice)
    assert team.members == (
        MemberChoice(start=(1, 2)),
        MemberChoice(footprint="box:0.5x0.3"),
    )
    assert spec.radios == ("unlimited", RadioChoice(range_m=15.0, loss=0.1))
    assert (spec.repetitions, spec.first_seed, spec.recordings) == (3, 5, "all")
    assert spec.limits == Limits(computing_s=60.0)
    assert spec.blocks == (Block(robots=(4,)),)
    assert spec.exclude == (Only(robots=1, faults="one dies"),)


def test_missing_fields_have_their_defaults():
    spec = ExperimentSpec.from_toml('name = "x"')
    assert (spec.robots, spec.starts, spec.radios) == ((1,), ("scattered",), ("unlimited",))
    assert (spec.repetitions, spec.first_seed, spec.recordings) == (20, 0, "failed")
    assert spec == ExperimentSpec(name="x")


# Round trips ---------------------------------------------------------------------------------

words = st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), max_size=10)
labels = words.filter(bool)
maybe = st.none() | labels
finite = st.floats(allow_nan=False, allow_infinity=False)
seeds = st.integers(0, 2**53)
options = st.dictionaries(words, st.booleans() | seeds | finite | words, max_size=2)
drives = st.none() | st.just(DriveSpec(kind="holonomic", speed_m_s=0.7))
sensors = st.none() | st.just(RangeFinderSpec(range_m=3.5, beams=360))
bodies = st.sampled_from(["disc:0.25", "box:0.5x0.3"])
environments = st.builds(
    EnvironmentChoice,
    name=labels,
    label=maybe,
    parameters=options,
    seed=st.none() | seeds | st.just("repetition"),
    seeds=words | st.lists(seeds, max_size=3).map(tuple),
    resolution_m=st.none() | finite,
    wkt=st.none() | words,
    starts=st.lists(st.tuples(finite, finite), max_size=2).map(tuple),
)
teams = st.builds(
    TeamChoice,
    label=labels,
    members=st.lists(
        st.builds(
            MemberChoice,
            start=st.none() | st.tuples(finite, finite),
            footprint=bodies,
            drive=drives,
            range_finder=sensors,
        ),
        min_size=1,
        max_size=3,
    ).map(tuple),
)
faults = st.builds(
    FaultsChoice,
    label=labels,
    faults=st.lists(
        st.builds(Death, robot=seeds, time_s=finite, when=st.sampled_from(["any", "master"]))
        | st.builds(Silence, robot=seeds, time_s=finite, duration_s=st.floats(0.1, 99.0))
        | st.builds(LateStart, robot=seeds, time_s=finite),
        max_size=3,
    ).map(tuple),
    deaths=st.integers(0, 9),
    between_s=st.tuples(finite, finite),
)


def some(*kinds):
    return st.lists(st.one_of(*kinds), min_size=1, max_size=3).map(tuple)


axes = {
    "environments": some(labels, environments),
    "strategies": some(
        labels, st.builds(StrategyChoice, name=labels, label=maybe, options=options)
    ),
    "robots": some(st.integers(1, 1000), teams),
    "starts": some(
        st.sampled_from(["scattered", "clustered"]),
        st.builds(
            StartsChoice,
            first=st.sampled_from(["any", "drawn"]),
            places=st.lists(st.tuples(finite, finite, finite), max_size=2).map(tuple),
            label=maybe,
        ),
    ),
    "radios": some(
        st.just("unlimited"),
        st.builds(RadioChoice, range_m=st.floats(0.0, 99.0), loss=st.floats(0.0, 0.9), label=maybe),
    ),
    "bodies": some(
        bodies,
        st.builds(BodyChoice, footprint=bodies, drive=drives, range_finder=sensors, label=maybe),
    ),
    "faults": some(st.just("none"), faults),
}
texts = words | st.lists(words, max_size=2).map(tuple)
experiments = st.builds(
    ExperimentSpec,
    name=labels,
    about=words,
    **axes,
    blocks=st.lists(
        st.builds(Block, **{name: st.none() | kind for name, kind in axes.items()}), max_size=2
    ).map(tuple),
    exclude=st.lists(st.builds(Only, environment=texts, radio=texts), max_size=2).map(tuple),
    repetitions=st.integers(1, 1_000_000),
    first_seed=seeds,
    stop=st.builds(StopRule, max_time_s=st.floats(1.0, 1e6)),
    recordings=st.sampled_from(["none", "failed", "all"]),
)


@pytest.mark.slow
@given(experiments)
@settings(max_examples=60, deadline=None, phases=[Phase.explicit, Phase.generate])
def test_round_trips_through_toml_and_json(spec):
    assert ExperimentSpec.from_toml(spec.to_toml()) == spec
    assert ExperimentSpec.from_json(spec.to_json()) == spec
    assert ExperimentSpec.from_dict(json.loads(spec.to_json())) == spec


# Errors --------------------------------------------------------------------------------------

START = 'name = "x"\nenvironments = ["open"]\nstrategies = ["srt-star"]\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (START + "robot = [1]", "there is no field 'robot' (did you mean 'robots'?)"),
        (START + "repetition = 3", "(did you mean 'repetitions'?)"),
        (START + "zzz = 3", "there is no field 'zzz'; there are: name, about, environments,"),
        (
            START + "radios = [{ range = 3 }]",
            "radios[0]: there is no field 'range' (did you mean 'range_m'?)",
        ),
        (
            START + "[[blocks]]\nrobot = [1]",
            "blocks[0]: there is no field 'robot' (did you mean 'robots'?)",
        ),
        (START + "[[exclude]]\nrobot = 1", "exclude[0]: there is no field 'robot' (did you mean"),
        (START + "[limits]\nmemory = 1", "limits: there is no field 'memory' (did you mean"),
        (START + 'robots = ["two"]', "robots[0]: Expected a whole number or a table, got text"),
        (START + "robots = [2, 0]", "robots[1]: Expected a whole number >= 1"),
        (START + "robots = 2", "robots: Expected a list, got a whole number"),
        (START + "robots = []", "robots: Expected a list of length >= 1"),
        (START + "repetitions = 0", "repetitions: Expected a whole number >= 1"),
        (
            START + 'starts = ["scatered"]',
            "starts[0]: unknown value 'scatered'; allowed: 'base', 'clustered', 'random'",
        ),
        (
            START + 'radios = [{ range_m = 9, walls = "blok" }]',
            "radios[0].walls: unknown value 'blok'; allowed: 'block', 'pass', 'weaken'",
        ),
        (
            START + 'recordings = "some"',
            "recordings: unknown value 'some'; allowed: 'all', 'failed', 'none'",
        ),
        (
            START + 'faults = [{ label = "a", faults = [{ fault = "deth", robot = 0 }] }]',
            "faults[0].faults[0].fault: unknown value 'deth'; allowed: 'death', 'silence'",
        ),
        (START + "faults = [{ deaths = 1 }]", "faults[0]: missing field `label`"),
        (
            START + 'bodies = ["disc:0.2", { drive = { kind = "train" } }]',
            "bodies[1].drive.kind: unknown value 'train'; allowed: 'differential'",
        ),
        (
            START + 'robots = [{ label = "a", members = [{ start = "here" }] }]',
            "robots[0].members[0].start: Expected a list, got text",
        ),
        (
            START + "[range_finder]\nrange_m = -1",
            "range_finder: the range of a range finder is a positive number of metres",
        ),
        (START + "[stop]\nmax_time_s = 0", "stop: max_time_s is a positive time"),
        ("name = ", "Invalid value (at end of document)"),
        ("name = 3", "name: Expected text, got a whole number"),
        ("", "missing field `name`"),
        ('name = "x"\n' + "a" * 16_000_000, "characters, where 16000000 are allowed"),
    ],
)
def test_errors_name_the_field_and_what_is_allowed(text, said):
    with pytest.raises(InvalidInputError) as error:
        ExperimentSpec.from_toml(text)
    message = str(error.value)
    assert message.startswith("not an experiment: ")
    assert said in message
    assert "\n" not in message


@pytest.mark.parametrize("text", ["{", b"\xff", '{"name": "x"} {}', "[" * 100_000])
def test_bad_json_is_refused(text):
    with pytest.raises(InvalidInputError, match=r"^not an experiment: "):
        ExperimentSpec.from_json(text)


# Schema --------------------------------------------------------------------------------------


def fits(value, node, root):
    """Whether a value is valid under a schema of draft 7, as far as ours uses it."""
    if "$ref" in node:
        return fits(value, root["definitions"][node["$ref"].removeprefix("#/definitions/")], root)
    if not all(fits(value, one, root) for one in node.get("allOf", ())):
        return False
    if "anyOf" in node and not any(fits(value, one, root) for one in node["anyOf"]):
        return False
    if "enum" in node and value not in node["enum"]:
        return False
    kinds: dict[str, type | tuple[type, ...]] = {
        "object": dict,
        "array": list,
        "string": str,
        "boolean": bool,
        "integer": int,
        "number": (int, float),
        "null": type(None),
    }
    kind = node.get("type")
    if kind is not None and not isinstance(value, kinds[kind]):
        return False
    if kind in ("integer", "number"):
        over = value > node.get("maximum", value) or value < node.get("minimum", value)
        return not over and value > node.get("exclusiveMinimum", -math.inf)
    if kind == "string":
        return node.get("minLength", 0) <= len(value) <= node.get("maxLength", len(value))
    if kind == "array":
        few, many = node.get("minItems", 0), node.get("maxItems", len(value))
        items = node.get("items", {})
        if isinstance(items, list):
            return len(value) == len(items) == many and all(map(fits, value, items, [root] * many))
        return few <= len(value) <= many and all(fits(v, items, root) for v in value)
    if kind == "object":
        known, others = node.get("properties", {}), node.get("additionalProperties", True)
        return all(name in value for name in node.get("required", ())) and all(
            fits(v, known[name], root)
            if name in known
            else (others if isinstance(others, bool) else fits(v, others, root))
            for name, v in value.items()
        )
    return True


def test_the_schema_accepts_valid_files():
    assert fits(tomllib.loads(WHOLE), schema(), schema())


@pytest.mark.parametrize(
    "text",
    [
        "",
        START + "robot = [1]",
        START + "robots = [0]",
        START + 'robots = ["two"]',
        START + 'starts = ["scatered"]',
        START + "radios = [{ range = 3 }]",
        START + "[limits]\nmemory_mb = 1",
        START + 'robots = [{ label = "a", members = [] }]',
        START + 'faults = [{ label = "a", faults = [{ fault = "deth", robot = 0, time_s = 1 }] }]',
    ],
)
def test_the_schema_rejects_invalid_files(text):
    assert not fits(tomllib.loads(text), schema(), schema())
    with pytest.raises(InvalidInputError):
        ExperimentSpec.from_toml(text)


@pytest.mark.slow
@given(experiments)
@settings(max_examples=30, deadline=None, phases=[Phase.explicit, Phase.generate])
def test_the_schema_accepts_every_written_experiment(spec):
    assert fits(json.loads(spec.to_json()), schema(), schema())


def nodes(part):
    if isinstance(part, dict):
        yield part
    for one in part.values() if isinstance(part, dict) else part if isinstance(part, list) else ():
        yield from nodes(one)


def test_the_schema_is_draft_7():
    made = schema()
    assert made["$schema"] == "http://json-schema.org/draft-07/schema#"
    assert made["type"] == "object"
    references = {node["$ref"] for node in nodes(made) if isinstance(node.get("$ref"), str)}
    assert references == {f"#/definitions/{name}" for name in made["definitions"]}
    # Nothing beside a reference, where draft 7 ignores it; no default null, which TOML lacks.
    assert all(len(node) == 1 for node in nodes(made) if isinstance(node.get("$ref"), str))
    assert not [node for node in nodes(made) if "default" in node and node["default"] is None]


def test_the_schema_describes_every_field():
    made = schema()
    for name, part in {"": made, **made["definitions"]}.items():
        assert part["description"], name
        for field, told in part.get("properties", {}).items():
            if name in ("Death", "Silence", "LateStart") and field == "fault":
                continue
            if name != "Block":
                assert told.get("description"), (name, field)
                assert "None" not in told["description"]
    radio = made["definitions"]["RadioChoice"]["properties"]
    assert "R_c" in radio["range_m"]["description"]


def test_names_and_labels_are_one_line():
    wrong = ('name = "a\\nb"', 'name = "\\u001b"', 'name = "a"\nfaults = [{ label = "\\u2028" }]')
    for text in wrong:
        with pytest.raises(InvalidInputError, match="on one line, without control characters"):
            ExperimentSpec.from_toml(text)
