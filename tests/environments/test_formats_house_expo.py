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


SPIKE = [[0, 0], [4, 0], [6, 0], [4, 0], [4, 4], [0, 4]]
# Two rooms without a wall between them, entered from a third; and two squares that meet in a point.
BACK_TO_BACK = [[0, 0], [8, 0], [8, 1], [4, 1], [4, 4], [8, 4], [8, 1], [8, 5], [0, 5]]
CORNER = [[0, 0], [2, 0], [2, 2], [4, 2], [4, 4], [2, 4], [2, 2], [0, 2]]
FILM = [[0, 0], [4, 0], [4, 2], [4.0005, 4], [4, 4.0], [4.0005, 2], [4, 4.1], [0, 4]]


@pytest.mark.parametrize(("verts", "area_m2"), [(SPIKE, 16), (BACK_TO_BACK, 28), (CORNER, 8)])
@pytest.mark.parametrize("step", [1, -1])
def test_an_outline_may_touch_itself(read, verts, area_m2, step):
    assert read(verts=verts[::step]).area_m2 == pytest.approx(area_m2)


def test_an_outline_may_cross_itself_by_less_than_a_millimetre(read):
    assert read(verts=FILM).area_m2 == pytest.approx(16.2, abs=0.01)


BOW = [[0, 0], [10, 8], [10, 0], [0, 8]]
LOOP = [[0, 0], [6, 0], [6, 4], [2, 4], [2, -1], [0, -1]]
TWICE = [[0, 0], [4, 0], [4, 4], [1, 4], [1, 1], [3, 1], [3, 5], [0, 5]]


@pytest.mark.parametrize(
    ("verts", "place"),
    [(BOW, r"\(5, 4\)"), (LOOP, r"\(2, 0\)"), (TWICE, r"\(3, 4\)"), (SPIKE + BOW, ".*")],
)
def test_an_outline_that_crosses_itself_is_refused_and_can_be_repaired(
    read, tmp_path, verts, place
):
    with pytest.raises(MapFormatError, match=f"crosses itself at {place}; draw .*--fix") as error:
        read(verts=verts)
    assert "plan.json" in str(error.value)
    world = read_environment(tmp_path / "plan.json", repair=True)
    assert world.cleaning.repaired_polygons == 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"verts": "none"}, "has no verts; a floor plan of HouseExpo has a list"),
        ({"verts": [[0, 0], [1, 1]]}, "has 2 vertices in verts; .* at least three"),
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
