"""Export of worlds, and of what robots knew of them, in a format chosen by the suffix."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from multisrt.environments.environment import Environment
from multisrt.environments.written_suffixes import SUFFIXES
from multisrt.exporting.drawings import dxf_bytes, svg_bytes
from multisrt.exporting.known_map import known_content, world_content
from multisrt.exporting.map_content import MapContent, MapOptions
from multisrt.exporting.map_server import map_server_files
from multisrt.exporting.polygon_text import geojson_bytes, wkt_bytes
from multisrt.exporting.solids import glb_bytes, stl_bytes
from multisrt.exporting.written import require_new, require_suffix, write_files
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.recording import Recording

Files = dict[Path, bytes]

LINE_LAYERS: Final = ("edges", "paths")
"""Lines that solids of a run show above the floor: edges of trees and paths of robots."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapWriter:
    """A format in which maps are written.

    Attributes
    ----------
    name : str
        Its name in messages and tables.
    suffixes : tuple of str
        Suffixes of its files in lower case, with the dot.
    files : callable
        Returns the files of a map, the named one first.
    others : tuple of str
        Suffixes of the files that are written beside the named one.
    options : tuple of str
        The fields of `MapOptions` that it uses.
    """

    name: str
    suffixes: tuple[str, ...]
    files: Callable[[MapContent, Path, MapOptions], Files]
    others: tuple[str, ...] = ()
    options: tuple[str, ...] = ()


def _drawn(
    encoded: Callable[[Environment], bytes],
) -> Callable[[MapContent, Path, MapOptions], Files]:
    return lambda content, path, options: {path: encoded(content.environment)}


def _solid(
    encoded: Callable[[MapContent, MapOptions], bytes],
) -> Callable[[MapContent, Path, MapOptions], Files]:
    return lambda content, path, options: {path: encoded(content, options)}


_WALLS: Final = ("height_m", "thickness_m")

MAP_WRITERS: Final = (
    MapWriter(
        name="ROS map server",
        suffixes=SUFFIXES["ROS map server"],
        files=map_server_files,
        others=(".pgm",),
        options=("cell_m",),
    ),
    MapWriter(name="GeoJSON", suffixes=SUFFIXES["GeoJSON"], files=_drawn(geojson_bytes)),
    MapWriter(
        name="well-known text", suffixes=SUFFIXES["well-known text"], files=_drawn(wkt_bytes)
    ),
    MapWriter(name="SVG", suffixes=SUFFIXES["SVG"], files=_drawn(svg_bytes)),
    MapWriter(name="DXF", suffixes=SUFFIXES["DXF"], files=_drawn(dxf_bytes)),
    MapWriter(name="STL", suffixes=(".stl",), files=_solid(stl_bytes), options=_WALLS),
    MapWriter(name="GLB", suffixes=(".glb",), files=_solid(glb_bytes), options=_WALLS),
)
"""The formats in which maps are written."""

MAP_SUFFIXES: Final = {suffix: writer.name for writer in MAP_WRITERS for suffix in writer.suffixes}
"""Names of the formats by suffix."""


def save_environment(
    environment: Environment,
    path: str | Path,
    *,
    options: MapOptions | None = None,
    overwrite: bool = False,
) -> None:
    """Write a world as a map file.

    Parameters
    ----------
    environment : Environment
        The world.
    path : str or Path
        The file, whose suffix determines the format:

        - ``.yaml`` or ``.yml``: ROS map server, with a ``.pgm`` image beside it
        - ``.geojson`` or ``.json``: GeoJSON, with the suggested starts
        - ``.wkt``: well-known text of free space
        - ``.svg``: its outlines, with the suggested starts
        - ``.dxf``: its outlines in layers, with the suggested starts
        - ``.stl``: its walls as solids
        - ``.glb``: its walls and its floor as solids

        It is written completely or not at all.
    options : MapOptions, optional
        Width of a pixel; height and thickness of walls.
    overwrite : bool, optional
        Whether an existing file is replaced.

    Raises
    ------
    InvalidInputError
        If the suffix is another one, the format cannot hold the world, the file exists and may not
        be replaced, or it cannot be written.
    MissingExtraError
        If the format is DXF and ezdxf is not installed (``multisrt[dxf]``).

    Notes
    -----
    Worlds read back from GeoJSON, well-known text, SVG and DXF have the same coordinates to the
    last digit. From a map server, walls differ by less than two cells, and passages narrower than
    two cells may be closed.

    Examples
    --------
    >>> import multisrt as ms
    >>> save_environment(ms.environment("office"), "office.geojson")
    >>> ms.read_environment("office.geojson") == ms.environment("office")
    True
    >>> save_environment(ms.environment("office"), "grid.yaml", options=MapOptions(cell_m=0.1))
    """
    _save(MapContent(environment=environment), Path(path), options, overwrite=overwrite)


