import contextlib
import io
import tracemalloc

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.lib import format as npy_format
from PIL import Image

from multisrt.environments.formats import format_of, read_environment
from multisrt.geometry.errors import MapFormatError

# A grid of 6 x 4 cells that is free in columns 1 to 4 of its upper two rows.
FREE = np.zeros((4, 6), dtype=bool)
FREE[:2, 1:5] = True
ROOM = shapely.box(1, 2, 5, 4)


def saved(tmp_path, array):
    path = tmp_path / "room.npy"
    np.save(path, array)
    return path


def assert_room(path, **options):
    world = read_environment(path, resolution_m=1.0, **options)
    assert world.free.equals(ROOM), shapely.to_wkt(world.free)


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize(
    "array",
    [
        ~FREE,
        np.where(FREE, 0, 100).astype(np.int8),
        np.where(FREE, 25, 26).astype(">i2"),
        np.where(FREE, 1, 100).astype(np.int16),
        np.where(FREE, 0, -1).astype(np.int64),
        np.where(FREE, 0.25, 0.26),
        np.where(FREE, 0, np.nan).astype(np.float32),
        np.where(FREE, 254, 205).astype(np.uint8),
        np.where(FREE, 195, 127).astype(np.uint8),
    ],
    ids=lambda array: f"{array.dtype}-{array.max()}",
)
def test_every_type_of_number_is_read(tmp_path, array, order):
    assert_room(saved(tmp_path, np.asarray(array, order=order)))


def test_the_first_row_is_at_the_top_as_in_an_image(tmp_path):
    grey = np.random.default_rng(1).integers(0, 256, (20, 30)).astype(np.uint8)
    Image.fromarray(grey).save(tmp_path / "noise.png")
    np.save(tmp_path / "noise.npy", grey)
    picture, array = (
        read_environment(tmp_path / f"noise{suffix}", resolution_m=0.1)
        for suffix in (".png", ".npy")
    )
    assert picture.digest == array.digest


def test_resolution_is_asked_for(tmp_path):
    path = saved(tmp_path, ~FREE)
    assert format_of(path).name == "numpy array"
    with pytest.raises(MapFormatError, match=r"room\.npy .*--resolution"):
        read_environment(path)


def test_threshold_is_for_grey_values(tmp_path):
    grey = saved(tmp_path, np.where(FREE, 129, 128).astype(np.uint8))
    assert_room(grey, threshold=128 / 255)
    with pytest.raises(MapFormatError, match="leave out --threshold"):
        read_environment(saved(tmp_path, ~FREE), resolution_m=1.0, threshold=0.5)


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (FREE.astype(np.uint8), "uint8 numbers up to 1, which may be occupancies"),
        (np.where(FREE, 0, 100).astype(np.uint8), "uint8 numbers up to 100"),
        (np.array([[0, 100, 255]], np.uint8), "uint8 numbers 0 to 100 and 255"),
        (FREE.astype(np.int8), "int8 numbers up to 1, which may be 1 per cent or occupied: save"),
        (FREE.astype(">i4"), "numbers up to 1, which may be 1 per cent or occupied: save"),
        (FREE.astype(np.int64), r"as int8 \(0 to 100, -1 unknown\) or bool \(True occupied\)"),
        (FREE.astype(np.int8) - np.eye(4, 6, dtype=np.int8), "numbers up to 1, which may be"),
        (FREE.astype(np.uint16), "type uint16"),
        (FREE.astype(complex), "type complex128"),
        (FREE.astype("datetime64[s]"), "type datetime64"),
        (FREE.astype("S3"), "convert it with astype"),
        (np.zeros((2, 2), [("a", "i4")]), "convert it with astype"),
        (np.zeros(4), r"shape \(4,\)"),
        (np.zeros((2, 2, 3)), r"shape \(2, 2, 3\)"),
        (np.zeros((0, 3)), r"shape \(0, 3\), which has no cell"),
        (np.full((2, 3), 101, np.int8), "row 0, column 0 is 101"),
        (np.array([[0, 0], [0, -2]]), "row 1, column 1 is -2"),
        (np.pad([[101]], ((599_999, 0), (0, 0))), "row 599999, column 0 is 101"),
        (np.array([[0, 1.5]]), "row 0, column 1 is 1.5; .*NaN for the unknown"),
        (np.array([[0, -np.inf]]), "row 0, column 1 is -inf"),
        (np.ones((2, 2)), "no cell has an occupancy of at most 0.25"),
        (np.full((2, 2), -1), "no cell has an occupancy of at most 0.25"),
    ],
)
def test_arrays_that_are_not_grids_are_refused(tmp_path, array, message):
    with pytest.raises(MapFormatError, match=message):
        read_environment(saved(tmp_path, array), resolution_m=1.0)


