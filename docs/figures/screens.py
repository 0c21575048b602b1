"""Take the pictures of the replay: ``python docs/figures/screens.py``.

They are those of a browser (Chromium, with `playwright` of the extra ``test``), which differ by its
version and fonts: no test compares them.
"""

from __future__ import annotations

import io
import shutil
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, sync_playwright

import multisrt as ms
from multisrt.replay import save_replay

PICTURES = Path(__file__).resolve().parents[1] / "pictures"
TEAM: dict[str, Any] = {"robots": 4, "starts": "clustered", "radio_range_m": 15.0, "seed": 1}
COLOURS = 256
ROUNDS = 2
"""Improvements of the palette, which keep the colours of small areas, such as those of robots."""

WIDE = {"viewport": {"width": 1200, "height": 820}}
PHONE = {
    "viewport": {"width": 390, "height": 780},
    "color_scheme": "dark",
    "is_mobile": True,
    "has_touch": True,
}


def main() -> None:
    """Make the runs, and take all pictures."""
    trees = ms.explore("museum", **TEAM).recording
    bids = ms.explore("museum", strategy="minpos", **TEAM).recording
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        one, two = Path(folder) / "one.html", Path(folder) / "two.html"
        save_replay(trees, one)
        save_replay([trees, bids], two)
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        _take(browser, one, "#t=420&robot=2", "replay", **WIDE)
        _take(browser, two, "#t=60&speed=10", "replay-two", **WIDE)
        _take(browser, one, "#t=250", "replay-phone", **PHONE)
        browser.close()


def _take(browser: Browser, page: Path, address: str, name: str, **options: Any) -> None:
    context = browser.new_context(**options)
    opened = context.new_page()
    opened.goto(page.as_uri() + address)
    opened.wait_for_timeout(2000)
    picture = Image.open(io.BytesIO(opened.screenshot()))
    few = picture.convert("RGB").quantize(COLOURS, kmeans=ROUNDS, dither=Image.Dither.NONE)
    few.save(PICTURES / f"{name}.png", optimize=True)
    context.close()


if __name__ == "__main__":
    main()
