"""Smaller figures: the same shapes and texts as in those of matplotlib."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.axes import Axes

from multisrt.drawing.looks import MARKERS
from multisrt.drawing.svg import printable
from multisrt.reporting import style
from multisrt.reporting.compact import SVG, compact
from multisrt.reporting.style import drawn


@pytest.fixture
def both(monkeypatch) -> Callable[[Callable[[Axes], None]], tuple[bytes, bytes]]:
    """Return a figure as matplotlib writes it, and the smaller one."""

    def draw_both(draw: Callable[[Axes], None]) -> tuple[bytes, bytes]:
        seen: list[bytes] = []

        def kept(svg: bytes) -> bytes:
            seen.append(svg)
            return compact(svg)

        monkeypatch.setattr(style, "compact", kept)
        small = drawn("name", "Title & <more>", "alt", 2.5, draw).svg
        return seen[0], small

    return draw_both


def series(axes: Axes) -> None:
    x = np.linspace(0.0, 10.0, 200)
    axes.plot(x, np.sin(x), label='it\'s <a> "label" & more')
    for k, marker in enumerate(MARKERS):
        axes.plot(x[::20], np.cos(x[::20]) + k, marker, markeredgewidth=0.0, alpha=0.75)
    axes.fill_between(x, np.sin(x) - 0.2, np.sin(x) + 0.2, alpha=0.2, linewidth=0)
    axes.boxplot([[1.0, 2.0, 2.5, 7.0], [3.0, 3.0, 3.0]], positions=[3.0, 5.0], manage_ticks=False)
    axes.legend()
    axes.set_ylabel("two\nlines")


def texts(svg: bytes) -> list[str]:
    found = [printable("".join(e.itertext())) for e in ET.fromstring(svg).iter(f"{SVG}text")]
    return sorted(found)


def test_texts_stay_and_bytes_go(both):
    large, small = both(series)
    assert texts(small) == texts(large)
    assert ET.fromstring(small).findtext(f"{SVG}title") == "Title & <more>"
    assert len(small) < 0.35 * len(large)
    assert b'"' not in re.sub(rb">[^<]*<", b"><", small)


def test_a_run_costs_a_few_bytes(both):
    def dots(count: int) -> Callable[[Axes], None]:
        values = np.random.default_rng(0).uniform(0.0, 100.0, (2, count))

        def draw(axes: Axes) -> None:
            axes.plot(*values, "o", markersize=2.6, markeredgewidth=0.0)

        return draw

    few, many = len(both(dots(100))[1]), len(both(dots(1100))[1])
    assert (many - few) / 1000 < 14.0


@pytest.mark.slow
def test_it_looks_the_same(both, browser):
    large, small = both(series)
    page = browser.new_page(viewport={"width": 620, "height": 380})
    shots = []
    for svg in (large, small):
        page.set_content(svg.decode(), wait_until="load")
        page.add_style_tag(content="body{margin:0}svg{width:600px;height:auto}")
        shots.append(pixels(page))
    page.close()
    difference = np.abs(shots[0] - shots[1]).max(axis=2)
    # Edges move by less than a pixel.
    assert (difference > 100).mean() < 0.002
    assert difference.mean() < 2.0
    assert (np.ptp(shots[0], axis=(0, 1)) > 100).all()


def pixels(page) -> np.ndarray:
    import io

    from matplotlib.image import imread

    shot = imread(io.BytesIO(page.screenshot()), format="png")
    return 255.0 * np.asarray(shot, np.float64)[:, :, :3]
