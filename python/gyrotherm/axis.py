# SPDX-License-Identifier: Apache-2.0
"""One axis of a record as columns: temperatures calibrated, bias from counts with the exact interval, Earth's rate
removed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .errors import RecordError
from .info import Axis, RunInfo, Thermometer, Unit, column_of
from .record import Numbers, Record

if TYPE_CHECKING:
    import pandas

EARTH_RATE_REMOVED = "earth rate removed"
FIRST_HOLD_REMOVED = "mean of the first hold removed"
NOTHING_REMOVED = "nothing removed"


@dataclass
class AxisColumns:
    """One row per sample, as in the record: seconds without a sample have none."""

    axis: Axis
    inputs: dict[str, Numbers]  #: what a model may take in: thermometers, then "self" and "aux:NAME" of the unit
    gradients: tuple[str, ...]  #: the thermometers whose differences are the multi-point gradients
    time_s: Numbers  #: since the run started: whole seconds, or a foreign record's own time
    bias_deg_per_h: Numbers
    true_bias_deg_per_h: Numbers  #: of a virtual gyro; NaN: not known
    bias_zero: str
    segment: NDArray[np.int32]
    cycle: NDArray[np.int32]
    set_point_c: Numbers
    imported: bool

    def to_pandas(self) -> pandas.DataFrame:
        """The inputs of a model, and "bias", in a row per sample."""
        import pandas

        frame = pandas.DataFrame({**self.inputs, "bias": self.bias_deg_per_h})
        frame.index = pandas.Index(self.time_s, name="time_s")
        return frame


def calibrated(thermometer: Thermometer, reading_c: Numbers) -> Numbers:
    """The temperatures that readings stand for.

    >>> calibrated(Thermometer("A", "", "", 0.5), np.array([20.0])).tolist()
    [20.5]
    >>> calibrated(Thermometer("A", "", "", 0.0, (1.0, 0.0, 0.01)), np.array([20.0])).tolist()
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
    if not found:  # by its label?
        found = [a for a in info.axes if a.label == unit and not axis]
        if len(found) == 1:
            return found[0]
    names = ", ".join(a.label for a in info.axes)
    if not info.axes:
        raise RecordError("the run has no gyro")
    if unit or axis:
        raise RecordError(f'has no single axis "{axis}" of a unit "{unit}", it has {names}')
    raise RecordError(f"has {len(info.axes)} axes, {names}: choose one with unit= and axis=")


def unit_of(info: RunInfo, axis: Axis) -> Unit:
    """Returns the unit under test of the axis."""
    return next(unit for unit in info.units if unit.name == axis.unit)


def own_inputs(unit: Unit) -> dict[str, str]:
    """Names of the inputs that a unit tells of itself, each with its column: its first temperature is "self"."""
    named: dict[str, str] = {}
    for value in unit.values:
        is_self = value.is_temperature and "self" not in named
        named["self" if is_self else f"aux:{value.name}"] = f"{unit.name}.{value.name}"
    return named


def thermometers_of(info: RunInfo, unit: Unit) -> list[Thermometer]:
    """Those on the unit and the rig's, and those that the unit names."""
    named = {*unit.gradients, *unit.three_point}
    return [t for t in info.thermometers if t.unit_under_test in ("", unit.name) or t.name in named]


def rotation_deg_per_h(record: Record, axis: Axis) -> Numbers:
    """What was counted or read, in °/h: 1 arcsec/s is 1 °/h exactly."""
    number = record.columns[column_of(axis.label, "pulses")]
    if axis.kind == "rate":
        return axis.scale * number
    with np.errstate(divide="ignore", invalid="ignore"):
        return axis.scale * number / (record.columns[column_of(axis.unit, "interval_ns")] * 1e-9)


def _marked(record: Record, flags: list[bool]) -> NDArray[np.bool_]:
    """Rows of segments that have the flag; a row of no segment has none."""
    inside = (record.segment >= 0) & (record.segment < len(flags))
    return inside & np.array([*flags, False])[np.where(inside, record.segment, -1)]


def bias_of(record: Record, axis: Axis, own_zero: bool = True) -> tuple[Numbers, str]:
    """The bias and what was removed as its zero. There is none while the profile waited for people. The Earth's rate
    has the other sign where the unit is turned around; where it is not known, the mean of the first hold is removed
    from our own records (`own_zero`), unless the unit was turned."""
    segments = record.info.segments
    bias = np.array(rotation_deg_per_h(record, axis))
    handled = _marked(record, [segment.prompt != "" for segment in segments])
    bias[handled & (record.in_segment_ns == 0)] = np.nan
    if axis.earth_rate_deg_per_h is not None:
        turned = _marked(record, [segment.unit_turned for segment in segments])
        return bias - np.where(turned, -axis.earth_rate_deg_per_h, axis.earth_rate_deg_per_h), EARTH_RATE_REMOVED
    if not own_zero or record.info.imported or any(segment.unit_turned for segment in segments):
        return bias, NOTHING_REMOVED
    known = np.isfinite(bias)
    in_hold = known & _marked(record, [segment.hold for segment in segments])
    if not in_hold.any():
        return bias, NOTHING_REMOVED
    first = record.segment[np.argmax(in_hold)]
    return bias - bias[known & (record.segment == first)].mean(), FIRST_HOLD_REMOVED


def axis_columns(record: Record, axis: Axis) -> AxisColumns:
    """The axis as columns."""
    info = record.info
    unit = unit_of(info, axis)
    inputs = {t.name: calibrated(t, record.columns[t.name]) for t in thermometers_of(info, unit)}
    gradients = unit.gradients or tuple(inputs)
    inputs.update({name: record.columns[column] for name, column in own_inputs(unit).items()})
    bias, zero = bias_of(record, axis)
    rows = record.slot.size
    segment = np.where(record.segment < len(info.segments), record.segment, -1).astype(np.int32)
    cycle = np.where(record.cycle < len(info.cycles), record.cycle, -1).astype(np.int32)
    return AxisColumns(
        axis=axis, inputs=inputs, gradients=gradients, bias_deg_per_h=bias, bias_zero=zero, segment=segment,
        cycle=cycle, time_s=record.time_s,
        true_bias_deg_per_h=record.columns[column_of(axis.label, "true_bias_deg_per_h")],
        set_point_c=np.full(rows, np.nan) if info.imported else record.columns["set_point_c"], imported=info.imported)
