"""Importing modules that register strategies."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

from multisrt.geometry.errors import InvalidInputError


def import_modules(modules: Sequence[str]) -> None:
    """Import modules, of installed packages or of the working directory.

    Parameters
    ----------
    modules : sequence of str
        Their names.

    Raises
    ------
    InvalidInputError
        If one cannot be imported.
    """
    here = os.getcwd()
    if modules and here not in sys.path:
        sys.path.append(here)
    for module in modules:
        try:
            import_module(module)
        except Exception as error:  # code of others may raise anything
            raise InvalidInputError(
                f"cannot import {module!r}: {type(error).__name__}: {error}; name a module of the "
                "working directory, or of a package that is installed"
            ) from None
