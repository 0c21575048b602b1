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
        TOLD: "The data sheet that a robot is given before it begins is what the spec says.",
        ARRIVALS: "Each message is received once, by its addressees only, at the time that the "
        "radio model defines.",
        NEWS: "Robots learn only nodes that reached them in messages; the base station learns all "
        "of them.",
        SCANS: "Range finders measure the distances to walls, from where robots are.",
        SIGHTINGS: "Robots see the bodies in sight, at their true places, and are told which one "
        "stopped them.",
        OVER: "A run ends when all robots have ended and no message is on its way.",
    }
)
"""Invariants that the witness judges, with their descriptions."""
