# SPDX-License-Identifier: Apache-2.0
"""Follows a run in progress through the live copy next to its record."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Callable

from .database import follow_links, live_path, open_database, record_path_from_copy
from .errors import BeingWritten, RecordError
from .info import read_info
from .record import Record, read_part, read_record, run_id_from_status
from .table import make_table, to_pandas

if TYPE_CHECKING:
    import pandas

_CLOSE_TIMEOUT_S = 10.0  # from the removal of the live copy to the closing of the record


class _AnotherRunError(RecordError):
    """The file belongs to another run, earlier or later than this one."""


def _read_run_id(record_path: Path) -> str:
    """Returns the ID of the run, from the record, or from its status file while the record is being written. Returns ""
    if it is unknown."""
    try:
        with open_database(record_path) as database:
            return read_info(database).id
    except RecordError:
        return run_id_from_status(record_path)


def _check_run(record: Record, run: str, path: Path) -> None:
    if run not in ("", record.info.id):
        raise _AnotherRunError(f"{path}: belongs to another run")


def _rows_from_slot(record: Record, first: int) -> pandas.DataFrame:
    """Returns the seconds of a whole record from the slot `first` on."""
    frame = to_pandas(make_table(record, removes_first_hold=False))
    return frame[frame.index >= first]


def _next_slot(record: Record, first: int) -> int:
    last = int(record.slot[-1]) if record.slot.size else first - 1
    return max([last, *(gap.last for gap in record.gaps)]) + 1


def _read_if_closed(record_path: Path) -> Record | None:
    """Returns the whole record, or None if it is being written. If the writer died, the live copy still exists."""
    try:
        with open_database(record_path):
            pass
    except RecordError:
        return None
    try:
        return read_record(record_path)
    except BeingWritten:  # in another part
        return None


def follow(path: str | os.PathLike[str], *, every_s: float = 1.0,
           sleep: Callable[[float], None] = time.sleep) -> Iterator[pandas.DataFrame]:
    """Yields the existing seconds of a run, then new seconds as they arrive, as DataFrames like those of `to_pandas`.
    Ends after the last second of the run.

    Reads the live copy, RUN.live.db, every `every_s` seconds, and checks whether the record itself is still being
    written. If the Earth rate is unknown, nothing is subtracted from the bias, because the first hold may not have
    ended. Raises `BeingWritten` if the run is active but has no live copy, and `RecordError` if another run replaces
    it."""
    record_path = record_path_from_copy(follow_links(path))
    live = live_path(record_path)
    first, waited, run = 0, 0.0, ""
    while True:
        try:
            with open_database(live) as database:
                part = read_part(database, first)
            _check_run(part, run or _read_run_id(record_path), live)
            run, waited = part.info.id, 0.0
        except RecordError as trouble:
            has_copy = live.exists() and not isinstance(trouble, _AnotherRunError)
            try:
                if has_copy:  # the program may be replacing it
                    raise
                whole = read_record(record_path)
                _check_run(whole, run, record_path)
            except RecordError as error:
                is_changing = has_copy or isinstance(error, BeingWritten)  # copy replaced, record closing, or no copy
                if not is_changing or waited >= _CLOSE_TIMEOUT_S:
                    raise
                waited += every_s
                sleep(every_s)
                continue
            if (rest := _rows_from_slot(whole, first)).size:
                yield rest
            return
        if (after := _next_slot(part, first)) > first:
            yield to_pandas(make_table(part, removes_first_hold=False, first=first))
            first = after
        elif (closed := _read_if_closed(record_path)) is not None:
            _check_run(closed, run, record_path)
            if (rest := _rows_from_slot(closed, first)).size:
                yield rest
            return
        sleep(every_s)
