# SPDX-License-Identifier: Apache-2.0
"""Description of a record, written before its first second: units under test, channels, segments."""

from __future__ import annotations

import math
import sqlite3
from dataclasses import dataclass, field

DEFAULT_UNIT_NAME = "gyro"  # of a unit under test without a name in the rig file


@dataclass(frozen=True)
class Thermometer:
    """A thermometer and its calibration: reading + offset, or Σ c_i reading^i if it has a polynomial, °C."""

    name: str
    instrument: str
    unit_under_test: str  #: to which it belongs; empty: the rig
    offset_k: float
    polynomial: tuple[float, ...] = ()
    certificate: str = ""
    due: str = ""
    calibration_uncertainty_k: float | None = None
    drift_k_per_year: float | None = None


@dataclass(frozen=True)
class Axis:
    """One input axis of a unit under test."""

    unit: str
    name: str  #: empty for the only axis of a unit
    kind: str  #: "pulse_count" or "rate"
    scale: float  #: arcsec per pulse, or °/h per unit of the stored number
    earth_rate_deg_per_h: float | None  #: on the input axis
    direction: tuple[float, float, float] | None = None
    label: str = ""  #: unique in the run: "gyro", "x", "u1.x"


@dataclass(frozen=True)
class Value:
    """A value that a unit reports about itself."""

    name: str
    unit_of_value: str
    is_temperature: bool


@dataclass(frozen=True)
class Unit:
    """A unit under test."""

    name: str
    serial_number: str
    model: str
    instrument: str
    axes: tuple[Axis, ...]
    values: tuple[Value, ...]
    gradients: tuple[str, ...]  #: thermometers whose differences are the multi-point gradients
    three_point: tuple[str, ...]
    in_use: bool = True  #: False: the position was empty


@dataclass(frozen=True)
class Segment:
    """A segment of the expanded profile."""

    name: str
    hold: bool
    target_c: float
    rate_c_per_min: float
    cycle: int  #: −1: none
    prompt: str
    unit_off: bool
    unit_turned: bool


@dataclass(frozen=True)
class RunInfo:
    """Description of a record, written before its first second."""

    id: str
    program_version: str
    profile_name: str
    rig_name: str
    simulated: bool  #: the rig, or some of its instruments, were virtual
    imported: bool  #: the rows come from a file of another program, with its times
    started_utc_ns: int
    seed: int
    days_later: int
    units: tuple[Unit, ...]
    thermometers: tuple[Thermometer, ...]
    chamber_columns: tuple[str, ...]  #: humidity and dew point of the chamber, if it measures them
    segments: tuple[Segment, ...]
    cycles: tuple[str, ...]
    virtual_instruments: tuple[str, ...]  #: of a real rig, such as "chamber"; empty for a virtual rig
    meta: dict[str, str] = field(repr=False)  #: the table `meta` unchanged, with the texts of profile and rig

    @property
    def order_number(self) -> str:
        """Number of the order that the units belong to; may be empty."""
        return self.meta.get("order_number", "")

    @property
    def origin(self) -> str:
        """Origin of the rows: "measured", or "SIMULATED: …" with the instruments that were virtual."""
        if self.virtual_instruments:
            return "SIMULATED: these instruments were virtual: " + ", ".join(self.virtual_instruments)
        return "SIMULATED: the instruments were virtual" if self.simulated else "measured"

    @property
    def axes(self) -> tuple[Axis, ...]:
        """All axes of the run, in order."""
        return tuple(axis for unit in self.units for axis in unit.axes)


def column_name(label: str, what: str) -> str:
    """Returns the name of a column of `sample` that belongs to an axis or a unit.

    >>> column_name("u1.x", "pulses"), column_name("gyro", "pulses")
    ('u1.x.pulses', 'pulses')
    """
    return what if label == DEFAULT_UNIT_NAME else f"{label}.{what}"


def _polynomial(text: str) -> tuple[float, ...]:
    return tuple(float(number) for number in text.replace(",", " ").split())


def _axes(database: sqlite3.Connection, units: list[str]) -> list[list[Axis]]:
    rows: list[list[Axis]] = [[] for _ in units]
    query = ("SELECT unit, name, kind, scale, earth_rate_deg_per_h, direction_x, direction_y, direction_z FROM axis"
             " ORDER BY unit, position")
    for unit, name, kind, scale, earth_rate, *direction in database.execute(query):
        at = (direction[0], direction[1], direction[2])
        known = None if any(number is None or not math.isfinite(number) for number in at) else at
        rows[unit].append(Axis(units[unit], name, kind, scale, earth_rate, known))
    labelled = []
    for unit_name, axes in zip(units, rows):
        several = len(axes) > 1
        labelled.append([Axis(a.unit, a.name, a.kind, a.scale, a.earth_rate_deg_per_h, a.direction,
                              f"{unit_name}.{a.name}" if several else unit_name) for a in axes])
    return labelled


