"""Numbers of numpy as arguments of the API: taken as builtin numbers, or refused in words."""

# Values of wrong types are what is tested here.
# mypy: disable-error-code="arg-type, dict-item, list-item"

from typing import Any

import numpy as np
import pytest

import multisrt as ms
from multisrt.experiments.spec import RadioChoice

SHORT: dict[str, Any] = {"max_time_s": 10.0}


@pytest.mark.parametrize(
    ("given", "plain"),
    [
        ({"robots": np.int64(2), "seed": np.int64(1)}, {"robots": 2, "seed": 1}),
        ({"range_m": np.float32(3.5)}, {"range_m": 3.5}),
        ({"range_m": np.array(3.5), "beams": np.int32(90)}, {"range_m": 3.5, "beams": 90}),
        ({"start": np.array([5, 6])}, {"start": (5.0, 6.0)}),
        ({"starts": np.array([[5.0, 5.0], [7.0, 5.0]])}, {"starts": [(5.0, 5.0), (7.0, 5.0)]}),
        ({"options": {"max_waits": np.int64(4)}}, {"options": {"max_waits": 4}}),
        (
            {"robots": np.int8(2), "radio_range_m": np.float16(15)},
            {"robots": 2, "radio_range_m": 15},
        ),
        (
            {"robots": [ms.RobotSpec(range_finder=ms.RangeFinderSpec(range_m=np.float32(3.5)))]},
            {"range_m": 3.5},
        ),
        (
            {"robots": 2, "faults": [ms.Death(robot=np.int64(1), time_s=np.float32(5))]},
            {"robots": 2, "faults": [ms.Death(robot=1, time_s=5.0)]},
        ),
    ],
)
def test_runs_with_numbers_of_numpy_are_those_with_builtin_ones(given, plain):
    assert ms.explore("open", **SHORT | given).digest == ms.explore("open", **SHORT | plain).digest


def test_specs_with_numbers_of_numpy_are_written():
    world = ms.CatalogEnvironment(name="open")
    spec = ms.RunSpec(environment=world, seed=np.int64(3))
    plain = ms.RunSpec(environment=world, seed=3)
    assert spec.to_toml() == plain.to_toml()
    assert spec.to_json() == plain.to_json()
    assert spec.to_dict() == plain.to_dict()
    assert type(spec.canonical().seed) is int


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"range_m": "4"}, "range_m is a number, not '4'"),
        ({"range_m": np.array([4.0, 5.0])}, r"range_m is a number, not array\(\[4\., 5\.\]\)"),
        ({"range_m": 2j}, "range_m is a number, not 2j"),
        ({"radio_range_m": "15"}, "radio_range_m is a number, not '15'"),
        ({"max_time_s": True}, "max_time_s is a number, not True"),
        ({"seed": np.float64(1)}, r"seed is a whole number, not np\.float64\(1\.0\)"),
        ({"seed": True}, "seed is a whole number, not True"),
        ({"beams": 90.0}, r"beams is a whole number, not 90\.0"),
        ({"start": np.array(3.0)}, r"a start is \(x, y\) or .*, not array\(3\.\)"),
        ({"start": "5,5"}, r"a start is \(x, y\) or .*, not '5,5'"),
        ({"start": (float("nan"), 1.0)}, "a start is finite"),
        ({"options": [1]}, r"options are a dictionary of names and values, not \[1\]"),
        ({"options": {"max_waits": np.arange(2)}}, "options"),
        ({"faults": [1]}, "faults are instances of Death, Silence and LateStart, not 1"),
        ({"faults": 1}, "faults are instances of Death, Silence and LateStart, not 1"),
    ],
)
def test_arguments_of_other_kinds_are_refused_in_words(given, said):
    with pytest.raises(ms.InvalidInputError, match=said) as caught:
        ms.explore("open", **SHORT | given)
    assert "\n" not in str(caught.value)


def test_a_spec_of_other_things_is_refused_in_words():
    world = ms.CatalogEnvironment(name="open")
    spec = ms.RunSpec(environment=world, options={"x": 2j})
    with pytest.raises(ms.InvalidInputError, match="a run spec holds text, numbers"):
        ms.simulate(spec)


@pytest.mark.slow
def test_comparisons_take_numbers_of_numpy():
    short = ms.compare(
        ["open"], ["closest"], robots=np.array([1]), seeds=np.int64(1), radios=[np.float32(15)]
    )
    (result,) = short.results
    spec = ms.ExperimentSpec(
        name="numbers",
        environments=("open",),
        strategies=("closest",),
        robots=(np.int64(1),),
        repetitions=np.int64(1),
        radios=(RadioChoice(range_m=np.float32(15)),),
    )
    (again,) = ms.compare(spec).results
    assert again.digest == result.digest


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"threshold": 1.1}, r"the threshold is 1\.1; lightness is in \[0, 1\]"),
        ({"threshold": np.float32(-1)}, "the threshold is -1; lightness"),
        ({"threshold": float("nan")}, "the threshold is nan; lightness"),
        ({"threshold": "0.5"}, "the threshold must be a number, not '0.5'"),
        ({"resolution_m": "0.05"}, "the resolution must be a number, not '0.05'"),
        ({"resolution_m": np.array([1.0, 2.0])}, "the resolution must be a number, not array"),
        ({"resolution_m": float("inf")}, "the resolution is inf m per cell"),
    ],
)
def test_options_of_images_are_refused_in_words(tmp_path, options, said):
    path = tmp_path / "map.pgm"
    path.write_bytes(b"P5 4 4 255\n" + bytes([255] * 16))
    with pytest.raises(ms.MultiSrtError, match=said):
        ms.read_environment(path, **{"resolution_m": 1.0} | options)
    world = ms.read_environment(path, resolution_m=np.float32(1), threshold=np.array(0.5))
    assert world.area_m2 == 16.0
