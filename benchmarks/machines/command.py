"""The command: makes a small experiment and a small campaign again and again, and breaks them.

Each breakage comes at several moments, drawn from a seed: when a number of further results are
stored, and up to 0.3 s later. Then the command is continued, undisturbed. It is verified that the
store has each run once, with the digest of an undisturbed run, that none was made again, that
nothing is left beside the results, and that each error was one line. Folders of what went wrong are
kept.
"""

from __future__ import annotations

import random
import resource
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchmarks.arguments import at_least, parser_of
from benchmarks.machines.breakages import BREAKAGES, LeftOutError
from benchmarks.machines.cases import Case, Undisturbed
from benchmarks.machines.cluster import ON_CLUSTER
from benchmarks.machines.processes import LateError
from benchmarks.machines.subjects import SUBJECTS, Subject

EVERY: Final = {
    name: (breaks, tuple(SUBJECTS) if name in BREAKAGES else ("experiment",))
    for name, breaks in (BREAKAGES | ON_CLUSTER).items()
}
"""All breakages, with the names of the subjects that they break."""

ABOUT: Final = f"""{__doc__}
A breakage takes about a minute. Exit code: 0, or 1 if anything is not right."""

EXAMPLES: Final = """
--list
--only sigterm full-disk --seed 7
""".strip()

TITLE: Final = (
    f"{'breakage':16} {'of':11} {'expected':>8} {'lost':>5} {'twice':>5} {'ok':4} what was done"
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Try some or all breakages; exit with 1 if anything is not right."""
    parser = parser_of("benchmarks.machines", ABOUT, EXAMPLES)
    parser.add_argument(
        "--only",
        nargs="+",
        action="extend",
        choices=EVERY,
        metavar="NAME",
        help="these breakages alone (default: all; --list names them)",
    )
    parser.add_argument("--list", action="store_true", help="list the breakages, and end")
    parser.add_argument(
        "--seed", type=at_least(0), default=0, metavar="S", help="seed of the moments (default: 0)"
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/machines"),
        metavar="DIR",
        help="folder for what is made (default: out/machines)",
    )
    named = parser.parse_args(arguments)
    if named.list:
        for name, (breaks, of) in EVERY.items():
            print(f"{name:16} {' and '.join(of):24} {(breaks.__doc__ or '').splitlines()[0]}")
        return
    begin_s = time.monotonic()
    all_right = tried(named.only or list(EVERY), named.seed, named.out.resolve())
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        f"{time.monotonic() - begin_s:.0f} s, of which {used.ru_utime + used.ru_stime:.0f} s of "
        "computing"
    )
    sys.exit(0 if all_right else 1)


def tried(names: Sequence[str], seed: int, out: Path) -> bool:
    """Try breakages, print the table, and return whether all is right.

    Parameters
    ----------
    names : sequence of str
        The breakages.
    seed : int
        Seed of the moments.
    out : Path
        Folder for what is made; of what is right, nothing stays.
    """
    undisturbed: dict[str, Undisturbed] = {}
    all_right = True
    print(TITLE, flush=True)
    for name in names:
        breaks, of = EVERY[name]
        for subject in (SUBJECTS[each] for each in of):
            if subject.name not in undisturbed:
                undisturbed[subject.name] = made_undisturbed(subject, out)
            case = Case(
                subject=subject,
                folder=fresh(out / f"{name}-{subject.name}"),
                draws=random.Random(f"{seed} {name} {subject.name}"),
                expected=undisturbed[subject.name],
            )
            case.prepare()
            left_out = ""
            try:
                breaks(case)
                case.finish()
            except LeftOutError as reason:
                left_out = str(reason)
            except LateError as error:
                case.faults.append(str(error))
            print(row(name, case, left_out), flush=True)
            if left_out or case.is_ok:
                fresh(case.folder)
            all_right &= bool(left_out) or case.is_ok
    return all_right


def row(name: str, case: Case, left_out: str = "") -> str:
    """Return a line of the table, and the faults in lines below it."""
    ok = "-" if left_out else "yes" if case.is_ok else "NO"
    lost, twice = ("-", "-") if left_out else (str(len(case.lost)), str(len(case.twice)))
    did = f"left out: {left_out}" if left_out else "; ".join(case.did)
    line = (
        f"{name:16} {case.subject.name:11} {len(case.expected.results):8} {lost:>5} {twice:>5} "
        f"{ok:4} {did}"
    )
    faults = [] if left_out else [*case.faults]
    faults += [f"lost: {', '.join(case.lost)}"] if not left_out and case.lost else []
    faults += [f"twice: {', '.join(case.twice)}"] if not left_out and case.twice else []
    return "\n".join((line, *(f"    {fault}" for fault in faults)))


def made_undisturbed(subject: Subject, out: Path) -> Undisturbed:
    """Return what a subject comes to if nothing breaks.

    Parameters
    ----------
    subject : Subject
        The subject.
    out : Path
        Folder for what is made, of which nothing stays.
    """
    nothing = Undisturbed(code=0, results={})
    folder = fresh(out / f"undisturbed-{subject.name}")
    case = Case(subject=subject, folder=folder, draws=random.Random(), expected=nothing)
    case.prepare()
    with case.running() as command:
        ended = command.end()
    results = {key: row.result for key, row in subject.rows(folder).items()}
    if ended.told or not results:
        sys.exit(f"the {subject.name} fails undisturbed: {' / '.join(ended.told)}")
    fresh(folder)
    return Undisturbed(code=ended.code, results=results)


def fresh(folder: Path) -> Path:
    """Remove what an earlier case left in and beside a folder, and return the folder."""
    for path in (folder, *folder.parent.glob(f"{folder.name}-*")):
        if path.is_dir():
            shutil.rmtree(path)
    return folder
