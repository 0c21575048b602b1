"""The program of a worker, which makes one run after another.

`python -m multisrt.experiments.worker_program [--path=FOLDER ...] [MODULE ...]` adds the folders
to the end of its import path and imports the modules, then reads jobs from standard input and
writes answers to standard output, one JSON object a line (see `job`): one to each job, and before
it any number that say which kernels are being compiled.
Whatever strategies print goes to standard error. The program ends when its input ends, even in
the middle of a run.
"""

from __future__ import annotations

import faulthandler
import gc
import queue
import signal
import sys
import threading
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import msgspec

from multisrt.experiments.import_path import extend_path
from multisrt.experiments.job import Job, Made, Ready, Unable
from multisrt.experiments.memory import MemoryTrimmer
from multisrt.experiments.modules import import_modules
from multisrt.experiments.pipes import own_pipes, queue_lines, write_line
from multisrt.experiments.user_source import provenance_with
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.registry import is_built_in, strategies

ALLOCATIONS_PER_COLLECTION = 50_000
"""Allocations between two passes of the garbage collector, of which few find anything: most of
what a run allocates lives until it ends."""


def main(arguments: Sequence[str]) -> None:
    """Execute runs until standard input ends.

    Parameters
    ----------
    arguments : sequence of str
        Folders to add to the import path, and modules or files to import before anything else.
    """
    modules = extend_path(arguments)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    jobs, answers = own_pipes()
    faulthandler.enable(all_threads=False)
    try:
        import_modules(modules)
        made_by = provenance_with(each for each in strategies() if not is_built_in(each.name))
    except InvalidInputError as error:
        write_line(answers, Unable(str(error)))
        return
    import multisrt.robots.explorers  # noqa: F401, what the first explorer would import
    from multisrt.experiments.mission import compilation_told, make_run

    gc.collect()
    gc.freeze()  # what was imported stays
    gc.set_threshold(ALLOCATIONS_PER_COLLECTION, 20, 50)
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=queue_lines, args=(jobs, lines), daemon=True).start()
    write_line(answers, Ready(made_by))
    tell = partial(write_line, answers)
    decoder = msgspec.json.Decoder(Job)
    trimmer = MemoryTrimmer()
    while True:
        job = decoder.decode(lines.get())
        path = Path(job.recording) if job.recording else None
        try:
            with compilation_told(tell):
                result = make_run(
                    job.run,
                    job.limits,
                    path,
                    only_failed=job.only_failed,
                    success_coverage=job.success_coverage,
                    horizon_s=job.horizon_s,
                )
        except InvalidInputError as error:
            write_line(answers, Unable(str(error)))
        else:
            write_line(answers, Made(result))
            trimmer.tidy()


if __name__ == "__main__":
    main(sys.argv[1:])
