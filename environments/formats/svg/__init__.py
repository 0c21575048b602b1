"""Floor plans in SVG: walls by the names of layers, or else by what is painted dark."""

from multisrt.environments.formats.svg.reader import SVG, read_svg

__all__ = ["SVG", "read_svg"]
