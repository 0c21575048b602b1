"""The source of the world of a run."""

from __future__ import annotations

from multisrt.spec.part import Part, Scalar


class CatalogEnvironment(Part, frozen=True, kw_only=True, tag_field="from", tag="catalog"):
    """An environment of the catalogue.

    Attributes
    ----------
    name : str
        Name in the catalogue.
    parameters : dict
        Parameters of a generator that differ from its defaults.
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


class SuiteEnvironment(Part, frozen=True, kw_only=True, tag_field="from", tag="suite"):
    """A world of a suite.

    Attributes
    ----------
    name : str
        Its name, such as "indoor-30/07".
    version : int
        Version of the suite; a different version is an error.

    Examples
    --------
    >>> import multisrt as ms
    >>> spec = ms.RunSpec(environment=ms.SuiteEnvironment(name="mazes-30/00", version=1), seed=1)
    >>> ms.RunSpec.from_toml(spec.to_toml()) == spec
    True
    """

    name: str
    version: int


class FileEnvironment(Part, frozen=True, kw_only=True, tag_field="from", tag="file"):
    """An environment read from a file.

    Attributes
    ----------
    path : str
        The file.
    resolution_m : float or None
        Metres per pixel, for an image whose file does not state them.
    threshold : float or None
        Lightness in [0, 1] above which a pixel of a plain image is free.
    starts_from : str or None
        A team file of MRESim with the suggested starts for a plain image.
    digest : str or None
        Expected digest of the free space in the file, as returned by `Environment.digest`; a file
        with a different digest is an error. None: not checked. The spec in a recording does not
        contain it, because the run does not depend on it.
    starts : tuple of (x, y) or None
        Expected suggested starts, in metres, in the file or in `starts_from`; others are an error.
        None: not checked. The spec in a recording does not contain them, because it has the starts
        of the robots.

    Examples
    --------
    >>> import multisrt as ms
    >>> with open("hall.wkt", "w") as file:
    ...     _ = file.write("POLYGON ((0 0, 8 0, 8 5, 0 5, 0 0))")
    >>> spec = ms.RunSpec(environment=ms.FileEnvironment(path="hall.wkt"), seed=1)
    >>> ms.explore(spec).environment.area_m2
    40.0
    """

    path: str
    resolution_m: float | None = None
    threshold: float | None = None
    starts_from: str | None = None
    digest: str | None = None
    starts: tuple[tuple[float, float], ...] | None = None


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

    Examples
    --------
    >>> import multisrt as ms
    >>> hall = ms.InlineEnvironment(
    ...     name="hall", wkt="POLYGON ((0 0, 8 0, 8 5, 0 5, 0 0))", starts=((1.0, 1.0),)
    ... )
    >>> run = ms.explore(ms.RunSpec(environment=hall, seed=1))
    >>> run.outcome, run.environment.bounds
    ('complete', (0.0, 0.0, 8.0, 5.0))
    """

    name: str
    wkt: str
    starts: tuple[tuple[float, float], ...] = ()


EnvironmentSpec = CatalogEnvironment | SuiteEnvironment | FileEnvironment | InlineEnvironment
