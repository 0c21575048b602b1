"""Floor plans in SVG: shapes by the names of their layers, or else by what is painted dark."""

from multisrt.environments.formats.svg.reader import SVG, read_svg

__all__ = ["SVG", "read_svg"]
