"""Cleaned copies of worlds, without narrow gaps, specks and superfluous vertices."""

from __future__ import annotations

import shapely

from multisrt.environments.cleaning import Cleaning, CleaningOptions, cleaned
from multisrt.environments.environment import Environment


def fixed(environment: Environment, options: CleaningOptions) -> Environment:
    """Return a cleaned copy of a world.

    Parameters
    ----------
    environment : Environment
        The world.
    options : CleaningOptions
        What is removed. Repeated and collinear vertices always are.

    Returns
    -------
    Environment
        The copy, without suggested starts that are no longer in free space. Its
        `Environment.cleaning` has the changes that were made here added to those of the world.

    Raises
    ------
    InvalidInputError
        If no free space is left.

    Examples
    --------
    >>> speck = shapely.box(1, 1, 1.02, 1.02)
    >>> hall = Environment("hall", shapely.box(0, 0, 4, 3) - speck, starts=[(2, 2)])
    >>> copy = fixed(hall, CleaningOptions(speck_m=0.05))
    >>> copy.area_m2, copy.starts, str(copy.cleaning)
    (12.0, ((2.0, 2.0),), '1 obstacle dropped as too small (0.0004 m2)')
    """
    space, changed = cleaned(environment.free, options)
    shapely.prepare(space)
    starts = [start for start in environment.starts if shapely.contains_xy(space, *start)]
    changed += Cleaning(removed_starts=len(environment.starts) - len(starts))
    return Environment(
        environment.name,
        space,
        starts=starts,
        origin=environment.origin,
        cleaning=environment.cleaning + changed,
        layers=environment.layers,
        outlined_obstacles=environment.outlined_obstacles,
    )
