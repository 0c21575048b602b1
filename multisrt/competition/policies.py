"""Where policies come from: strategies of this package by name, and files of others."""

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

OWN: Final = "gain-home"
"""Name of the policy that is made for the competition."""

NAMES: Final = (OWN, "gain", "closest", "greedy", "minpos")
"""Strategies that can be run in the competition."""

FOLDER: Final = Path(__file__).parent

PARTS: Final = ("grid_kernels.py", "gain_home.py")
"""Files of the policy `OWN`, in the order in which they are joined."""

OWN_IMPORTS: Final = re.compile(r"from (__future__|multisrt[.\w]*) import (\([^)]*\)|.*)\n")
"""Imports that a joined file does without, or has at its head."""

STANDS_ALONE: Final = '''\
"""Policy {name} of multisrt, for the indoor exploration competition; it stands alone.

Run it in the competition's folder scripts: python3 main.py --policy_path THIS_FILE
"""

'''

OWN_END: Final = """

from base_policy import BasePolicy  # noqa: E402


class Policy(GainHome, BasePolicy):
    \"\"\"The policy of the competition.\"\"\"
"""

RULE_FILE: Final = '''\
"""Strategy {name} of multisrt, for the indoor exploration competition; it needs multisrt.

Run it in the competition's folder scripts: python3 main.py --policy_path THIS_FILE
"""

from base_policy import BasePolicy
from multisrt.competition.rules import RulePolicy


class Policy(RulePolicy, BasePolicy):
    """The policy of the competition."""

    def __init__(self) -> None:
        super().__init__("{name}")
'''


@dataclass(frozen=True)
class PolicySource:
    """A policy that a process can build.

    Attributes
    ----------
    name : str
        The strategy's name, or that of the file.
    text : str
        The policy's file.
    path : Path or None
        Where a file of others is; None for a strategy of this package.
    """

    name: str
    text: str
    path: Path | None = None

    @staticmethod
    def of(strategy: str) -> PolicySource:
        """Return a strategy of this package.

        Raises
        ------
        InvalidInputError
            If there is none of that name.
        """
        if strategy not in NAMES:
            raise InvalidInputError(
                f"no strategy for the competition is called {strategy!r}"
                f"{did_you_mean(strategy, NAMES)}; there are {', '.join(NAMES)}, and --policy "
                "FILE takes any policy"
            )
        if strategy != OWN:
            return PolicySource(strategy, RULE_FILE.format(name=strategy))
        return PolicySource(strategy, STANDS_ALONE.format(name=OWN) + _joined() + OWN_END)

    @staticmethod
    def read(path: Path) -> PolicySource:
        """Return the policy of a file.

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
        """Digest of what the policy's decisions depend on, as far as this package knows it."""
        parts = [self.text.encode()]
        if self.path is None and self.name != OWN:
            parts += [(FOLDER / name).read_bytes() for name in (*PARTS, "rules.py")]
        return hashlib.sha256(b"\0".join(parts)).hexdigest()[:16]

    def build(self, base: type) -> Any:
        """Return the policy, a subclass of the competition's ``BasePolicy``.

        Raises
        ------
        InvalidInputError
            If the file has no class ``Policy`` that is one, or cannot be executed.
        """
        if self.path is None:
            return self._own(base)()
        spec = importlib.util.spec_from_file_location("submitted_policy", self.path)
        if spec is None or spec.loader is None:
            raise InvalidInputError(f"{self.path} is not a file of Python")
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

    def _own(self, base: type) -> Callable[[], Any]:
        if self.name == OWN:
            from multisrt.competition.gain_home import GainHome

            return type("Policy", (GainHome, base), {})
        from multisrt.competition.rules import policy

        return type("Policy", (policy(self.name), base), {})


def _joined() -> str:
    """Return the files of the policy `OWN` as one, without docstrings of modules."""
    bodies: list[str] = []
    for name in PARTS:
        text = (FOLDER / name).read_text(encoding="utf-8")
        _, _, body = text.removeprefix('"""').partition('"""\n')
        lines = OWN_IMPORTS.sub("", body).splitlines()
        before = "\n".join(bodies).splitlines()
        kept = [x for x in lines if not (x.startswith(("import ", "from ")) and x in before)]
        bodies.append("\n".join(kept).strip())
    return "from __future__ import annotations\n\n" + "\n\n\n".join(bodies) + "\n"
