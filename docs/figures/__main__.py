"""Draw the pictures of the documentation: ``python docs/figures``.

Those of the algorithms are drawn by the functions that they explain, all others by the commands
beside which they stand. With names (``python docs/figures minpos``) only those whose file names
contain one of them. Writes to `docs/pictures`, of which `docs/plan.py` draws the plan; the same
program draws the same bytes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import bidding
import gallery
import own
import papers
import runs
import teams
import trees
import worlds

PICTURES = Path(__file__).resolve().parents[1] / "pictures"
FIGURES: dict[str, dict[str, Callable[[], str]]] = {
    "": runs.FIGURES,
    "algorithms": {**trees.FIGURES, **teams.FIGURES, **bidding.FIGURES, **own.FIGURES},
    "gallery": {**gallery.FIGURES, **worlds.FIGURES},
    "figures": papers.FIGURES,
}


def main(wanted: list[str]) -> None:
    """Draw the pictures whose names contain a wanted word; all without any."""
    for folder, figures in FIGURES.items():
        (PICTURES / folder).mkdir(exist_ok=True)
        for name, draw in figures.items():
            if not wanted or any(word in name for word in wanted):
                (PICTURES / folder / f"{name}.svg").write_text(draw(), encoding="utf-8")
    for name, make in runs.PAGES.items():
        if not wanted or any(word in name for word in wanted):
            (PICTURES / f"{name}.html").write_text(make(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
