"""Areas as text."""

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
