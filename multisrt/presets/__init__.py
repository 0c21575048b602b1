"""The experiments of the papers, their printed figures, and the judgement of their claims."""

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
"""All presets, by name."""


def preset_named(name: str) -> Preset:
    """Return the preset of a name.

    Parameters
    ----------
    name : str
        A key of `PRESETS`.

    Returns
    -------
    Preset
        The experiment of a paper.

    Raises
    ------
    InvalidInputError
        If there is no preset of the name; the message lists them.

    Examples
    --------
    >>> tuple(one.name for one in preset_named("minpos").experiment(True).strategies)
    ('closest', 'greedy', 'minpos')
    """
    if name not in PRESETS:
        raise InvalidInputError(
            f"there is no preset {name!r}{did_you_mean(name, PRESETS)}; "
            f"there are: {', '.join(PRESETS)}"
        )
    return PRESETS[name]
