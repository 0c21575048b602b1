"""Writing an animation to a file of any format."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

from multisrt.drawing.account import description
from multisrt.drawing.animation.layout import WIDTH
from multisrt.drawing.animation.moving_svg import moving_svg
from multisrt.drawing.animation.pace import Pace
from multisrt.drawing.animation.scene import Scene, scene_of
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording, atomic_write


class Format(NamedTuple):
    """Defaults of a format of animations.

    Attributes
    ----------
    fps : float
        Pictures a second; in SVG steps a second in which things appear, as robots move smoothly.
    width : int
        Width in pixels.
    """

    fps: float
    width: int


FORMATS: Final[Mapping[str, Format]] = {
    ".mp4": Format(25.0, 1280),
    ".gif": Format(10.0, 720),
    ".svg": Format(5.0, WIDTH),
}
"""The formats of animations, by the suffixes of files."""

Say = Callable[[int, int], None]
"""Is told how many pictures are done, and of how many."""


def animation_svg(
    recording: Recording,
    *,
    duration_s: float | None = None,
    speed: float | None = None,
    fps: float | None = None,
    size: int | tuple[int, int] | None = None,
    without: Collection[str] = (),
) -> str:
    """Return an animation of a run as SVG, which moves by itself.

    Parameters
    ----------
    recording : Recording
        The run.
    duration_s, speed, fps, size, without
        As for `multisrt.Run.animate`.

    Returns
    -------
    str
        An SVG document without scripts. Equal recordings give equal documents.

    Raises
    ------
    InvalidInputError
        If an argument is out of range, or the recording contradicts itself.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", seed=1, max_time_s=10.0)
    >>> animation_svg(run.recording, duration_s=5.0).count("<svg")
    1
    """
    fps = FORMATS[".svg"].fps if fps is None else fps
    pace = Pace.of(recording.footer.time_s, duration_s=duration_s, speed=speed, fps=fps)
    return moving_svg(_scene(recording, pace, size, ".svg", without), description(recording))


def save_animation(
    recording: Recording,
    path: str | Path,
    *,
    duration_s: float | None = None,
    speed: float | None = None,
    fps: float | None = None,
    size: int | tuple[int, int] | None = None,
    without: Collection[str] = (),
    say: Say | None = None,
) -> None:
    """Write an animation of a run; see `multisrt.Run.animate`.

    Parameters
    ----------
    recording : Recording
        The run.
    path : str or Path
        The file, which is replaced once the animation is complete. Its suffix determines the
        format, one of `FORMATS`.
    duration_s, speed, fps, size, without
        As for `multisrt.Run.animate`.
    say : callable, optional
        Called with the number of pictures that are done, and that of all.

    Raises
    ------
    InvalidInputError
        If an argument is out of range, the recording contradicts itself, or the file cannot be
        written.
    MissingExtraError
        If an MP4 or GIF is to be written and imageio-ffmpeg is not installed
        (``multisrt[animation]``).
    EncodingError
        If ffmpeg fails.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", seed=1, max_time_s=10.0)
    >>> save_animation(run.recording, "run.svg", duration_s=5.0)
    >>> "<animate " in Path("run.svg").read_text()
    True
    """
    path = Path(path)
    suffix = require_format(path)
    if suffix == ".svg":
        text = animation_svg(
            recording, duration_s=duration_s, speed=speed, fps=fps, size=size, without=without
        )
        with atomic_write(path) as file:
            file.write(text.encode())
        return
    from multisrt.drawing.animation.video import ffmpeg, gif_fps

    ffmpeg()
    fps = FORMATS[suffix].fps if fps is None else fps
    pace = Pace.of(recording.footer.time_s, duration_s=duration_s, speed=speed, fps=fps)
    if suffix == ".gif":
        pace = replace(pace, fps=gif_fps(fps))
    _save_film(_scene(recording, pace, size, suffix, without), path, suffix, say)


def require_format(path: Path) -> str:
    """Return the suffix of a file in lower case.

    Raises
    ------
    InvalidInputError
        If it is not of a format of animations.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        known = ", ".join(FORMATS)
        raise InvalidInputError(
            f"animations are files of the formats {known}; {path} is none of these"
        )
    return suffix


def _scene(
    recording: Recording,
    pace: Pace,
    size: int | tuple[int, int] | None,
    suffix: str,
    without: Collection[str],
) -> Scene:
    given = FORMATS[suffix].width if size is None else size
    width, height = given if isinstance(given, tuple) else (given, None)
    return scene_of(
        recording, recording.environment(), pace, width=width, height=height, without=without
    )


def _save_film(scene: Scene, path: Path, suffix: str, say: Say | None) -> None:
    from multisrt.drawing.animation.painter import Painter
    from multisrt.drawing.animation.video import Film, save_gif, save_mp4

    layout, pace = scene.layout, scene.pace
    film = Film(
        (layout.width, layout.height), pace.fps, pace.pictures, lambda: Painter(scene).picture
    )

    def tell(done: int) -> None:
        if say is not None:
            say(done, film.count)

    save = save_gif if suffix == ".gif" else save_mp4
    save(film, path, tell)
