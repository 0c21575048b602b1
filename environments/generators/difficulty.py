"""The difficulty of worlds, for generators that have no parameter of that name.

The generators of caverns, warehouses, cities, forests and dungeons have a parameter `difficulty`.
For the others it sets the parameters below, which change linearly with it.
"""

from multisrt.environments.generators.parameters import number

KNOB = "difficulty"
"""Name of the parameter."""

RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "garden": {"path_m": (1.4, 0.9)},
    "clutter": {"cover": (0.02, 0.12)},
    "rooms": {"loops": (1.0, 0.0)},
    "office": {"connecting": (0.6, 0.0), "door_m": (1.3, 0.8)},
    "maze": {"loops": (0.6, 0.0)},
    "hospital": {"links": (1.0, 0.0), "door_m": (1.6, 0.9)},
}
"""Values of a generator's parameters at difficulty 0 and 1."""


def between(ends: tuple[float, float], difficulty: float) -> float:
    """Return the value at a difficulty between those at 0 and 1.

    Examples
    --------
    >>> between((0.6, 0.0), 0.5)
    0.3
    """
    easy, hard = ends
    return easy + difficulty * (hard - easy)


def parameters_at(generator: str, difficulty: float) -> dict[str, float]:
    """Return the parameters of a generator that a difficulty sets.

    Parameters
    ----------
    generator : str
        A name in `RANGES`.
    difficulty : float
        From 0 (easy to explore) to 1 (hard).

    Returns
    -------
    dict
        Values of the parameters by their names.

    Raises
    ------
    InvalidInputError
        If the difficulty is out of range.

    Examples
    --------
    >>> parameters_at("maze", 0.5)
    {'loops': 0.3}
    """
    share = number(generator, KNOB, difficulty, 0.0, 1.0)
    return {name: round(between(ends, share), 6) for name, ends in RANGES[generator].items()}
