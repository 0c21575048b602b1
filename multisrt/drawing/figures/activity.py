"""What each robot was doing in the course of a run, as strips."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from multisrt.analysis.activity import ACTIVITIES, Activity, Spell, activities
from multisrt.analysis.isolation import isolation
from multisrt.drawing.colours import INK, VERMILION, WHITE
from multisrt.drawing.figures.style import FigureStyle, freeze, legend_below, new_figure
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

EDGE: Final = "#9a9a9a"
"""Colour of the outlines and hatches of light fills."""

STRIP_IN: Final = 0.2
"""Height of the strip of a robot, in inches."""


STRIP: Final = (-0.38, 0.76)
"""Top of a strip, from the middle of its row, and its height."""

CUT_OFF: Final = (0.22, 0.16)
"""The same of the bar that shows when the robot was cut off, over the lower edge of the strip."""


class Fill(NamedTuple):
    """How an activity is filled: colours differ in lightness or hatching."""

    colour: str
    hatch: str = ""


FILLS: Final[dict[Activity, Fill]] = {
    "waits": Fill("#e4e4e4"),
    "coordinates": Fill("#e69f00"),
    "moves": Fill("#0072b2"),
    "supports": Fill("#56b4e9", "////"),
    "cut off": Fill(VERMILION),
    "done": Fill(WHITE),
    "dead": Fill(INK),
    "not started": Fill(WHITE, "...."),
}


def draw_activity(recording: Recording, ax: Axes, robots: Sequence[int] | None = None) -> list[Any]:
    """Draw a strip for each robot, filled by what it was doing, and when it was cut off.

    What robots do is what `activities` tells of them without isolation; a bar over the lower edge
    of a strip is drawn while its robot is isolated, see `multisrt.isolation`.

    Parameters
    ----------
    recording : Recording
        The run.
    ax : Axes
        Where to draw: time in seconds, and robots from the top.
    robots : sequence of int, optional
        The robots; by default all.

    Returns
    -------
    list of Patch
        Entries of a legend, for activities that occur.
    """
    from matplotlib.patches import Patch

    found = activities(recording, with_isolation=False)
    cut_off = isolation(recording)
    rows = list(range(len(found)) if robots is None else robots)
    there = set()
    for row, robot in enumerate(rows):
        spells = [*found[robot], *(Spell(*own, "cut off") for own in cut_off[robot].spells)]
        # Bars last, as they lie over the strips.
        for activity in sorted(FILLS, key=lambda name: name == "cut off"):
            spans = [(s.start_s, s.end_s - s.start_s) for s in spells if s.activity == activity]
            if spans:
                there.add(activity)
                top, height = CUT_OFF if activity == "cut off" else STRIP
                ax.broken_barh(
                    spans,
                    (row + top, height),
                    **_look(FILLS[activity]),
                    gid=f"robot {robot} {activity}",
                )
    ax.set_yticks(range(len(rows)), [str(robot) for robot in rows])
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.set_xlim(0.0, max(recording.footer.time_s, 1e-9))
    ax.grid(False, axis="y")
    ax.tick_params(axis="y", length=0)
    return [Patch(label=name, **_look(FILLS[name])) for name in ACTIVITIES if name in there]


def activity_figure(
    recording: Recording, style: FigureStyle, robots: Sequence[int] | None = None
) -> Figure:
    """Return a figure with the activities of the robots of a run; see `draw_activity`."""
    figure, (ax,) = new_figure(style)
    handles = draw_activity(recording, ax, robots)
    rows = len(ax.get_yticks())
    figure.set_size_inches(style.width_in, min(style.max_height_in, 1.0 + STRIP_IN * rows))
    ax.set_xlabel("time (s)")
    ax.set_ylabel("robot")
    legend_below(figure, handles, style)
    freeze(figure)
    return figure


def _look(fill: Fill) -> dict[str, Any]:
    return {
        "facecolor": fill.colour,
        "edgecolor": EDGE if fill.colour in (WHITE, FILLS["waits"].colour) else WHITE,
        "hatch": fill.hatch or None,
        "linewidth": 0.25,
    }
