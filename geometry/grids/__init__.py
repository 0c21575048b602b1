"""Rasters, occupancy, and distances and paths on grids."""
