# SPDX-License-Identifier: Apache-2.0
"""Reads a record: the raw columns of its samples, joined from all files of the record."""

from __future__ import annotations

import itertools
import json
import re
import sqlite3
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .chain import is_intact
from .database import open_database
from .errors import BeingWritten, NotARecord, RecordError
from .info import RunInfo, column_name, read_info

Numbers = NDArray[np.float64]

PHASES = ("ramping", "holding", "waiting for soak", "overdue", "complete")
STATES = ("execute", "suspended", "held", "aborting", "aborted", "stopped", "complete")
EVENT_COLUMNS = ("slot", "monotonic_ns", "utc_ns", "kind", "interlock", "reaction", "segment", "channel", "text")
FAULT_COLUMNS = ("slot", "channel", "kind", "where", "what")
_COMMON_COLUMNS = ("set_point_c", "chamber_air_c", "chamber_set_point_c")


@dataclass(frozen=True)
class Gap:
    """Slots without a sample, and the cause."""

    first: int
    last: int
    cause: str


@dataclass
class Record:
    """Columns of equal length, one row per sample in order of time. A failed reading is NaN."""

    info: RunInfo
    finished: bool
    slot: NDArray[np.int64]
    time_s: Numbers  #: since the start of the run: the slot; for an imported record the time of its file
    utc_ns: Numbers  #: wall clock minus `info.started_utc_ns`; NaN if unknown
    columns: dict[str, Numbers]  #: raw values by column name of the table `sample`
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
    """Describes in a continuation file why it replaced the previous file, which could not be written any longer."""

    part: int
    previous: str
    first: int  #: first slot in the continuation file
    cause: str


def channel_columns(info: RunInfo) -> list[str]:
    """Returns the columns of `sample` for the channels of the run."""
    names = [*info.chamber_columns, *(thermometer.name for thermometer in info.thermometers)]
    for unit in info.units:
        names += [column_name(axis.label, "pulses") for axis in unit.axes]
        names += [column_name(unit.name, "interval_ns")]
        names += [f"{unit.name}.{value.name}" for value in unit.values]
    return names + [column_name(axis.label, "true_bias_deg_per_h") for axis in info.axes]


