"""What campaigns found of planted defects: kept in a file, one JSON object a line."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import msgspec

from benchmarks.mutants.mutant import Mutant
from multisrt.experiments.provenance import program_digest
from multisrt.geometry.errors import InvalidInputError


class Finding(msgspec.Struct, frozen=True, kw_only=True):
    """What a campaign came to.

    Attributes
    ----------
    mutant : str
        The defect, or the control.
    key : str
        Digest of the program with the defect, and of the seed; see `key_of`.
    missions : int
        Number of missions that were made.
    mission : int or None
        Number of missions up to the first that failed, that one included; None if none did.
    invariants : tuple of str
        The invariants that it violated.
    says : str
        What the first of them says.
    seconds : float
        Elapsed time of the runs and their checks (s).
    """

    mutant: str
    key: str
    missions: int
    mission: int | None
    invariants: tuple[str, ...]
    says: str
    seconds: float

    @property
    def program(self) -> str:
        """Digest of the source of the program without the defect."""
        return self.key.partition("-")[0]


def key_of(mutant: Mutant | None, seed: int) -> str:
    """Return what a finding depends on: the program in use, the defect and the seed."""
    return f"{program_digest('campaign', 'analysis')}-{mutant.digest if mutant else '0'}-{seed}"


class Findings:
    """The findings in a file; of several with one key, the last counts.

    Parameters
    ----------
    path : Path
        The file; it need not exist.

    Raises
    ------
    InvalidInputError
        If the file holds something else.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._by_key: dict[str, Finding] = {}
        text = path.read_text() if path.is_file() else ""
        for number, line in enumerate(text.splitlines(), 1):
            try:
                finding = msgspec.json.decode(line, type=Finding)
            except msgspec.MsgspecError as error:
                raise InvalidInputError(
                    f"{path}, line {number}: no finding ({error}); remove the line"
                ) from None
            self._by_key[finding.key] = finding

    def of(self, key: str) -> Finding | None:
        """Return the finding with a key; None if there is none."""
        return self._by_key.get(key)

    def settles(self, key: str, missions: int) -> bool:
        """Whether a finding needs no more missions: it failed, or has as many as wanted."""
        found = self.of(key)
        return found is not None and (found.mission is not None or found.missions >= missions)

    def add(self, finding: Finding) -> None:
        """Keep a finding."""
        self._by_key[finding.key] = finding
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("ab") as file:
            file.write(msgspec.json.encode(finding) + b"\n")

    def among(self, keys: Iterable[str]) -> dict[str, Finding]:
        """Return the findings with some keys, by mutant."""
        found = [self._by_key[key] for key in keys if key in self._by_key]
        return {finding.mutant: finding for finding in found}
