"""The readers under test: their seeds, dictionaries, options and calls.

A folder of seeds has the files of one format; the files that they name (an image, an included
file) are in its folder ``companions``, which is copied beside every input.
"""

from __future__ import annotations

import shutil
import tempfile
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from benchmarks.fuzz.mutations import (
    Mutation,
    mutated,
    of_dxf,
    of_image,
    of_npy,
    of_text,
    pick,
)
from multisrt.environments.environment import Environment
from multisrt.environments.formats import read_environment
from multisrt.events import AnyEvent
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Footer, Header, Recording
from multisrt.recording.lines import digest_of

FOLDER: Final = Path(__file__).resolve().parents[2] / "tests" / "environments" / "fuzz"
"""Folder of the seeds and of the kept inputs."""

Options = dict[str, Any]
Read = Callable[..., Environment]
Finish = Callable[[bytes, np.random.Generator], bytes]


@dataclass(frozen=True, slots=True)
class Input:
    """A file for a reader: its content, the suffix of its name, and the options of the reader."""

    content: bytes
    suffix: str
    options: Options


def _as_it_is(content: bytes, rng: np.random.Generator) -> bytes:
    return content


@dataclass(frozen=True, kw_only=True)
class Target:
    """A reader, and how its inputs are made.

    Attributes
    ----------
    name : str
        The format, and the name of the folders of its seeds and of its kept inputs.
    options : tuple of dict
        Sets of options of the reader: each input uses one of them, kept inputs are read with all.
    mutate : Mutation
        Mutation of its files.
    words : tuple of bytes
        The dictionary of the format.
    read : callable
        Takes the path and the options.
    finish : callable
        Last step in making an input, such as the repair of a digest.
    """

    name: str
    options: tuple[Options, ...] = ({},)
    mutate: Mutation = of_text
    words: tuple[bytes, ...] = ()
    read: Read = read_environment
    finish: Finish = _as_it_is

    @cached_property
    def seeds(self) -> list[tuple[str, bytes]]:
        """Suffix and content of the seeds, in the order of their names."""
        return [(path.suffix, path.read_bytes()) for path in files_in(FOLDER / "seeds" / self.name)]

    def input(self, seed: int, number: int) -> Input:
        """Return an input by its number: first the unchanged seeds, then mutations of them.

        Parameters
        ----------
        seed : int
            Seed of the campaign.
        number : int
            Number of the input, from 0.
        """
        rng = np.random.default_rng((seed, zlib.crc32(self.name.encode()), number))
        options = pick(rng, self.options)
        if number < len(self.seeds):
            suffix, content = self.seeds[number]
            return Input(content, suffix, options)
        suffix, content = pick(rng, self.seeds)
        contents = [other for _, other in self.seeds]
        changed = mutated(content, rng, contents, self.words, self.mutate)
        return Input(self.finish(changed, rng), suffix, options)

    def warm_up(self) -> None:
        """Read the seeds once, so that later inputs include no compilation and imports."""
        with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
            self.prepare(Path(name))
            for (suffix, content), options in product(self.seeds, self.options):
                path = Path(name) / f"input{suffix}"
                path.write_bytes(content)
                with suppress(InvalidInputError):
                    self.read(path, **options)

    def prepare(self, folder: Path) -> None:
        """Copy the companions of the inputs into an empty folder."""
        for path in files_in(FOLDER / "seeds" / self.name / "companions"):
            shutil.copy(path, folder)


def files_in(folder: Path) -> list[Path]:
    """Return the files of a folder, sorted by name; none if there is no folder."""
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if path.is_file())


def _of_team(path: Path, **options: Any) -> Environment:
    return read_environment(path.parent / "rooms.png", starts_from=path, **options)


def _of_recording(path: Path) -> Environment:
    recording = Recording.load(path)
    try:
        return recording.environment()
    except InvalidInputError as error:  # names the world: the file is read
        raise InvalidInputError(f"{path}: {error}") from error


