# SPDX-License-Identifier: Apache-2.0
"""Follows a run in progress through the live copy next to its record."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Callable

from .database import live_path, opened, record_behind, record_of_copy
from .errors import BeingWritten, RecordError
from .info import read_info
from .record import Record, read_record, record_of, run_told_of
from .table import table_of, to_pandas

if TYPE_CHECKING:
    import pandas

_PATIENCE_S = 10.0  # for the record to be closed once its live copy is gone


class _AnotherRun(RecordError):
    """The file belongs to another run, earlier or later than this one."""


def _run_at(record_path: Path) -> str:
    """The run that a record is of: it says so itself, or its status file while it is being written. "": not known."""
    try:
        with opened(record_path) as database:
            return read_info(database).id
    except RecordError:
        return run_told_of(record_path)


def _check_run(record: Record, run: str, path: Path) -> None:
    if run not in ("", record.info.id):
        raise _AnotherRun(f"{path}: belongs to another run")


def _from_slot(record: Record, first: int) -> pandas.DataFrame:
    """The seconds of a whole record from a slot on."""
    frame = to_pandas(table_of(record, own_zero=False))
    return frame[frame.index >= first]


def _next_slot(record: Record, first: int) -> int:
    last = int(record.slot[-1]) if record.slot.size else first - 1
    return max([last, *(gap.last for gap in record.gaps)]) + 1


def _if_closed(record_path: Path) -> Record | None:
    """The whole record once nobody writes it: its writer may have died and left the live copy behind."""
    try:
        with opened(record_path):
            pass
    except RecordError:
        return None
    try:
        return read_record(record_path)
    except BeingWritten:  # in another part
        return None


def follow(path: str | os.PathLike[str], *, every_s: float = 1.0,
           sleep: Callable[[float], None] = time.sleep) -> Iterator[pandas.DataFrame]:
    """Yields the seconds of a run as they come, first all that there are: DataFrames like those of `to_pandas`. Ends
    when the run has ended and its last second has been yielded. Looks every `every_s` at the live copy, RUN.live.db;
    the record itself is only asked whether it is being written. Where the Earth's rate is not known nothing is removed
    from the bias: the first hold may not be over. Raises `BeingWritten` if the run goes on and has no live copy of its
    own, and `RecordError` if another run takes its place."""
    record_path = record_of_copy(record_behind(path))
    live = live_path(record_path)
    first, waited, run = 0, 0.0, ""
    while True:
        try:
            with opened(live) as database:
                part = record_of(database, first)
            _check_run(part, run or _run_at(record_path), live)
            run, waited = part.info.id, 0.0
        except RecordError as trouble:
            has_copy = live.exists() and not isinstance(trouble, _AnotherRun)
            try:
                if has_copy:  # and may be begun anew just now
                    raise
                whole = read_record(record_path)
                _check_run(whole, run, record_path)
            except RecordError as error:
                being_changed = has_copy or isinstance(error, BeingWritten)  # begun, closed, or never copied
                if not being_changed or waited >= _PATIENCE_S:
                    raise
                waited += every_s
                sleep(every_s)
                continue
            if (rest := _from_slot(whole, first)).size:
                yield rest
            return
        if (after := _next_slot(part, first)) > first:
            yield to_pandas(table_of(part, own_zero=False, first=first))
            first = after
        elif (closed := _if_closed(record_path)) is not None:
            _check_run(closed, run, record_path)
            if (rest := _from_slot(closed, first)).size:
                yield rest
            return
        sleep(every_s)
