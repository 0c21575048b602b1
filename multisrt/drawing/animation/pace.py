"""How run time becomes animation time: duration, speed, and pictures a second."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from multisrt.geometry.errors import InvalidInputError

DURATION_S: Final = 24.0
"""Default of the time that an animation takes for a run, in seconds; less for shorter runs."""

HOLD_S: Final = 2.0
"""Time for which the last picture stays, in seconds."""

DURATION_RANGE_S: Final = (0.5, 600.0)
FPS_RANGE: Final = (1.0, 60.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pace:
    """The pictures of an animation: when each is shown, and what time of the run it shows.

    Attributes
    ----------
    run_s : float
        Duration of the run, in seconds.
    duration_s : float
        Time that the animation takes for it, in seconds; the last picture stays for another
        `HOLD_S`.
    fps : float
        Pictures a second.
    """

    run_s: float
    duration_s: float
    fps: float

    @classmethod
    def of(cls, run_s: float, *, duration_s: float | None, speed: float | None, fps: float) -> Pace:
        """Return the pace of an animation of a run.

        Parameters
        ----------
        run_s : float
            Duration of the run, in seconds.
        duration_s : float, optional
            Time that the animation takes for it.
        speed : float, optional
            How many times as fast as the robots it is.
        fps : float
            Pictures a second.

        Returns
        -------
        Pace
            The pace.

        Raises
        ------
        InvalidInputError
            If both duration and speed are given, or a number is out of range.

        Examples
        --------
        >>> pace = Pace.of(500.0, duration_s=None, speed=25.0, fps=10.0)
        >>> pace.duration_s, pace.last, pace.time_s(100)
        (20.0, 200, 250.0)
        """
        if duration_s is not None and speed is not None:
            raise InvalidInputError("give the duration of an animation or its speed, not both")
        if speed is not None:
            if not (math.isfinite(speed) and speed > 0.0):
                raise InvalidInputError(f"the speed is {speed!r}; give a positive number")
            duration_s = run_s / speed
            least, most = DURATION_RANGE_S
            if run_s > 0.0 and not least <= duration_s <= most:
                raise InvalidInputError(
                    f"at {speed:g} times the speed of the robots the animation takes "
                    f"{duration_s:.3g} s; give a speed from {run_s / most:.3g} to "
                    f"{run_s / least:.3g}"
                )
        elif duration_s is not None:
            _require_within(
                "the duration of the animation in seconds", duration_s, DURATION_RANGE_S
            )
        else:
            duration_s = min(DURATION_S, run_s)
        _require_within("the number of pictures a second", fps, FPS_RANGE)
        return cls(run_s=run_s, duration_s=max(DURATION_RANGE_S[0], duration_s), fps=fps)

    @property
    def last(self) -> int:
        """Number of the picture that shows the end of the run, counted from 0."""
        return max(1, round(self.duration_s * self.fps))

    @property
    def pictures(self) -> int:
        """Number of pictures, with those that show the end."""
        return self.last + round(HOLD_S * self.fps) + 1

    @property
    def total_s(self) -> float:
        """Duration of the animation with the last picture, in seconds."""
        return self.duration_s + HOLD_S

    @property
    def speed(self) -> float:
        """How many times as fast as the robots the animation is."""
        return self.run_s / self.duration_s

    def time_s(self, picture: int) -> float:
        """Return the time of the run that a picture shows, in seconds."""
        return self.run_s * min(1.0, picture / self.last)

    def picture_after(self, time_s: float) -> int:
        """Return the first picture that shows a time of the run or a later one."""
        if self.run_s <= 0.0:
            return 0
        # Times are those of pictures where they differ from them by rounding only.
        return min(self.last, max(0, math.ceil(self.last * time_s / self.run_s - 1e-9)))

    def share(self, time_s: float) -> float:
        """Return when a time of the run is shown, as a share of the whole animation."""
        done = time_s / self.run_s if self.run_s > 0.0 else 0.0
        return min(1.0, max(0.0, done)) * self.duration_s / self.total_s

    def share_of(self, picture: int) -> float:
        """Return when a picture is shown, as a share of the whole animation."""
        return picture / self.last * self.duration_s / self.total_s


def _require_within(what: str, value: float, limits: tuple[float, float]) -> None:
    least, most = limits
    if not least <= value <= most:
        raise InvalidInputError(f"{what} is {value!r}; give a number from {least:g} to {most:g}")
