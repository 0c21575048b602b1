"""Optional dependencies: the extras of an installation, data frames, and notebooks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Final

from multisrt.geometry.errors import MultiSrtError

EXTRAS: Final[Mapping[str, tuple[str, ...]]] = {
    "plots": ("matplotlib",),
    "frames": ("pandas",),
    "polars": ("polars",),
    "parquet": ("pyarrow",),
    "cluster": ("distributed",),
    "learn": ("gymnasium", "pettingzoo"),
    "animation": ("imageio-ffmpeg",),
    "dxf": ("ezdxf",),
    "mcap": ("mcap",),
    "rerun": ("rerun-sdk",),
}
"""The packages that each extra brings."""

MODULES: Final[Mapping[str, str]] = {
    "imageio-ffmpeg": "imageio_ffmpeg",
    "rerun-sdk": "rerun",
}
"""The modules of those packages that are imported by another name."""


class MissingExtraError(MultiSrtError, ImportError):
    """A package of an extra is not installed; the message says which extra to install.

    Examples
    --------
    >>> from multisrt.extras import MissingExtraError
    >>> issubclass(MissingExtraError, ImportError)
    True
    """


@contextmanager
def extra(name: str, what: str) -> Iterator[None]:
    """Name the extra to install if an import within the block finds no package of it.

    Parameters
    ----------
    name : str
        The extra, a key of `EXTRAS`.
    what : str
        What needs it, for the message.

    Raises
    ------
    MissingExtraError
        If a package of the extra is not installed. Errors of other imports are raised
        unchanged.

    Examples
    --------
    >>> with extra("plots", "a figure"):
    ...     import matplotlib
    """
    try:
        yield
    except ModuleNotFoundError as error:
        module = (error.name or "").partition(".")[0]
        missing = next((one for one in EXTRAS[name] if MODULES.get(one, one) == module), None)
        if missing is None:
            raise
        raise MissingExtraError(
            f"{what} needs {missing}, which is not installed: pip install 'multisrt[{name}]'"
        ) from None
