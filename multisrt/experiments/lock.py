"""The lock that lets one process at a time write to a file."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path
from typing import IO

from multisrt.geometry.errors import InvalidInputError


class WriteLock:
    """The right to write to a file, held by one process at a time.

    It is a lock of the operating system on a file beside the one it protects: it is released when
    the process ends, however it ends.

    Parameters
    ----------
    path : Path
        The file to protect; the lock is taken at once, without waiting.

    Raises
    ------
    InvalidInputError
        If another process holds the lock, or the disk supports none.
    """

    def __init__(self, path: Path) -> None:
        self._path = path.with_name(path.name + ".lock")
        while True:
            try:
                file = self._path.open("a+")
            except OSError as error:
                raise InvalidInputError(f"cannot write {path}: {error.strerror}") from None
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                file.seek(0)
                holder = file.read().strip()
                file.close()
                raise InvalidInputError(
                    f"{path}: another process executes its runs now"
                    + (f" (process {holder})" if holder else "")
                    + "; wait for it, stop it, or choose another file"
                ) from None
            except OSError as error:
                file.close()
                raise InvalidInputError(
                    f"cannot lock {path}: {error.strerror}; choose a file on another disk"
                ) from None
            if self._is_mine(file):
                break
            file.close()  # its former holder has just removed this file
        self._file: IO[str] = file
        with suppress(OSError):  # the number serves messages only
            file.truncate(0)
            file.write(str(os.getpid()))
            file.flush()

    def _is_mine(self, file: IO[str]) -> bool:
        try:
            return os.path.samestat(os.fstat(file.fileno()), self._path.stat())
        except FileNotFoundError:
            return False

    def release(self) -> None:
        """Release the lock and remove its file."""
        with suppress(OSError):
            self._path.unlink()
        with suppress(OSError):  # closing writes what a full disk refused before
            self._file.close()
