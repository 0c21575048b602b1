"""A forest: trunks of varied thickness, spread by Poisson-disc sampling."""

import math

import numpy as np
import shapely
from scipy.spatial import cKDTree

from multisrt.environments.environment import Environment
from multisrt.environments.generators.as_drawn import polygon_around, starts_among
from multisrt.environments.generators.parameters import call_text, number, rounded_up, seed_number
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray

TRUNK_M = (0.15, 0.6)
"""Radii of the thinnest and the thickest trunks, in metres."""

CORNERS = 6
"""Corners of a trunk's outline."""

OPEN_GAP_M = 5.0
"""Distance between trunks that is added to the passage at difficulty 0, in metres."""

ROUNDS = 4
"""Number of batches of places for trunks; later ones fill the remaining gaps."""


def forest(
    *, size_m: float = 28.0, difficulty: float = 0.5, passage_m: float = 1.2, seed: int = 0
) -> Environment:
    """Draw a square forest in which every trunk can be driven around.

    Trunks of different radii are spread by Poisson-disc sampling: each keeps a gap to all others
    and to the border. The gap is never narrower than `passage_m`, so that a disc of diameter
    ``0.9 * passage_m`` reaches everything.

    Parameters
    ----------
    size_m : float
        Inner width and height, 6 to 1000 m.
    difficulty : float
        From 0 to 1: the gap between trunks shrinks from the passage plus 5 m to the passage. The
        number of trunks grows with it, and so does the length of walls per area.
    passage_m : float
        Minimum distance between trunks, 0.8 to 4 m.
    seed : int
        Seed of the places and the thickness of the trunks.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range or there is no room for trunks.

    Notes
    -----
    Source: R. Bridson, Fast Poisson disk sampling in arbitrary dimensions, 2007; differs in:
    trunks have radii, and places are drawn in batches; of two that are too close, the earlier one
    is kept.

    Examples
    --------
    >>> world = forest(size_m=12, difficulty=0.2, seed=1)
    >>> world.origin
    'forest(size_m=12, difficulty=0.2, passage_m=1.2, seed=1)'
    >>> len(world.free.geoms[0].interiors) < len(forest(size_m=12, seed=1).free.geoms[0].interiors)
    True
    """
    size_m = number("forest", "size_m", size_m, 6.0, 1000.0)
    difficulty = number("forest", "difficulty", difficulty, 0.0, 1.0)
    passage_m = number("forest", "passage_m", passage_m, 0.8, 4.0)
    seed = seed_number("forest", seed)

    least = 2 * (passage_m + TRUNK_M[1])
    if size_m < least:
        raise InvalidInputError(
            f"forest: size_m={size_m:g} has no room for trunks with passage_m={passage_m:g}; give "
            f"a size_m of at least {rounded_up(least)} m, or a narrower passage"
        )

    rng = np.random.default_rng(seed)
    gap_m = passage_m + (1.0 - difficulty) ** 2 * OPEN_GAP_M
    centres, radii = _spread(size_m, gap_m, passage_m, rng)
    turns = (np.arange(CORNERS) + rng.uniform(0.0, 1.0, (len(radii), 1))) * (math.tau / CORNERS)
    outlines = centres[:, None] + radii[:, None, None] * np.stack(
        [libm.cos(turns), libm.sin(turns)], axis=-1
    )
    side, middle = passage_m / 2, size_m / 2
    clearance = min(0.6, 0.45 * passage_m)
    along = np.linspace(side, size_m - side, 60)
    places = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    far = cKDTree(centres).query(places)[0] > TRUNK_M[1] + clearance if len(centres) else [True]
    return Environment(
        "forest",
        polygon_around(shapely.box(0.0, 0.0, size_m, size_m), outlines),
        starts=starts_among(
            places[far] if np.any(far) else np.array([[side, side]]),
            [(middle, side), (middle, middle), (side, side), (size_m - side, size_m - side)],
        ),
        origin=call_text(
            "forest", size_m=size_m, difficulty=difficulty, passage_m=passage_m, seed=seed
        ),
    )


def _spread(
    size_m: float, gap_m: float, margin_m: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return centres ``(n, 2)`` and radii ``(n,)`` of trunks that keep their gap."""
    centres, radii = np.empty((0, 2)), np.empty(0)
    darts = math.ceil(1.5 * size_m**2 / (gap_m + sum(TRUNK_M)) ** 2) + 8
    for _ in range(ROUNDS):
        drawn = TRUNK_M[0] + (TRUNK_M[1] - TRUNK_M[0]) * rng.random(darts) ** 2
        least = (drawn + margin_m)[:, None]
        places = np.round(least + rng.random((darts, 2)) * (size_m - 2 * least), 3)
        centres, radii = np.vstack([centres, places]), np.append(radii, np.round(drawn, 3))
        kept = _first_come(centres, radii, gap_m)
        centres, radii = centres[kept], radii[kept]
    return centres, radii


def _first_come(centres: FloatArray, radii: FloatArray, gap_m: float) -> BoolArray:
    """Return which discs are kept if those too close to an earlier kept one are dropped."""
    pairs = cKDTree(centres).query_pairs(gap_m + 2 * TRUNK_M[1], output_type="ndarray")
    apart = np.hypot(*(centres[pairs[:, 0]] - centres[pairs[:, 1]]).T)
    # Rounding of the outlines may narrow a gap by up to a millimetre.
    pairs = pairs[apart < radii[pairs].sum(axis=1) + gap_m + 1e-3]
    earlier, later = pairs.min(axis=1), pairs.max(axis=1)
    refused = np.zeros(len(centres), dtype=np.bool_)
    undecided = np.ones(len(centres), dtype=np.bool_)
    while undecided.any():
        waiting = np.zeros(len(centres), dtype=np.bool_)
        waiting[later[undecided[earlier]]] = True
        kept = undecided & ~waiting
        undecided &= ~kept
        beaten = later[kept[earlier]]
        refused[beaten] = True
        undecided[beaten] = False
    return ~refused