def _with_digest(content: bytes, rng: np.random.Generator) -> bytes:
    """Repair the digest of half of the recordings, if their lines can be read."""
    if rng.random() < 0.5:
        return content
    try:
        header, *events, footer = (_LINE.decode(line) for line in content.splitlines())
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return content  # the reader says what is wrong
    if not isinstance(header, Header) or not isinstance(footer, Footer):
        return content
    found = [event for event in events if not isinstance(event, Header | Footer)]
    return content.replace(footer.digest.encode(), digest_of(header, found).encode())


_LINE: Final = msgspec.json.Decoder(Header | AnyEvent | Footer)


def _words(text: str) -> tuple[bytes, ...]:
    return tuple(word.encode() for word in text.split())


def _choices(**values: tuple[Any, ...]) -> tuple[Options, ...]:
    """Return the combinations of values of options; None leaves an option out."""
    return tuple(
        {name: value for name, value in zip(values, some, strict=True) if value is not None}
        for some in product(*values.values())
    )


_SVG_WORDS: Final = (
    *_words("none nonzero evenodd inherit url(#c) #c #w wall free door start obstacle 9% 5mm"),
    *_words("M m L H V C S Q T A Z a c z round square bevel transparent currentColor #fff #0000"),
    b'<use href="#w"/>',
    b'<use href="#c"/>',
    b'<g clip-path="url(#c)">',
    b'<g id="w">',
    b"</g>",
    b'<clipPath id="c"><rect width="5" height="5"/></clipPath>',
    b'<rect x="1" y="1" width="3" height="2"/>',
    b'<path d="M0 0L9 9M0 9L9 0" stroke="black" stroke-width="0.2"/>',
    b'<!DOCTYPE svg [<!ENTITY a "b">]>',
    b'<!DOCTYPE svg SYSTEM "file:///etc/passwd">',
    b"&a;",
    b"<![CDATA[",
    b"]]>",
    b"<!--",
    b"-->",
    b'<image href="a.png"/>',
    b'<svg width="50%" viewBox="0 0 1 1">',
    b"</svg>",
    b'transform="scale(1e6)"',
    b'transform="matrix(1 0 0 0 0 0)"',
    b'style="display:none"',
    b"<style>.a{fill:red}@media print{*{fill:none}}</style>",
)

_DXF_WORDS: Final = (
    *_words("SECTION ENDSEC EOF HEADER TABLES BLOCKS ENTITIES OBJECTS LINE LWPOLYLINE POLYLINE"),
    *_words("VERTEX SEQEND CIRCLE ARC ELLIPSE SPLINE HATCH SOLID TRACE INSERT POINT TEXT MLINE"),
    *_words("BLOCK ENDBLK LAYER TABLE ENDTAB A-WALL OUTLINE door starts b c AC1009 AC1032 3DFACE"),
)

_SCALES: Final = (None, 0.1, 0.01)

