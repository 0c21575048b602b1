"""Pictures of worlds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from multisrt.drawing.axes import label_axes, on_axes
from multisrt.drawing.colours import SUGGESTED_START
from multisrt.drawing.sheet import LegendEntry, Sheet
from multisrt.drawing.svg import child, length
from multisrt.environments.environment import Environment
from multisrt.recording import atomic_write

if TYPE_CHECKING:
    from matplotlib.axes import Axes

START_MM = 1.6


def environment_svg(environment: Environment) -> str:
    """Return a picture of a world: free space, obstacles and suggested starts.

    Parameters
    ----------
    environment : Environment
        The world.

    Returns
    -------
    str
        An SVG document with metres as user units. Equal worlds give equal documents.

    Examples
    --------
    >>> from multisrt.environments import environment
    >>> "20 m x 20 m, 400 m² free" in environment_svg(environment("open"))
    True
    """
    return environment_sheet(environment).svg()


def environment_sheet(environment: Environment) -> Sheet:
    """Return the sheet of `environment_svg`, for other formats."""
    x0, y0, x1, y1 = environment.bounds
    parts = len(environment.free.geoms)
    sheet = Sheet(
        environment,
        [
            environment.name,
            f"{length(x1 - x0)} x {length(y1 - y0)}, {length(environment.area_m2)}² free"
            + (f" in {parts} separate parts" if parts > 1 else ""),
        ],
        description=f"A world to explore. Origin: {environment.origin or 'not known'}.",
    )
    sheet.draw_ground("free space")
    sheet.draw_obstacles(environment)
    if environment.starts:
        layer = sheet.layer("suggested starts", SUGGESTED_START)
        size = sheet.metres(START_MM)
        path = "".join(sheet.pen.marker("diamond", x, y, size) for x, y in environment.starts)
        child(layer, "path", d=path)
        sheet.legend.append(
            LegendEntry(
                label="suggested start",
                style=SUGGESTED_START,
                marker="diamond",
                size_mm=START_MM,
            )
        )
    return sheet


def save_environment_svg(environment: Environment, path: str | Path) -> None:
    """Write the picture of a world to a file; see `environment_svg`.

    The file appears once it is complete.

    Parameters
    ----------
    environment : Environment
        The world.
    path : str or Path
        The file, which is replaced if it exists. Its folder must exist.

    Raises
    ------
    InvalidInputError
        If the file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from multisrt.environments import environment
    >>> save_environment_svg(environment("open"), "open.svg")
    >>> Path("open.svg").read_text().count("<svg")
    1
    """
    with atomic_write(Path(path)) as file:
        file.write(environment_svg(environment).encode())


def plot_environment(environment: Environment, ax: Axes | None = None) -> Axes:
    """Draw a world on axes of matplotlib; see `Environment.plot`."""
    drawn = on_axes(environment_sheet(environment), ax)
    label_axes(drawn, "x (m)", "y (m)")
    return drawn
