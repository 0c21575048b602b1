"""The command: campaigns of the program with each of the defects, and the table of what they find.

Findings are kept in a file in the folder, so that the same command goes on where it was
interrupted; a defect is tried anew if the program has changed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchmarks.arguments import add_count, parser_of
from benchmarks.mutants.campaigns import Campaigns
from benchmarks.mutants.catalogue import CONTROL, MUTANTS
from benchmarks.mutants.findings import Finding, Findings, key_of
from benchmarks.mutants.page import PAGE, page, rows_of
from multisrt.experiments.lock import WriteLock
from multisrt.geometry.errors import InvalidInputError

ABOUT: Final = f"""{__doc__}
A defect that is found takes from a few seconds to four minutes on one core; one that is not, and
the control, take one to two seconds for each mission. Exit code: 0, 1 if a defect was not found or
the control failed, 2 if a campaign could not be run."""

EXAMPLES: Final = """
--list
--only too-fast control --missions 100
--page
""".strip()

UNFOUND, BAD_INPUT = 1, 2
"""Exit codes: a defect was not found, or the control failed; a campaign could not be run."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Try defects, or write the page; return the exit code."""
    parser = parser_of("benchmarks.mutants", ABOUT, EXAMPLES)
    names = (*MUTANTS, CONTROL)
    parser.add_argument(
        "--only",
        nargs="+",
        choices=names,
        metavar="NAME",
        help="defects (default: all; --list names them)",
    )
    parser.add_argument("--list", action="store_true", help="print the defects, and try none")
    parser.add_argument(
        "--page", action="store_true", help=f"write {PAGE.name} from what is kept, and try none"
    )
    add_count(parser, "--missions", "N", 3000, 1, "missions of each, if none fails")
    add_count(parser, "--workers", "N", 1, 1, "number of processes")
    add_count(parser, "--seed", "S", 0, 0, "seed of the campaigns")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/mutants"),
        metavar="DIR",
        help="folder for the copy and the findings (default: out/mutants)",
    )
    given = parser.parse_args(arguments)
    chosen = list(dict.fromkeys(given.only or names))
    if given.list:
        for name in MUTANTS:
            print(f"{name:28} {MUTANTS[name].file}: {MUTANTS[name].breaks}")
        return 0
    try:
        findings = Findings(given.out / "findings.jsonl")
        if given.page:
            PAGE.write_text(page(_kept(findings, given.seed), given.seed))
            return 0
        return _try(chosen, findings, given)
    except InvalidInputError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT


def _try(names: Sequence[str], findings: Findings, given: argparse.Namespace) -> int:
    given.out.mkdir(parents=True, exist_ok=True)
    campaigns = Campaigns(
        folder=given.out, missions=given.missions, workers=given.workers, seed=given.seed
    )
    lock = WriteLock(given.out / "findings.jsonl")
    try:
        as_wanted = True
        for name in names:
            found = campaigns.find(MUTANTS.get(name), findings)
            print(_line(found), flush=True)
            as_wanted &= (found.mission is None) == (name == CONTROL)
    finally:
        lock.release()
    return 0 if as_wanted else UNFOUND


def _line(found: Finding) -> str:
    ((name, breaks, by, missions, seconds),) = rows_of([found.mutant], {found.mutant: found})
    return f"{name:28} {by}; missions: {missions}; {seconds} s; {found.says or breaks}"


def _kept(findings: Findings, seed: int) -> dict[str, Finding]:
    mutants = (*MUTANTS.values(), None)
    return findings.among(key_of(mutant, seed) for mutant in mutants)