def save_map(
    recording: Recording,
    path: str | Path,
    *,
    robot: int | None = None,
    time_s: float | None = None,
    environment: Environment | None = None,
    options: MapOptions | None = None,
    without: Iterable[str] = (),
    overwrite: bool = False,
) -> None:
    """Write what a robot of a run, or the team, knew of the world at some time as a map file.

    Parameters
    ----------
    recording : Recording
        The run.
    path : str or Path
        The file, whose suffix determines the format, as for `save_environment`. In the image of a
        map server, cells are free if their centre was known to be free, occupied if an observed
        surface passes through them, and unknown otherwise. Solids have walls at observed surfaces,
        and show trees and paths above the floor.
    robot, time_s, environment
        As for `known_map`.
    options : MapOptions, optional
        Width of a pixel; height and thickness of walls.
    without : iterable of {"edges", "paths"}, optional
        Lines that solids do not show: edges of trees, or paths of robots.
    overwrite : bool, optional
        Whether an existing file is replaced.

    Raises
    ------
    InvalidInputError
        If there is no such robot or time, nothing was known then, or for the reasons of
        `save_environment`.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> save_map(run.recording, "team.yaml")
    >>> save_map(run.recording, "robot-1.geojson", robot=1, time_s=5.0)
    """
    path = Path(path)
    require_suffix(path, MAP_SUFFIXES, "maps")
    content = known_content(
        recording,
        environment or recording.environment(),
        robot=robot,
        time_s=time_s,
        layers=shown_lines(without),
    )
    _save(content, path, options, overwrite=overwrite)


def save_world(
    recording: Recording,
    path: str | Path,
    *,
    environment: Environment | None = None,
    options: MapOptions | None = None,
    without: Iterable[str] = (),
    overwrite: bool = False,
) -> None:
    """Write the true world of a run, with the starts of its robots, as a map file.

    Parameters are those of `save_map`. Solids show the trees and paths of the whole run.

    Raises
    ------
    InvalidInputError
        For the reasons of `save_environment`.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> save_world(run.recording, "run.glb")
    """
    path = Path(path)
    require_suffix(path, MAP_SUFFIXES, "maps")
    content = world_content(
        recording, environment or recording.environment(), layers=shown_lines(without)
    )
    _save(content, path, options, overwrite=overwrite)


def shown_lines(without: Iterable[str]) -> list[str]:
    """Return the lines of solids that are not left out.

    Raises
    ------
    InvalidInputError
        If a name is not one of `LINE_LAYERS`.
    """
    absent = set(without)
    for name in sorted(absent.difference(LINE_LAYERS)):
        raise InvalidInputError(
            f"solids have no layer {name!r}{did_you_mean(name, LINE_LAYERS)}; "
            f"they have {', '.join(LINE_LAYERS)}"
        )
    return [name for name in LINE_LAYERS if name not in absent]


def map_writer(path: Path) -> MapWriter:
    """Return the format of the suffix of a path.

    Raises
    ------
    InvalidInputError
        If maps are not written in such a format.
    """
    suffix = require_suffix(path, MAP_SUFFIXES, "maps")
    return next(writer for writer in MAP_WRITERS if suffix in writer.suffixes)


def map_files(path: Path) -> list[Path]:
    """Return the files that are written for a map with a path, that path first."""
    return [path, *(path.with_suffix(suffix) for suffix in map_writer(path).others)]


def _save(content: MapContent, path: Path, options: MapOptions | None, *, overwrite: bool) -> None:
    require_new(map_files(path), overwrite=overwrite)
    files = map_writer(path).files(content, path, options or MapOptions())
    write_files(files, overwrite=overwrite)
