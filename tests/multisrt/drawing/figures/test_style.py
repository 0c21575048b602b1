"""Sizes, fonts and bytes of figures."""

import re

import matplotlib as mpl
import pytest

from multisrt.drawing.figures import (
    KINDS,
    STYLES,
    FigureOptions,
    draw_figure,
    figure_bytes,
    figure_style,
    save_figure,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording

WIDTHS_IN = {
    "ieee": 3.5,
    "ieee-wide": 7.16,
    "springer": 84 / 25.4,
    "springer-wide": 174 / 25.4,
    "screen": 6.4,
}


def test_styles_are_as_wide_as_columns():
    assert {name: style.width_in for name, style in STYLES.items()} == pytest.approx(WIDTHS_IN)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "maps"])
def test_every_kind_is_as_wide_as_its_style(kind, growers):
    figure = draw_figure(kind, growers, style="springer-wide")
    assert figure.get_figwidth() == pytest.approx(WIDTHS_IN["springer-wide"])
    assert figure.get_figheight() <= STYLES["springer-wide"].max_height_in + 1e-9
    svg = figure_bytes(kind, growers, "svg", style="ieee").decode()
    points = re.search(r'<svg[^>]* width="([\d.]+)pt"', svg)
    assert points is not None
    assert float(points[1]) / 72.0 == pytest.approx(WIDTHS_IN["ieee"], abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["map", "trajectories", "visits"])
def test_maps_fill_the_width(kind, growers):
    figure = draw_figure(kind, growers, style="ieee")
    ax = figure.axes[0]
    box = ax.get_window_extent()
    assert box.width > 0.93 * figure.bbox.width
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    assert box.height / box.width == pytest.approx((y1 - y0) / (x1 - x0), rel=0.01)


@pytest.mark.slow
def test_everything_is_within_the_figure(growers, curves):
    for kind in KINDS:
        runs = curves if kind == "coverage" else growers
        options = FigureOptions(times_s=(10.0, 100.0)) if kind == "maps" else None
        figure = draw_figure(kind, runs, style="springer", options=options)
        tight = figure.get_tightbbox()
        width, height = figure.get_size_inches()
        assert tight.x0 > -0.01, kind
        assert tight.y0 > -0.01, kind
        assert tight.x1 < width + 0.01, kind
        assert tight.y1 < height + 0.01, kind


@pytest.mark.slow
def test_fonts_are_embedded_and_of_one_typeface(growers):
    for style, font in (("ieee", b"STIXGeneral"), ("springer", b"DejaVuSans")):
        pdf = figure_bytes("activity", growers, "pdf", style=style)
        fonts = set(re.findall(rb"/BaseFont /(?:[A-Z]{6}\+)?(\w+)", pdf))
        assert fonts == {font}
        assert b"/FontFile2" in pdf
        assert b"/Type3" not in pdf
        assert b"CreationDate" not in pdf
    assert b"<text" not in figure_bytes("activity", growers, "svg", style="ieee")
    assert b"<text" in figure_bytes("activity", growers, "svg", style="screen")


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["map", "activity", "visits"])
def test_equal_recordings_give_equal_bytes(kind, bidders, tmp_path):
    bidders.save(tmp_path / "recording.jsonl")
    again = Recording.load(tmp_path / "recording.jsonl")
    for file_format in ("svg", "pdf") if kind == "activity" else ("svg",):
        one = figure_bytes(kind, bidders, file_format, style="ieee")
        assert figure_bytes(kind, again, file_format, style="ieee") == one
        assert b"dc:date" not in one
    if kind == "activity":
        for number in range(2):
            save_figure(kind, again, tmp_path / f"{number}.png", style="ieee")
        assert (tmp_path / "0.png").read_bytes() == (tmp_path / "1.png").read_bytes()


@pytest.mark.slow
def test_settings_of_the_user_are_neither_used_nor_changed(curves):
    expected = figure_bytes("coverage", curves)
    with mpl.rc_context({"font.size": 30.0, "lines.linewidth": 9.0, "axes.grid": False}):
        before = dict(mpl.rcParams)
        assert figure_bytes("coverage", curves) == expected
        assert dict(mpl.rcParams) == before


def test_styles_are_for_figures_of_ones_own_too():
    before = mpl.rcParams["font.family"]
    with figure_style("ieee") as style:
        assert mpl.rcParams["font.family"] == ["STIXGeneral"]
        assert mpl.rcParams["pdf.fonttype"] == 42
        assert style.width_in == 3.5
    assert mpl.rcParams["font.family"] == before


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"kind": "tracks"}, "there is no kind of figures 'tracks'; the kinds are map,"),
        ({"kind": "trajectory"}, "(did you mean 'trajectories'?)"),
        ({"style": "springe"}, "there is no style 'springe' of figures (did you mean 'springer'?)"),
        ({"kind": "maps", "twice": True}, "a figure of kind maps shows one run, not 2"),
        ({"kind": "map", "options": {"robots": (0,)}}, "does not depend on robots; these do: maps"),
        ({"kind": "maps", "options": {"times_s": (1e6,)}}, "1e+06 s is not within the run"),
        (
            {"kind": "activity", "options": {"robots": (3,)}},
            "there is no robot 3: the team has 3 robots",
        ),
        ({"kind": "map", "options": {"without": ("node",)}}, "no layer 'node' (did you mean"),
    ],
)
def test_what_cannot_be_drawn_is_refused(given, message, growers):
    runs = [growers] * (2 if given.get("twice") else 1)
    options = FigureOptions(**given.get("options", {}))
    with pytest.raises(InvalidInputError, match=re.escape(message)):
        draw_figure(
            given.get("kind", "map"), runs, style=given.get("style", "screen"), options=options
        )


@pytest.mark.slow
def test_runs_of_different_worlds_are_refused(growers, curves):
    with pytest.raises(InvalidInputError, match="runs of one world, and these are of 'apartment'"):
        draw_figure("coverage", [growers, curves[0]])
    draw_figure("decisions", [growers, curves[0]])


def test_nothing_is_written_if_a_figure_cannot_be(growers, tmp_path):
    with pytest.raises(InvalidInputError, match=r"written as \.pdf, \.svg or \.png"):
        save_figure("map", growers, tmp_path / "map.jpg")
    with pytest.raises(InvalidInputError, match="nowhere"):
        save_figure("activity", growers, tmp_path / "nowhere" / "map.pdf")
    assert list(tmp_path.iterdir()) == []
