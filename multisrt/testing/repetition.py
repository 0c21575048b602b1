"""An explorer that is driven by hand, and whose actions are compared with those of before."""

from __future__ import annotations

from typing import NoReturn

import msgspec

from multisrt.robots.defects import ExplorerDefect, brief
from multisrt.robots.explorer import Move, Steps
from multisrt.testing.fingerprint import fingerprint
from multisrt.testing.supervision import SupervisedExplorer
from multisrt.testing.watchdog import ComputesTooLong, Watchdog

MAX_DESCRIBED = 120
"""Characters to which actions and their fields are cut in messages."""


class ActionDiffers(Exception):
    """An explorer acted otherwise than before."""

    def __init__(self, what: str, where: str) -> None:
        super().__init__(what)
        self.what = what
        self.where = where
        self.has_drawn = False

    def defect(self, why: str, remedy: str) -> ExplorerDefect:
        """Return the defect, with a reason and a remedy."""
        return ExplorerDefect(f"{self.what}: {why}", self.where, remedy)


class Repetition:
    """An explorer that is driven by hand, and must act as it did before.

    Parameters
    ----------
    before : SupervisedExplorer
        What it was sent and did.
    actions : generator
        The actions of the new explorer.
    title : str
        Name of the run in messages.
    watchdog : Watchdog
        Calls it.
    """

    def __init__(
        self,
        before: SupervisedExplorer,
        actions: Steps,
        title: str,
        watchdog: Watchdog,
    ) -> None:
        self._before = before
        self._actions = actions
        self._title = title
        self._watchdog = watchdog
        self._turn = 0

    def advance(self) -> bool:
        """Send it the next outcome; return whether there are more.

        Raises
        ------
        ActionDiffers
            If it does not yield what it yielded before.
        """
        turn = self._before.turns[self._turn]
        self._turn += 1
        try:
            action = self._watchdog.call(self._actions.send, turn.outcome)
        except StopIteration:
            acted = "nothing"
        except ComputesTooLong:
            acted = "nothing for long"
        except Exception as error:
            acted = f"{type(error).__name__}: {error}"
        else:
            if fingerprint(action) == turn.print:
                return self._turn < len(self._before.turns)
            if found := difference(action, turn.action):
                self._raise(f"yielded {found}")
            acted = _described(action)
        self._raise(f"yielded {acted}, not {_described(turn.action)}")

    def _raise(self, what: str) -> NoReturn:
        me = self._before.me
        who = "the robot" if me.team == 1 else f"robot {me.robot} of {me.team}"
        raise ActionDiffers(
            f"sent the same as before, it {what}",
            f"{who} in {self._title}, action {self._turn}",
        )


def _described(action: object) -> str:
    if isinstance(action, Move):
        x, y, heading = action.trajectory.end
        return f"Move to ({x:.6g}, {y:.6g}, {heading:.6g})"
    return brief(action, MAX_DESCRIBED)


def difference(now: object, before: object) -> str:
    """Return the first field in which two long actions of one kind differ, in words.

    Parameters
    ----------
    now, before : object
        The actions.

    Returns
    -------
    str
        Such as ``Note with event.rule = 'near', not 'far'``; empty for motions, actions of
        several kinds, and those that can be read as a whole.
    """
    if (
        type(now) is not type(before)
        or isinstance(now, Move)
        or max(len(repr(now)), len(repr(before))) <= MAX_DESCRIBED
    ):
        return ""
    kind, place = type(now).__name__, ""
    while isinstance(now, msgspec.Struct) and type(now) is type(before):
        for name in now.__struct_fields__:
            one, other = getattr(now, name), getattr(before, name)
            if fingerprint(one) != fingerprint(other):
                place = f"{place}.{name}" if place else name
                now, before = one, other
                break
        else:
            return ""
    return f"{kind} with {place} = {brief(now, MAX_DESCRIBED)}, not {brief(before, MAX_DESCRIBED)}"
