"""Worlds without narrow gaps, specks and vertices that are not needed."""

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
        What is removed; repeated and collinear vertices always are.

    Returns
    -------
    Environment
        The copy. Suggested starts that are no longer in free space are left out. Its
        `Environment.cleaning` says what was changed, also before.

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
    )
