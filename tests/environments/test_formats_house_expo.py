import json

import pytest
import shapely

from multisrt.environments.formats import read_environment
from multisrt.geometry.errors import MapFormatError

# Two rooms of 4 x 3 m with a door of 1 m between them, in a wall of 0.2 m.
VERTS = [[0, 0], [4, 0], [4, 1], [4.2, 1], [4.2, 0], [8.2, 0], [8.2, 3], [4.2, 3]]
VERTS += [[4.2, 2], [4, 2], [4, 3], [0, 3]]
PLAN = {
    "verts": VERTS,
    "id": "0004d52d1aeeb8ae6de39d6bd993e992",
    "room_category": {"bedroom": [[0, 0, 4, 3], [4.2, 0, 8.2, 3]]},
    "room_num": 2,
    "bbox": {"min": [0, 0], "max": [8.2, 3]},
}


@pytest.fixture
def read(tmp_path):
    def write_and_read(text=None, name=None, **changes):
        path = tmp_path / "plan.json"
        path.write_text(json.dumps(PLAN | changes) if text is None else text)
        return read_environment(path, name=name)

    return write_and_read


def test_the_outline_is_free_space_in_metres(read):
    world = read()
    door = shapely.box(4, 1, 4.2, 2)
    rooms = shapely.box(0, 0, 4, 3) | shapely.box(4.2, 0, 8.2, 3)
    assert world.free.symmetric_difference(rooms | door).area < 1e-12
    assert len(world.components) == 1
    assert (world.name, world.origin) == (PLAN["id"], "plan.json")


def test_the_name_is_the_id_unless_one_is_given(read):
    assert read(name="flat").name == "flat"
    for house in (None, 5, "", "x" * 81):
        assert read(id=house).name == "plan"


def test_an_outline_that_touches_itself_is_filled_by_the_even_odd_rule(read):
    # A square that is entered along a spike, and a figure of eight.
    spike = read(verts=[[0, 0], [4, 0], [6, 0], [4, 0], [4, 4], [0, 4]])
    assert spike.area_m2 == pytest.approx(16)
    eight = read(verts=[[0, 0], [4, 4], [4, 0], [0, 4]])
    assert eight.area_m2 == pytest.approx(8)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"verts": "none"}, "has no verts; a floor plan of HouseExpo has a list"),
        ({"verts": [[0, 0], [1, 1]]}, "has no verts; .* at least three"),
        ({"verts": [[0, 0], [1, 1], [2]]}, r"vertex 3 is a list of 1; it must be \[x, y\]"),
        ({"verts": [[0, 0], [1, 1], 5]}, "vertex 3 is 5; it must be"),
        ({"verts": [[0, 0], [1, "a"], [2, 0]]}, "vertex 2 is a list of 2; it must be"),
        ({"verts": [[0, 0], [1, True], [2, 0]]}, "vertex 2 is"),
        ({"verts": [[0, 0], [1, float("nan")], [2, 0]]}, "vertex 2 is"),
        ({"verts": [[10**400, 0], [1, 1], [2, 0]]}, "vertex 1 is"),
        ({"verts": [[0, 0], [1, 1], [2, 2]]}, "free space is empty|no area|polygons"),
    ],
)
def test_fault_is_named(read, changes, message):
    with pytest.raises(MapFormatError, match=message) as error:
        read(**changes)
    assert "plan.json" in str(error.value)


def test_text_that_is_not_json_is_refused(read):
    with pytest.raises(MapFormatError, match=r"plan\.json is not JSON, line 1"):
        read('{"verts": [[0, 0]')
    with pytest.raises(MapFormatError, match=r"plan\.json is not a floor plan of HouseExpo: "):
        read('{"verts": ' + "[" * 100_000)


def test_a_plan_has_its_own_scale(tmp_path):
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(PLAN))
    with pytest.raises(MapFormatError, match="leave out --resolution"):
        read_environment(path, resolution_m=1.0)
    with pytest.raises(MapFormatError, match="leave out --threshold"):
        read_environment(path, threshold=0.5)
