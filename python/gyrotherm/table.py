# SPDX-License-Identifier: Apache-2.0
"""A record as one table with a row per second and units of measure, and its conversion to a DataFrame or a Dataset."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .axis import calibrate, compute_bias, unit_inputs
from .info import column_name
from .record import PHASES, STATES, Numbers, Record

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass
class Column:
    """One column and its attributes."""

    values: NDArray[Any]
    attrs: dict[str, Any]
    labels: tuple[str, ...] = ()  #: if not empty, values are indices of the labels, −1 for none


@dataclass
class Table:
    """Columns with a common time axis."""

    time_s: Numbers
    utc: NDArray[np.datetime64]
    columns: dict[str, Column]
    attrs: dict[str, str] = field(default_factory=dict)


class _Grid:
    """The time axis of a table: every second from the first to the last, or the times of an imported record."""

    def __init__(self, record: Record, first: int) -> None:
        self._rows: NDArray[np.int64] | None = None
        if record.info.imported:
            self.time_s = record.time_s
            return
        last = max([int(record.slot[-1]) if record.slot.size else first - 1, *(gap.last for gap in record.gaps)])
        self.time_s = np.arange(first, last + 1, dtype=np.float64)
        if record.slot.size != self.time_s.size:
            self._rows = record.slot - first

    def expand(self, values: NDArray[Any], fill: Any = np.nan) -> NDArray[Any]:
        """Returns one value per row of the table from one value per sample. Rows without a sample are filled."""
        if self._rows is None:
            return values
        expanded = np.full(self.time_s.size, fill, dtype=values.dtype)
        expanded[self._rows] = values
        return expanded


def _thermometer_attrs(record: Record, name: str, is_calibrated: bool) -> dict[str, Any]:
    thermometer = next(t for t in record.info.thermometers if t.name == name)
    attrs: dict[str, Any] = {"units": "degC", "long_name": f"temperature of {name}", "model_input": name,
                             "instrument": thermometer.instrument, "unit_under_test": thermometer.unit_under_test}
    attrs["calibration"] = "applied" if is_calibrated else "not applied"
    for key in ("certificate", "due"):
        if getattr(thermometer, key):
            attrs[key] = getattr(thermometer, key)
    return attrs


def _columns(record: Record, is_calibrated: bool, removes_first_hold: bool) -> dict[str, Column]:
    info, raw = record.info, record.columns
    columns = {name: Column(raw[name], {"units": "degC", "long_name": long_name}) for name, long_name in (
        ("set_point_c", "set point of the profile"), ("chamber_air_c", "air temperature of the chamber"),
        ("chamber_set_point_c", "set point read back from the chamber"))}
    chamber = {"chamber_humidity_percent": ("percent", "relative humidity of the chamber"),
               "chamber_dew_point_c": ("degC", "dew point of the chamber")}
    for name in info.chamber_columns:
        units, long_name = chamber[name]
        columns[name] = Column(raw[name], {"units": units, "long_name": long_name})
    for t in info.thermometers:
        values = calibrate(t, raw[t.name]) if is_calibrated else raw[t.name]
        columns[t.name] = Column(values, _thermometer_attrs(record, t.name, is_calibrated))
    for unit in info.units:
        of_unit = {"unit_under_test": unit.name, "instrument": unit.instrument}
        interval = column_name(unit.name, "interval_s")
        for axis in unit.axes:
            pulses, is_count = column_name(axis.label, "pulses"), axis.kind != "rate"
            columns[pulses] = Column(raw[pulses], {**of_unit, "units": "1", "input_axis": axis.label,
                                                   "scale": axis.scale,
                                                   "long_name": "pulses counted" if is_count else "number as read"})
            bias, reference = compute_bias(record, axis, removes_first_hold)
            columns[column_name(axis.label, "bias_deg_per_h")] = Column(
                bias, {**of_unit, "units": "degree/hour", "input_axis": axis.label, "bias_zero": reference,
                       "long_name": f"bias of {axis.label}, {reference}"})
        columns[interval] = Column(raw[column_name(unit.name, "interval_ns")] * 1e-9,
                                   {**of_unit, "units": "s", "long_name": "interval over which pulses were counted"})
        names = {column: name for name, column in unit_inputs(unit).items()}
        for value in unit.values:
            column = f"{unit.name}.{value.name}"
            units = "degC" if value.is_temperature else value.unit_of_value or "1"
            columns[column] = Column(raw[column], {**of_unit, "units": units, "model_input": names[column],
                                                   "long_name": f"{value.name} of {unit.name}"})
    for axis in info.axes:
        name = column_name(axis.label, "true_bias_deg_per_h")
        if np.isfinite(raw[name]).any():
            columns[name] = Column(raw[name], {"units": "degree/hour", "input_axis": axis.label,
                                               "long_name": f"true bias of {axis.label}, from its virtual laboratory"})
    return columns


def make_table(record: Record, is_calibrated: bool = True, removes_first_hold: bool = True, first: int = 0) -> Table:
    """Returns the record as a table that starts at the slot `first`."""
    info = record.info
    grid = _Grid(record, first)
    columns = _columns(record, is_calibrated, removes_first_hold)
    columns["segment"] = Column(record.segment, {"long_name": "index of the segment, -1: none"})
    columns["cycle"] = Column(record.cycle, {"long_name": "index of the cycle, -1: none"})
    columns["phase"] = Column(record.phase, {"long_name": "phase of the segment"}, PHASES)
    columns["state"] = Column(record.state, {"long_name": "state of the run"}, STATES)
    for column in columns.values():
        column.values = grid.expand(column.values, np.nan if column.values.dtype.kind == "f" else -1)
    known = np.isfinite(record.utc_ns)
    since_start = np.where(known, record.utc_ns, 0.0).astype(np.int64)
    utc = (info.started_utc_ns + since_start).astype("datetime64[ns]")
    utc[~known] = np.datetime64("NaT")
    attrs = {"title": info.profile_name, "source": info.origin, "run_id": info.id,
             "profile": info.profile_name, "rig": info.rig_name, "program_version": info.program_version,
             "finished": "yes" if record.finished else "no",
             "rows": "times of the imported file" if info.imported else "one per second"}
    return Table(grid.time_s, grid.expand(utc, np.datetime64("NaT")), columns, attrs)


def to_pandas(table: Table) -> pandas.DataFrame:
    """Returns a DataFrame indexed by the time since the start, s. `attrs["columns"]` contains the attributes of each
    column, with its unit."""
    import pandas

    data: dict[str, Any] = {"utc": pandas.DatetimeIndex(table.utc).tz_localize("UTC")}
    for name, column in table.columns.items():
        values = column.values
        data[name] = pandas.Categorical.from_codes(values, list(column.labels)) if column.labels else values
    frame = pandas.DataFrame(data, index=pandas.Index(table.time_s, name="time_s"), copy=False)
    frame.attrs = {**table.attrs, "columns": {name: column.attrs for name, column in table.columns.items()}}
    return frame


def to_xarray(table: Table) -> xarray.Dataset:
    """Returns a Dataset with the dimension `time_s`, the time since the start in s, and the coordinate `utc`."""
    import xarray

    variables = {}
    for name, column in table.columns.items():
        attrs = dict(column.attrs)
        if column.labels:
            attrs["flag_values"] = np.arange(len(column.labels), dtype=np.int8)
            attrs["flag_meanings"] = " ".join(label.replace(" ", "_") for label in column.labels)
        variables[name] = ("time_s", column.values, attrs)
    time_name = "start of the second, since the start of the run; for an imported record the time of its file"
    time = ("time_s", table.time_s, {"units": "s", "long_name": time_name})
    utc = ("time_s", table.utc, {"long_name": "time (UTC)"})
    return xarray.Dataset(variables, coords={"time_s": time, "utc": utc}, attrs=dict(table.attrs))
