"""Álvarez's Table 4.1: its maps with their figures, and our maps in their place."""

from __future__ import annotations

from dataclasses import dataclass

from multisrt.spec import Scalar


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A map of the thesis with its row of Table 4.1, and our map in its place.

    Attributes
    ----------
    number : int
        Number of the map in the thesis.
    kind : str
        Kind of the map, by Figures 4.1 to 4.3.
    area_m2 : float
        Area of the map.
    success_percent : float
        Percentage of successful explorations.
    time, distance : (float, float)
        Coefficient (s, m) and exponent of the two power laws.
    name : str
        Generator of our map, which has the outer size and the kind of the thesis's map.
    parameters : dict from str to Scalar
        Parameters of the generator.
    """

    number: int
    kind: str
    area_m2: float
    success_percent: float
    time: tuple[float, float]
    distance: tuple[float, float]
    name: str
    parameters: dict[str, Scalar]

    @property
    def was_seen(self) -> bool:
        """Whether single runs on our map had been looked at when it was chosen."""
        return self.name == "maze"

    @property
    def label(self) -> str:
        """Label of our map in tables."""
        return f"scenario {self.number} ({self.name})"


PASSAGE_M = 1.5
"""Width of doors and passages (m): the body with its margin, and a cell of 0.5 m."""

_ROOMS: dict[str, Scalar] = {"corridor_m": 2.4, "door_m": PASSAGE_M, "furnished": False}

SCENARIOS = (
    Scenario(
        number=1,
        kind="rooms and corridors",
        area_m2=600.0,
        success_percent=97.50,
        time=(747.31, -0.891),
        distance=(140.97, -1.362),
        name="office",
        parameters={"width_m": 30.0, "height_m": 20.0, **_ROOMS},
    ),
    Scenario(
        number=11,
        kind="maze",
        area_m2=900.0,
        success_percent=96.56,
        time=(1424.9, -0.886),
        distance=(239.03, -1.154),
        name="maze",
        parameters={"size_m": 30.0, "cells": 8, "loops": 0.1},
    ),
    Scenario(
        number=10,
        kind="rooms and corridors",
        area_m2=1600.0,
        success_percent=95.31,
        time=(2615.7, -0.920),
        distance=(460.03, -1.080),
        name="rooms",
        parameters={"size_m": 40.0, "rooms_per_side": 5, "door_m": PASSAGE_M},
    ),
    Scenario(
        number=13,
        kind="rooms and corridors",
        area_m2=1600.0,
        success_percent=98.13,
        time=(1642.4, -0.861),
        distance=(288.86, -1.000),
        name="office",
        parameters={"width_m": 40.0, "height_m": 40.0, **_ROOMS},
    ),
    Scenario(
        number=43,
        kind="irregular obstacles",
        area_m2=1600.0,
        success_percent=98.44,
        time=(2209.4, -0.801),
        distance=(366.41, -1.005),
        name="clutter",
        parameters={"size_m": 40.0, "cover": 0.1, "passage_m": PASSAGE_M},
    ),
    Scenario(
        number=18,
        kind="irregular obstacles, dense",
        area_m2=1600.0,
        success_percent=94.06,
        time=(2221.9, -0.729),
        distance=(296.85, -0.940),
        name="clutter",
        parameters={"size_m": 40.0, "cover": 0.12, "passage_m": 1.2},
    ),
    Scenario(
        number=45,
        kind="maze",
        area_m2=1600.0,
        success_percent=99.06,
        time=(2692.6, -0.893),
        distance=(434.44, -1.048),
        name="maze",
        parameters={"size_m": 40.0, "cells": 10, "loops": 0.3},
    ),
    Scenario(
        number=16,
        kind="irregular obstacles",
        area_m2=1600.0,
        success_percent=97.19,
        time=(2639.0, -0.875),
        distance=(401.84, -1.045),
        name="clutter",
        parameters={"size_m": 40.0, "cover": 0.1, "obstacle_m": 5.0, "passage_m": PASSAGE_M},
    ),
    Scenario(
        number=21,
        kind="maze",
        area_m2=3600.0,
        success_percent=97.19,
        time=(4745.6, -0.855),
        distance=(772.29, -0.930),
        name="maze",
        parameters={"size_m": 60.0, "cells": 14, "loops": 0.3},
    ),
    Scenario(
        number=46,
        kind="rooms and corridors",
        area_m2=4378.0,
        success_percent=96.56,
        time=(7083.3, -0.910),
        distance=(1180.10, -0.970),
        name="office",
        parameters={"width_m": 72.0, "height_m": 60.8, **_ROOMS},
    ),
)
"""Rows of Table 4.1, in its order."""

QUICK_SCENARIOS = (1, 11, 43)
"""Numbers of the smallest maps of each kind."""
