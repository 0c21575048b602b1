"""How things look in an animation, in SVG and in frames alike."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from multisrt.drawing.animation.scene import Actor, Scene
from multisrt.drawing.colours import INK, LATE_START, VERMILION, WHITE, RobotStyles, Style, tint
from multisrt.drawing.sheet import shortened
from multisrt.drawing.svg import text_width

PROGRESS: Final = "#5c5c5c"
TRACK: Final = "#e2e2e2"
"""Colours of the bar of progress, done and to do."""

HALO_MM: Final = 1.1
HEADING_MM: Final = 0.5
DARK: Final = 0.3
"""On bodies of a lower relative luminance the heading is white."""

CUT_OFF_RING: Final = Style(stroke=VERMILION, width_mm=0.5, dashes_mm=(1.2, 0.8))
RING: Final = 1.6
"""Radius of the ring around a robot that is cut off, in radii of its body."""

GOAL_MM: Final = 1.1
LABEL_AWAY: Final = 1.0
"""Distance of a robot's number beyond its body, in halves of the text size."""

MAX_LABELS: Final = 16
"""Largest team whose robots are numbered on the map."""

BAR_PX: Final = 4.0
"""Height of the bar of progress, in a picture of the default width."""

MAX_BAR_SHARE: Final = 0.68
MIN_BAR_SHARE: Final = 0.1
"""Bounds of the width of the bar of progress, as shares of that of the map."""

TITLE_GAP: Final = 1.0
"""Distance of the title from the text beside it, in sizes of its letters."""

MIN_TITLE_SHARE: Final = 0.5
"""Share of the width of the map that the title needs for the speed to stand beside it."""


@lru_cache(maxsize=128)
def styles_of(robot: int) -> RobotStyles:
    """Return the styles of a robot; see `RobotStyles.of`."""
    return RobotStyles.of(robot)


def path_style(robot: int, actor: Actor) -> Style:
    """Return the style of the path of a robot: thin beneath a tree, else bold."""
    if actor.has_tree:
        return Style(stroke=_colour(robot), stroke_opacity=0.55, width_mm=0.2)
    return Style(stroke=_colour(robot), width_mm=0.4)


def goal_style(robot: int) -> Style:
    """Return the style of the goal of a robot."""
    return Style(fill=WHITE, stroke=_colour(robot), width_mm=0.45)


def body_fill(robot: int, activity: str) -> str:
    """Return the colour of a body by what the robot does."""
    if activity == "dead":
        return INK
    if activity == "not started":
        return str(LATE_START.fill)
    return tint(_colour(robot), 0.45) if activity == "done" else _colour(robot)


def heading_colour(fill: str) -> str:
    """Return the colour of the heading on a body, which stands out from that of the body."""
    red, green, blue = (int(fill[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return WHITE if 0.30 * red + 0.59 * green + 0.11 * blue < DARK else INK


def area_fill(robot: int) -> str:
    """Return the colour of the area that a robot saw first."""
    return str(styles_of(robot).area.fill)


def _colour(robot: int) -> str:
    return str(styles_of(robot).end.fill)


def is_numbered(scene: Scene) -> bool:
    """Return whether bodies have the numbers of their robots beside them."""
    return scene.team and len(scene.actors) <= MAX_LABELS


def title_texts(scene: Scene) -> tuple[str, str]:
    """Return the title, and how fast the animation is, as they fit beside each other.

    Returns
    -------
    (str, str)
        The title, without details for which there is no room; an ellipsis may end it. The speed in
        words, empty where there is no room.
    """
    layout = scene.layout
    room = layout.map[2] - TITLE_GAP * layout.title_px
    speed = speed_text(scene)
    left = room - text_width(speed, layout.text_px)
    if left < MIN_TITLE_SHARE * room:
        speed, left = "", room
    title = shortened(scene.title)
    letters = int(left / text_width("n", layout.title_px))
    # Whole details are left out first, the last ones before others.
    while len(title) > letters and ", " in title:
        title = title.rpartition(", ")[0]
    return title if len(title) <= letters else f"{title[: max(1, letters - 1)]}…", speed


def speed_text(scene: Scene) -> str:
    """Return how fast the animation is, in words."""
    speed = scene.pace.speed
    return f"{speed:.0f} times as fast" if speed >= 9.95 else f"{speed:.2g} times as fast"


def bar_width(scene: Scene) -> float:
    """Return the width of the bar of progress beside the longest caption, in pixels; 0 for none."""
    layout = scene.layout
    longest = max((text_width(span.shown, layout.text_px) for span in scene.captions), default=0.0)
    left = min(MAX_BAR_SHARE * layout.map[2], layout.map[2] - longest - layout.text_px)
    return left if left >= MIN_BAR_SHARE * layout.map[2] else 0.0


def label_place(outer: float, size: float) -> float:
    """Return how far up and to the right of a body its number is."""
    return 0.7 * outer + 0.5 * LABEL_AWAY * size


def entry_text(robot: int, activity: str) -> str:
    """Return what the list of robots says of one."""
    return f"{robot}: {activity}"
