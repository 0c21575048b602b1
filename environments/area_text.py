"""Areas and extents as text."""

from __future__ import annotations


def area_text(area_m2: float, digits: int = 4) -> str:
    """Return an area in square metres as text, without its unit.

    Parameters
    ----------
    area_m2 : float
        The area, in square metres.
    digits : int, optional
        Number of significant digits. Areas of more digits are rounded to whole square metres.

    Examples
    --------
    >>> [area_text(area) for area in (0.01234, 52.5, 389999.7)]
    ['0.01234', '52.5', '390,000']
    """
    text = f"{area_m2:.{digits}g}"
    return f"{area_m2:,.0f}" if "e+" in text else text


def extent_text(bounds: tuple[float, float, float, float], area_m2: float) -> str:
    """Return the size of a world and its free area as text.

    Parameters
    ----------
    bounds : (x0, y0, x1, y1)
        Bounds of free space, in metres.
    area_m2 : float
        Area of free space, in square metres.

    Examples
    --------
    >>> extent_text((-2.0, 0.0, 10.5, 8.0), 92.25), extent_text((0.0, 0.0, 12e3, 700.0), 8.1e6)
    ('12.5 x 8 m, 92.25 m2 free', '12,000 x 700 m, 8,100,000 m2 free')
    """
    x0, y0, x1, y1 = bounds
    return f"{area_text(x1 - x0)} x {area_text(y1 - y0)} m, {area_text(area_m2)} m2 free"
