# SPDX-License-Identifier: Apache-2.0
"""Opens one file of a record for reading. Changes, creates or removes no file."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
import stat
import struct
import tempfile
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Iterator
from urllib.parse import quote

from .errors import BeingWritten, NotARecord, RecordError

try:
    import fcntl
except ImportError:  # not POSIX: only SQLite's own locks are used
    fcntl = None  # type: ignore[assignment]

APPLICATION_ID = 0x67797274  # "gyrt"
USER_VERSION = 1
SCHEMA = "gyrotherm-run/1"
TABLES = ("meta", "unit", "axis", "unit_value", "channel", "segment", "list", "sample", "fault", "event", "gap",
          "frames")
_LIVE = ".live.db"
_FIRST_LOCKED_BYTE, _LOCKED_BYTES = 0x40000002, 510  # where SQLite keeps its shared locks


def live_path(path: str | os.PathLike[str]) -> Path:
    """Returns the path of the live copy that exists next to a record while the record is being written.

    >>> live_path("data/ramp.db").as_posix()
    'data/ramp.live.db'
    """
    record = Path(path)
    return record.with_name(record.name.removesuffix(".db") + _LIVE)


def record_path_from_copy(path: str | os.PathLike[str]) -> Path:
    """Returns the record of a live copy. Returns any other path unchanged.

    >>> record_path_from_copy("data/ramp.live.db").as_posix()
    'data/ramp.db'
    """
    copy = Path(path)
    return copy.with_name(copy.name.removesuffix(_LIVE) + ".db") if copy.name.endswith(_LIVE) else copy


def follow_links(path: str | os.PathLike[str]) -> Path:
    """Returns the record that a path leads to. Its continuation files and live copy are named after it, not after a
    link to it."""
    record, most_links = Path(path), 40
    while most_links > 0 and record.is_symlink() and not record.name.endswith(_LIVE):
        record, most_links = record.parent / record.readlink(), most_links - 1
    return record


def _being_written_error(path: Path) -> BeingWritten:
    writer = ""
    try:
        status = json.loads(Path(f"{path}.status").read_text(encoding="utf-8"))
        if status.get("being_written") and status.get("pid"):
            writer = f" (process {status['pid']})"
    except (OSError, ValueError, AttributeError):
        pass
    has_copy = live_path(path).exists()
    remedy = "gyrotherm.follow() yields new seconds as they arrive" if has_copy else "open it after the run has ended"
    return BeingWritten(f"{path}: is being written by another program{writer}; {remedy}")


@contextmanager
def _shared_lock(path: Path) -> Iterator[None]:
    """Holds a shared lock on the file. Raises `BeingWritten` if a writer has its exclusive lock."""
    with open(path, "rb") as file:
        if fcntl is not None and hasattr(fcntl, "F_OFD_SETLK"):
            lock = struct.pack("hhqqi4x", fcntl.F_RDLCK, os.SEEK_SET, _FIRST_LOCKED_BYTE, _LOCKED_BYTES, 0)
            try:
                fcntl.fcntl(file, fcntl.F_OFD_SETLK, lock)
            except (BlockingIOError, PermissionError):
                raise _being_written_error(path) from None
            except OSError:  # a file system without locks
                pass
        yield


def _connect(path: Path, option: str) -> sqlite3.Connection:
    address = f"file:{quote(os.fsencode(path.absolute()))}?{option}"
    connection = sqlite3.connect(address, uri=True, timeout=2, isolation_level=None)
    connection.execute("PRAGMA trusted_schema = OFF")
    return connection


def _check(database: sqlite3.Connection, path: Path) -> None:
    if database.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise NotARecord(f"{path}: not a gyrotherm record")
    version = database.execute("PRAGMA user_version").fetchone()[0]
    if version != USER_VERSION:
        raise NotARecord(f'{path}: schema "gyrotherm-run/{version}", expected "{SCHEMA}"')
    tables = {name for name, in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if missing := [table for table in TABLES if table not in tables]:
        raise NotARecord(f'{path}: not a gyrotherm record: table "{missing[0]}" is missing')
    schema = database.execute("SELECT value FROM meta WHERE key = 'schema'").fetchone()
    if schema is None or schema[0] != SCHEMA:
        raise NotARecord(f'{path}: schema "{schema[0] if schema else ""}", expected "{SCHEMA}"')


@contextmanager
def _connection(path: Path) -> Iterator[sqlite3.Connection]:
    """Connects to a database without creating files next to it.

    - Not in write-ahead mode: the file is closed, and is read in place.
    - Write-ahead mode with an index: a live copy, which is read while its writer continues.
    - Write-ahead mode without an index and with an empty log: the file is read as immutable.
    - Write-ahead mode without an index but with a log: the writer died. A temporary copy of file and log is read."""
    path = path.resolve()  # RUN.live.db is a link; log and index are next to its target
    log, index = Path(f"{path}-wal"), Path(f"{path}-shm")
    with open(path, "rb") as file:
        in_wal_mode = file.read(20)[18:19] == b"\x02" or (log.exists() and log.stat().st_size > 0)
    if not in_wal_mode or index.exists():
        with closing(_connect(path, "mode=ro")) as database:
            yield database
    elif not log.exists() or log.stat().st_size == 0:
        with closing(_connect(path, "mode=ro&immutable=1")) as database:
            yield database
    else:
        with tempfile.TemporaryDirectory(prefix="gyrotherm-") as folder:
            copy = Path(folder) / "record.db"
            shutil.copyfile(path, copy)
            shutil.copyfile(log, f"{copy}-wal")
            with closing(_connect(copy, "mode=ro")) as database:
                yield database


@contextmanager
def open_database(path: Path) -> Iterator[sqlite3.Connection]:
    """Connects to one file of a record and checks that it is one. Raises `BeingWritten` or `RecordError`."""
    try:
        mode = path.stat().st_mode
    except OSError as error:
        raise RecordError(f"{path}: {error.strerror or error}, expected a gyrotherm record") from None
    if not stat.S_ISREG(mode):
        raise NotARecord(f"{path}: is not a regular file, expected a gyrotherm record")
    if os.path.lexists(f"{path}-journal"):
        raise NotARecord(f"{path}: a journal exists next to it: another program was interrupted while it changed the "
                         "record; restore the record from a copy")
    try:
        with _shared_lock(path), _connection(path) as database:
            database.execute("BEGIN")  # all queries read the same state
            _check(database, path)
            yield database
    except sqlite3.OperationalError as error:
        if "locked" in str(error) or "busy" in str(error):
            raise _being_written_error(path) from None
        raise RecordError(f"{path}: {error}") from None
    except sqlite3.DatabaseError as error:
        kind = NotARecord if getattr(error, "sqlite_errorname", "") == "SQLITE_NOTADB" else RecordError
        raise kind(f"{path}: {error}, expected a gyrotherm record") from None
    except OSError as error:
        raise RecordError(f"{path}: {error.strerror or error}") from None
