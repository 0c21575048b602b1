"""Pipes of a process that reads jobs from its standard input and answers on its standard output."""

from __future__ import annotations

import os
import queue
from typing import IO

import msgspec


def own_pipes() -> tuple[IO[bytes], IO[bytes]]:
    """Move the pipes to other descriptors, away from what strategies print and read.

    Returns
    -------
    (jobs, answers)
        What was standard input, and what was standard output. What is printed goes to standard
        error from now on, and nothing is there to be read.
    """
    jobs = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return jobs, answers


def queue_lines(jobs: IO[bytes], lines: queue.SimpleQueue[bytes]) -> None:
    """Queue the lines of the input and exit at its end; runs in a separate thread.

    Parameters
    ----------
    jobs : binary file
        The input.
    lines : queue.SimpleQueue
        Where its lines go.
    """
    while line := jobs.readline():
        lines.put(line)
    os._exit(0)


def write_line(answers: IO[bytes], answer: msgspec.Struct) -> None:
    """Write an answer as a line of JSON.

    Parameters
    ----------
    answers : binary file
        The output.
    answer : msgspec.Struct
        The answer.
    """
    answers.write(msgspec.json.encode(answer) + b"\n")
    answers.flush()