def _quote_name(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _index_expression(column: str, words: tuple[str, ...]) -> str:
    return f"CASE {column} " + " ".join(f"WHEN '{word}' THEN {i}" for i, word in enumerate(words)) + " ELSE -1 END"


def _samples(database: sqlite3.Connection, info: RunInfo, first: int) -> tuple[list[str], NDArray[np.float64]]:
    """Returns the names of the columns and their values, columns × samples; NaN for NULL.

    All numbers go through one iterator into one array. A list of rows would take twice the time and ten times the
    memory."""
    null = "9e999"  # infinity: SQLite returns no NaN, and a record contains no infinity
    numbers = [*_COMMON_COLUMNS, *channel_columns(info)]
    selected = {"slot": "slot", "time": "monotonic_ns / 1e9",
             "utc": f"ifnull(utc_ns - {info.started_utc_ns}, {null})",
             "segment": "ifnull(segment, -1)", "cycle": "ifnull(cycle, -1)",
             "phase": _index_expression("phase", PHASES), "state": _index_expression("state", STATES),
             "in_segment_ns": f"ifnull(in_segment_ns, {null})"}
    if not info.imported:
        del selected["time"]
    if all(segment.prompt == "" for segment in info.segments):
        del selected["in_segment_ns"]  # used only with prompts
    expressions = [*selected.values(), *(f"ifnull({_quote_name(name)}, {null})" for name in numbers)]
    rows = database.execute(f"SELECT {', '.join(expressions)} FROM sample WHERE slot >= ? ORDER BY slot", (first,))
    try:
        flat = np.fromiter(itertools.chain.from_iterable(rows), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordError(f"a sample contains a value that is not a number: {error}") from None
    table = np.ascontiguousarray(flat.reshape(-1, len(expressions)).T)
    table[table == np.inf] = np.nan
    return [*selected, *numbers], table


def imported_gaps(record: Record) -> list[tuple[float, float, str]]:
    """Returns the times before and after each gap of an imported record, and a text. The limit is the one that the
    import used, which it states in a note of the record."""
    text = EVENT_COLUMNS.index("text")
    notes = [re.match(r"\d+ gaps? longer than (\S+) s, ", str(event[text])) for event in record.events]
    limits = [float(note[1]) for note in notes if note]
    if not limits:
        return []
    spacing = np.diff(record.time_s)
    rounding = 1e-5  # the note has six digits
    before = np.flatnonzero(spacing > limits[0] * (1 + rounding))
    return [(float(record.time_s[i]), float(record.time_s[i + 1]), f"no row for {spacing[i]:g} s") for i in before]


def read_part(database: sqlite3.Connection, first: int = 0) -> Record:
    """Reads one open file from the slot `first` on."""
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
    """Returns the path of a file of the record: part 1 is the record itself, later parts are its continuations.

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


def _lost_gap(continuation: Continuation, first: int) -> Gap:
    return Gap(first, continuation.first - 1, f"lost with {continuation.previous}: {continuation.cause}")


def _join(record: Record, part: Record, continuation: Continuation) -> None:
    """Appends a continuation file. From its first slot on it replaces the record. Slots that neither contains were lost
    with the previous file, and become a gap."""
    kept = int(np.searchsorted(record.slot, continuation.first))
    record.gaps = [gap for gap in record.gaps if gap.first < continuation.first]
    record.events = [event for event in record.events if event[0] < continuation.first]
    record.faults = [fault for fault in record.faults if fault[0] < continuation.first]
    last = max(int(record.slot[kept - 1]) if kept else -1, record.gaps[-1].last if record.gaps else -1)
    if last + 1 < continuation.first:
        record.gaps.append(_lost_gap(continuation, last + 1))
    part.utc_ns = part.utc_ns + (part.info.started_utc_ns - record.info.started_utc_ns)
    if len(part.info.segments) > len(record.info.segments):  # a decision of a self-ending run has added segments
        record.info = replace(record.info, segments=part.info.segments)
    for name in ("slot", "time_s", "utc_ns", "segment", "cycle", "phase", "state", "in_segment_ns"):
        setattr(record, name, np.concatenate([getattr(record, name)[:kept], getattr(part, name)]))
    record.columns = {name: np.concatenate([column[:kept], part.columns[name]])
                      for name, column in record.columns.items()}
    record.gaps += part.gaps
    record.events += part.events
    record.faults += part.faults
    record.finished = part.finished


def _part_numbers(path: Path) -> list[int]:
    """Returns the numbers of all files that are named like a part of the record, with or without gaps. A number of more
    than 6 digits is a date in the name of another record."""
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


def run_id_from_status(path: Path) -> str:
    """Returns the run ID from the status file next to a record, or "" if there is none."""
    try:
        return str(json.loads(Path(f"{path}.status").read_text(encoding="utf-8"))["id"])
    except (OSError, ValueError, LookupError, TypeError):
        return ""


def _find_parts(path: Path) -> tuple[list[tuple[Path, Continuation | None]], RecordError | None]:
    """Returns the files of a record in order, and the reason if its own file is not one of them."""
    parts: list[tuple[Path, Continuation | None]] = []
    lost = damaged = None
    try:
        with open_database(path) as database:
            run_id = read_info(database).id
        parts.append((path, None))
    except BeingWritten:
        raise
    except RecordError as error:
        lost = error
        run_id = run_id_from_status(path)
    for number in _part_numbers(path):
        name = part_path(path, number)
        try:
            with open_database(name) as database:
                continuation = _continuation(database)
                events = database.execute("SELECT count(*) FROM event").fetchone()[0]
                its_run = read_info(database).id
        except NotARecord:  # unrelated, or its writer died before the schema was complete
            continue
        except RecordError as error:
            if run_id_from_status(name) not in ("", run_id):  # another record: parts have no status file
                continue
            if isinstance(error, BeingWritten):
                raise
            damaged = error
            continue
        if continuation is None or continuation.part != number or events == 0:
            continue
        run_id = its_run if not parts else run_id
        if its_run == run_id:
            damaged = None  # the run continued in this file
            parts.append((name, continuation))
    if damaged is not None:
        raise damaged
    parts.sort(key=lambda part: part[1].first if part[1] is not None else 0)
    return parts, lost


def read_record(path: Path) -> Record:
    """Reads all files of a record. Skips a file that has a continuation and was changed after it was written; its rows
    are then in the continuation, or become a gap. Raises `BeingWritten` or `RecordError`."""
    parts, lost = _find_parts(path)
    if not parts:
        raise lost or RecordError(f"{path}: is not a record")
    record: Record | None = None
    for name, continuation in parts:
        try:
            with open_database(name) as database:
                if name != parts[-1][0] and not is_intact(database):
                    continue
                part = read_part(database)
        except BeingWritten:
            raise
        except RecordError:
            if name == parts[-1][0]:
                raise
            continue
        if record is None:
            record = part
            if continuation is not None and continuation.first > 0:
                record.gaps.insert(0, _lost_gap(continuation, 0))
        elif continuation is not None:
            _join(record, part, continuation)
    assert record is not None
    return record
