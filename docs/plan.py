"""Draw the plan of the code from its own imports: ``python docs/plan.py`` (or ``make plan``).

Every folder and every single module directly in the package is a room. A room stands one floor
above the highest room that it imports. Writes `docs/pictures/plan.svg`; exits with 1 if rooms
import each other in a cycle.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path

import grimp

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "pictures" / "plan.svg"
PACKAGE = "multisrt"

WIDTH, MARGIN = 960, 24
ROOM_HEIGHT, FLOOR_HEIGHT = 46, 92
MIN_GAP = 14

Arrows = dict[str, set[str]]

STYLE = """
  svg { background: #fff; font-family: system-ui, sans-serif; }
  rect { fill: #eef3f8; stroke: #33587a; }
  rect.robots { fill: #fdf1dc; stroke: #a36a00; }
  rect.truth { fill: #f6e3e3; stroke: #a03a3a; }
  text { fill: #14212c; text-anchor: middle; }
  .name { font-size: 14px; font-weight: 600; }
  .lines { font-size: 11px; fill: #52616d; }
  .key { font-size: 12px; text-anchor: start; }
  path { fill: none; stroke: #33587a; stroke-width: 1.3; }
  path.indirect { stroke: #b9c7d3; stroke-width: 0.8; }
  marker path { fill: #33587a; stroke: none; }
"""


class CircularImportsError(Exception):
    """Rooms import each other in a cycle."""


def main() -> None:
    """Draw the plan, and print its floors."""
    lines, arrows = read_rooms()
    try:
        floors = floors_of(arrows)
    except CircularImportsError as error:
        sys.exit(str(error))
    PICTURE.write_text(draw(floors, lines, arrows), encoding="utf-8")
    for number, rooms in reversed(list(enumerate(floors, start=1))):
        print(f"layer {number:2}: " + ", ".join(f"{room} ({lines[room]})" for room in rooms))
    count = sum(map(len, arrows.values()))
    print(f"{len(arrows)} packages and modules, {count} arrows, in {PICTURE.relative_to(ROOT)}")


def read_rooms() -> tuple[dict[str, int], Arrows]:
    """Return the lines of code in each room, and for each room those that it imports."""
    graph = grimp.build_graph(PACKAGE)
    rooms = {child.rpartition(".")[2] for child in graph.find_children(PACKAGE)}
    lines = {room: _lines_of(room) for room in rooms}
    arrows: Arrows = {room: set() for room in rooms}
    for module in graph.modules - {PACKAGE}:
        for imported in graph.find_modules_directly_imported_by(module) - {PACKAGE}:
            room, other = module.split(".")[1], imported.split(".")[1]
            if room != other:
                arrows[room].add(other)
    return lines, arrows


def floors_of(arrows: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """Return the packages of each floor, from the ground up.

    Raises
    ------
    CircularImportsError
        If some rooms import each other in a cycle; the message names them.
    """
    floor: dict[str, int] = {}
    left = set(arrows)
    while left:
        ready = {room for room in left if all(other in floor for other in arrows[room])}
        if not ready:
            raise CircularImportsError(f"import cycle among: {', '.join(sorted(left))}")
        for room in ready:
            floor[room] = 1 + max((floor[other] for other in arrows[room]), default=-1)
        left -= ready
    height = max(floor.values(), default=-1) + 1
    return [sorted(room for room in floor if floor[room] == level) for level in range(height)]


def behind(room: str, arrows: Arrows) -> set[str]:
    """Return the rooms that a room imports, directly or not."""
    return set(arrows[room]).union(*(behind(other, arrows) for other in arrows[room]))


def direct_arrows(arrows: Arrows) -> Arrows:
    """Return the arrows that no longer way over other arrows replaces."""
    below = {room: behind(room, arrows) for room in arrows}
    return {
        room: {o for o in to if not any(o in below[b] for b in to)} for room, to in arrows.items()
    }


def kinds_of(arrows: Arrows) -> dict[str, str]:
    """Return for each room ``"robots"``, ``"truth"`` or ``""``: what it has to do with robots.

    What the robots import runs on a robot; what else the simulation imports is the truth.
    """
    robots = {"robots", *behind("robots", arrows)}
    simulation = {"simulation", *behind("simulation", arrows)}
    return {
        room: "robots" if room in robots else "truth" if room in simulation else ""
        for room in arrows
    }


def draw(floors: list[list[str]], lines: Mapping[str, int], arrows: Arrows) -> str:
    """Return the plan as SVG, the highest floor at its top."""
    boxes = _boxes(_ordered(floors, arrows), lines)
    height = len(floors) * FLOOR_HEIGHT + 2 * MARGIN + 20
    direct = direct_arrows(arrows)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img">',
        "<title>Imports between the packages of multisrt</title>",
        f"<style>{STYLE}</style>",
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0 0 8 4 0 8z"/></marker></defs>',
    ]
    for kind in ("indirect", "direct"):
        for room in sorted(arrows):
            for other in sorted(arrows[room]):
                if (other in direct[room]) == (kind == "direct"):
                    parts.append(_arrow(boxes[room], boxes[other], kind))
    kinds = kinds_of(arrows)
    parts += [_room(room, box, lines[room], kinds[room]) for room, box in sorted(boxes.items())]
    parts += _key(height)
    return "\n".join([*parts, "</svg>\n"])


Box = tuple[float, float, float]
"""Left edge, top edge and width of a room."""


def _ordered(floors: list[list[str]], arrows: Arrows) -> list[list[str]]:
    # Rooms near those that they are tied to: the mean place of these, a few times down and up.
    tied: Arrows = {room: set(others) for room, others in direct_arrows(arrows).items()}
    for room, others in list(tied.items()):
        for other in others:
            tied[other].add(room)
    place = {room: k / (len(rooms) + 1) for rooms in floors for k, room in enumerate(rooms, 1)}
    for _ in range(8):
        for rooms in (*floors, *reversed(floors)):
            means = {
                room: sum(place[o] for o in tied[room]) / max(1, len(tied[room])) for room in rooms
            }
            rooms.sort(key=lambda room: (means[room], room))
            place.update({room: k / (len(rooms) + 1) for k, room in enumerate(rooms, 1)})
    return floors


def _boxes(floors: list[list[str]], lines: Mapping[str, int]) -> dict[str, Box]:
    boxes = {}
    for level, rooms in enumerate(reversed(floors)):
        widths = [max(78.0, 9.0 * len(room) + 16.0, lines[room] / 40.0) for room in rooms]
        gap = (WIDTH - 2 * MARGIN - sum(widths)) / (len(rooms) + 1)
        gap = max(MIN_GAP, gap)
        left = MARGIN + gap
        for room, width in zip(rooms, widths, strict=True):
            boxes[room] = (left, MARGIN + level * FLOOR_HEIGHT, width)
            left += width + gap
    return boxes


def _arrow(start: Box, end: Box, kind: str) -> str:
    x0, y0 = start[0] + start[2] / 2, start[1] + ROOM_HEIGHT
    x1, y1 = end[0] + end[2] / 2, end[1]
    bend = 0.4 * (y1 - y0)
    tip = ' marker-end="url(#tip)"' if kind == "direct" else ""
    path = f"M{x0:.0f} {y0:.0f}C{x0:.0f} {y0 + bend:.0f} {x1:.0f} {y1 - bend:.0f} {x1:.0f} {y1:.0f}"
    return f'<path class="{kind}" d="{path}"{tip}/>'


def _room(room: str, box: Box, lines: int, kind: str) -> str:
    left, top, width = box
    middle = left + width / 2
    return (
        f'<rect class="{kind}" x="{left:.0f}" y="{top}" width="{width:.0f}" '
        f'height="{ROOM_HEIGHT}" rx="6"/>'
        f'<text class="name" x="{middle:.0f}" y="{top + 20}">{escape(room)}</text>'
        f'<text class="lines" x="{middle:.0f}" y="{top + 36}">{lines} lines</text>'
    )


def _key(height: int) -> list[str]:
    y = height - MARGIN
    entries = (
        ("robots", "runs on a robot"),
        ("truth", "the truth, which robots do not have"),
        ("", "all else"),
    )
    parts, x = [], MARGIN
    for kind, text in entries:
        parts.append(f'<rect class="{kind}" x="{x}" y="{y - 11}" width="14" height="14" rx="3"/>')
        parts.append(f'<text class="key" x="{x + 20}" y="{y}">{text}</text>')
        x += 50 + 7 * len(text)
    parts.append(
        f'<text class="key" x="{x}" y="{y}">pale line: an import that a longer path implies</text>'
    )
    return parts


def _lines_of(room: str) -> int:
    place = (ROOT / PACKAGE / room).resolve()
    files = place.rglob("*.py") if place.is_dir() else [place.with_suffix(".py")]
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


if __name__ == "__main__":
    main()
