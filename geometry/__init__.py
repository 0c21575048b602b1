"""Shapes and numbers: visibility, safe regions, frontier arcs, rasters, footprints, collision.

This room knows no robots. Everything is in metres and radians, angles are counter-clockwise
from +x, points are ``(n, 2)`` arrays of x and y, grids are ``[row, column]``.
"""
