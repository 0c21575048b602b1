"""Films of pictures, by ffmpeg: MP4 and GIF."""

from __future__ import annotations

import math
import os
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import IO, TYPE_CHECKING, Final

from multisrt.extras import extra
from multisrt.geometry.errors import InvalidInputError, MultiSrtError

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_SAMPLES: Final = 24
"""Largest number of pictures from which the colours of a GIF are chosen."""

QUIET: Final = ("-hide_banner", "-loglevel", "error", "-nostdin", "-y")
EXACT: Final = ("-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact")
"""Options of ffmpeg that keep the time and its version out of files."""

H264: Final = ("-c:v", "libx264", "-preset", "medium", "-crf", "20", "-pix_fmt", "yuv420p")
"""What all browsers and slides play."""

THREADS: Final = ("-threads", "2")
"""Encoders divide their work by threads, so that the number is fixed."""


class EncodingError(MultiSrtError):
    """The encoder of films failed; the message holds what it said.

    Examples
    --------
    >>> issubclass(EncodingError, MultiSrtError)
    True
    """


class Film:
    """The pictures of a film, which can be drawn repeatedly.

    Parameters
    ----------
    size : (width, height)
        Size of the pictures.
    fps : float
        Pictures a second.
    count : int
        Number of pictures.
    draw : callable
        Starts a new sequence: returns a function from the number of a picture to the picture,
        which is called with increasing numbers.
    """

    def __init__(
        self,
        size: tuple[int, int],
        fps: float,
        count: int,
        draw: Callable[[], Callable[[int], Image]],
    ) -> None:
        self.size, self.fps, self.count, self.draw = size, fps, count, draw

    def pictures(self, numbers: Iterable[int]) -> Iterator[bytes]:
        """Yield pictures as rows of red, green and blue bytes."""
        picture = self.draw()
        for number in numbers:
            yield picture(number).tobytes()


def gif_fps(fps: float) -> float:
    """Return the nearest number of pictures a second that a GIF can have.

    Examples
    --------
    >>> gif_fps(10.0), round(gif_fps(30.0), 3)
    (10.0, 33.333)
    """
    return 100.0 / max(2, round(100.0 / fps))


def save_mp4(film: Film, path: Path, say: Callable[[int], None]) -> None:
    """Write a film as MP4 with H.264; see `save_gif`.

    Pictures of an odd size get a white row or column, as the format wants even sizes.
    """
    even = "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white"
    with _part_of(path) as part:
        options = ("-vf", even, *H264, *THREADS, "-movflags", "+faststart", *EXACT, "-f", "mp4")
        _encode(film, range(film.count), (), options, part, say)


def save_gif(film: Film, path: Path, say: Callable[[int], None]) -> None:
    """Write a film as GIF, with colours chosen from pictures of all of its parts.

    Parameters
    ----------
    film : Film
        The film.
    path : Path
        The file, which is replaced once the film is complete.
    say : callable
        Called with the number of pictures that are encoded.

    Raises
    ------
    MissingExtraError
        If there is no imageio-ffmpeg.
    EncodingError
        If ffmpeg fails.
    InvalidInputError
        If the file cannot be written.
    """
    samples = sorted({round(k * (film.count - 1) / (MAX_SAMPLES - 1)) for k in range(MAX_SAMPLES)})
    with _part_of(path) as part, TemporaryDirectory() as folder:
        colours = Path(folder) / "colours.png"
        choose = ("-vf", "palettegen=reserve_transparent=0:stats_mode=full", *EXACT, "-f", "image2")
        _encode(film, samples, (), (*choose, "-update", "1"), colours, lambda _: None)
        # A GIF counts hundredths of a second.
        use = ("-lavfi", "paletteuse=dither=none:diff_mode=rectangle", "-loop", "0")
        inputs = ("-i", str(colours))
        options = (*use, "-threads", "1", *EXACT, "-f", "gif")
        _encode(film, range(film.count), inputs, options, part, say)


@contextmanager
def _part_of(path: Path) -> Iterator[Path]:
    # The name of an unfinished file, which gets its own name at the end.
    if not path.name:
        raise InvalidInputError(f"cannot write {path}: it is a folder; name a file")
    part = path.with_name(f"{path.name}.part")
    try:
        part.open("wb").close()
        yield part
        os.replace(part, path)
    except BaseException as error:
        with suppress(OSError):
            part.unlink()
        if isinstance(error, OSError):
            raise InvalidInputError(f"cannot write {path}: {error.strerror or error}") from None
        raise


def ffmpeg() -> str:
    """Return the program that encodes films.

    Raises
    ------
    MissingExtraError
        If imageio-ffmpeg is not installed.
    EncodingError
        If it brings no program for this machine.
    """
    with extra("animation", "an animation as MP4 or GIF"):
        import imageio_ffmpeg
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError as error:
        raise EncodingError(
            f"imageio-ffmpeg has no ffmpeg for this machine ({_line(str(error))}); write an SVG, "
            "or name a program in the environment variable IMAGEIO_FFMPEG_EXE"
        ) from None


def _encode(
    film: Film,
    numbers: Sequence[int],
    inputs: Sequence[str],
    options: Sequence[str],
    path: Path,
    say: Callable[[int], None],
) -> None:
    width, height = film.size
    raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", _rate(film.fps))
    command = [ffmpeg(), *QUIET, *raw, "-i", "pipe:0", *inputs, *options, f"file:{path.absolute()}"]
    with TemporaryFile() as said:
        try:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=said)
        except OSError as error:
            raise EncodingError(
                f"cannot start ffmpeg ({command[0]}): {error.strerror or error}"
            ) from None
        try:
            _feed(process, film.pictures(numbers), say)
            process.wait()
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
        if process.returncode:
            raise EncodingError(f"ffmpeg failed: {_last_line(said)}")


def _feed(
    process: subprocess.Popen[bytes], pictures: Iterator[bytes], say: Callable[[int], None]
) -> None:
    assert process.stdin is not None
    # A program that has ended no longer reads; its code and its words say why.
    try:
        with suppress(BrokenPipeError):
            for number, picture in enumerate(pictures, 1):
                process.stdin.write(picture)
                say(number)
    finally:
        with suppress(BrokenPipeError):
            process.stdin.close()


def _rate(fps: float) -> str:
    # Rates of a GIF are fractions of 100, which ffmpeg must not round.
    delay = 100.0 / fps
    return f"100/{round(delay)}" if math.isclose(delay, round(delay)) else f"{fps:.6g}"


def _last_line(said: IO[bytes]) -> str:
    said.seek(0)
    return _line(said.read(100_000).decode(errors="replace")) or "it said nothing"


def _line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1][:300] if lines else ""
