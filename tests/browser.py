"""Chromium for tests of pages: the fixture `browser` of tests/conftest.py.

Without a browser such tests are skipped, with `MULTISRT_BROWSER=required` they fail.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
"""Software rendering, and nothing that asks for a network."""


def chromium() -> str | None:
    """Return the path of Chromium or Chrome; None if there is none."""
    found = (shutil.which(name) for name in NAMES)
    return next((path for path in found if path), None)


@contextmanager
def launched() -> Iterator["Browser"]:
    """Launch Chromium; skip or fail the test that needs it if there is none."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _do_without("playwright is not installed (pip install 'multisrt[test]')")
    with sync_playwright() as playwright:
        path = chromium()
        if path is None and not Path(playwright.chromium.executable_path).exists():
            _do_without(f"no browser is installed: none of {', '.join(NAMES)} is on the PATH")
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


def _do_without(why: str) -> None:
    if os.environ.get("MULTISRT_BROWSER") == "required":
        pytest.fail(f"MULTISRT_BROWSER=required, but {why}")
    pytest.skip(why)
