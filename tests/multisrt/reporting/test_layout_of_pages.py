"""Reports in a browser: on a phone and on a desk, with links that lead somewhere."""

import re
from pathlib import Path

import pytest

import multisrt as ms
from multisrt.reporting.page import write_report
from multisrt.reporting.run_rows import MAX_RUNS
from multisrt.spec import RunSpec
from tests.multisrt.reporting.test_page import Page, made_up

WIDE = """() => [...document.body.querySelectorAll('*')].filter((one) => {
  const around = one.closest('.scroll');
  if (around && around !== one) return false;
  const { left, right } = one.getBoundingClientRect();
  return left < -1 || right > innerWidth + 1;
}).map((one) => one.outerHTML.slice(0, 80))"""

OPEN_ALL = "document.querySelectorAll('details').forEach((part) => (part.open = true))"

CUES = """() => [...document.querySelectorAll('.scroll')].map((part) => ({
  hidden: part.scrollWidth - part.clientWidth,
  cue: getComputedStyle(part).getPropertyValue('--right').trim() !== '0rem',
  focusable: part.tabIndex === 0 || part.querySelector('a') !== null,
}))"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """The folder of a report with long names, a gallery, replays and runs that failed."""
    compared = ms.compare(
        "open",
        ["srt-radial", "minpos"],
        [2, 3],
        2,
        starts=["scattered", "clustered"],
        stop=ms.spec.StopRule(max_time_s=40.0),
        workers=0,
        progress=False,
    )
    out = tmp_path_factory.mktemp("pages") / "report"
    compared.report(out, measures=["coverage"])
    return out


def shown(browser, folder: Path, width: int, scheme: str = "light"):
    page = browser.new_page(viewport={"width": width, "height": 800}, color_scheme=scheme)
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto((folder / "index.html").as_uri())
    page.evaluate(OPEN_ALL)
    page.wait_for_timeout(200)
    assert errors == []
    return page


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1300, 1920])
def test_nothing_is_wider_than_the_window(browser, folder, width):
    page = shown(browser, folder, width)
    assert page.evaluate("document.documentElement.scrollWidth") == width
    assert page.evaluate(WIDE) == []
    if width > 1000:
        used = page.evaluate("document.querySelector('#gallery .grid').clientWidth")
        assert used > 0.9 * width
    page.close()


@pytest.mark.slow
def test_what_scrolls_says_so_until_its_end(browser, folder):
    page = shown(browser, folder, 390)
    cues = page.evaluate(CUES)
    assert any(each["hidden"] > 1 for each in cues)
    for each in cues:
        assert each["cue"] == (each["hidden"] > 1)
        assert each["focusable"] or each["hidden"] <= 1
    page.evaluate("document.querySelectorAll('.scroll').forEach((p) => (p.scrollLeft = 99999))")
    page.wait_for_timeout(200)
    assert not any(each["cue"] for each in page.evaluate(CUES))
    # The label of a row stays, with a shadow.
    label = "document.querySelector('#overview tbody th')"
    assert page.evaluate(f"{label}.getBoundingClientRect().left") >= 0
    assert page.evaluate(f"getComputedStyle({label}).boxShadow") != "none"
    page.close()


@pytest.mark.slow
def test_dark_pages_are_dark_and_readable(browser, folder):
    page = shown(browser, folder, 390, "dark")
    ground, ink = page.evaluate(
        "[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]"
    )
    dark, light = (sum(map(int, re.findall(r"\d+", colour)[:3])) for colour in (ground, ink))
    assert dark < 150 < 600 < light
    page.close()


@pytest.mark.slow
def test_a_button_copies_the_command_of_a_run(browser, folder):
    page = shown(browser, folder, 1300)
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    button = page.locator(".runs button").first
    command = button.get_attribute("title")
    assert re.fullmatch(
        r"multisrt explore --spec specs/[0-9a-f]{12}\.toml --view --out again", command
    )
    button.click()
    page.wait_for_timeout(200)
    assert button.text_content() in ("copied", command)
    page.close()


@pytest.mark.slow
def test_rows_and_pictures_lead_to_replays_and_specs(folder):
    page = Page((folder / "index.html").read_text())
    links = [link["href"] for link in page.all("a") if not link["href"].startswith("#")]
    assert links
    assert all((folder / link).is_file() for link in links)
    replays = {path.name for path in (folder / "replays").iterdir()}
    assert len(replays) == len(list((folder / "gallery").iterdir())) > 0
    # One link at the picture, one in its caption, one in the list of runs.
    for name in replays:
        assert links.count(f"replays/{name}") == 3
        assert "<script" in (folder / "replays" / name).read_text()
    specs = list((folder / "specs").iterdir())
    # Runs that are the same for every seed are listed once.
    rows = sum(head.get("scope") == "row" and "data-sort" not in head for head in page.all("th"))
    assert 8 < len(specs) == sum(link.startswith("specs/") for link in links) <= min(16, rows)
    text = specs[0].read_text()
    assert RunSpec.from_toml(text).to_toml() == text
    total_mb = sum(path.stat().st_size for path in (folder / "replays").iterdir()) / 1e6
    assert f"Replays are pages of their own ({total_mb:.1f} MB together)" in page.text


@pytest.mark.slow
def test_without_replays_pictures_lead_to_their_svg(monkeypatch, tmp_path):
    compared = ms.compare("open", "minpos", 2, 1, workers=0, progress=False)
    page = Page(compared.report(tmp_path / "r", replays=False, measures=["coverage"]).read_text())
    assert not (tmp_path / "r" / "replays").exists()
    links = [link["href"] for link in page.all("a")]
    assert sum(link.startswith("gallery/") for link in links) == 2
    assert "Replays" not in page.text


@pytest.mark.slow
def test_a_run_costs_less_than_1400_bytes(tmp_path, monkeypatch):
    sizes = []
    for count in (5, 45):
        results = made_up(("a", "b"), (1, 2, 4, 8), count)
        page = write_report(results, tmp_path / f"{count}", measures=["time_to_95_s"])
        sizes.append(len(page.read_bytes()))
    assert (sizes[1] - sizes[0]) / (8 * 40) < 300.0
    assert sizes[1] / (8 * 45) < 1400.0


def test_runs_are_listed_up_to_a_limit(tmp_path, monkeypatch):
    monkeypatch.setattr("multisrt.reporting.run_rows.MAX_RUNS", 10)
    monkeypatch.setattr("multisrt.reporting.figures.box_plots", lambda *_: [])
    results = made_up(("a", "b"), (1,), 8)
    page = Page(write_report(results, tmp_path / "r", measures=["coverage"]).read_text())
    assert "6 more runs are not listed" in page.text
    assert sum(row.get("scope") == "rowgroup" for row in page.all("th")) == 2
    assert MAX_RUNS > 1400
