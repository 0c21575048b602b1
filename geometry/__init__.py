"""Plane geometry: visibility, safe regions, frontier arcs, rasters, footprints, collision.

Nothing here knows of robots or their environments. Lengths are in metres and angles in radians,
counter-clockwise from +x. Points are ``(n, 2)`` arrays of x and y; grids are ``[row, column]``,
row 0 being the lowest y.

numerics
    Kernels, and what they share: boxes, segments, distances, rings, points found by place.
regions
    What a range finder sees, and what is known to be free.
grids
    Rasters, occupancy, and distances and paths on grids.
bodies
    Footprints, their clearance and their collisions.
"""
