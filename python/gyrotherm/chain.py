# SPDX-License-Identifier: Apache-2.0
"""Detects changed files of a record: the rows are chained by SHA-256. The package checks only files that have a
continuation, which takes some seconds each. To check a whole record, use `gyrotherm status RUN.db --verify`."""

from __future__ import annotations

import hashlib
import heapq
import sqlite3
import struct
from collections.abc import Iterable, Iterator
from typing import Any

_DESCRIPTION = (
    ("meta", "SELECT key, value FROM meta WHERE key NOT IN ('outcome', 'chain_start', 'chain_end') ORDER BY key"),
    ("channel", "SELECT * FROM channel ORDER BY position"), ("unit", "SELECT * FROM unit ORDER BY position"),
    ("axis", "SELECT * FROM axis ORDER BY unit, position"),
    ("unit_value", "SELECT * FROM unit_value ORDER BY unit, position"),
    ("segment", "SELECT * FROM segment WHERE position < {described} ORDER BY position"),
    ("list", "SELECT * FROM list ORDER BY name, of, position"))
#: table, column that contains the second, rank within a second, sort column
_ROWS = (("sample", 0, 0, "slot"), ("gap", 1, 0, "first"), ("fault", 1, 1, "id"), ("event", 1, 2, "id"))
_INTEGER_LIMIT = 9.2e18  # just below 2^63, the limit of SQLite's integers


def _encode(value: Any) -> bytes:
    """Returns the bytes of a value that are hashed. A float that is an integer has the bytes of the integer.

    >>> _encode(3) == _encode(3.0), _encode("A"), _encode(None)
    (True, b't\\x01\\x00\\x00\\x00\\x00\\x00\\x00\\x00A', b'n')
    """
    if value is None or value != value:
        return b"n"
    if isinstance(value, str):
        text = value.encode("utf-8")
        return b"t" + struct.pack("<Q", len(text)) + text
    if isinstance(value, int):
        return b"i" + struct.pack("<q", value)
    if abs(value) < _INTEGER_LIMIT and value == int(value):
        return b"i" + struct.pack("<q", int(value))
    return b"r" + struct.pack("<d", value)


def next_head(head: bytes, table: str, values: Iterable[Any]) -> bytes:
    """Returns the head of the chain after a row."""
    return hashlib.sha256(head + _encode(table) + b"".join(map(_encode, values))).digest()


def described_segments(database: sqlite3.Connection) -> int:
    """Returns the number of segments that the description covers. Decisions of a self-ending run add the others."""
    row = database.execute("SELECT value FROM list WHERE name = 'goal' AND of = 'segments'").fetchone()
    return int(row[0] if row else database.execute("SELECT count(*) FROM segment").fetchone()[0])


def description_head(database: sqlite3.Connection) -> bytes:
    """Returns the start of the hash chain: the hash over all content written before the first second."""
    head = bytes(32)
    described = described_segments(database)
    for table, query in _DESCRIPTION:
        for row in database.execute(query.format(described=described)):
            head = next_head(head, table, row)
    return head


def rows_in_order(database: sqlite3.Connection) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """Yields the rows in the order of writing: for each second the sample or gap, then faults, then events."""
    def rows(position: int, table: str, key: int, rank: int, order: str) -> Iterator[Any]:
        for row in database.execute(f"SELECT * FROM {table} ORDER BY {order}"):
            yield (row[key], rank, position), table, row

    for _, table, row in heapq.merge(*(rows(i, *of) for i, of in enumerate(_ROWS)), key=lambda found: found[0]):
        yield table, row


def added_segments(database: sqlite3.Connection) -> dict[int, list[Any]] | None:
    """Returns the values of the segments that each decision adds, by the number of its event, or None if a segment
    belongs to no decision. A decision adds the segments up to the first one of the next decision."""
    described = described_segments(database)
    segments = database.execute("SELECT * FROM segment ORDER BY position").fetchall()
    decisions = database.execute(
        "SELECT id, segment FROM event WHERE kind = 'note' AND reaction IN ('continues', 'ends') AND segment >= ?"
        " ORDER BY id DESC", (described,)).fetchall()
    added, end = {}, len(segments)
    for event, first in decisions:
        added[event] = [value for segment in segments[first:end] for value in segment]
        end = min(first, end)
    return added if end == min(described, len(segments)) else None


def rows_head(database: sqlite3.Connection, start: bytes) -> bytes | None:
    """Returns the head of the chain after the last row, or None if the hash of a row is wrong."""
    head = start
    added = added_segments(database)
    if added is None:
        return None
    for table, row in rows_in_order(database):
        more = added.get(row[0], []) if table == "event" else []
        head = next_head(head, table, [*row[:-1], *more])
        if row[-1] != struct.unpack("<q", head[:8])[0]:
            return None
    return head


def is_intact(database: sqlite3.Connection) -> bool:
    """Returns True if the description, rows and end of the file match their hashes."""
    meta = dict(database.execute("SELECT key, value FROM meta").fetchall())
    start = description_head(database)
    if start.hex() != meta.get("chain_start"):
        return False
    head = rows_head(database, start)
    frames = database.execute("SELECT head, seen, lost, bad FROM frames").fetchone() or ("", 0, 0, 0)
    if head is None or head.hex() != (frames[0] or meta["chain_start"]):
        return False
    if database.execute("SELECT EXISTS(SELECT 1 FROM frames WHERE id <> 1)").fetchone()[0]:
        return False
    finished = meta.get("outcome") == "finished"
    return (next_head(head, "end", frames[1:]).hex() if finished else "") == (meta.get("chain_end") or "")
