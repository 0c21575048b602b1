"""Worlds to explore, which the robots cannot see: model, generators, file formats, maps.

Names are imported on first use.
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

    Importing one of these modules would replace the function by the module, so that the meaning
    of a name would depend on earlier imports.
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
