"""Mutations of SQLite files: of their rows, tables, triggers, views and headers, or of their bytes.

Seeds and kept inputs may be texts of SQL, from which the files are made.
"""

from __future__ import annotations

import json
import math
import re
import sqlite3
from collections.abc import Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, Final

import msgspec
from numpy.random import Generator

from benchmarks.fuzz.mutations import of_bytes, of_text, pick
from benchmarks.fuzz.trees import UNREADABLE, changed
from multisrt.experiments.provenance import program_digest, provenance

PAGE_BYTES: Final = 1024
"""Size of a page of the files that are made of SQL."""

CELLS: Final[tuple[Any, ...]] = (
    *(None, 0, 1, -1, 2, 2**31, 2**63 - 1, -(2**63), 0.5, -0.5, 1e308, -1e308, math.inf, -math.inf),
    *(5e-324, "", "a", "0", "nan", "1e999", "null", "[]", "{}", "[[", "\0", "\x1b[2J", "a\nb"),
    *("\u202e", "x" * 20_000, b"", b"\xff\xfe", b"[]", b"\0" * 20_000, "../..", "/dev/zero"),
)
"""Replacements of values; SQLite stores no number that is none, and takes it for NULL."""

OBJECTS: Final = (
    "CREATE TRIGGER t AFTER INSERT ON {0} BEGIN DELETE FROM {0}; END",
    "CREATE TRIGGER t BEFORE UPDATE ON {0} BEGIN SELECT RAISE(ABORT, 'a\nb'); END",
    "CREATE VIEW v AS SELECT * FROM {0}",
    "CREATE TABLE v (a, b)",
    "CREATE UNIQUE INDEX i ON {0} (1)",
    "ALTER TABLE {0} RENAME TO v; CREATE VIEW {0} AS SELECT * FROM v",
    "ALTER TABLE {0} RENAME TO v; CREATE VIEW {0} AS SELECT v.* FROM v, v AS w, v AS x",
    "ALTER TABLE {0} RENAME TO v; CREATE VIEW {0} AS WITH RECURSIVE w AS "
    "(SELECT * FROM v UNION ALL SELECT * FROM w) SELECT * FROM w",
    "ALTER TABLE {0} ADD COLUMN v",
    "ALTER TABLE {0} ADD COLUMN v AS (hex(zeroblob(100000000)))",
    "ALTER TABLE {0} RENAME TO v",
    "DROP TABLE {0}",
    "DELETE FROM {0}",
    "DELETE FROM {0} WHERE rowid % 2",
)
"""Statements about a table; they are executed as far as SQLite accepts them."""


def from_sql(path: Path) -> tuple[str, bytes]:
    """Return suffix and content of a file, made from SQL if its suffix is ``.sql``.

    In the text ``@program@`` and ``@provenance@`` stand for those of this version of the program.
    """
    if path.suffix != ".sql":
        return path.suffix, path.read_bytes()
    made_by = msgspec.json.encode(provenance()).decode()
    text = path.read_text(encoding="utf-8").replace("@program@", program_digest("campaign"))
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.execute(f"PRAGMA page_size = {PAGE_BYTES}")
        connection.executescript(text.replace("@provenance@", made_by.replace("'", "''")))
        return ".sqlite", connection.serialize()


def of_sqlite(
    content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]
) -> bytes:
    """Change rows, tables or the header of an SQLite file, or its bytes."""
    if rng.random() < 0.2 or not content.startswith(b"SQLite format 3"):
        return of_bytes(content, rng, seeds, words)
    try:
        with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
            connection.deserialize(content)
            _damage(connection, rng, words)
            return connection.serialize()
    except (sqlite3.Error, OverflowError, UnicodeDecodeError):  # damaged before
        return of_bytes(content, rng, seeds, words)


def _damage(connection: sqlite3.Connection, rng: Generator, words: Sequence[bytes]) -> None:
    names = "SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name"
    tables = [_quoted(name) for (name,) in connection.execute(names)]
    kind = int(rng.integers(20))
    if kind == 0 or not tables:
        header = pick(rng, ("user_version", "application_id"))
        connection.execute(f"PRAGMA {header} = {int(rng.integers(-1, 4))}")
        return
    table = pick(rng, tables)
    columns = [_quoted(row[1]) for row in connection.execute(f"PRAGMA table_info({table})")]
    if kind <= 3 or not columns:
        with suppress(sqlite3.OperationalError):
            connection.executescript(pick(rng, OBJECTS).format(table))
        return
    column = pick(rng, columns)
    match kind:
        case 4:
            _loosen(connection, table)
            with suppress(sqlite3.OperationalError):
                connection.execute(f"ALTER TABLE {table} DROP COLUMN {column}")
        case 5:
            other = pick(rng, (_quoted("v"), *columns))
            with suppress(sqlite3.OperationalError):
                connection.execute(f"ALTER TABLE {table} RENAME COLUMN {column} TO {other}")
        case 6:
            _loosen(connection, table)
            for _ in range(pick(rng, (1, 1, 5))):
                connection.execute(f"INSERT INTO {table} SELECT * FROM {table}")
        case _:
            _change_cells(connection, rng, words, table, column)


def _change_cells(
    connection: sqlite3.Connection, rng: Generator, words: Sequence[bytes], table: str, column: str
) -> None:
    rows = connection.execute(f"SELECT {column} FROM {table}").fetchall()
    if not rows:
        return
    at = int(rng.integers(len(rows)))
    before = rows[at][0]
    after = _other(before, rng, words)
    where = "" if rng.random() < 0.2 else f"WHERE {column} IS ?1"
    change = f"UPDATE {table} SET {column} = ?2 {where}"
    values = (before, after) if where else (None, after)
    try:
        connection.execute(change, values)
    except sqlite3.IntegrityError:
        _loosen(connection, table)
        connection.execute(change, values)


def _other(before: Any, rng: Generator, words: Sequence[bytes]) -> Any:
    """Return another value: of a text that is JSON, often one with a changed tree."""
    if isinstance(before, str) and rng.random() < 0.7:
        try:
            tree = json.loads(before)
            if isinstance(tree, list | dict):
                return json.dumps(changed(tree, rng, words=words)).encode().decode()
        except UNREADABLE:
            pass
        text = of_text(before.encode(errors="replace"), rng, [b"a"], words)
        return text.decode(errors="replace")
    if isinstance(before, int | float) and rng.random() < 0.3:
        return before + int(rng.integers(-3, 4))
    return pick(rng, CELLS)


def _loosen(connection: sqlite3.Connection, table: str) -> None:
    """Replace a table by one with the same rows, and without types and constraints."""
    connection.execute(f"CREATE TABLE loose AS SELECT * FROM {table}")
    connection.execute(f"DROP TABLE {table}")
    connection.execute(f"ALTER TABLE loose RENAME TO {table}")


def _quoted(name: str) -> str:
    return '"' + re.sub('"', '""', name) + '"'
