"""Where the world of a run comes from."""

from __future__ import annotations

from multisrt.spec.part import Part, Scalar


class CatalogEnvironment(Part, frozen=True, kw_only=True, tag_field="from", tag="catalog"):
    """An environment of the catalogue.

    Attributes
    ----------
    name : str
        Name in the catalogue.
    parameters : dict
        Parameters of a generator that are not its defaults.
    seed : int or None
        Seed of a generator, independent of the seed of the run; None for the generator's default.

    Examples
    --------
    >>> CatalogEnvironment(name="rooms", parameters={"size_m": 18.0}, seed=3).name
    'rooms'
    """

    name: str
    parameters: dict[str, Scalar] = {}
    seed: int | None = None


class FileEnvironment(Part, frozen=True, kw_only=True, tag_field="from", tag="file"):
    """An environment read from a file.

    Attributes
    ----------
    path : str
        The file.
    resolution_m : float or None
        Metres per pixel, for an image whose file does not give them.
    threshold : float or None
        Lightness in [0, 1] above which a pixel of a plain image is free.
    """

    path: str
    resolution_m: float | None = None
    threshold: float | None = None


class InlineEnvironment(Part, frozen=True, kw_only=True, tag_field="from", tag="wkt"):
    """An environment written out in the spec.

    Attributes
    ----------
    name : str
        Its name.
    wkt : str
        Free space as well-known text, in metres.
    starts : tuple of (x, y)
        Suggested starts, in metres.
    """

    name: str
    wkt: str
    starts: tuple[tuple[float, float], ...] = ()


EnvironmentSpec = CatalogEnvironment | FileEnvironment | InlineEnvironment
