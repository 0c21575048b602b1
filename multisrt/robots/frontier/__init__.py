"""Frontier bidding: teams that share out the frontiers of a raster by what they cost."""
