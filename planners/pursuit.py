"""Where a robot that is out of touch may be on the route that it reported, and where to meet it.

The route is a sequence of cells. In each step a robot on the route stays, leaves it, or goes on to
the next cell; one that has left it stays away or comes back to where it left. So its place is a
Markov chain, and a pursuer most probably meets it at the cell at which it most probably is when the
pursuer can be there.

Source: M-TARE (repository `caochao39/mtare_planner`, `pursuit_mdp`; C. Cao, H. Zhu, Z. Ren,
H. Choset and J. Zhang, Representation granularity enables time-efficient autonomous exploration in
large, complex worlds, Science Robotics 2023), with its probabilities as defaults. Differs in: at
the end of the route, where there is no next cell, a robot that would go on stays; one off the
route comes back where it left it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray


class Meeting(NamedTuple):
    """Place and time at which to meet a robot.

    Attributes
    ----------
    cell : int
        Index of the cell on the route.
    step : int
        Number of the step.
    probability : float
        Probability that the robot is at the cell after that step.
    """

    cell: int
    step: int
    probability: float


def presence(
    cells: int, steps: int, *, stay: float = 0.35, leave: float = 0.15, stay_away: float = 0.5
) -> FloatArray:
    """Return the probability that a robot is at each cell of its route after each step.

    Parameters
    ----------
    cells : int
        Number of cells of the route; the robot begins at the first.
    steps : int
        Number of steps.
    stay, leave : float
        Probability of a robot on the route to stay at its cell, or to leave the route; otherwise it
        goes on.
    stay_away : float
        Probability of a robot off the route to stay there.

    Returns
    -------
    (steps + 1, cells) array
        The sum of a row is 1 minus the probability that the robot is off the route.

    Raises
    ------
    InvalidInputError
        If there is no cell, the number of steps is negative, or a value is not a probability.

    Examples
    --------
    >>> presence(3, 2).round(4).tolist()
    [[1.0, 0.0, 0.0], [0.35, 0.5, 0.0], [0.1975, 0.35, 0.25]]
    """
    if cells < 1 or steps < 0:
        raise InvalidInputError(f"{cells} cells and {steps} steps; at least 1 and 0 are needed")
    shares = (stay, leave, stay_away, 1.0 - stay - leave)
    if not all(-1e-12 <= share <= 1.0 for share in shares):
        raise InvalidInputError(
            f"stay is {stay}, leave {leave} and stay_away {stay_away}; they must be from 0 to 1, "
            "and stay and leave together at most 1"
        )
    on, off = np.zeros((steps + 1, cells)), np.zeros(cells)
    on[0, 0] = 1.0
    for k in range(steps):
        going = (1.0 - stay - leave) * on[k]
        on[k + 1] = stay * on[k] + (1.0 - stay_away) * off
        on[k + 1, 1:] += going[:-1]
        on[k + 1, -1] += going[-1]
        off = leave * on[k] + stay_away * off
    return on


def best_meeting(arrivals: ArrayLike, probabilities: FloatArray) -> Meeting | None:
    """Return the place and time at which a pursuer most probably meets a robot.

    Parameters
    ----------
    arrivals : (cells,) array of float
        First step at which the pursuer can be at each cell; ``inf`` if never.
    probabilities : (steps + 1, cells) array
        As `presence` returns it.

    Returns
    -------
    Meeting or None
        Of equally probable ones the earliest, then the first cell; None if the pursuer can reach no
        cell within the steps.

    Examples
    --------
    A pursuer that comes from the end of the route meets it there:

    >>> cell, step, probability = best_meeting([6.0, 5.0, 4.0], presence(3, 10))
    >>> cell, step, round(probability, 4)
    (2, 4, 0.4775)
    >>> best_meeting([11.0, float("inf"), 20.0], presence(3, 10)) is None
    True
    """
    last = len(probabilities) - 1
    found = [
        Meeting(cell, int(step), float(probabilities[int(step), cell]))
        for cell, step in enumerate(np.ceil(np.asarray(arrivals, dtype=float)).tolist())
        if step <= last
    ]
    return min(found, key=lambda m: (-m.probability, m.step, m.cell), default=None)