TARGETS: Final = {
    target.name: target
    for target in (
        Target(
            name="wkt",
            options=_choices(repair=(None, True)),
            words=(
                *_words("POLYGON MULTIPOLYGON GEOMETRYCOLLECTION EMPTY Z M ZM LINESTRING POINT"),
                *(b"POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))", b", POLYGON EMPTY", b"SRID=4326;"),
                *(b"GEOMETRYCOLLECTION (", b"((", b"))", b"), (", b"CURVEPOLYGON"),
            ),
        ),
        Target(
            name="geojson",
            options=_choices(repair=(None, True)),
            words=(
                *_words('"type" "Feature" "FeatureCollection" "GeometryCollection" "Polygon"'),
                *_words('"MultiPolygon" "Point" "MultiPoint" "LineString" "coordinates" "crs"'),
                *_words('"geometry" "geometries" "features" "properties" "kind" "obstacle"'),
                *_words('"start" "outline" null true false {} [] [[]] [0,0] "EPSG:4326" "\\ud800"'),
            ),
        ),
        Target(
            name="house_expo",
            words=_words('"verts" "id" "bbox" "room_category" null true {} [] [0,0] [9,0] "\\n"'),
        ),
        Target(
            name="map_server",
            words=(
                *_words("image: resolution: origin: negate: occupied_thresh: free_thresh: mode:"),
                *_words("trinary scale raw true no ~ 0x1f 1:30 5e-2 .nan .inf &a *a <<: !!binary"),
                *_words("!!python/object:os.system !!timestamp 2001-01-01 [0,0,0] {} | > ---"),
                *_words("rooms.png rooms.pgm ../rooms.png /etc/passwd . 16bit.png alpha.png"),
                *(b"b: &a [*a, *a]\n", b"<<: [*a, *a]\n", b"0x" + b"f" * 5000, b"? [a]\n: b\n"),
            ),
        ),
        Target(
            name="stage",
            words=(
                *_words("bitmap size pose origin boundary obstacle_return ranger_return noblocks"),
                *_words("block points point[0] model position define include floorplan a ( ) [ ]"),
                *_words('"rooms.png" "part.inc" "../rooms.png" "/dev/zero" "a.world" "" "cm"'),
                *(b"unit_length", b"unit_angle", b'include "part.inc"', b"model ( size [1 1 1] )"),
                *(
                    b"define a a ( )",
                    b"define a b ( a ( ) a ( ) )",
                    b'floorplan ( bitmap "rooms.png" )',
                ),
            ),
        ),
        Target(
            name="moving_ai",
            options=_choices(resolution_m=(1.0, 0.001)),
            words=_words("type octile height width map . @ T S W G O .... @@@@ 8000 tile"),
        ),
        Target(
            name="moving_ai_scenario",
            options=_choices(resolution_m=(1.0,)),
            words=_words("version 1 1.0 2 room.map maps/room.map ../room.map . / 0 99999999 \t"),
        ),
        Target(
            name="imr",
            options=_choices(repair=(None, True)),
            words=(
                *_words("[SCALE] [BORDER] [OBSTACLE] [INFO] [MAP_POINTS] [MAP_BORDER] [HOLE]"),
                *_words("[MAP_OBSTACLE] [NAME] [LIMITS] [POINTS] [NUM_HOLES] [MESH_NODES] [X]"),
                *(b"FORMAT=MAP_POINTS", b"FORMAT=X", b"\n0 0\n", b"\n[OBSTACLE]\n1 1\n2 1\n2 2\n"),
            ),
        ),
        Target(
            name="team",
            options=_choices(resolution_m=(1.0,)),
            words=_words("BaseStation Relay Explorer 0 1 99999999 1e5 A"),
            read=_of_team,
        ),
        Target(
            name="svg",
            options=_choices(resolution_m=_SCALES, threshold=(None, None, 0.2)),
            words=_SVG_WORDS,
        ),
        Target(
            name="dxf",
            options=_choices(resolution_m=_SCALES),
            mutate=of_dxf,
            words=_DXF_WORDS,
        ),
        Target(
            name="image",
            options=_choices(resolution_m=(1.0, 0.05), threshold=(None, 0.0, 0.5)),
            mutate=of_image,
        ),
        Target(
            name="numpy_array",
            options=_choices(resolution_m=(1.0,), threshold=(None, 0.5)),
            mutate=of_npy,
            words=_words(
                "descr fortran_order shape True False |b1 <i8 |i1 |u1 <f8 <f2 >i4 |O <U9 ()"
            ),
        ),
        Target(
            name="recording",
            words=_words('null true [] {} "event" "header" "footer" "robots" "free" 0 -1 [[]]'),
            read=_of_recording,
            finish=_with_digest,
        ),
    )
}
"""The readers by the names of their formats."""
