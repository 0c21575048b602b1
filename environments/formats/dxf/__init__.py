"""Floor plans in DXF: lines of CAD drawings as walls, by the names of layers."""

from multisrt.environments.formats.dxf.reader import DXF, read_dxf

__all__ = ["DXF", "read_dxf"]
