"""How a robot gets on: what it counts of the steps that did not go as planned."""

from __future__ import annotations

from dataclasses import dataclass

MOST_TRIES = 12
"""After so many tries a robot plans around those who stand in its way; and if it is boxed in,
it gives up."""

MOST_WAITS = 3
"""A robot that was told to wait so often in a row plans anew."""

MOST_STOPS = 3
"""A robot with more protective stops of late stands aside: two may stop one another for ever."""

MOST_ROUNDS = 40
"""After so many rounds of questions in one step a robot goes on without who does not agree."""


class BoxedIn(Exception):
    """The robot cannot get anywhere: bodies that do not answer stand all around."""


@dataclass(slots=True)
class Progress:
    """Counts of a robot's steps."""

    waits: int = 0
    troubles: float = 0.0
    stops: float = 0.0
    stays: int = 0
    rounds: int = 0

    @property
    def is_boxed_in(self) -> bool:
        """Whether it has found no way at all, time after time."""
        return self.stays > MOST_TRIES
