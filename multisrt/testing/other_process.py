"""The runs of a checked explorer once more in another process, where sets have another order.

Within one process, equal sets of text have one order; every process has its own. So an explorer
that goes by the order of a set repeats its runs until the program is started again.

`python -m multisrt.testing.other_process REFERENCE` reads specs from standard input, as a list in
JSON, and writes the digests of their runs to standard output.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence

import msgspec

from multisrt.experiments.modules import reference_of
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.loading import import_reference
from multisrt.robots.registry import is_built_in
from multisrt.robots.strategy import Strategy
from multisrt.simulation.simulate import simulate
from multisrt.spec import RunSpec

MIN_LIMIT_S = 120.0
"""Seconds that the other process may take at least: it may have to compile kernels."""


def digests_elsewhere(
    strategy: Strategy, specs: Sequence[RunSpec], limit_s: float
) -> tuple[str, ...]:
    """Return the digests of runs that another process makes.

    Parameters
    ----------
    strategy : Strategy
        What the specs name.
    specs : sequence of RunSpec
        The runs.
    limit_s : float
        Seconds that they may take, if that is more than `MIN_LIMIT_S`.

    Returns
    -------
    tuple of str
        One digest for each; fewer if the process ended early.

    Raises
    ------
    InvalidInputError
        If another process cannot import the strategy; the message says why.
    """
    reference = "" if is_built_in(strategy.name) else reference_of(strategy)
    other_order = "1" if os.environ.get("PYTHONHASHSEED") != "1" else "2"
    path = os.pathsep.join(folder or os.getcwd() for folder in sys.path)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "multisrt.testing.other_process", reference],
            input=msgspec.json.encode([spec.to_json() for spec in specs]),
            capture_output=True,
            env={**os.environ, "PYTHONHASHSEED": other_order, "PYTHONPATH": path},
            timeout=max(MIN_LIMIT_S, limit_s),
            check=False,
        )
    except subprocess.TimeoutExpired:
        return ()
    if done.returncode == 2:
        raise InvalidInputError(done.stderr.decode(errors="replace").strip().rpartition("\n")[2])
    return tuple(done.stdout.decode().split())


def main(reference: str) -> None:
    """Make the runs that standard input names.

    Parameters
    ----------
    reference : str
        What to import for their strategy; empty if it is built in.
    """
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # Whatever strategies print is no answer.
    try:
        if reference:
            import_reference(reference)
    except InvalidInputError as error:
        print(error, file=sys.stderr)
        raise SystemExit(2) from None
    for text in msgspec.json.decode(sys.stdin.buffer.read(), type=list[str]):
        print(simulate(RunSpec.from_json(text)).footer.digest, file=answers, flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