def test_objects_are_not_unpickled(tmp_path):
    path = tmp_path / "object.npy"
    np.save(path, np.array([[print, 0]], object), allow_pickle=True)
    with pytest.raises(MapFormatError, match=r"object \(pickled Python\)"):
        read_environment(path, resolution_m=1.0)


def header(shape, descr="'|b1'", version=(1, 0), rest=b""):
    text = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    size = len(text).to_bytes(2 if version == (1, 0) else 4, "little")
    return b"\x93NUMPY" + bytes(version) + size + text + rest


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (header("(2, 3)", rest=bytes(5)), "ends after 5 of 6 bytes"),
        (header("(100000, 100000)"), "100000 x 100000 cells; grids are read up to 64,000,000"),
        (header("(-1, -6)", rest=bytes(6)), "sides are not negative"),
        (header(f"({'9' * 4000}, 6)", rest=bytes(6)), "damaged header"),
        (header("(" + "1, " * 500 + ")", rest=bytes(6)), r"shape \(1, [1 ,]*\.\.\.; a grid has"),
        (header("(True, 6)", rest=bytes(6)), "sides are not negative"),
        (header("(2.0, 3)", rest=bytes(6)), "damaged header"),
        (header("(2, 3", rest=bytes(6)), "damaged header"),
        (header("(" * 300, rest=bytes(6)), "damaged header"),
        (header("(" * 9 + "2, 3" + ")" * 9, rest=bytes(6)), "damaged header"),
        (header("-" * 9000 + "1", rest=bytes(6)), "damaged header"),
        (header("not " * 2000 + "1", rest=bytes(6)), "damaged header"),
        (header("(2, 3)", descr="'|O'", rest=bytes(6)), "object"),
        (header("(2, 3)", version=(3, 0), rest=bytes(6)), r"version 3\.0"),
        (header("(2, 3)" + " " * 20_000, rest=bytes(6)), "header of 20,0"),
        (header("(2, 3)", version=(2, 0))[:8] + b"\xff" * 4, "header of 4,294,967,295 bytes"),
        (b"\x93NUMPY", "version none"),
        (b"\x93NUMPY\x01\x00\x76", "damaged header"),
    ],
)
def test_faulty_files_are_named(tmp_path, content, message):
    path = tmp_path / "room.npy"
    path.write_bytes(content)
    with pytest.raises(MapFormatError, match=rf"room\.npy.*{message}"):
        read_environment(path, resolution_m=1.0)


def test_a_bool_with_other_bytes_is_occupied(tmp_path):
    path = tmp_path / "room.npy"
    path.write_bytes(header("(2, 2)", rest=b"\0\0\2\xff"))
    assert read_environment(path, resolution_m=1.0).bounds == (0, 1, 2, 2)


def test_a_suffix_alone_is_not_enough(tmp_path):
    path = tmp_path / "room.npy"
    path.write_text("no array")
    with pytest.raises(MapFormatError, match=r"not a \.npy file"):
        read_environment(path, resolution_m=1.0)


def test_a_claim_of_many_cells_allocates_nothing(tmp_path):
    path = tmp_path / "room.npy"
    path.write_bytes(header("(8000, 8000)", descr="'<f8'"))
    tracemalloc.start()
    with pytest.raises(MapFormatError, match="ends after 0 of 512,000,000 bytes"):
        read_environment(path, resolution_m=1.0)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 2**20


@st.composite
def damaged(draw):
    """A sound file, some of whose bytes are replaced, left out or repeated."""
    dtype = draw(st.sampled_from(["?", "u1", "i1", "<i4", ">f4", "f8"]))
    file = io.BytesIO()
    array = np.random.default_rng(draw(st.integers(0, 9))).integers(0, 2, (3, 5)).astype(dtype)
    npy_format.write_array(file, array, version=draw(st.sampled_from([(1, 0), (2, 0)])))
    raw = bytearray(file.getvalue())
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(raw) - 1))
        kind = draw(st.sampled_from(["replace", "cut", "repeat", "word"]))
        if kind == "replace":
            raw[at] = draw(st.integers(0, 255))
        elif kind == "cut":
            del raw[at : at + draw(st.integers(1, 9))]
        elif kind == "repeat":
            raw[at:at] = raw[at : at + 9] * draw(st.integers(1, 50))
        else:
            raw[at : at + 2] = draw(
                st.sampled_from([b"99999999", b"-1", b"(", b"'", b"[('a','f8')]", b"None", b"e9"])
            )
        raw = raw or bytearray(b"\x93")
    return bytes(raw)


@settings(max_examples=300, deadline=None)
@given(content=damaged())
def test_damage_raises_nothing_but_map_format_errors(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "damaged.npy"
    path.write_bytes(content)
    with contextlib.suppress(MapFormatError):
        read_environment(path, resolution_m=1.0)
