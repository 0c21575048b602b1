"""Kinematics, timed motions, and planning of motions inside known free space."""
