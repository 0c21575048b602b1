"""All invariants of a campaign, with what each demands."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from multisrt.campaign.invariants import INVARIANTS
from multisrt.campaign.lane import EQUAL_DIGEST, REPEATED_EVERY
from multisrt.campaign.mission import ENDS, JUDGED, NO_ERROR
from multisrt.campaign.mission_process import HANG_S, HANGS
from multisrt.geometry.errors import InvalidInputError, did_you_mean, shown

OWN: Final = MappingProxyType(
    {
        NO_ERROR: "Making a run raises no error and does not take its process down.",
        ENDS: "Every run ends within a bound on events and its time limit, with an outcome and a "
        "reason that fit.",
        HANGS: f"Every run ends within {HANG_S:g} s of a clock, whatever it does.",
        EQUAL_DIGEST: "Another process makes the same recording, byte for byte; tried for every "
        f"run that fails, and one in {REPEATED_EVERY}.",
        JUDGED: "The invariants can be judged: none of them raises an error.",
    }
)
"""What is judged of a run while it is made, by name; the others are judged of its recording."""


def demands() -> dict[str, str]:
    """Return what each invariant demands, by name: the first line of its docstring.

    Returns
    -------
    dict of str to str
        Those that are judged while a run is made, then those that are judged of its recording.

    Examples
    --------
    >>> demands()["no-error"]
    'Making a run raises no error and does not take its process down.'
    """
    judged = {name: _demanded(invariant.__doc__ or "") for name, invariant in INVARIANTS.items()}
    return {**OWN, **{name: text for name, text in judged.items() if name not in OWN}}


def _demanded(doc: str) -> str:
    """Return what an invariant demands, by the first line of its docstring, "Check that ..."."""
    text = doc.strip().partition("\n")[0].removeprefix("Check that ")
    return text[:1].upper() + text[1:]


def require_invariant(name: str) -> None:
    """Raise InvalidInputError unless there is an invariant of a name.

    Examples
    --------
    >>> require_invariant("no-error")
    """
    if name not in (known := demands()):
        raise InvalidInputError(
            f"there is no invariant {shown(name)}{did_you_mean(name, known)}; "
            "'multisrt campaign invariants' lists them"
        )
