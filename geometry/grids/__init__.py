"""Rasters and the distances in them."""
