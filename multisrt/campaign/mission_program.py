"""The program of a process that makes missions, one after another.

`python -m multisrt.campaign.mission_program [--path=FOLDER ...]` reads jobs from standard input and
writes answers to standard output, one JSON object a line (see `jobs`). Whatever is printed goes to
standard error; on SIGUSR1 the stacks of all threads do, too. The program ends when
its input ends, even in the middle of a run.
"""

from __future__ import annotations

import faulthandler
import queue
import signal
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import msgspec

from multisrt.campaign.failure import RECORDING_NAME, REPLAY_NAME
from multisrt.campaign.jobs import Answer, Attempt, Job, Make
from multisrt.campaign.mission import judge_recorded, make
from multisrt.experiments.import_path import extend_path
from multisrt.experiments.memory import MemoryTrimmer
from multisrt.experiments.pipes import own_pipes, queue_lines, write_line
from multisrt.geometry.errors import InvalidInputError, reason_of
from multisrt.recording import Recording
from multisrt.spec import RunSpec


def main(arguments: Sequence[str]) -> None:
    """Make missions until standard input ends.

    Parameters
    ----------
    arguments : sequence of str
        Folders to add to the import path.
    """
    extend_path(arguments)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    jobs, answers = own_pipes()
    faulthandler.enable(all_threads=False)
    faulthandler.register(signal.SIGUSR1, all_threads=True)
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=queue_lines, args=(jobs, lines), daemon=True).start()
    decoder = msgspec.json.Decoder(Job)
    trimmer = MemoryTrimmer()
    while True:
        write_line(answers, _answer(decoder.decode(lines.get()), answers))
        trimmer.tidy()


def _answer(job: Job, answers: IO[bytes]) -> Answer:
    if isinstance(job, Make):

        def on_draw(spec: RunSpec | None, refused: int) -> None:
            write_line(answers, Attempt(spec=spec, refused=refused))

        return Answer(verdict=make(job.seed, job.number, on_draw))
    verdict, recording = judge_recorded(job.spec)
    if job.folder and recording is not None:
        try:
            _keep(recording, Path(job.folder))
        except (InvalidInputError, OSError) as error:
            return Answer(verdict=verdict, unwritten=reason_of(error))
    return Answer(verdict=verdict)


def _keep(recording: Recording, folder: Path) -> None:
    from multisrt.replay import save_replay

    recording.save(folder / RECORDING_NAME)
    save_replay(recording, folder / REPLAY_NAME)


if __name__ == "__main__":
    main(sys.argv[1:])
