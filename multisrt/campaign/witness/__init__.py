"""What passes between explorers and the simulation, of which recordings have only a part.

The witness of a run sees every action that an explorer yields, and every outcome that it is sent:
messages, scans, sightings, ends of motions. Each module judges one kind of them; its docstrings
state what is required, and the tolerances.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from multisrt.campaign.witness.arrivals import NAME as ARRIVALS
from multisrt.campaign.witness.datasheets import NAME as TOLD
from multisrt.campaign.witness.news import NAME as NEWS
from multisrt.campaign.witness.scans import NAME as SCANS
from multisrt.campaign.witness.sightings import NAME as SIGHTINGS
from multisrt.campaign.witness.witness import OVER, Witness

__all__ = ["WITNESSED", "Witness"]

WITNESSED: Final = MappingProxyType(
    {
        TOLD: "Robots are told of themselves, before they begin, what the spec says.",
        ARRIVALS: "Messages are received once, by those that they are for, and when the radio "
        "says.",
        NEWS: "Robots learn nodes from messages that they receive; the base station from all that "
        "reach it.",
        SCANS: "Range finders measure the distances to walls, from where robots are.",
        SIGHTINGS: "Robots see the bodies that are in sight, as and where these are, and are told "
        "by which one they were stopped.",
        OVER: "A run ends when all robots have, and no message is on its way.",
    }
)
"""Invariants that the witness judges, with their descriptions."""
