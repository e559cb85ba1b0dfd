# SPDX-License-Identifier: Apache-2.0
"""Clusters: means over 100 s, with their rates and temperature lags, for training and verifying models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .axis import AxisColumns
from .errors import ModelError, RecordError
from .record import Numbers
from .terms import Factor, Term, evaluate, parse_term

if TYPE_CHECKING:
    import pandas
    import xarray

SECONDS_PER_MINUTE = 60
_TIME_SLACK = 1e-9  # tolerance for rounded timestamps, relative to the cluster length


def lags(temperature_c: Numbers, elapsed_s: Numbers, time_constant_s: Numbers) -> Numbers:
    """Returns the first-order lag of bodies behind a temperature, K. Rows are times, columns are bodies.

    `elapsed_s` is the time since the previous row, infinite in the first row of a run. A NaN row extends the next step.
    >>> lags(np.array([[20.0], [21.0]]), np.array([np.inf, 100.0]), np.array([100.0])).round(4).tolist()
    [[0.0], [0.3679]]
    """
    behind = np.full(temperature_c.shape, np.nan)
    followed = np.full(temperature_c.shape[1:], np.nan)
    waited = np.zeros(temperature_c.shape[1:])
    for row, temperature in enumerate(temperature_c):
        known = ~np.isnan(temperature)
        waited = waited + elapsed_s[row]
        start = np.where(np.isnan(followed), temperature, followed)
        now = np.exp(-waited / time_constant_s) * (temperature - start)
        followed = np.where(known, temperature - now, followed)
        waited = np.where(known, 0.0, waited)
        behind[row] = now  # NaN where the temperature is
    return behind


@dataclass
class Clusters:
    """The complete clusters of one axis of a run, one row each."""

    label: str  #: of the axis
    run_id: str
    profile_name: str
    simulated: bool
    length_s: float
    names: tuple[str, ...]  #: of the inputs: thermometers, "self", "aux:NAME"
    gradients: tuple[str, ...]
    start_s: Numbers  #: since the start of the run
    temperature_c: Numbers  #: clusters × inputs
    bias_deg_per_h: Numbers
    true_bias_deg_per_h: Numbers
    set_point_c: Numbers
    segment: NDArray[np.int32]  #: of the first sample; −1: none
    cycle: NDArray[np.int32]  #: of the first sample; −1: none
    history_elapsed_s: Numbers  #: time since the previous row of the history: all clusters without a missing second
    history_c: Numbers  #: temperatures of the history, from which lags are computed
    history_rows: NDArray[np.int64]  #: row of each cluster in the history

    def __len__(self) -> int:
        return int(self.start_s.size)

    @cached_property
    def rate_c_per_min(self) -> Numbers:
        """Returns the causal rate: (mean − mean of the previous cluster)/length; NaN in the first and after a gap."""
        rate = np.full(self.temperature_c.shape, np.nan)
        if len(self) > 1:
            follows = np.diff(np.rint((self.start_s - self.start_s[0]) / self.length_s)) == 1
            steps = np.diff(self.temperature_c, axis=0) * (SECONDS_PER_MINUTE / self.length_s)
            rate[1:][follows] = steps[follows]
        return rate

    def _column(self, name: str) -> int:
        if name not in self.names:
            raise ModelError(f'no thermometer "{name}", expected one of: {", ".join(self.names)}')
        return self.names.index(name)

    def _compute_lags(self, factors: set[Factor]) -> dict[Factor, Numbers]:
        ordered = sorted(factors, key=lambda factor: factor.order)
        if not ordered:
            return {}
        columns = [self._column(factor.first) for factor in ordered]
        constants = np.array([float(factor.time_constant_s) for factor in ordered])
        values = lags(self.history_c[:, columns], self.history_elapsed_s, constants)[self.history_rows]
        return dict(zip(ordered, values.T))

    def inputs(self, terms: Sequence[Term | str] | str) -> Numbers:
        """Returns the unscaled values of terms, clusters × terms: `clusters.inputs("A,A-B,rate:A,lag:600:A")`. A rate
        is NaN in the first cluster and after a gap."""
        if isinstance(terms, str):
            terms = [text.strip() for text in terms.split(",")]
        parsed = [term if isinstance(term, Term) else parse_term(term, self.names) for term in terms]
        lag_values = self._compute_lags({f for term in parsed for f in term.factors if f.kind == "lag"})

        def value_of(factor: Factor) -> Numbers:
            if factor.kind == "lag":
                return lag_values[factor]
            first = self._column(factor.first)
            if factor.kind == "rate":
                return self.rate_c_per_min[:, first]
            if factor.kind == "gradient":
                return self.temperature_c[:, first] - self.temperature_c[:, self._column(factor.second)]
            return self.temperature_c[:, first]

        return np.column_stack(evaluate(parsed, value_of)) if parsed else np.empty((len(self), 0))

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the means of the inputs, the bias and the profile position, indexed by the start of each cluster."""
        import pandas

        frame = pandas.DataFrame(dict(zip(self.names, self.temperature_c.T)))
        frame["bias_deg_per_h"] = self.bias_deg_per_h
        frame["true_bias_deg_per_h"] = self.true_bias_deg_per_h
        frame["set_point_c"] = self.set_point_c
        frame["segment"] = self.segment
        frame["cycle"] = self.cycle
        frame.index = pandas.Index(self.start_s, name="start_s")
        frame.attrs = {"run_id": self.run_id, "axis": self.label, "length_s": self.length_s,
                       "origin": "SIMULATED: instruments were virtual" if self.simulated else "measured"}
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Returns the content of `to_pandas` as a Dataset."""
        frame = self.to_pandas()
        dataset = frame.to_xarray()
        dataset.attrs = dict(frame.attrs)
        return dataset


def _missing_columns_text(axis: AxisColumns) -> str:
    missing = [name for name, values in axis.inputs.items()
               if name != "self" and not name.startswith("aux:") and not np.isfinite(values).any()]
    if not np.isfinite(axis.bias_deg_per_h).any():
        missing.append("the bias")
    return f"; no row has a value of {', '.join(missing)}" if missing else ""


def make_clusters(axis: AxisColumns, length_s: float, run_id: str, profile_name: str, simulated: bool) -> Clusters:
    """Divides an axis into clusters. Cluster k contains the samples with k·length ≤ t − t_0 < (k + 1)·length.

    A cluster is complete if each of its seconds has every temperature and the bias; values that the unit reports about
    itself may be missing. In an imported record each row has its own time, so no number of rows is required."""
    time = axis.time_s
    if time.size == 0:
        raise RecordError(f"contains no complete cluster of {length_s:g} s")
    step = float(np.sort(np.diff(time))[(time.size - 1) // 2]) if axis.imported and time.size > 1 else 1.0
    number = np.floor((time - time[0]) / length_s + _TIME_SLACK).astype(np.int64)
    complete = int(np.floor((time[-1] - time[0] + step) / length_s + _TIME_SLACK))
    firsts = np.flatnonzero(np.diff(number, prepend=number[0] - 1))
    counts = np.diff(firsts, append=time.size)
    numbers = number[firsts]

    def means(values: Numbers) -> Numbers:
        return np.add.reduceat(values, firsts) / counts

    each_second = (numbers < complete) & (axis.imported | (counts == round(length_s)))
    if not axis.inputs:
        raise RecordError("the record has no thermometer")
    temperatures = np.column_stack([means(values) for values in axis.inputs.values()])
    bias = means(axis.bias_deg_per_h)
    whole = each_second & np.isfinite(bias)
    for name, values in zip(axis.inputs, temperatures.T):
        if name != "self" and not name.startswith("aux:"):
            whole &= np.isfinite(values)
    if not whole.any():
        raise RecordError(f"contains no complete cluster of {length_s:g} s{_missing_columns_text(axis)}")
    history_numbers = numbers[each_second]
    return Clusters(
        label=axis.axis.label, run_id=run_id, profile_name=profile_name, simulated=simulated, length_s=length_s,
        names=tuple(axis.inputs), gradients=axis.gradients, start_s=time[0] + numbers[whole] * length_s,
        temperature_c=temperatures[whole], bias_deg_per_h=bias[whole],
        true_bias_deg_per_h=means(axis.true_bias_deg_per_h)[whole], set_point_c=means(axis.set_point_c)[whole],
        segment=axis.segment[firsts][whole], cycle=axis.cycle[firsts][whole],
        history_elapsed_s=np.concatenate([[np.inf], np.diff(history_numbers) * length_s]),
        history_c=temperatures[each_second], history_rows=np.flatnonzero(whole[each_second]))
