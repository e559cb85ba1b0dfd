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

from .errors import BeingWritten, NoRecord, RecordError

try:
    import fcntl
except ImportError:  # no POSIX: SQLite's own locks have to do
    fcntl = None  # type: ignore[assignment]

APPLICATION_ID = 0x67797274  # "gyrt"
USER_VERSION = 1
SCHEMA = "gyrotherm-run/1"
TABLES = ("meta", "unit", "axis", "unit_value", "channel", "segment", "list", "sample", "fault", "event", "gap",
          "frames")
_LIVE = ".live.db"
_FIRST_LOCKED_BYTE, _LOCKED_BYTES = 0x40000002, 510  # where SQLite keeps its shared locks


def live_path(path: str | os.PathLike[str]) -> Path:
    """The live copy that stands beside a record while it is being written.

    >>> live_path("data/ramp.db").as_posix()
    'data/ramp.live.db'
    """
    record = Path(path)
    return record.with_name(record.name.removesuffix(".db") + _LIVE)


def record_of_copy(path: str | os.PathLike[str]) -> Path:
    """The record beside which a live copy stands; another path as it is.

    >>> record_of_copy("data/ramp.live.db").as_posix()
    'data/ramp.db'
    """
    copy = Path(path)
    return copy.with_name(copy.name.removesuffix(_LIVE) + ".db") if copy.name.endswith(_LIVE) else copy


def record_behind(path: str | os.PathLike[str]) -> Path:
    """The record that a path leads to: its parts and its live copy go by its own name, not by that of a link to it."""
    record, most_links = Path(path), 40
    while most_links > 0 and record.is_symlink() and not record.name.endswith(_LIVE):
        record, most_links = record.parent / record.readlink(), most_links - 1
    return record


def _being_written(path: Path) -> BeingWritten:
    writer = ""
    try:
        status = json.loads(Path(f"{path}.status").read_text(encoding="utf-8"))
        if status.get("being_written") and status.get("pid"):
            writer = f" (process {status['pid']})"
    except (OSError, ValueError, AttributeError):
        pass
    has_copy = live_path(path).exists()
    how = "gyrotherm.follow() yields its seconds as they come" if has_copy else "open it when it is closed"
    return BeingWritten(f"{path}: is being written by another program{writer}; {how}")


@contextmanager
def _writers_kept_out(path: Path) -> Iterator[None]:
    """Holds a shared lock on the file; the run's writer has an exclusive one."""
    with open(path, "rb") as file:
        if fcntl is not None and hasattr(fcntl, "F_OFD_SETLK"):
            lock = struct.pack("hhqqi4x", fcntl.F_RDLCK, os.SEEK_SET, _FIRST_LOCKED_BYTE, _LOCKED_BYTES, 0)
            try:
                fcntl.fcntl(file, fcntl.F_OFD_SETLK, lock)
            except (BlockingIOError, PermissionError):
                raise _being_written(path) from None
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
        raise NoRecord(f"{path}: not a gyrotherm record")
    version = database.execute("PRAGMA user_version").fetchone()[0]
    if version != USER_VERSION:
        raise NoRecord(f'{path}: schema "gyrotherm-run/{version}", expected "{SCHEMA}"')
    there = {name for name, in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if missing := [table for table in TABLES if table not in there]:
        raise NoRecord(f'{path}: it has no table "{missing[0]}"')
    schema = database.execute("SELECT value FROM meta WHERE key = 'schema'").fetchone()
    if schema is None or schema[0] != SCHEMA:
        raise NoRecord(f'{path}: schema "{schema[0] if schema else ""}", expected "{SCHEMA}"')


@contextmanager
def _connected(path: Path) -> Iterator[sqlite3.Connection]:
    """Four cases. A closed file is read where it lies. One in write-ahead mode whose index is there is a live copy, and
    is read beside its writer. One without an index is looked at as it is if its log is empty; else the writer died, and
    a copy of the file and its log is read, since SQLite would make files beside the original."""
    path = path.resolve()  # RUN.live.db is a link, and log and index lie beside what it leads to
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
def opened(path: Path) -> Iterator[sqlite3.Connection]:
    """A connection to one file of a record, which has been seen to be one. Raises `BeingWritten` or `RecordError`."""
    try:
        mode = path.stat().st_mode
    except OSError as error:
        raise RecordError(f"{path}: {error.strerror or error}, expected a gyrotherm record") from None
    if not stat.S_ISREG(mode):
        raise NoRecord(f"{path}: is not a regular file, expected a gyrotherm record")
    if os.path.lexists(f"{path}-journal"):
        raise NoRecord(f"{path}: a journal exists next to it: another program was interrupted while it "
                       "changed the record, and the journal is not played back here")
    try:
        with _writers_kept_out(path), _connected(path) as database:
            database.execute("BEGIN")  # all that is read is of one moment
            _check(database, path)
            yield database
    except sqlite3.OperationalError as error:
        if "locked" in str(error) or "busy" in str(error):
            raise _being_written(path) from None
        raise RecordError(f"{path}: {error}") from None
    except sqlite3.DatabaseError as error:
        kind = NoRecord if getattr(error, "sqlite_errorname", "") == "SQLITE_NOTADB" else RecordError
        raise kind(f"{path}: {error}, expected a gyrotherm record") from None
    except OSError as error:
        raise RecordError(f"{path}: {error.strerror or error}") from None
