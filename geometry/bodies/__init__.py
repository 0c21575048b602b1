"""Footprints of robots, their clearance from obstacles and their collisions."""
