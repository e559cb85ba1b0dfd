# SPDX-License-Identifier: Apache-2.0
"""One axis of a record as columns: calibrated temperatures, and the bias from the counts and the exact interval, minus
the Earth rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .errors import RecordError
from .info import Axis, RunInfo, Thermometer, Unit, column_name
from .record import Numbers, Record

if TYPE_CHECKING:
    import pandas

EARTH_RATE_REMOVED = "earth rate removed"
FIRST_HOLD_REMOVED = "mean of the first hold removed"
NOTHING_REMOVED = "nothing removed"


@dataclass
class AxisColumns:
    """Columns of one axis. A row is a sample of the record; a second without a sample has no row."""

    axis: Axis
    inputs: dict[str, Numbers]  #: possible model inputs: thermometers, then "self" and "aux:NAME" of the unit
    gradients: tuple[str, ...]  #: thermometers whose differences are the multi-point gradients
    time_s: Numbers  #: since the start of the run: whole seconds; for an imported record the times of its file
    bias_deg_per_h: Numbers
    true_bias_deg_per_h: Numbers  #: of a virtual gyro; NaN if unknown
    bias_zero: str  #: the bias reference: one of the three constants above
    segment: NDArray[np.int32]
    cycle: NDArray[np.int32]
    set_point_c: Numbers
    imported: bool

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the possible model inputs and "bias", one row per sample."""
        import pandas

        frame = pandas.DataFrame({**self.inputs, "bias": self.bias_deg_per_h})
        frame.index = pandas.Index(self.time_s, name="time_s")
        return frame


def calibrate(thermometer: Thermometer, reading_c: Numbers) -> Numbers:
    """Returns calibrated temperatures, °C.
    >>> calibrate(Thermometer("A", "", "", 0.5), np.array([20.0])).tolist()
    [20.5]
    >>> calibrate(Thermometer("A", "", "", 0.0, (1.0, 0.0, 0.01)), np.array([20.0])).tolist()
    [5.0]
    """
    if not thermometer.polynomial:
        return reading_c + thermometer.offset_k
    total = np.zeros_like(reading_c)
    for coefficient in reversed(thermometer.polynomial):
        total = total * reading_c + coefficient
    return total


def choose_axis(info: RunInfo, unit: str = "", axis: str = "") -> Axis:
    """Returns the requested axis. An empty name selects the only one."""
    found = [a for a in info.axes if (not unit or a.unit == unit) and (not axis or a.name == axis)]
    if len(found) == 1:
        return found[0]
    if not found:  # `unit` may be a label
        found = [a for a in info.axes if a.label == unit and not axis]
        if len(found) == 1:
            return found[0]
    names = ", ".join(a.label for a in info.axes)
    if not info.axes:
        raise RecordError("the run has no gyro")
    if unit or axis:
        raise RecordError(f'axis "{axis}" of unit "{unit}" does not identify one axis; the run has {names}')
    raise RecordError(f"the run has {len(info.axes)} axes ({names}); choose one with unit= and axis=")


def find_unit(info: RunInfo, axis: Axis) -> Unit:
    """Returns the unit under test of the axis."""
    return next(unit for unit in info.units if unit.name == axis.unit)


def unit_inputs(unit: Unit) -> dict[str, str]:
    """Returns the inputs that a unit reports about itself: name → column. The first temperature is "self"."""
    named: dict[str, str] = {}
    for value in unit.values:
        is_self = value.is_temperature and "self" not in named
        named["self" if is_self else f"aux:{value.name}"] = f"{unit.name}.{value.name}"
    return named


def unit_thermometers(info: RunInfo, unit: Unit) -> list[Thermometer]:
    """Returns the thermometers of the unit, of the rig, and those that the unit's settings name."""
    named = {*unit.gradients, *unit.three_point}
    return [t for t in info.thermometers if t.unit_under_test in ("", unit.name) or t.name in named]


def measured_rate_deg_per_h(record: Record, axis: Axis) -> Numbers:
    """Returns the rate that was counted or read, °/h. 1 arcsec/s is exactly 1 °/h."""
    number = record.columns[column_name(axis.label, "pulses")]
    if axis.kind == "rate":
        return axis.scale * number
    with np.errstate(divide="ignore", invalid="ignore"):
        return axis.scale * number / (record.columns[column_name(axis.unit, "interval_ns")] * 1e-9)


def _rows_with_flag(record: Record, flags: list[bool]) -> NDArray[np.bool_]:
    """Returns the mask of the rows whose segment has the flag. A row outside all segments is False."""
    inside = (record.segment >= 0) & (record.segment < len(flags))
    return inside & np.array([*flags, False])[np.where(inside, record.segment, -1)]


def compute_bias(record: Record, axis: Axis, removes_first_hold: bool = True) -> tuple[Numbers, str]:
    """Returns the bias, °/h, and a text that names the subtracted reference. The bias is NaN while the profile waited
    for an operator.

    The reference is the Earth rate, with opposite sign while the unit is turned around. If the Earth rate is unknown,
    it is the mean of the first hold (with `removes_first_hold`), but not for imported records and turned units. An Earth
    rate of 0 in an imported record removes nothing."""
    segments = record.info.segments
    bias = np.array(measured_rate_deg_per_h(record, axis))
    handled = _rows_with_flag(record, [segment.prompt != "" for segment in segments])
    bias[handled & (record.in_segment_ns == 0)] = np.nan
    is_zero_of_import = record.info.imported and axis.earth_rate_deg_per_h == 0
    if axis.earth_rate_deg_per_h is not None and not is_zero_of_import:
        turned = _rows_with_flag(record, [segment.unit_turned for segment in segments])
        return bias - np.where(turned, -axis.earth_rate_deg_per_h, axis.earth_rate_deg_per_h), EARTH_RATE_REMOVED
    if not removes_first_hold or record.info.imported or any(segment.unit_turned for segment in segments):
        return bias, NOTHING_REMOVED
    known = np.isfinite(bias)
    in_hold = known & _rows_with_flag(record, [segment.hold for segment in segments])
    if not in_hold.any():
        return bias, NOTHING_REMOVED
    first = record.segment[np.argmax(in_hold)]
    return bias - bias[known & (record.segment == first)].mean(), FIRST_HOLD_REMOVED


def make_axis_columns(record: Record, axis: Axis) -> AxisColumns:
    """Returns the columns of an axis."""
    info = record.info
    unit = find_unit(info, axis)
    inputs = {t.name: calibrate(t, record.columns[t.name]) for t in unit_thermometers(info, unit)}
    gradients = unit.gradients or tuple(inputs)
    inputs.update({name: record.columns[column] for name, column in unit_inputs(unit).items()})
    bias, reference = compute_bias(record, axis)
    rows = record.slot.size
    segment = np.where(record.segment < len(info.segments), record.segment, -1).astype(np.int32)
    cycle = np.where(record.cycle < len(info.cycles), record.cycle, -1).astype(np.int32)
    return AxisColumns(
        axis=axis, inputs=inputs, gradients=gradients, bias_deg_per_h=bias, bias_zero=reference, segment=segment,
        cycle=cycle, time_s=record.time_s,
        true_bias_deg_per_h=record.columns[column_name(axis.label, "true_bias_deg_per_h")],
        set_point_c=np.full(rows, np.nan) if info.imported else record.columns["set_point_c"], imported=info.imported)
