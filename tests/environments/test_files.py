"""Names of other files in map files, and lengths: the same rules for all readers."""

import math

import hypothesis.strategies as st
import pytest
from hypothesis import given

from multisrt.environments.environment import MAX_COORDINATE_M, MIN_LENGTH_M
from multisrt.environments.formats import read_environment
from multisrt.environments.formats.files import MAX_NAME_LENGTH, named_file, require_length
from multisrt.geometry.errors import MapFormatError

YAML = (
    'image: "{}"\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\n'
    "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
)
NAMING = {
    "map.yaml": YAML,
    "bitmap.world": 'model ( bitmap "{}" )',
    "include.world": 'include "{}"',
    "map.scen": "version 1\n0\t{}\t3\t2\t0\t1\t1\t0\t1\n",
}
LONG = {
    "longer than the bound": "a" * 5000,
    "longer than a name of the file system": "é" * 200,
    "folders": "a/" * 2000,
    "back and forth": "../maps/" * 40,
}


@pytest.mark.parametrize("map_file", NAMING)
@pytest.mark.parametrize("what", LONG)
def test_files_that_cannot_be_opened_are_named_in_short(tmp_path, map_file, what):
    folder = tmp_path / "maps"
    folder.mkdir()
    path = folder / map_file
    path.write_text(NAMING[map_file].format(LONG[what]), encoding="utf-8")
    resolution_m = 1.0 if map_file.endswith(".scen") else None
    with pytest.raises(MapFormatError, match=r"names the file '.*\.\.\.") as caught:
        read_environment(path, resolution_m=resolution_m)
    assert len(str(caught.value)) < 300 + 2 * len(str(path))


def test_a_name_leads_to_a_file_or_to_none(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "a.png").touch()
    assert named_file(tmp_path, "sub/a.png", "m") == tmp_path / "sub" / "a.png"
    assert named_file(tmp_path, "sub/b.png", "m") is None
    assert named_file(tmp_path, "a" * MAX_NAME_LENGTH, "m") is None
    with pytest.raises(MapFormatError, match=r"^m names the file .* at most 255 characters"):
        named_file(tmp_path, "a" * (MAX_NAME_LENGTH + 1), "m")
    with pytest.raises(
        MapFormatError, match=r"^m names the file '\.\./x', which is not in the fol"
    ):
        named_file(tmp_path / "sub", "../x", "m")


@given(st.floats())
def test_lengths_have_finite_products_and_quotients(length_m):
    if MIN_LENGTH_M <= length_m <= MAX_COORDINATE_M:
        assert require_length("map", "the size", length_m) == length_m
    else:
        with pytest.raises(MapFormatError, match=r"^map: the size is .* m; it must be a finite"):
            require_length("map", "the size", length_m)


@pytest.mark.parametrize("length_m", [math.inf, math.nan, 1e308, 5e-324, 0.0, -1.0])
def test_lengths_out_of_range_are_refused(length_m):
    with pytest.raises(MapFormatError, match=r"the scale is .* m per unit; .* at most 1e.07 m"):
        require_length("map", "the scale", length_m, unit="m per unit")
