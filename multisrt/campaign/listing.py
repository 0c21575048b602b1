"""All invariants of a campaign, with their descriptions."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from multisrt.campaign.invariants import INVARIANTS
from multisrt.campaign.lane import EQUAL_DIGEST, REPEATED_EVERY
from multisrt.campaign.mission import ENDS, JUDGED, NO_ERROR
from multisrt.campaign.mission_process import HANG_S, HANGS
from multisrt.campaign.witness import WITNESSED
from multisrt.geometry.errors import InvalidInputError, did_you_mean, shown

OWN: Final = MappingProxyType(
    {
        NO_ERROR: "The run raises no error and does not terminate its process.",
        ENDS: "The run ends within its time limit and a bounded number of events, with a "
        "consistent outcome and reason.",
        HANGS: f"The run takes less than {HANG_S:g} s of elapsed time.",
        EQUAL_DIGEST: "Another process produces the same recording, byte for byte; checked for "
        f"every run that fails and for one run in {REPEATED_EVERY}.",
        JUDGED: "All invariants can be evaluated: none of them raises an error.",
    }
)
"""Invariants that are checked while a run is executed; the others are checked on its recording."""


def descriptions() -> dict[str, str]:
    """Return the description of each invariant, by name: the first line of its docstring.

    Returns
    -------
    dict of str to str
        Those that are checked while a run is executed, those that its witness judges, then those
        checked on its recording.

    Examples
    --------
    >>> descriptions()["no-error"]
    'The run raises no error and does not terminate its process.'
    """
    judged = {name: _description(invariant.__doc__ or "") for name, invariant in INVARIANTS.items()}
    return {**OWN, **WITNESSED, **{name: text for name, text in judged.items() if name not in OWN}}


def _description(doc: str) -> str:
    """Return the description in the first line of a docstring, without "Check that"."""
    text = doc.strip().partition("\n")[0].removeprefix("Check that ")
    return text[:1].upper() + text[1:]


def require_invariant(name: str) -> None:
    """Raise InvalidInputError if there is no invariant with this name.

    Examples
    --------
    >>> require_invariant("no-error")
    """
    if name not in (known := descriptions()):
        raise InvalidInputError(
            f"there is no invariant {shown(name)}{did_you_mean(name, known)}; "
            "'multisrt campaign invariants' lists them"
        )
