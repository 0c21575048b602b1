"""The truth that the robots do not have: worlds, their generators, their file formats.

Names are loaded on first use, so that importing this package costs nothing.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multisrt.environments.catalog import catalog, environment
    from multisrt.environments.environment import Environment
    from multisrt.environments.formats import read_environment

__all__ = ["Environment", "catalog", "environment", "read_environment"]

_HOMES = {
    "Environment": "multisrt.environments.environment",
    "catalog": "multisrt.environments.catalog",
    "environment": "multisrt.environments.catalog",
    "read_environment": "multisrt.environments.formats",
}


class _Package(ModuleType):
    """Package whose functions `catalog` and `environment` share the names of two modules.

    When those modules are imported, Python would bind them here in place of the functions,
    and what a name means would depend on what was imported before.
    """

    def __getattr__(self, name: str) -> object:
        if name not in _HOMES:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        return getattr(import_module(_HOMES[name]), name)

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *_HOMES})


sys.modules[__name__].__class__ = _Package
