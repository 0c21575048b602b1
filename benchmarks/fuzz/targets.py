"""The readers under test by the names of their formats."""

from __future__ import annotations

from itertools import product
from typing import Any, Final

import msgspec
import numpy as np

from benchmarks.fuzz.flaws import flaw_of_shown
from benchmarks.fuzz.mutations import of_dxf, of_image, of_npy
from benchmarks.fuzz.readers import (
    flaw_of_spec,
    of_campaign_store,
    of_experiment,
    of_experiment_store,
    of_failure,
    of_recording,
    of_run_spec,
    of_team,
)
from benchmarks.fuzz.scripts import NAMES, REFUSALS, flaw_of_run, run_script
from benchmarks.fuzz.tables import from_sql, of_sqlite
from benchmarks.fuzz.target import Options, Target
from benchmarks.fuzz.trees import of_json, of_json_lines, of_toml, of_yaml
from multisrt.events import AnyEvent
from multisrt.recording import Footer, Header
from multisrt.recording.lines import digest_of


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

_SPEC_WORDS: Final = (
    *_words('"from" "catalog" "suite" "file" "wkt" "name" "parameters" "seed" "size_m" "path"'),
    *_words('"open" "maze" "clutter" "office" "indoor-30/07" "version" "starts" "start"'),
    *_words('"strategy" "srt-ball" "minpos" "gain" "informed" "mine.py:Mine" "options" "home"'),
    *_words('"worth" "relays" "pursue" "robots" "footprint" "disc:0" "disc:9" "box:1e9x1" "poly:"'),
    *_words('"drive" "kind" "dubins" "holonomic" "range_finder" "range_m" "beams" "radio" "walls"'),
    *_words('"weaken" "loss" "base" "faults" "fault" "death" "late_start" "time_s" "when" "stop"'),
    *_words('"max_time_s" "max_idle_s" "clustered" "suggested" [0,0] [1,1,0] [[1,1]] {} nan inf'),
    *(b'"POLYGON EMPTY"', b'"POLYGON ((0 0, 9 0, 9 9, 0 0))"', b'"polygon:0,0 1,0 0,1"'),
)

_STORE_WORDS: Final = _words(
    '"experiment" "folder" "provenance" "asked" "seed" "program" "complete" "crashed" "closest" '
    '"coverage" "makespan_s" "metrics" "covered" "delivered" "invariant" "says" null [] {} -1 1e308'
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
            mutate=of_json,
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
            mutate=of_json,
            words=_words('"verts" "id" "bbox" "room_category" null true {} [] [0,0] [9,0] "\\n"'),
        ),
        Target(
            name="map_server",
            mutate=of_yaml,
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
            read=of_team,
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
            mutate=of_json_lines,
            read=of_recording,
            finish=_with_digest,
        ),
        Target(
            name="run_spec",
            mutate=of_toml,
            words=_SPEC_WORDS,
            read=of_run_spec,
            flaw=flaw_of_spec,
        ),
        Target(
            name="experiment",
            mutate=of_toml,
            words=(
                *_SPEC_WORDS,
                *_words('"name" "label" "repetition" "0-9" "3-1" "1,2" "repetitions" "drawn"'),
                *_words('"strategies" "environments" "blocks" "exclude" "members" "places" "none"'),
                *_words('"informed" "failed" "all" "limits" "memory_mb" "horizon_s" "between_s"'),
            ),
            read=of_experiment,
            flaw=flaw_of_spec,
        ),
        Target(
            name="experiment_store",
            mutate=of_sqlite,
            words=_STORE_WORDS,
            read=of_experiment_store,
            flaw=flaw_of_shown,
            made=from_sql,
        ),
        Target(
            name="campaign_store",
            mutate=of_sqlite,
            words=_STORE_WORDS,
            read=of_campaign_store,
            flaw=flaw_of_shown,
            made=from_sql,
        ),
        Target(
            name="failure",
            mutate=of_toml,
            words=_words('"says" "invariant" "seed" "number" "robot" "no-collision" -1 nan'),
            read=of_failure,
            flaw=lambda failure: flaw_of_shown(str(failure.violation)),
        ),
        Target(
            name="strategy",
            options=_choices(radio=(None, True)),
            mutate=of_json,
            words=NAMES,
            read=run_script,
            flaw=flaw_of_run,
            must_name=REFUSALS,
        ),
    )
}
"""The readers by the names of their formats."""
