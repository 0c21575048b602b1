"""Damaged files: what once broke a reader, the first inputs of each format, and heavy ones."""

import re
from pathlib import Path

import pytest

from benchmarks.fuzz.heavy import HEAVY, heavy_input
from benchmarks.fuzz.judging import Verdict, judge
from benchmarks.fuzz.target import FOLDER, Input, files_in
from benchmarks.fuzz.targets import TARGETS
from multisrt.environments.formats import FORMATS, read_environment

INPUTS = 50
MORE = dict.fromkeys(("run_spec", "experiment", "failure", "strategy"), 200)
MAX_SEED_BYTES = 9000
BINARY = ("dxf", "image", "numpy_array", "experiment_store", "campaign_store")
TEXTS = [name for name in TARGETS if name not in BINARY]
WORD = re.compile(rb"[A-Za-z]{2,}[\w.-]*|\d{2,}")
SEEDS = FOLDER / "seeds"
KEPT = [
    path
    for folder in sorted((FOLDER / "kept").iterdir())
    if folder.is_dir()
    for path in files_in(folder)
]


def prepared(name, folder):
    if name == "dxf":
        pytest.importorskip("ezdxf")
    target = TARGETS[name]
    target.prepare(folder)
    return target


def assert_right(outcome, what):
    assert outcome.verdict.is_right, f"{what}: {outcome.verdict.value}: {outcome.detail}"


@pytest.mark.parametrize("name", TARGETS)
def test_damaged_files_are_read_or_refused(name, tmp_path):
    target = prepared(name, tmp_path)
    read = 0
    inputs = MORE.get(name, INPUTS)
    for number in range(inputs):
        outcome = judge(target, target.input(0, number), tmp_path)
        assert_right(outcome, f"{name}, number {number}")
        read += outcome.verdict is Verdict.READ
    assert 0 < read < inputs


@pytest.mark.parametrize("path", KEPT, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_kept_inputs_are_read_or_refused(path, tmp_path):
    target = prepared(path.parent.name, tmp_path)
    for options in target.options:
        suffix, content = target.made(path)
        outcome = judge(target, Input(content, suffix, options), tmp_path)
        assert_right(outcome, f"{path.name}, {options}")


@pytest.mark.parametrize("name", TEXTS)
def test_long_words_and_numbers_are_not_cited_in_full(name, tmp_path):
    target = prepared(name, tmp_path)
    for suffix, content in target.seeds:
        for word in WORD.finditer(content):
            long = content[: word.start()] + word[0] * 300 + content[word.end() :]
            outcome = judge(target, Input(long, suffix, target.options[-1]), tmp_path)
            assert_right(outcome, f"{name}, {word[0]!r} at {word.start()}")


@pytest.mark.slow
@pytest.mark.parametrize("name", HEAVY)
def test_heavy_files_are_answered_in_seconds(name, tmp_path):
    form, one = heavy_input(name)
    assert_right(judge(prepared(form, tmp_path), one, tmp_path), name)


@pytest.mark.parametrize("name", TARGETS)
def test_seeds_are_small_and_can_be_read(name, tmp_path):
    target = prepared(name, tmp_path)
    assert all(path.stat().st_size <= MAX_SEED_BYTES for path in files_in(SEEDS / name))
    for suffix, content in target.seeds:
        verdicts = {
            judge(target, Input(content, suffix, options), tmp_path).verdict
            for options in target.options
        }
        assert Verdict.READ in verdicts, (name, suffix)


def test_every_format_has_seeds():
    named = {getattr(known.read, "__name__", "").removeprefix("read_") for known in FORMATS}
    assert named <= TARGETS.keys()
    assert all(target.seeds for target in TARGETS.values())


def test_an_image_outside_the_folder_of_its_map_is_not_read(tmp_path):
    # The kept file names an image that need not exist; this one does.
    folder = tmp_path / "maps"
    folder.mkdir()
    target = prepared("map_server", tmp_path)
    text = (SEEDS / "map_server" / "rooms.yaml").read_text()
    for image in ("../rooms.pgm", tmp_path / "rooms.pgm"):
        path = folder / "input.yaml"
        path.write_text(text.replace("rooms.pgm", str(image)))
        with pytest.raises(ValueError, match="not in the folder of the map"):
            target.read(path)
    path = Path(tmp_path) / "rooms.yaml"
    path.write_text(text)
    assert read_environment(path).area_m2 > 0
