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


class SuiteEnvironment(Part, frozen=True, kw_only=True, tag_field="from", tag="suite"):
    """A world of a suite.

    Attributes
    ----------
    name : str
        Its name, such as "indoor-30/07".
    version : int
        Version of the suite; another one is an error.

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
        Metres per pixel, for an image whose file does not give them.
    threshold : float or None
        Lightness in [0, 1] above which a pixel of a plain image is free.
    starts_from : str or None
        A team file of MRESim that gives a plain image its suggested starts.
    digest : str or None
        Digest of the free space that the file is to hold, as `Environment.digest` returns it; a
        file that holds another world is an error. None: whatever the file holds. It is no part of
        the spec in a recording, since a run does not depend on it.
    starts : tuple of (x, y) or None
        Suggested starts in metres that the file is to hold, or the one of `starts_from`; others are
        an error. None: whatever it holds. It is no part of the spec in a recording, either, which
        has the starts of the robots.

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