def _units(database: sqlite3.Connection) -> tuple[Unit, ...]:
    rows = database.execute("SELECT name, serial_number, model, instrument FROM unit ORDER BY position").fetchall()
    axes = _axes(database, [row[0] for row in rows])
    values: list[list[Value]] = [[] for _ in rows]
    query = "SELECT unit, name, unit_of_value, is_temperature FROM unit_value ORDER BY unit, position"
    for unit, name, unit_of_value, is_temperature in database.execute(query):
        values[unit].append(Value(name, unit_of_value, is_temperature != 0))

    def listed(name: str, of: str) -> tuple[str, ...]:
        found = database.execute("SELECT value FROM list WHERE name = ? AND of = ? ORDER BY position", (name, of))
        return tuple(value for value, in found)

    unused = listed("unused_units", "")
    return tuple(Unit(name, serial, model, instrument, tuple(axes[i]), tuple(values[i]), listed("gradients", name),
                      listed("three_point", name), name not in unused)
                 for i, (name, serial, model, instrument) in enumerate(rows))


def _thermometers(database: sqlite3.Connection) -> tuple[Thermometer, ...]:
    query = ("SELECT name, instrument, unit_under_test, offset_k, polynomial, certificate, due,"
             " calibration_uncertainty_k, drift_k_per_year FROM channel WHERE measures = 'temperature'"
             " ORDER BY position")
    return tuple(Thermometer(name, instrument, unit, offset or 0.0, _polynomial(polynomial), certificate, due, u, drift)
                 for name, instrument, unit, offset, polynomial, certificate, due, u, drift in database.execute(query))


def _chamber_columns(database: sqlite3.Connection) -> tuple[str, ...]:
    query = "SELECT name FROM channel WHERE measures IN ('humidity', 'dew point') ORDER BY position"
    return tuple(str(name) for name, in database.execute(query))


def _segments(database: sqlite3.Connection) -> tuple[Segment, ...]:
    query = ("SELECT name, hold, target_c, rate_c_per_min, cycle, prompt, unit_off, unit_turned FROM segment"
             " ORDER BY position")
    return tuple(Segment(name, hold != 0, target, rate, cycle, prompt, off != 0, turned != 0)
                 for name, hold, target, rate, cycle, prompt, off, turned in database.execute(query))


def _started_utc_ns(database: sqlite3.Connection, described: int) -> int:
    """Returns the UTC time at which the run's clock was zero, from the first sample. Returns `described`, the time at
    which the description was written, if there is no sample: a real run prepares its chamber in between."""
    first = database.execute("SELECT utc_ns - monotonic_ns FROM sample ORDER BY slot LIMIT 1").fetchone()
    return first[0] if first and isinstance(first[0], int) and first[0] >= 0 else described


def read_info(database: sqlite3.Connection) -> RunInfo:
    """Reads the description of an open record."""
    rows = database.execute("SELECT key, value FROM meta")
    meta = {str(key): "" if value is None else str(value) for key, value in rows}
    cycles = database.execute("SELECT value FROM list WHERE name = 'cycles' ORDER BY position")
    served = database.execute("SELECT value FROM list WHERE name = 'virtual_instruments' ORDER BY position")
    virtual_instruments = tuple(value for value, in served)

    def whole(key: str) -> int:
        return int(meta.get(key) or 0)

    started = whole("started_utc_ns")
    if not whole("simulated") and not whole("imported"):
        started = _started_utc_ns(database, started)
    return RunInfo(
        id=meta.get("id", ""), program_version=meta.get("program_version", ""),
        profile_name=meta.get("profile_name", ""), rig_name=meta.get("rig_name", ""),
        simulated=whole("simulated") != 0 or virtual_instruments != (), imported=whole("imported") != 0,
        started_utc_ns=started, seed=whole("seed"), days_later=whole("days_later"), units=_units(database),
        thermometers=_thermometers(database), chamber_columns=_chamber_columns(database), segments=_segments(database),
        cycles=tuple(value for value, in cycles), virtual_instruments=virtual_instruments, meta=meta)
