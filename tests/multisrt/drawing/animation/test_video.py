"""MP4 and GIF, read again by ffmpeg."""

import re
import stat
import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from multisrt.drawing.animation import save_animation
from multisrt.drawing.animation.pace import HOLD_S, Pace
from multisrt.drawing.animation.painter import Painter
from multisrt.drawing.animation.scene import scene_of
from multisrt.drawing.animation.video import EncodingError, Film, save_gif, save_mp4
from multisrt.geometry.errors import InvalidInputError


def read(path):
    """Return what ffmpeg says of a film, and its pictures."""
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-fps_mode", "passthrough", "-"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-nostdin", "-i", str(path), *raw]
    done = subprocess.run(command, capture_output=True, check=True)
    text = done.stderr.decode()
    found = re.search(
        r"Duration: 00:00:(?P<duration>[\d.]+).*?Video: (?P<codec>\w+).*?, (?P<pixels>\w+)[(,]"
        r".*?, (?P<width>\d+)x(?P<height>\d+).*?, (?P<fps>[\d.]+) fps",
        text,
        re.DOTALL,
    )
    assert found, text
    about = found.groupdict()
    size = int(about["width"]), int(about["height"])
    pictures = np.frombuffer(done.stdout, np.uint8).reshape(-1, size[1], size[0], 3)
    return about | {"size": size}, pictures


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_films_have_the_pictures_the_size_and_the_duration(told, tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    heard = []
    save_animation(
        told, path, duration_s=2.0, fps=10.0, size=(321, 300),
        say=lambda done, of: heard.append((done, of)),
    )  # fmt: skip
    about, pictures = read(path)
    count = 20 + round(HOLD_S * 10) + 1
    assert len(pictures) == count
    assert heard == [(done, count) for done in range(1, count + 1)]
    # H.264 wants even sizes.
    assert about["size"] == ((322, 300) if suffix == ".mp4" else (321, 300))
    assert float(about["fps"]) == pytest.approx(10.0)
    assert float(about["duration"]) == pytest.approx(count / 10.0, abs=0.11)
    expected = ("h264", "yuv420p") if suffix == ".mp4" else ("gif", "bgra")
    assert (about["codec"], about["pixels"]) == expected
    # It moves, and then stays.
    moved = np.abs(pictures[0].astype(int) - pictures[20]).max()
    assert moved > 100
    assert np.abs(pictures[21].astype(int) - pictures[-1]).max() < 30
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


@pytest.mark.slow
def test_colours_of_a_gif_are_those_of_the_picture(told, tmp_path):
    save_animation(told, tmp_path / "film.gif", duration_s=1.0, size=400)
    _, pictures = read(tmp_path / "film.gif")
    pace = Pace.of(40.0, duration_s=1.0, speed=None, fps=10.0)
    true = Painter(scene_of(told, told.environment(), pace, width=400)).picture(5)
    assert np.abs(np.asarray(true, int) - pictures[5]).mean() < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_equal_runs_give_equal_bytes(told, tmp_path, suffix):
    one, two = tmp_path / f"one{suffix}", tmp_path / f"two{suffix}"
    for path in (one, two):
        save_animation(told, path, duration_s=1.0, fps=10.0, size=300)
    assert one.read_bytes() == two.read_bytes()


def film(count: int = 40) -> Film:
    return Film((64, 48), 10.0, count, lambda: lambda _: Image.new("RGB", (64, 48)))


@pytest.fixture
def program(tmp_path, monkeypatch):
    """Use a program in place of ffmpeg."""

    def written(code: str) -> None:
        path = tmp_path / "program"
        path.write_text(f"#!{sys.executable}\n{code}\n")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(path))

    return written


@pytest.mark.parametrize("save", [save_mp4, save_gif])
@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import sys; sys.exit('first\\nno space is left  \\n\\n')", "failed: no space is left"),
        ("import sys; sys.stdin.read(10); sys.exit(3)", "failed: it said nothing"),
    ],
)
def test_a_failure_is_one_line_and_leaves_nothing(tmp_path, program, save, code, said):
    program(code)
    folder = tmp_path / "films"
    folder.mkdir()
    (folder / "film").write_text("what was there before")
    with pytest.raises(EncodingError, match=f"^ffmpeg {said}$"):
        save(film(4000), folder / "film", lambda _: None)
    assert [file.name for file in folder.iterdir()] == ["film"]
    assert (folder / "film").read_text() == "what was there before"


def test_an_error_in_a_picture_ends_the_program_and_leaves_nothing(tmp_path):
    def draw():
        def picture(number: int) -> Image.Image:
            if number == 3:
                raise InvalidInputError("no such picture")
            return Image.new("RGB", (64, 48))

        return picture

    with pytest.raises(InvalidInputError, match="no such picture"):
        save_mp4(Film((64, 48), 10.0, 9, draw), tmp_path / "film.mp4", lambda _: None)
    assert list(tmp_path.iterdir()) == []


def test_a_program_that_cannot_start_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(tmp_path))
    with pytest.raises(EncodingError, match=rf"cannot start ffmpeg \({tmp_path}\): "):
        save_mp4(film(), tmp_path / "film.mp4", lambda _: None)


def test_files_that_cannot_be_written_are_named(told, tmp_path):
    with pytest.raises(InvalidInputError, match=r"cannot write .*none/film.mp4: No such file"):
        save_mp4(film(), tmp_path / "none" / "film.mp4", lambda _: None)
    for name in ("film.webm", "film", "film.mp4.txt"):
        with pytest.raises(InvalidInputError, match=r"formats \.mp4, \.gif, \.svg; .*film"):
            save_animation(told, tmp_path / name)


def test_names_that_ffmpeg_could_read_otherwise_are_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("-y.mp4", "concat:a.mp4", "a%03d.mp4"):
        save_mp4(film(2), Path(name), lambda _: None)
    assert {file.name for file in tmp_path.iterdir()} == {"-y.mp4", "concat:a.mp4", "a%03d.mp4"}
