"""Rooms along a corridor, each drawn in a frame of its own, for offices and hospitals."""

from dataclasses import dataclass

import numpy as np
from shapely import affinity, box
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics.kernel import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Bay:
    """A room seen from its corridor.

    Its own x runs along the front wall from 0 to `width_m`, its y from the front wall's inner
    face (0) to the far wall (`depth_m`).

    Parameters
    ----------
    x, y : float
        Where the corner with own coordinates (0, 0) lies in the world, in metres.
    along, inward : (x, y)
        Unit vectors of the two axes in the world.
    width_m, depth_m : float
        Inner size.
    """

    x: float
    y: float
    along: tuple[float, float]
    inward: tuple[float, float]
    width_m: float
    depth_m: float

    def place(self, drawing: BaseGeometry) -> BaseGeometry:
        """Return a drawing in the room's frame, transformed to the frame of the world."""
        (a, d), (b, e) = self.along, self.inward
        return affinity.affine_transform(drawing, [a, b, d, e, self.x, self.y])

    def floor(self) -> BaseGeometry:
        """Return the room's floor in the frame of the world."""
        return self.place(box(0.0, 0.0, self.width_m, self.depth_m))

    def doorway(self, at_m: float, door_m: float, wall_m: float) -> BaseGeometry:
        """Return an opening in the front wall around x = `at_m`, in the frame of the world."""
        return self.place(box(at_m - door_m / 2, -wall_m, at_m + door_m / 2, 0.0))

    def split(self, widths_m: FloatArray, wall_m: float) -> list["Bay"]:
        """Divide the bay into rooms of the given widths (m), starting at x = 0 of its frame."""
        rooms, left = [], 0.0
        for width in widths_m:
            rooms.append(
                Bay(
                    x=self.x + left * self.along[0],
                    y=self.y + left * self.along[1],
                    along=self.along,
                    inward=self.inward,
                    width_m=float(width),
                    depth_m=self.depth_m,
                )
            )
            left += float(width) + wall_m
        return rooms

    def mirrored(self) -> "Bay":
        """Return the same room with the x axis of its frame reversed."""
        return Bay(
            x=self.x + self.width_m * self.along[0],
            y=self.y + self.width_m * self.along[1],
            along=(-self.along[0], -self.along[1]),
            inward=self.inward,
            width_m=self.width_m,
            depth_m=self.depth_m,
        )


def shared_widths(total_m: float, shares: FloatArray, wall_m: float) -> FloatArray:
    """Return the widths of rooms along a length, in proportion to `shares`, with walls between.

    Widths are whole centimetres; the last room takes the rest.
    """
    usable = total_m - (len(shares) - 1) * wall_m
    widths: FloatArray = np.round(usable * shares / shares.sum(), 2)
    widths[-1] = usable - widths[:-1].sum()
    return widths


def clear_zone(at_m: float, door_m: float, reach_m: float) -> BaseGeometry:
    """Return the floor behind a door that is kept free of furniture, in the room's frame."""
    return box(at_m - door_m / 2 - 0.1, -0.1, at_m + door_m / 2 + 0.1, reach_m)
