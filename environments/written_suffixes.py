"""Suffixes of the map files that are written and can be read again.

Help pages show them; the formats themselves, which take longer to import, use the same ones.
"""

from typing import Final

SUFFIXES: Final = {
    "ROS map server": (".yaml", ".yml"),
    "GeoJSON": (".geojson", ".json"),
    "well-known text": (".wkt",),
    "SVG": (".svg",),
    "DXF": (".dxf",),
}
"""Suffixes by the name of the format, in lower case; the usual one first."""

READABLE_SUFFIXES: Final = {suffix: name for name, some in SUFFIXES.items() for suffix in some}
"""Names of the formats by suffix."""
