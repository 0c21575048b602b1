"""Floor plans in DXF: walls by the names of layers, or else all lines."""

from multisrt.environments.formats.dxf.reader import DXF, read_dxf

__all__ = ["DXF", "read_dxf"]
