# SPDX-License-Identifier: Apache-2.0
"""Content of a run's record, read by Python's own SQLite and compared with the values that the laboratory served.

A record is copied before it is opened, and never while it is being written.
"""
from __future__ import annotations

import os
import pathlib
import shutil
import sqlite3
from dataclasses import dataclass, field
from typing import Any

from laboratory import Laboratory
from rig import CHANNELS

UTC_EARLY, UTC_LATE = 0.25, 1.15  # s, permitted offset of a reading from its second
FRAME_EARLY = 2.2  # s; a frame may have waited on the line
PULSE_SCALE = 10 ** 9  # ns per frame


@dataclass
class Record:
    """Rows of all readable files of a run, each second once."""
    rows: dict[int, dict[str, Any]] = field(default_factory=dict)
    gaps: list[tuple[int, int, str]] = field(default_factory=list)
    events: list[tuple[int, str, str]] = field(default_factory=list)  # slot, kind, text
    faults: list[tuple[int, str, str]] = field(default_factory=list)  # slot, channel, what
    damaged: dict[str, str] = field(default_factory=dict)  # file → reason

    def accounted(self) -> set[int]:
        """Returns the seconds that are rows or are in a gap."""
        seconds = set(self.rows)
        for first, last, _ in self.gaps:
            seconds.update(range(first, last + 1))
        return seconds

    def states(self) -> dict[int, str]:
        return {slot: row["state"] for slot, row in sorted(self.rows.items())}

    def airs(self) -> dict[int, float | None]:
        return {slot: row["chamber_air_c"] for slot, row in sorted(self.rows.items())}


def part_path(record: pathlib.Path, number: int) -> pathlib.Path:
    return record if number == 1 else record.with_name(f"{record.stem}.{number}{record.suffix}")


def read_record(record: pathlib.Path, copies: pathlib.Path) -> Record:
    """Reads RUN.db, RUN.2.db, … from copies in the folder `copies`, which it makes."""
    copies.mkdir(parents=True)
    found = Record()
    for number in range(1, 100):
        part = part_path(record, number)
        if not part.is_file() and number > 2:
            break
        if part.is_file():
            try:
                add_part(found, part, copies)
            except (sqlite3.Error, OSError) as error:
                found.damaged[part.name] = str(error)
        elif number == 1:
            found.damaged[part.name] = "is missing"
    found.events.sort(key=lambda event: event[0])
    return found


def add_part(found: Record, part: pathlib.Path, copies: pathlib.Path) -> None:
    if not os.access(part, os.R_OK):
        part.chmod(0o600)  # an attack removed the permissions
    copy = copies / part.name
    shutil.copyfile(part, copy)
    log = part.with_name(part.name + "-wal")
    if log.is_file():
        shutil.copyfile(log, copies / log.name)
    database = sqlite3.connect(copy)
    try:
        database.row_factory = sqlite3.Row
        verdict = database.execute("PRAGMA integrity_check").fetchone()[0]
        if verdict != "ok":
            raise sqlite3.DatabaseError(verdict)
        rows = {row["slot"]: dict(row) for row in database.execute("SELECT * FROM sample")}
        gaps = [tuple(row) for row in database.execute("SELECT first, last, cause FROM gap")]
        events = [tuple(row) for row in database.execute("SELECT slot, kind, text FROM event ORDER BY id")]
        faults = [tuple(row) for row in database.execute("SELECT slot, channel, what FROM fault")]
    finally:
        database.close()
    found.rows |= rows
    found.gaps += [gap for gap in gaps if gap not in found.gaps]
    found.events += [event for event in events if event not in found.events]
    found.faults += [fault for fault in faults if fault not in found.faults]


def lost_seconds(record: Record, acknowledged: int) -> list[int]:
    """Returns the acknowledged seconds that are neither rows nor gaps."""
    return sorted(set(range(acknowledged + 1)) - record.accounted())


def holes(record: Record) -> list[int]:
    """Returns the seconds up to the last one that are neither rows nor gaps, or both."""
    accounted = record.accounted()
    last = max(accounted, default=-1)
    both = [slot for first, end, _ in record.gaps for slot in range(first, end + 1) if slot in record.rows]
    return sorted(set(range(last + 1)) - accounted | set(both))


def wrong_readings(record: Record, laboratory: Laboratory) -> list[str]:
    """Returns every recorded reading that the laboratory did not serve in that second."""
    return wrong_airs(record, laboratory) + wrong_thermometers(record, laboratory) + wrong_counts(record, laboratory)


def was_served(times: list[float], utc: float, early: float = UTC_EARLY) -> bool:
    return any(utc - early <= at <= utc + UTC_LATE for at in times)


def offset_text(times: list[float], utc: float) -> str:
    nearest = min(times, key=lambda at: abs(at - utc), default=None)
    return "never served" if nearest is None else f"served {nearest - utc:+.2f} s from its second"


def wrong_airs(record: Record, laboratory: Laboratory) -> list[str]:
    served: dict[float, list[float]] = {}
    for utc, value in list(laboratory.chamber.airs):
        served.setdefault(value, []).append(utc)
    wrong = []
    for slot, row in record.rows.items():
        value, utc = row["chamber_air_c"], row["utc_ns"] / 1e9
        if value is not None and not was_served(served.get(value, []), utc):
            wrong.append(f"second {slot}: air {value!r} was {offset_text(served.get(value, []), utc)}")
    return wrong


def wrong_thermometers(record: Record, laboratory: Laboratory) -> list[str]:
    served: dict[tuple[str, float], list[float]] = {}
    for names, instrument in ((CHANNELS[:8], laboratory.thermometer_1), (CHANNELS[8:], laboratory.thermometer_2)):
        for utc, texts in list(instrument.served):
            for name, text in zip(names, texts):
                served.setdefault((name, float(text)), []).append(utc)
    wrong = []
    for slot, row in record.rows.items():
        for name in CHANNELS:
            value, utc = row[name], row["utc_ns"] / 1e9
            if value is not None and not was_served(served.get((name, value), []), utc):
                wrong.append(f"second {slot}: {name} {value!r} was {offset_text(served.get((name, value), []), utc)}")
    return wrong


def wrong_counts(record: Record, laboratory: Laboratory) -> list[str]:
    """Returns pulses that do not match the number of complete frames in their interval, or whose last frame was sent in
    another second."""
    sent = list(laboratory.gyro.sent)
    wrong = []
    for slot, row in record.rows.items():
        if row["pulses"] is None:
            continue
        utc, frames = row["utc_ns"] / 1e9, round(row["interval_ns"] / PULSE_SCALE)
        sums = [count - sent[i - frames][1] for i, (at, count) in enumerate(sent)
                if i >= frames > 0 and utc - FRAME_EARLY <= at <= utc + UTC_LATE]
        if row["pulses"] not in sums:
            wrong.append(f"second {slot}: {row['pulses']} pulses in {row['interval_ns']} ns were not sent then: {sums}")
    return wrong
