"""Scans of range finders, the safe regions that follow from it, and their frontiers."""
