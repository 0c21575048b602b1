"""Campaigns of a copy of the program, each until its first failure."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.mutants.catalogue import CONTROL
from benchmarks.mutants.copies import ProgramCopy
from benchmarks.mutants.findings import Finding, Findings, key_of
from benchmarks.mutants.mutant import Mutant
from multisrt.campaign.store import CampaignStore
from multisrt.geometry.errors import InvalidInputError

SHOWN: Final = 2000
"""Number of characters of what a process wrote that an error cites."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaigns:
    """How campaigns are run.

    Attributes
    ----------
    folder : Path
        Folder of the copy, and of the missions of all campaigns.
    missions : int
        Number of missions of each campaign that finds nothing.
    workers : int
        Number of processes.
    seed : int
        Seed of the campaigns.
    """

    folder: Path
    missions: int
    workers: int
    seed: int

    def find(self, mutant: Mutant | None, findings: Findings) -> Finding:
        """Run a campaign of the program with a defect, or go on with it; keep what it came to.

        Parameters
        ----------
        mutant : Mutant or None
            The defect; None: none.
        findings : Findings
            Where the finding is kept. One that settles it is returned as it is.

        Returns
        -------
        Finding
            What the campaign came to.

        Raises
        ------
        InvalidInputError
            If the text of the mutant is not in the package, or its campaign cannot be run.
        """
        key = key_of(mutant, self.seed)
        before = findings.of(key)
        if before is not None and findings.settles(key, self.missions):
            return before
        name = CONTROL if mutant is None else mutant.name
        copy = ProgramCopy(self.folder)
        copy.prepare(mutant)
        store = self.folder.resolve() / "missions" / name / f"{key}.sqlite"
        store.parent.mkdir(parents=True, exist_ok=True)
        self._run(name, copy, store)
        found = finding_of(name, key, store)
        findings.add(found)
        return found

    def _run(self, name: str, copy: ProgramCopy, store: Path) -> None:
        command = [
            *(sys.executable, "-P", "-m", "multisrt", "campaign", "run", "--quiet"),
            *("--missions", str(self.missions), "--workers", str(self.workers)),
            *("--seed", str(self.seed), "--store", str(store)),
            *("--shrink", "0", "--stop-at-first"),
        ]
        done = subprocess.run(
            command,
            cwd=store.parent,
            env=copy.environment(),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode not in (0, 1) or not store.is_file():
            raise InvalidInputError(
                f"the campaign of {name} ended with {done.returncode}: {done.stderr[-SHOWN:]}"
            )


def finding_of(name: str, key: str, store: Path) -> Finding:
    """Return what a campaign came to, by the file of its missions.

    Parameters
    ----------
    name, key : str
        The defect, and the key of the finding.
    store : Path
        The file.

    Returns
    -------
    Finding
        The finding.
    """
    with CampaignStore.open(store) as opened:
        rows = list(opened.rows())
    seconds = math.fsum(row.run_s + row.check_s for row in rows)
    failed = next((row for row in rows if row.violations), None)
    if failed is None:
        return Finding(
            mutant=name,
            key=key,
            missions=len(rows),
            mission=None,
            invariants=(),
            says="",
            seconds=seconds,
        )
    return Finding(
        mutant=name,
        key=key,
        missions=len(rows),
        mission=failed.number + 1,
        invariants=tuple(violation.invariant for violation in failed.violations),
        says=failed.violations[0].says,
        seconds=seconds,
    )
