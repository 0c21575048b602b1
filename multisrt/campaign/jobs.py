"""What a process of a campaign is asked and answers: JSON objects, one a line."""

from __future__ import annotations

import msgspec

from multisrt.campaign.mission import Verdict
from multisrt.spec import RunSpec


class Make(msgspec.Struct, frozen=True, kw_only=True, tag="make"):
    """Draw a mission and judge it.

    Attributes
    ----------
    seed, number : int
        Seed of the campaign, and number of the mission.
    """

    seed: int
    number: int


class Judge(msgspec.Struct, frozen=True, kw_only=True, tag="judge"):
    """Make a run and judge it.

    Attributes
    ----------
    spec : RunSpec
        The run.
    folder : str
        Folder for its recording and replay; empty: neither is written.
    """

    spec: RunSpec
    folder: str = ""


Job = Make | Judge


class Attempt(msgspec.Struct, frozen=True, kw_only=True, tag="attempt"):
    """Message ahead of the answer to `Make`, before each draw and before each set-up.

    Attributes
    ----------
    spec : RunSpec or None
        The run that is set up; None while it is drawn.
    refused : int
        Number of draws before it that were impossible.
    """

    spec: RunSpec | None
    refused: int


class Answer(msgspec.Struct, frozen=True, kw_only=True, tag="verdict"):
    """Answer to a job.

    Attributes
    ----------
    verdict : Verdict
        What is judged.
    unwritten : str
        Why its recording and replay could not be written; empty if they were, or were not asked
        for.
    """

    verdict: Verdict
    unwritten: str = ""


ANSWERS = msgspec.json.Decoder(Attempt | Answer)
"""Decodes a line that a process wrote."""
