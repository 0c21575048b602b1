"""How a command ends at a signal, and if its output cannot be written."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Any, Final, NoReturn, Self

import click

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

NO_OUTPUT: Final = 1
"""Exit code if standard output cannot be written."""

BY_SIGNAL: Final = 128
"""Exit code of a command that a signal ended, less the number of the signal."""

TERMINATIONS: Final = (signal.SIGTERM, signal.SIGHUP)
"""Signals at which a command tidies up and ends, as at an interrupt from the keyboard."""

REPEATED_S: Final = 1.0
"""Time within which another of them is the same request (s): a terminal that closes sends two."""


class Terminations:
    """As a context manager, raises KeyboardInterrupt at the signals `TERMINATIONS`.

    A signal that the process was told to ignore, as by ``nohup``, is ignored still. In another
    thread than the main one nothing is changed.

    Attributes
    ----------
    received : signal.Signals or None
        The signal that came first.
    is_interrupted : bool
        Whether there was an interrupt from the keyboard. The KeyboardInterrupt may have become
        another error: a SystemError in compiled code, an ImportError where an extension module is
        imported, an OSError if the terminal is closed.
    """

    def __init__(self) -> None:
        self.received: signal.Signals | None = None
        self.is_interrupted = False
        self._received_s = 0.0
        self._handled: list[signal.Signals] = []

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in TERMINATIONS:
                if signal.getsignal(number) is signal.SIG_DFL:
                    signal.signal(number, self._interrupt)
                    self._handled.append(number)
            if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
                signal.signal(signal.SIGINT, self._note_interrupt)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number in self._handled:
            signal.signal(number, signal.SIG_DFL)
        if signal.getsignal(signal.SIGINT) == self._note_interrupt:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _note_interrupt(self, number: int, frame: FrameType | None) -> None:
        self.is_interrupted = True
        signal.default_int_handler(number, frame)

    def _interrupt(self, number: int, _frame: FrameType | None) -> None:
        now_s = time.monotonic()
        if self.received is None:
            self.received = signal.Signals(number)
        elif now_s - self._received_s < REPEATED_S:
            return
        self._received_s = now_s
        raise KeyboardInterrupt


class _OutputError(OSError):
    """Standard output could not be written."""


class _Output(io.FileIO):
    """Standard output, whose errors are told from those of other files."""

    def write(self, data: ReadableBuffer, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            raise _OutputError(error.errno, error.strerror) from None


@contextmanager
def standard_streams() -> Iterator[None]:
    """Exit with a message if standard output cannot be written: at once if it is closed.

    If what reads it has gone, as ``head`` does, that is no error to report: the exit code tells it.
    """
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115, open until the process ends
    if sys.stdout is None:
        fail("error: standard output is closed; redirect it, if only to /dev/null", NO_OUTPUT)
    if sys.stdout is (stream := sys.__stdout__) and stream is not None:
        sys.stdout = _output_to(stream)
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except _OutputError as error:
        # What is left in the buffer is not written again when the interpreter ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if error.errno == errno.EPIPE:
            raise SystemExit(NO_OUTPUT) from None
        fail(f"error: cannot write to standard output: {error.strerror}", NO_OUTPUT)


def _output_to(stream: io.TextIOWrapper[Any]) -> io.TextIOWrapper[io.BufferedWriter]:
    return io.TextIOWrapper(
        io.BufferedWriter(_Output(stream.fileno(), "w", closefd=False)),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.isatty(),
    )


def fail(message: str, code: int) -> NoReturn:
    """Print a message on standard error, if that can be written, and exit with a code."""
    with suppress(OSError):
        click.echo(message, err=True)
    raise SystemExit(code)
