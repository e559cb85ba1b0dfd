# SPDX-License-Identifier: Apache-2.0
"""A record read back: the columns of its seconds, raw, joined from all files that it consists of."""

from __future__ import annotations

import itertools
import json
import re
import sqlite3
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .chain import is_as_written
from .database import opened
from .errors import BeingWritten, NoRecord, RecordError
from .info import RunInfo, column_of, read_info

Numbers = NDArray[np.float64]

PHASES = ("ramping", "holding", "waiting for soak", "overdue", "complete")
STATES = ("execute", "suspended", "held", "aborting", "aborted", "stopped", "complete")
EVENT_COLUMNS = ("slot", "monotonic_ns", "utc_ns", "kind", "interlock", "reaction", "segment", "channel", "text")
FAULT_COLUMNS = ("slot", "channel", "kind", "where", "what")
_OF_EACH_RECORD = ("set_point_c", "chamber_air_c", "chamber_set_point_c")


@dataclass(frozen=True)
class Gap:
    """Slots without a sample, and why."""

    first: int
    last: int
    cause: str


@dataclass
class Record:
    """Columns of equal length, one row per sample in order of time; NaN where a reading was a fault."""

    info: RunInfo
    finished: bool
    slot: NDArray[np.int64]
    time_s: Numbers  #: since the run started: the slot; of an imported record the foreign one's own time
    utc_ns: Numbers  #: by the wall clock, less `info.started_utc_ns`; NaN if not known
    columns: dict[str, Numbers]  #: by their names in the table `sample`; raw
    segment: NDArray[np.int32]  #: −1: none
    cycle: NDArray[np.int32]  #: −1: none
    phase: NDArray[np.int8]  #: index into PHASES; −1: none
    state: NDArray[np.int8]  #: index into STATES; −1: none
    in_segment_ns: Numbers  #: NaN where no segment has a prompt
    gaps: list[Gap] = field(default_factory=list)
    events: list[tuple[Any, ...]] = field(default_factory=list)  #: EVENT_COLUMNS
    faults: list[tuple[Any, ...]] = field(default_factory=list)  #: FAULT_COLUMNS


@dataclass(frozen=True)
class Continuation:
    """What a file says of the one before it, which failed."""

    part: int
    before: str
    first: int  #: slots from here on stand in it
    cause: str


def channel_columns(info: RunInfo) -> list[str]:
    """Returns the columns of `sample` for the channels of the run."""
    names = [thermometer.name for thermometer in info.thermometers]
    for unit in info.units:
        names += [column_of(axis.label, "pulses") for axis in unit.axes]
        names += [column_of(unit.name, "interval_ns")]
        names += [f"{unit.name}.{value.name}" for value in unit.values]
    return names + [column_of(axis.label, "true_bias_deg_per_h") for axis in info.axes]


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _index(column: str, words: tuple[str, ...]) -> str:
    return f"CASE {column} " + " ".join(f"WHEN '{word}' THEN {i}" for i, word in enumerate(words)) + " ELSE -1 END"


