"""Policies for the competition: strategies of this package by name, and files of others."""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from multisrt.geometry.errors import InvalidInputError, did_you_mean

GAIN_HOME: Final = "gain-home"
"""Name of the strategy that was developed for the competition."""

NAMES: Final = (GAIN_HOME, "gain", "closest", "greedy", "minpos")
"""Names of the strategies that can be run in the competition."""

FOLDER: Final = Path(__file__).parent

GAIN_HOME_FILES: Final = ("grid_kernels.py", "gain_home.py")
"""Files of the strategy `GAIN_HOME`, in the order in which they are joined."""

DROPPED_IMPORTS: Final = re.compile(r"from (__future__|multisrt[.\w]*) import (\([^)]*\)|.*)\n")
"""Imports that the joined file does not need, or has in its first line."""

GAIN_HOME_HEAD: Final = '''\
"""Strategy {name} of multisrt for the indoor exploration competition; needs numpy and numba only.

Run it in the competition's folder scripts: python3 main.py --policy_path THIS_FILE
"""

'''

GAIN_HOME_CLASS: Final = """

from base_policy import BasePolicy  # noqa: E402


class Policy(GainHome, BasePolicy):
    \"\"\"The policy of the competition.\"\"\"
"""

FRONTIER_POLICY_FILE: Final = '''\
"""Strategy {name} of multisrt for the indoor exploration competition; needs multisrt.

Run it in the competition's folder scripts: python3 main.py --policy_path THIS_FILE
"""

from base_policy import BasePolicy
from multisrt.competition.frontier_policies import FrontierPolicy


class Policy(FrontierPolicy, BasePolicy):
    """The policy of the competition."""

    def __init__(self) -> None:
        super().__init__("{name}")
'''


@dataclass(frozen=True)
class PolicySource:
    """A policy as text, from which any process can build it.

    Attributes
    ----------
    name : str
        Name of the strategy, or of the file without its suffix.
    text : str
        Text of the policy's file.
    path : Path or None
        Path of the file; None for a strategy of this package.
    """

    name: str
    text: str
    path: Path | None = None

    @staticmethod
    def of(strategy: str) -> PolicySource:
        """Return the policy of a strategy of this package.

        Raises
        ------
        InvalidInputError
            If there is no strategy of that name.
        """
        if strategy not in NAMES:
            raise InvalidInputError(
                f"no strategy for the competition is called {strategy!r}"
                f"{did_you_mean(strategy, NAMES)}; there are {', '.join(NAMES)}, and --policy "
                "FILE takes any policy"
            )
        if strategy != GAIN_HOME:
            return PolicySource(strategy, FRONTIER_POLICY_FILE.format(name=strategy))
        head = GAIN_HOME_HEAD.format(name=strategy)
        return PolicySource(strategy, head + _joined_files() + GAIN_HOME_CLASS)

    @staticmethod
    def read(path: Path) -> PolicySource:
        """Return the policy in a file.

        Raises
        ------
        InvalidInputError
            If the file cannot be read.
        """
        try:
            return PolicySource(path.stem, path.read_text(encoding="utf-8"), path.resolve())
        except (OSError, UnicodeError) as error:
            raise InvalidInputError(f"{path} cannot be read: {error}") from error

    @property
    def digest(self) -> str:
        """Digest of the files on which the policy's decisions depend, as far as they are known."""
        parts = [self.text.encode()]
        if self.path is None and self.name != GAIN_HOME:
            names = (*GAIN_HOME_FILES, "frontier_policies.py")
            parts += [(FOLDER / name).read_bytes() for name in names]
        return hashlib.sha256(b"\0".join(parts)).hexdigest()[:16]

    def build(self, base: type) -> Any:
        """Return a new policy object.

        Parameters
        ----------
        base : type
            The competition's class ``BasePolicy``.

        Raises
        ------
        InvalidInputError
            If the file cannot be executed, or has no class ``Policy`` that is derived from `base`.
        """
        if self.path is None:
            return self._strategy_class(base)()
        spec = importlib.util.spec_from_file_location("submitted_policy", self.path)
        if spec is None or spec.loader is None:
            raise InvalidInputError(f"{self.path} is not a Python file")
        module = importlib.util.module_from_spec(spec)
        sys.modules[spec.name] = module
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            raise InvalidInputError(
                f"{self.path} cannot be executed: {type(error).__name__}: {error}"
            ) from error
        found = getattr(module, "Policy", None)
        if not (isinstance(found, type) and issubclass(found, base)):
            raise InvalidInputError(f"{self.path} has no class Policy that is a BasePolicy")
        return found()

    def _strategy_class(self, base: type) -> Callable[[], Any]:
        if self.name == GAIN_HOME:
            from multisrt.competition.gain_home import GainHome

            return type("Policy", (GainHome, base), {})
        from multisrt.competition.frontier_policies import policy_class

        return type("Policy", (policy_class(self.name), base), {})


def _joined_files() -> str:
    """Return `GAIN_HOME_FILES` as one text, without the docstrings of modules."""
    bodies: list[str] = []
    for name in GAIN_HOME_FILES:
        text = (FOLDER / name).read_text(encoding="utf-8")
        _, _, body = text.removeprefix('"""').partition('"""\n')
        lines = DROPPED_IMPORTS.sub("", body).splitlines()
        before = "\n".join(bodies).splitlines()
        kept = [x for x in lines if not (x.startswith(("import ", "from ")) and x in before)]
        bodies.append("\n".join(kept).strip())
    return "from __future__ import annotations\n\n" + "\n\n\n".join(bodies) + "\n"
