"""The papers' own experiments, their printed figures, and which of their claims hold here."""

from __future__ import annotations

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.presets.alvarez import ALVAREZ
from multisrt.presets.minpos import MINPOS_PRESET
from multisrt.presets.multi_srt import MULTI_SRT
from multisrt.presets.preset import Preset
from multisrt.presets.sbx_r import SBX_R_PRESET

__all__ = ["PRESETS", "Preset", "preset_named"]

PRESETS: dict[str, Preset] = {
    preset.name: preset for preset in (MULTI_SRT, SBX_R_PRESET, MINPOS_PRESET, ALVAREZ)
}


def preset_named(name: str) -> Preset:
    """Find a preset.

    Raises
    ------
    InvalidInputError
        If there is none of that name; the message lists them.
    """
    if name not in PRESETS:
        raise InvalidInputError(
            f"there is no preset {name!r}{did_you_mean(name, PRESETS)}; "
            f"there are: {', '.join(PRESETS)}"
        )
    return PRESETS[name]
