"""Repeat the runs of a checked explorer in another process, where sets iterate differently.

Equal sets of strings iterate in the same order within one process, but not in another one. So an
explorer that depends on the order of a set repeats its runs until the program is restarted.

`python -m multisrt.testing.other_process [--path=FOLDER ...] REFERENCE` adds the folders to the end
of its import path, reads specs from standard input, as a list in JSON, and writes the digests of
their runs to standard output. It ends with code 2 if it cannot import what makes them.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence

import msgspec

from multisrt.experiments.import_path import extend_path, python_command
from multisrt.experiments.modules import reference_of
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.loading import import_reference
from multisrt.robots.registry import is_built_in, strategies
from multisrt.robots.strategy import Strategy
from multisrt.simulation.simulate import simulate
from multisrt.spec import RunSpec

MIN_LIMIT_S = 120.0
"""Minimum time limit of the other process in seconds: it may have to compile kernels."""

CANNOT_IMPORT = 2
"""Exit code of the other process if it cannot import the strategy."""

_IS_OTHER = "MULTISRT_REPEATS_A_CHECK"
"""Variable of the environment that is set in the other process."""


def require_first() -> None:
    """Check that this is not the other process, which repeats runs and does not check again.

    Raises
    ------
    InvalidInputError
        If it is: what it imports begins a check, which would begin another process, and so on.
    """
    if _IS_OTHER in os.environ:
        raise InvalidInputError(
            "it begins a check whenever it is imported; put that under if __name__ == '__main__'"
        )


def digests_elsewhere(
    own: Strategy, specs: Sequence[RunSpec], limit_s: float
) -> tuple[tuple[str, ...], str]:
    """Return the digests of runs that another process makes.

    Parameters
    ----------
    own : Strategy
        What the specs name.
    specs : sequence of RunSpec
        The runs.
    limit_s : float
        Seconds that they may take, if that is more than `MIN_LIMIT_S`.

    Returns
    -------
    (digests, reason)
        One digest for each; fewer if the process ended early, with the reason in words.

    Raises
    ------
    InvalidInputError
        If another process cannot import the strategy; the message says why.
    """
    reference = "" if is_built_in(own.name) else reference_of(own)
    other_order = "1" if os.environ.get("PYTHONHASHSEED") != "1" else "2"
    limit_s = max(MIN_LIMIT_S, limit_s)
    try:
        done = subprocess.run(
            python_command("multisrt.testing.other_process", [reference]),
            input=msgspec.json.encode([spec.to_json() for spec in specs]),
            capture_output=True,
            env={**os.environ, "PYTHONHASHSEED": other_order, _IS_OTHER: "1"},
            timeout=limit_s,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return (), f"it takes more than {limit_s:.0f} s there"
    said = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
    if done.returncode == CANNOT_IMPORT:
        raise InvalidInputError(said)
    return tuple(done.stdout.decode().split()), said or f"it exits with {done.returncode} there"


def main(arguments: Sequence[str]) -> None:
    """Make the runs that standard input names.

    Parameters
    ----------
    arguments : sequence of str
        Folders to add to the import path, and what to import for their strategy; empty if it is
        built in.
    """
    (reference,) = extend_path(arguments)
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # Whatever strategies print is no answer.
    specs = msgspec.json.decode(sys.stdin.buffer.read(), type=list[str])
    try:
        if reference:
            import_reference(reference)
        names = [each.name for each in strategies()]
        for name in {RunSpec.from_json(text).strategy for text in specs}.difference(names):
            raise InvalidInputError(f"{reference} has no strategy {name!r} and registers none")
    except InvalidInputError as error:
        print(error, file=sys.stderr)
        raise SystemExit(CANNOT_IMPORT) from None
    for text in specs:
        try:
            print(simulate(RunSpec.from_json(text)).footer.digest, file=answers, flush=True)
        except ExplorerDefect as defect:
            raise SystemExit(defect.what) from None


if __name__ == "__main__":
    main(sys.argv[1:])
