# SPDX-License-Identifier: Apache-2.0
"""Whether a file of a record is as it was written: its rows are chained by SHA-256. Only files that others go on from
are looked at here, some seconds each; a whole record is for `gyrotherm status RUN.db --verify`."""

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
    ("segment", "SELECT * FROM segment ORDER BY position"), ("list", "SELECT * FROM list ORDER BY name, of, position"))
#: of each table the column that says the second, its rank within one, and by what it is sorted
_ROWS = (("sample", 0, 0, "slot"), ("gap", 1, 0, "first"), ("fault", 1, 1, "id"), ("event", 1, 2, "id"))
_LARGEST = 9.2e18  # of SQLite's integers, about


def _hashed(value: Any) -> bytes:
    """
    >>> _hashed(3) == _hashed(3.0), _hashed("A"), _hashed(None)
    (True, b't\\x01\\x00\\x00\\x00\\x00\\x00\\x00\\x00A', b'n')
    """
    if value is None or value != value:
        return b"n"
    if isinstance(value, str):
        text = value.encode("utf-8")
        return b"t" + struct.pack("<Q", len(text)) + text
    if isinstance(value, int):
        return b"i" + struct.pack("<q", value)
    if abs(value) < _LARGEST and value == int(value):
        return b"i" + struct.pack("<q", int(value))
    return b"r" + struct.pack("<d", value)


def link(head: bytes, table: str, values: Iterable[Any]) -> bytes:
    """The chain's head after a row."""
    return hashlib.sha256(head + _hashed(table) + b"".join(map(_hashed, values))).digest()


def description_head(database: sqlite3.Connection) -> bytes:
    """Returns the start of the hash chain: the hash over all content written before the first second."""
    head = bytes(32)
    for table, query in _DESCRIPTION:
        for row in database.execute(query):
            head = link(head, table, row)
    return head


def _in_order(database: sqlite3.Connection) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """The rows as they were written: of each second sample or gap, faults, events."""
    def rows(place: int, table: str, key: int, rank: int, order: str) -> Iterator[Any]:
        for row in database.execute(f"SELECT * FROM {table} ORDER BY {order}"):
            yield (row[key], rank, place), table, row

    for _, table, row in heapq.merge(*(rows(i, *of) for i, of in enumerate(_ROWS)), key=lambda found: found[0]):
        yield table, row


def rows_head(database: sqlite3.Connection, start: bytes) -> bytes | None:
    """The chain's head after the last row; None if a row does not fit."""
    head = start
    for table, row in _in_order(database):
        head = link(head, table, row[:-1])
        if row[-1] != struct.unpack("<q", head[:8])[0]:
            return None
    return head


def is_as_written(database: sqlite3.Connection) -> bool:
    """Returns true if description, rows and end of the file are consistent."""
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
    return (link(head, "end", frames[1:]).hex() if finished else "") == (meta.get("chain_end") or "")