def _samples(database: sqlite3.Connection, info: RunInfo, first: int) -> tuple[list[str], NDArray[np.float64]]:
    """Names, and a row of numbers for each; NaN for NULL. Numbers go through one iterator into one array: a list of
    rows would cost twice the time and ten times the memory."""
    nothing = "9e999"  # no NaN comes out of SQLite, and no infinity is in a record
    numbers = [*_OF_EACH_RECORD, *channel_columns(info)]
    taken = {"slot": "slot", "time": "monotonic_ns / 1e9",
             "utc": f"ifnull(utc_ns - {info.started_utc_ns}, {nothing})",
             "segment": "ifnull(segment, -1)", "cycle": "ifnull(cycle, -1)", "phase": _index("phase", PHASES),
             "state": _index("state", STATES), "in_segment_ns": f"ifnull(in_segment_ns, {nothing})"}
    if not info.imported:
        del taken["time"]
    if all(segment.prompt == "" for segment in info.segments):
        del taken["in_segment_ns"]  # asked for nowhere else
    expressions = [*taken.values(), *(f"ifnull({_quoted(name)}, {nothing})" for name in numbers)]
    rows = database.execute(f"SELECT {', '.join(expressions)} FROM sample WHERE slot >= ? ORDER BY slot", (first,))
    try:
        flat = np.fromiter(itertools.chain.from_iterable(rows), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordError(f"a sample contains a value that is not a number: {error}") from None
    table = np.ascontiguousarray(flat.reshape(-1, len(expressions)).T)
    table[table == np.inf] = np.nan
    return [*taken, *numbers], table


def record_of(database: sqlite3.Connection, first: int = 0) -> Record:
    """Content of one open file from a slot on."""
    info = read_info(database)
    names, table = _samples(database, info, first)
    column = dict(zip(names, table))
    column.setdefault("time", column["slot"])
    column.setdefault("in_segment_ns", np.full(len(column["slot"]), np.nan))
    gaps = database.execute("SELECT first, last, cause FROM gap WHERE last >= ? ORDER BY first", (first,))
    events = database.execute(f"SELECT {', '.join(EVENT_COLUMNS)} FROM event WHERE slot >= ? ORDER BY id",
                              (first if first > 0 else -1,))
    faults = database.execute('SELECT slot, channel, kind, "where", what FROM fault WHERE slot >= ? ORDER BY id',
                              (first,))
    return Record(
        info=info, finished=info.meta.get("outcome") == "finished", slot=column.pop("slot").astype(np.int64),
        time_s=column.pop("time"), utc_ns=column.pop("utc"), segment=column.pop("segment").astype(np.int32),
        cycle=column.pop("cycle").astype(np.int32), phase=column.pop("phase").astype(np.int8),
        state=column.pop("state").astype(np.int8), in_segment_ns=column.pop("in_segment_ns"), columns=column,
        gaps=[Gap(*row) for row in gaps], events=events.fetchall(), faults=faults.fetchall())


def part_path(path: Path, part: int) -> Path:
    """
    >>> part_path(Path("ramp.db"), 2).name
    'ramp.2.db'
    """
    return path if part == 1 else path.with_name(f"{path.stem}.{part}{path.suffix}")


def _continuation(database: sqlite3.Connection) -> Continuation | None:
    query = "SELECT key, value FROM meta WHERE key IN ('part', 'continues', 'continues_from', 'continues_cause')"
    found = dict(database.execute(query).fetchall())
    if found.get("part") is None:
        return None
    return Continuation(int(found["part"]), str(found.get("continues", "")), int(found.get("continues_from", 0)),
                        str(found.get("continues_cause", "")))


def _lost_with(continuation: Continuation, first: int) -> Gap:
    return Gap(first, continuation.first - 1, f"lost with {continuation.before}: {continuation.cause}")


def _join(record: Record, part: Record, continuation: Continuation) -> None:
    """What the part says from its first slot on counts; slots that neither has went with the file that failed."""
    kept = int(np.searchsorted(record.slot, continuation.first))
    record.gaps = [gap for gap in record.gaps if gap.first < continuation.first]
    record.events = [event for event in record.events if event[0] < continuation.first]
    record.faults = [fault for fault in record.faults if fault[0] < continuation.first]
    last = max(int(record.slot[kept - 1]) if kept else -1, record.gaps[-1].last if record.gaps else -1)
    if last + 1 < continuation.first:
        record.gaps.append(_lost_with(continuation, last + 1))
    part.utc_ns = part.utc_ns + (part.info.started_utc_ns - record.info.started_utc_ns)
    for name in ("slot", "time_s", "utc_ns", "segment", "cycle", "phase", "state", "in_segment_ns"):
        setattr(record, name, np.concatenate([getattr(record, name)[:kept], getattr(part, name)]))
    record.columns = {name: np.concatenate([column[:kept], part.columns[name]])
                      for name, column in record.columns.items()}
    record.gaps += part.gaps
    record.events += part.events
    record.faults += part.faults
    record.finished = part.finished


def _numbers_beside(path: Path) -> list[int]:
    """The numbers of all files that have the name of a part of the record, whatever is missing in between; one of more
    than 6 digits is a date, in the name of a record of its own."""
    numbers = set()
    try:
        names = [entry.name for entry in path.parent.iterdir()]
    except OSError:  # a folder that cannot be listed
        names = []
    for name in names:
        if name.startswith(f"{path.stem}.") and name.endswith(path.suffix):
            number = name[len(path.stem) + 1:len(name) - len(path.suffix)]
            if re.fullmatch("[1-9][0-9]{0,5}", number) and number != "1" and (path.parent / name).exists():
                numbers.add(int(number))
    numbers.update(itertools.takewhile(lambda number: part_path(path, number).exists(), itertools.count(2)))
    return sorted(numbers)


def run_told_of(path: Path) -> str:
    """Returns the run of the status file next to a record; empty if there is no file."""
    try:
        return str(json.loads(Path(f"{path}.status").read_text(encoding="utf-8"))["id"])
    except (OSError, ValueError, LookupError, TypeError):
        return ""


def _parts(path: Path) -> tuple[list[tuple[Path, Continuation | None]], RecordError | None]:
    """Returns the files of a record in order, and the reason if its own file is not one of them."""
    parts: list[tuple[Path, Continuation | None]] = []
    lost = damaged = None
    try:
        with opened(path) as database:
            run_id = read_info(database).id
        parts.append((path, None))
    except BeingWritten:
        raise
    except RecordError as error:
        lost = error
        run_id = run_told_of(path)
    for number in _numbers_beside(path):
        name = part_path(path, number)
        try:
            with opened(name) as database:
                continuation = _continuation(database)
                events = database.execute("SELECT count(*) FROM event").fetchone()[0]
                its_run = read_info(database).id
        except NoRecord:  # somebody's file, or one whose writer died before it was a record
            continue
        except RecordError as error:
            if run_told_of(name) not in ("", run_id):  # a record of its own: no part has a status file
                continue
            if isinstance(error, BeingWritten):
                raise
            damaged = error
            continue
        if continuation is None or continuation.part != number or events == 0:
            continue
        run_id = its_run if not parts else run_id
        if its_run == run_id:
            damaged = None  # the run went on from there
            parts.append((name, continuation))
    if damaged is not None:
        raise damaged
    parts.sort(key=lambda part: part[1].first if part[1] is not None else 0)
    return parts, lost


def read_record(path: Path) -> Record:
    """Everything, of all the files that the record consists of. One that others go on from, and that is not as it was
    written, is passed over: what it held is in those after it, or is a gap. Raises `BeingWritten` or `RecordError`."""
    parts, lost = _parts(path)
    if not parts:
        raise lost or RecordError(f"{path}: is not a record")
    record: Record | None = None
    for name, continuation in parts:
        try:
            with opened(name) as database:
                if name != parts[-1][0] and not is_as_written(database):
                    continue  # one that others go on from must be as it was written
                part = record_of(database)
        except BeingWritten:
            raise
        except RecordError:
            if name == parts[-1][0]:
                raise
            continue
        if record is None:
            record = part
            if continuation is not None and continuation.first > 0:
                record.gaps.insert(0, _lost_with(continuation, 0))
        elif continuation is not None:
            _join(record, part, continuation)
    assert record is not None
    return record
