"""What pictures of runs and worlds have in common with the reader of SVG, which reads them back."""

import math
import re
from typing import Final

START_SYMBOLS: Final = {
    # A disc with a tip in the direction of the heading, for robots of a team.
    "pin": (
        *((math.cos(a), math.sin(a)) for a in (math.pi / 16 * n for n in range(3, 30))),
        (1.6, 0.0),
    ),
    # For a single robot.
    "arrow": ((1.3, 0.0), (-0.9, 0.9), (-0.4, 0.0), (-0.9, -0.9)),
}
"""Corners of the symbols of starts with a heading, of size 1 around the place of the start."""

TO_START: Final = "data-to-start"
"""Attribute of a symbol that stands beside its start: the vector ``dx dy`` from there to it."""

LINES_TO_STARTS: Final = "lines to starts"
"""Label of the layer with lines from starts to symbols that stand beside them."""

_OWN_LAYER: Final = re.compile(
    r"robot \d+: .+|known|known to the base|base|frontier left|separate part|out of reach of .+"
    r"|narrow passage|passage that is too narrow|widths"
)


def is_own_layer(label: str) -> bool:
    """Return whether a layer of a picture of a run or a check shows something else than space.

    Parameters
    ----------
    label : str
        Its label.

    Examples
    --------
    >>> is_own_layer("robot 0: seen first"), is_own_layer("furniture")
    (True, False)
    """
    return _OWN_LAYER.fullmatch(label) is not None
