"""The breakages of one machine, each by name with a function that breaks a case."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from benchmarks.machines.cases import Case, in_words
from benchmarks.machines.processes import (
    Command,
    Ended,
    LateError,
    Limits,
    started,
)

CLOCK: Final = Path(__file__).parent / "clock"
"""Folder of the module that sets clocks back."""

JUMPS_S: Final = 6.0
"""Time of a process within which its clock is set back (s)."""

DISKS_KB: Final = {"experiment": (12, 100, 400), "campaign": (12, 36, 52)}
"""About how large disks are, one after another, until they are large enough (kB)."""

LARGE_KB: Final = 200_000
"""Size of a disk that is large enough (kB)."""

MARGINS_KB: Final = (0, 64, 1024)
"""Memory that a process may still allocate when it is limited, one of them (kB)."""

FULL: Final = Path("/dev/full")
"""A device on which there is never room."""

READ_ONLY, USUAL = 0o555, 0o755
"""Permissions of folders."""


class LeftOutError(Exception):
    """A breakage cannot be tried here."""


# Signals --------------------------------------------------------------------------------------


def killed_runner(case: Case) -> None:
    """Kill the command; its workers end with it."""
    signalled(case, signal.SIGKILL, 3)


def terminated(case: Case) -> None:
    """End the command as `kill` and the managers of services and of batches do."""
    signalled(case, signal.SIGTERM, 2)


def hung_up(case: Case) -> None:
    """Close the terminal of the command."""
    signalled(case, signal.SIGHUP, 1)


def interrupted(case: Case) -> None:
    """Interrupt the command from the keyboard."""
    signalled(case, signal.SIGINT, 2)


def signalled(case: Case, number: signal.Signals, times: int) -> None:
    """Send the command a signal, some times, each at a moment; it is continued in between."""
    moments = []
    for _ in range(times):
        with case.running() as command:
            moments.append(case.reach(command))
            command.send(number)
            ended = command.end()
            case.require_gone(command)
        case.look()
        if number is signal.SIGKILL:
            case.require(ended.code == -number, f"exit code {ended.code}")
            case.require(not ended.told, f"it wrote: {' / '.join(ended.told)}")
        else:
            _require_interrupted(case, ended, number)
    case.did.append(f"{number.name} {in_words(moments)}")


def _require_interrupted(case: Case, ended: Ended, number: signal.Signals) -> None:
    case.require(ended.code == 128 + number, f"exit code {ended.code}, not {128 + number}")
    name = "" if number is signal.SIGINT else f" by {number.name}"
    told = " / ".join(ended.told)
    *before, last = ended.told or ("",)
    is_told = len(before) == 1 and "the same command continues" in before[0]
    is_all_made = len(case.seen[-1]) == len(case.expected.results)  # it was past making runs
    is_right = last == f"interrupted{name}" and (is_told or (is_all_made and not before))
    case.require(is_right, f"it wrote: {told}")
    case.require_tidy()


def killed_worker(case: Case) -> None:
    """Kill a process that makes runs; the command goes on."""
    moments = []
    with case.running() as command:
        for _ in range(2):
            moments.append(case.reach(command, 1))  # not the same run again
            kill(case.draws.choice(workers(command)))
        case.require_success(command.end())
        case.require_gone(command)
    case.look()
    case.did.append(f"SIGKILL {in_words(moments)}")


def workers(command: Command) -> list[int]:
    """Return the processes that a command has started, of which there is at least one."""
    command.wait_until(lambda: bool(command.children()), "a worker was there")
    return command.children()


def kill(pid: int) -> None:
    """Kill a process; raise LateError if it has ended."""
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        raise LateError("a worker had ended before it was killed") from None


# Disks ----------------------------------------------------------------------------------------


def full_disk(case: Case) -> None:
    """Let the disk be full, and make room, several times."""
    sizes = [size + case.draws.randrange(0, size // 4, 4) for size in DISKS_KB[case.subject.name]]
    with _disk(case) as resized:
        for size_kb in sizes:
            with case.running(limits=resized(size_kb)) as command:
                ended = command.end()
                case.require_gone(command)
            if len(case.look()) < len(case.expected.results):
                case.require_error(ended, "disk|No space left|File too large")
        case.require(len(case.seen[0]) < len(case.expected.results), "the disk was never full")
        resized(LARGE_KB)
        case.did.append(f"full at {', '.join(map(str, sizes))} kB, then room")
        case.finish()


@contextmanager
def _disk(case: Case) -> Iterator[Callable[[int], Limits]]:
    """Put the folder on a disk of its own; provide what gives it a size (kB).

    Where disks cannot be mounted, the length of files is limited instead.
    """
    is_mounted = False

    def resized(size_kb: int) -> Limits:
        if not is_mounted:
            return Limits(file_bytes=1000 * size_kb)
        _mount(case.folder, f"remount,size={size_kb}k")
        return Limits()

    is_mounted = _mount(case.folder, f"size={LARGE_KB}k")
    if is_mounted:
        for name, text in case.subject.files.items():
            (case.folder / name).write_text(text)
    else:
        case.did.append("by a limit of files:")
    try:
        yield resized
    finally:
        if is_mounted:
            subprocess.run(["umount", str(case.folder)], check=True)


def _mount(folder: Path, options: str) -> bool:
    command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def read_only(case: Case) -> None:
    """Take the permission to write from the folder: before, between two calls, and during one."""
    folder, bound = case.folder, Limits(as_anyone=True)
    try:
        folder.chmod(READ_ONLY)
        with case.running(limits=bound) as command:
            case.require_error(command.end(), "cannot write")
        case.require(not case.look(), "a store was written")
        folder.chmod(USUAL)
        with case.running(limits=bound) as command:
            stored = case.reach(command)
            for each in _folders(folder):
                each.chmod(READ_ONLY)
            ended = command.end()
            case.require_gone(command)
        if ended.code != case.expected.code:
            case.require_error(ended, "cannot|readonly|unable")
        case.look()
        for each in _folders(folder):
            each.chmod(USUAL)
        (folder / case.subject.store).chmod(0o444)
        with case.running(limits=bound) as command:
            ended = command.end()
        if len(case.seen[-1]) < len(case.expected.results):
            case.require_error(ended, "cannot|readonly|unable")
        case.look()
    finally:
        for each in _folders(folder):
            each.chmod(USUAL)
        if (store := folder / case.subject.store).exists():
            store.chmod(0o644)
    case.did.append(f"before, {in_words([stored])}, and the store alone")


def _folders(folder: Path) -> list[Path]:
    return [folder, *(path for path in folder.iterdir() if path.is_dir())]


def full_output(case: Case) -> None:
    """Let nothing be written to standard output: it is full, or closed."""
    words = [word for word in case.subject.words if word != "--quiet"] + ["--workers", "1"]
    if not FULL.exists():
        raise LeftOutError(f"there is no {FULL}")
    for limits, output in ((Limits(closed=1), Path("/dev/null")), (Limits(), FULL)):
        with started(
            ("-m", "multisrt", *words), case.folder, limits=limits, output=output
        ) as command:
            ended = command.end()
            case.require_error(
                ended._replace(told=ended.told[-1:]),  # lines of progress come before
                "standard output",
                code=1,
            )
        case.require_tidy()
        rows = case.look()
        complete = 0 if limits.closed == 1 else len(case.expected.results)
        case.require(len(rows) == complete, f"{len(rows)} stored, not {complete}")
    case.did.append("standard output closed, and full")


# Clocks and memory ----------------------------------------------------------------------------


def set_back_clock(case: Case) -> None:
    """Set the clock back by an hour, several times in each process."""
    jumps = sorted(round(case.draws.uniform(0.0, JUMPS_S), 2) for _ in range(4))
    log = case.folder.with_name(f"{case.folder.name}-clock")
    environment = {
        "PYTHONPATH": str(CLOCK),
        "CLOCK_JUMPS": " ".join(map(str, jumps)),
        "CLOCK_LOG": str(log),
    }
    log.unlink(missing_ok=True)
    with case.running(environment=environment) as command:
        case.require_success(command.end())
        case.require_gone(command)
    case.require(len(log.read_text().split()) >= 2, "no worker had a clock that was set back")
    log.unlink()
    wrong = [key for key, row in case.look().items() if not 0.0 <= row.elapsed_s < 600.0]
    case.require(not wrong, f"times by the clock: {wrong}")
    case.did.append(f"by an hour at {', '.join(map(str, jumps))} s of each process")


def short_memory(case: Case) -> None:
    """Let a process that makes runs allocate hardly more: what it makes may fail, the rest not."""
    moments, margins = [], case.draws.sample(MARGINS_KB, 2)
    for margin_kb in margins:
        with case.running() as command:
            moments.append(case.reach(command))
            _limit_memory(case.draws.choice(workers(command)), margin_kb)
            ended = command.end()
            case.require_gone(command)
        failed = [key for key, row in case.look().items() if not row.result[1]]
        case.require(len(failed) <= len(moments), f"more than one failed: {failed}")
        if ended.code == 2:
            case.require_error(ended, "MemoryError|ended before it was ready")
        else:
            # Exit code 3: some runs did not succeed.
            case.require_success(ended, (3,) if failed else ())
            case.require(len(case.seen[-1]) == len(case.expected.results), "some were not made")
            break
    margins = margins[: len(moments)]
    case.did.append(f"{', '.join(map(str, margins))} kB more {in_words(moments)}")


def _limit_memory(pid: int, margin_kb: int) -> None:
    try:
        size_kb = int(Path(f"/proc/{pid}/statm").read_text().split()[0])
        size_kb *= resource.getpagesize() // 1024
        limit = 1024 * (size_kb + margin_kb)
        resource.prlimit(pid, resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
    except (OSError, ValueError):
        raise LateError("a worker had ended before it was limited") from None


# Several commands -----------------------------------------------------------------------------


def two_runners(case: Case) -> None:
    """Give the command twice at the same time, and again while it runs."""
    with case.running() as one, case.running() as other:
        one.wait_until(lambda: case.has_store(one) or case.has_store(other), "one had the store")
        first, second = (one, other) if case.has_store(one) else (other, one)
        first.send(signal.SIGSTOP)  # it is there until the others have looked
        case.require_error(second.end(), "another process")
        first.send(signal.SIGCONT)
        stored = case.reach(first)
        first.send(signal.SIGSTOP)
        with case.running() as third:
            case.require_error(third.end(), f"another process.*process {first.popen.pid}")
        first.send(signal.SIGCONT)
        case.require_success(first.end())
        case.require_gone(first)
    case.require_tidy()
    case.look()
    case.did.append(f"at the same time, and {in_words([stored])}")


BREAKAGES: Final[dict[str, Callable[[Case], None]]] = {
    "killed-runner": killed_runner,
    "killed-worker": killed_worker,
    "sigterm": terminated,
    "sighup": hung_up,
    "sigint": interrupted,
    "full-disk": full_disk,
    "read-only": read_only,
    "full-output": full_output,
    "clock": set_back_clock,
    "memory": short_memory,
    "two-runners": two_runners,
}
"""The breakages, in the order in which they are tried."""
