"""The results of runs, one a line of a JSONL file, so that a grid of them can go on later."""

from __future__ import annotations

from pathlib import Path
from typing import Generic, Literal, TypeVar

import msgspec

from multisrt.geometry.errors import InvalidInputError

Status = Literal["complete", "stalled", "out_of_time", "over_limit", "error"]


class Measures(msgspec.Struct, frozen=True, kw_only=True):
    """What is kept of a run's metrics; `multisrt.metrics.Metrics` says what they are.

    Each benchmark adds those that it needs, under the names that they have there.
    """

    exploration_time_s: float | None
    total_distance_m: float
    coverage: float
    collisions: int


CaseT = TypeVar("CaseT", bound=msgspec.Struct)
MeasuresT = TypeVar("MeasuresT", bound=Measures)


class Row(msgspec.Struct, Generic[CaseT, MeasuresT], frozen=True, kw_only=True):
    """One run: how it ended, and what was measured unless it failed before its end.

    `program` is the digest of the source that made it, `seconds` the time that it took.
    """

    case: CaseT
    status: Status
    reason: str
    measures: MeasuresT | None
    seconds: float
    program: str

    @property
    def failed(self) -> bool:
        """Whether it has to be looked at: not complete, or a collision."""
        return self.status != "complete" or self.measures is None or self.measures.collisions > 0


def read(
    path: Path, case: type[CaseT], measures: type[MeasuresT]
) -> dict[CaseT, Row[CaseT, MeasuresT]]:
    """Read the rows that are there; of a run that was repeated, the last counts.

    Raises
    ------
    InvalidInputError
        If a line is no row. A last line that was cut short by an interruption is left out.
    """
    rows: dict[CaseT, Row[CaseT, MeasuresT]] = {}
    if not path.exists():
        return rows
    decoder = msgspec.json.Decoder(Row[case, measures])  # type: ignore[valid-type]
    lines = path.read_bytes().splitlines(keepends=True)
    for number, line in enumerate(lines, 1):
        try:
            row = decoder.decode(line)
        except msgspec.MsgspecError as error:
            if number == len(lines) and not line.endswith(b"\n"):
                break
            raise InvalidInputError(
                f"{path}:{number}: not a result of this benchmark: {error}; remove the line, or "
                "write to another file with --out"
            ) from None
        rows[row.case] = row
    return rows


def append(path: Path, row: Row[CaseT, MeasuresT]) -> None:
    """Write a row at the end, in place of a last line that was cut short."""
    with path.open("ab+") as file:
        if file.tell() > 0:
            file.seek(0)
            file.truncate(file.read().rfind(b"\n") + 1)
        file.write(msgspec.json.encode(row) + b"\n")
