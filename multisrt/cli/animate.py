"""`multisrt animate`: animate a recording."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from multisrt.cli.layers import without_option
from multisrt.cli.output_options import ANIMATION_NAME, force_option, out_file, quiet_option
from multisrt.cli.outputs import require_place
from multisrt.cli.recordings import recording_in


@click.command()
@click.argument("recording", metavar="RECORDING", type=click.Path(path_type=Path))
@out_file("the animation: .mp4, .gif or .svg", ANIMATION_NAME)
@force_option()
@click.option(
    "--duration",
    "duration_s",
    type=float,
    metavar="S",
    help="Length of the animation (s); its last picture stays for another 2 s.  "
    "[default: 24, less for shorter runs]",
)
@click.option(
    "--speed", type=float, metavar="X", help="Speed, as a multiple of that of the robots."
)
@click.option(
    "--fps",
    type=float,
    metavar="N",
    help="Frames per second; in SVG the steps per second in which things appear, as robots move "
    "smoothly.  [default: MP4 25, GIF 10, SVG 5]",
)
@click.option(
    "--size",
    metavar="W[xH]",
    help="Width in pixels, or width and height.  [default: width 1280, GIF 720, SVG 960]",
)
@without_option("animation")
@quiet_option()
def animate(
    recording: Path,
    *,
    out: Path | None,
    size: str | None,
    force: bool,
    quiet: bool,
    **drawing: Any,
) -> None:
    """Animate a run as MP4, GIF or animated SVG.

    RECORDING is the folder that 'multisrt explore' wrote, or the file recording.jsonl in it.

    SVG needs no extra, and is animated on web pages and on GitHub. MP4 and GIF need the extra
    'animation'.

    \b
    Examples:
      multisrt animate runs/office-srt-radial-0
      multisrt animate out --out out.mp4 --speed 20
      multisrt animate out --out out.gif --duration 12 --size 600 --without paths
    """
    from multisrt.drawing.animation.saving import require_format, save_animation
    from multisrt.recording import Recording
    from multisrt.terminal import LiveLine

    if drawing["duration_s"] is not None and drawing["speed"] is not None:
        raise click.UsageError("--duration and --speed exclude each other: give one of them")
    pixels = None if size is None else _pixels(size)
    if out is not None:
        require_format(out)
    path = recording_in(recording)
    out = path.with_name(ANIMATION_NAME) if out is None else out
    require_place(out, force=force)
    with LiveLine(not quiet, "reading", str(path)) as line:
        loaded = Recording.load(path)
        line.update(description="drawing", note=str(out))
        save_animation(
            loaded,
            out,
            size=pixels,
            **drawing,
            say=lambda done, of: line.update(completed=done, total=of),
        )
    if not quiet:
        click.echo(out)


def _pixels(size: str) -> int | tuple[int, int]:
    found = re.fullmatch(r"([0-9]{1,5})(?:x([0-9]{1,5}))?", size)
    if found is None:
        raise click.UsageError(
            f"--size {size!r} is not a size; give a width (960) or a width and a height (960x600)"
        )
    width, height = found.groups()
    return int(width) if height is None else (int(width), int(height))
