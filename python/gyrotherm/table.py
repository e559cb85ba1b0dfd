# SPDX-License-Identifier: Apache-2.0
"""A record as one table on its grid of seconds, with units: what becomes a DataFrame or a Dataset."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .axis import bias_of, calibrated, own_inputs
from .info import column_of
from .record import PHASES, STATES, Numbers, Record

if TYPE_CHECKING:
    import pandas
    import xarray

SIMULATED = "SIMULATED: the instruments were virtual"
MEASURED = "measured"


@dataclass
class Column:
    """One column and what is known of it."""

    values: NDArray[Any]
    attrs: dict[str, Any]
    words: tuple[str, ...] = ()  #: values are indices of these; −1: none


@dataclass
class Table:
    """Columns on one axis of time."""

    time_s: Numbers
    utc: NDArray[np.datetime64]
    columns: dict[str, Column]
    attrs: dict[str, str] = field(default_factory=dict)


class _Grid:
    """Puts a value per sample on all seconds from the first to the last; imported records keep their own times."""

    def __init__(self, record: Record, first: int) -> None:
        self._rows: NDArray[np.int64] | None = None
        if record.info.imported:
            self.time_s = record.time_s
            return
        last = max([int(record.slot[-1]) if record.slot.size else first - 1, *(gap.last for gap in record.gaps)])
        self.time_s = np.arange(first, last + 1, dtype=np.float64)
        if record.slot.size != self.time_s.size:
            self._rows = record.slot - first

    def put(self, values: NDArray[Any], nothing: Any = np.nan) -> NDArray[Any]:
        if self._rows is None:
            return values
        table = np.full(self.time_s.size, nothing, dtype=values.dtype)
        table[self._rows] = values
        return table


def _thermometer_attrs(record: Record, name: str, is_calibrated: bool) -> dict[str, Any]:
    thermometer = next(t for t in record.info.thermometers if t.name == name)
    attrs: dict[str, Any] = {"units": "degC", "long_name": f"temperature of {name}", "model_input": name,
                             "instrument": thermometer.instrument, "unit_under_test": thermometer.unit_under_test}
    attrs["calibration"] = "applied" if is_calibrated else "not applied"
    for key in ("certificate", "due"):
        if getattr(thermometer, key):
            attrs[key] = getattr(thermometer, key)
    return attrs


def _columns(record: Record, is_calibrated: bool, own_zero: bool) -> dict[str, Column]:
    info, raw = record.info, record.columns
    columns = {name: Column(raw[name], {"units": "degC", "long_name": long_name}) for name, long_name in (
        ("set_point_c", "set point of the profile"), ("chamber_air_c", "air of the chamber"),
        ("chamber_set_point_c", "set point read back from the chamber"))}
    for t in info.thermometers:
        values = calibrated(t, raw[t.name]) if is_calibrated else raw[t.name]
        columns[t.name] = Column(values, _thermometer_attrs(record, t.name, is_calibrated))
    for unit in info.units:
        of_unit = {"unit_under_test": unit.name, "instrument": unit.instrument}
        interval = column_of(unit.name, "interval_s")
        for axis in unit.axes:
            pulses, counts = column_of(axis.label, "pulses"), axis.kind != "rate"
            columns[pulses] = Column(raw[pulses], {**of_unit, "units": "1", "input_axis": axis.label,
                                                   "scale": axis.scale,
                                                   "long_name": "pulses counted" if counts else "number as read"})
            bias, zero = bias_of(record, axis, own_zero)
            columns[column_of(axis.label, "bias_deg_per_h")] = Column(
                bias, {**of_unit, "units": "degree/hour", "input_axis": axis.label, "bias_zero": zero,
                       "long_name": f"bias of {axis.label}, {zero}"})
        columns[interval] = Column(raw[column_of(unit.name, "interval_ns")] * 1e-9,
                                   {**of_unit, "units": "s", "long_name": "interval over which pulses were counted"})
        names = {column: name for name, column in own_inputs(unit).items()}
        for value in unit.values:
            column = f"{unit.name}.{value.name}"
            units = "degC" if value.is_temperature else value.unit_of_value or "1"
            columns[column] = Column(raw[column], {**of_unit, "units": units, "model_input": names[column],
                                                   "long_name": f"{value.name} of {unit.name}"})
    for axis in info.axes:
        name = column_of(axis.label, "true_bias_deg_per_h")
        if np.isfinite(raw[name]).any():
            columns[name] = Column(raw[name], {"units": "degree/hour", "input_axis": axis.label,
                                               "long_name": f"bias of {axis.label} as its laboratory knows it"})
    return columns


def table_of(record: Record, is_calibrated: bool = True, own_zero: bool = True, first: int = 0) -> Table:
    """The whole record on its grid from the slot `first` on."""
    info = record.info
    grid = _Grid(record, first)
    columns = _columns(record, is_calibrated, own_zero)
    columns["segment"] = Column(record.segment, {"long_name": "index of the segment, -1: none"})
    columns["cycle"] = Column(record.cycle, {"long_name": "index of the cycle, -1: none"})
    columns["phase"] = Column(record.phase, {"long_name": "phase of the segment"}, PHASES)
    columns["state"] = Column(record.state, {"long_name": "state of the run"}, STATES)
    for column in columns.values():
        column.values = grid.put(column.values, np.nan if column.values.dtype.kind == "f" else -1)
    known = np.isfinite(record.utc_ns)
    since_start = np.where(known, record.utc_ns, 0.0).astype(np.int64)
    utc = (info.started_utc_ns + since_start).astype("datetime64[ns]")
    utc[~known] = np.datetime64("NaT")
    attrs = {"title": info.profile_name, "source": SIMULATED if info.simulated else MEASURED, "run_id": info.id,
             "profile": info.profile_name, "rig": info.rig_name, "program_version": info.program_version,
             "finished": "yes" if record.finished else "no",
             "rows": "at a foreign record's own times" if info.imported else "one a second"}
    return Table(grid.time_s, grid.put(utc, np.datetime64("NaT")), columns, attrs)


def to_pandas(table: Table) -> pandas.DataFrame:
    """A DataFrame by seconds since the start; `attrs["columns"]` says the units of each column."""
    import pandas

    data: dict[str, Any] = {"utc": pandas.DatetimeIndex(table.utc).tz_localize("UTC")}
    for name, column in table.columns.items():
        data[name] = pandas.Categorical.from_codes(column.values, list(column.words)) if column.words else column.values
    frame = pandas.DataFrame(data, index=pandas.Index(table.time_s, name="time_s"), copy=False)
    frame.attrs = {**table.attrs, "columns": {name: column.attrs for name, column in table.columns.items()}}
    return frame


def to_xarray(table: Table) -> xarray.Dataset:
    """A Dataset along `time_s`, seconds since the start, with the coordinate `utc`."""
    import xarray

    variables = {}
    for name, column in table.columns.items():
        attrs = dict(column.attrs)
        if column.words:
            attrs["flag_values"] = np.arange(len(column.words), dtype=np.int8)
            attrs["flag_meanings"] = " ".join(word.replace(" ", "_") for word in column.words)
        variables[name] = ("time_s", column.values, attrs)
    begins = "begin of the second since the run started; of an imported record its own time"
    time = ("time_s", table.time_s, {"units": "s", "long_name": begins})
    utc = ("time_s", table.utc, {"long_name": "time (UTC)"})
    return xarray.Dataset(variables, coords={"time_s": time, "utc": utc}, attrs=dict(table.attrs))
