"""Roles of the parts of a drawn plan by the names of layers: free space, walls, starts."""

import re
from collections.abc import Iterable
from enum import Enum
from typing import Final

from multisrt.environments.layers import Layers, counted_layers
from multisrt.geometry.errors import escaped


class Role(Enum):
    """Role of a part of a plan."""

    FREE = "free"
    """Its area, or the area inside its outline, is free space."""

    WALL = "wall"
    """Its filled areas and its lines, with their thickness, are occupied."""

    OBSTACLE = "obstacle"
    """Its area is occupied, whether filled or not."""

    DOOR = "door"
    """Its areas are openings in walls."""

    START = "start"
    """Its centre is a suggested start."""


# In order of precedence: a "wall door" is a door, an "obstacle outline" an obstacle.
WORDS: Final = {
    Role.DOOR: ("door", "doors", "doorway", "doorways", "opening", "openings"),
    Role.OBSTACLE: (
        "obstacle",
        "obstacles",
        "occupied",
        "blocked",
        "column",
        "columns",
        "cols",
        "pillar",
        "pillars",
        "furniture",
        "furn",
    ),
    Role.WALL: ("wall", "walls", "window", "windows", "glaz", "glazing"),
    Role.START: ("start", "starts"),
    Role.FREE: ("free", "outline", "outlines"),
}
"""The words in names that give parts their roles."""

PLURALS: Final = {
    Role.FREE: "free space",
    Role.WALL: "walls",
    Role.OBSTACLE: "obstacles",
    Role.DOOR: "doors",
    Role.START: "starts",
}
"""What layers of each role are read as, for messages."""

_ROLES: Final = {word: role for role, words in WORDS.items() for word in words}
_WORD: Final = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")


def role_of(names: Iterable[str]) -> Role | None:
    """Return the role of a part of a plan by its names.

    Parameters
    ----------
    names : iterable of str
        Names of the part: label, class, identifier or layer. Upper and lower case are the same;
        capitals, digits and punctuation separate words.

    Returns
    -------
    Role or None
        None if the names have none of the `WORDS`.

    Examples
    --------
    >>> role_of(["A-WALL-FULL"]), role_of(["innerWalls2"]), role_of(["layer1", "Free space"])
    (<Role.WALL: 'wall'>, <Role.WALL: 'wall'>, <Role.FREE: 'free'>)
    >>> role_of(["wallpaper"]) is None
    True
    """
    found = {_ROLES.get(word.lower()) for name in names for word in _WORD.findall(name)}
    return next((role for role in WORDS if role in found), None)


def role_within(names: Iterable[str], around: Role | None) -> Role | None:
    """Return the role of a part within a group that may have a role itself.

    Parameters
    ----------
    names : iterable of str
        Names of the part.
    around : Role or None
        The role of the group.

    Returns
    -------
    Role or None
        That of the part, or else of the group. Within a group that has a role, ``free`` and
        ``outline`` mean the outline of that object, for instance of a piece of furniture.

    Examples
    --------
    >>> role_within(["door"], Role.WALL), role_within(["outline"], Role.OBSTACLE)
    (<Role.DOOR: 'door'>, <Role.OBSTACLE: 'obstacle'>)
    """
    own = role_of(names)
    if own is None or (own is Role.FREE and around is not None):
        return around
    return own


def layers_of(shapes: Iterable[tuple[str, Role | None]]) -> Layers:
    """Return the layers of a plan that is read by their names.

    Parameters
    ----------
    shapes : iterable of (name, role)
        For each shape the name of its layer, and its role.

    Examples
    --------
    >>> layers_of([("A-WALL", Role.WALL), ("Layer 1", None)]).left_out
    (Layer(name='Layer 1', read_as='', shapes=1),)
    """
    shapes = list(shapes)
    return Layers(
        layers=counted_layers(
            (escaped(name), "" if role is None else PLURALS[role]) for name, role in shapes
        ),
        bounds_space=any(role in (Role.WALL, Role.FREE) for _, role in shapes),
        remedy="name layers walls, obstacles, free, ... to read them",
    )


def role_names() -> str:
    """Return the words that name walls, obstacles and free space, for messages."""
    return ", ".join(WORDS[role][0] for role in (Role.WALL, Role.OBSTACLE, Role.FREE))
