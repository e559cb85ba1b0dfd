# SPDX-License-Identifier: Apache-2.0
"""A trained compensation model: reads a model file and evaluates it with NumPy, as the program does."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from .budget import Uncertainty, expanded_uncertainty_outside, mean_uncertainty
from .clusters import Clusters
from .errors import ModelError
from .functions import function_from_json, variance_from_json
from .record import Numbers
from .stream import apply_lead, inputs_each_second
from .terms import term_from_json

if TYPE_CHECKING:
    import pandas
    import xarray

    from .run import Run

SCHEMA = "gyrotherm-model/1"
OUTSIDE_POLICIES = ("continue", "refuse", "extrapolate")
_ROUNDING = 1e-9  # tolerance for a rounded mean, relative to the trained range
Predictable = Union["Run", Clusters, "pandas.DataFrame", "xarray.Dataset"]


class Model:
    """A trained model of the bias, °/h. Subtract its prediction to compensate. `json` is the content of the file."""

    def __init__(self, content: dict[str, Any], file: str = "model") -> None:
        if content.get("schema") != SCHEMA:
            raise ModelError(f'{file}: schema "{content.get("schema", "")}", expected "{SCHEMA}"')
        try:
            self.json = content
            self.method: str = content["method"]
            self.cluster_length_s = float(content["cluster_length_s"])
            self.terms = tuple(term_from_json(entry) for entry in content["terms"])
            self.mean, self.std, self.min, self.max = (
                np.array([float(entry[key]) for entry in content["terms"]]) for key in ("mean", "std", "min", "max"))
            if (self.max < self.min).any():
                raise ValueError("the max of an input is less than its min")
            if not (self.std > 0).all():
                raise ValueError("the std of an input is not above 0")
            self.target_mean_deg_per_h = float(content["target"]["mean_deg_per_h"])
            self.target_std_deg_per_h = float(content["target"]["std_deg_per_h"])
            if not self.target_std_deg_per_h > 0:
                raise ValueError("the std of the target is not above 0")
            self.is_led = bool(content.get("latency", {}).get("is_led", False))
            self.function = function_from_json(content["function"], len(self.terms))
            self._variance = variance_from_json(content["variance"], len(self.terms)) if "variance" in content else None
        except (KeyError, TypeError, ValueError) as error:
            raise ModelError(f"{file}: cannot be evaluated as a model: {error!r}") from error

    def __repr__(self) -> str:
        return f"<gyrotherm model: {self.method} on {', '.join(map(str, self.terms))}>"

    @property
    def names(self) -> tuple[str, ...]:
        """Returns the names of the thermometers (and "self", "aux:NAME") that the model requires, sorted."""
        named = {name for term in self.terms for f in term.factors for name in (f.first, f.second) if name}
        return tuple(sorted(named))

    @property
    def axis(self) -> tuple[str, str]:
        """Returns the unit and the axis of the training record; empty if the record had only one."""
        first = self.json["trained_on"][0] if self.json.get("trained_on") else {}
        return first.get("unit", ""), first.get("axis", "")

    @property
    def rounding_deg_per_h(self) -> float:
        """Returns the tolerance within which two evaluations of the model agree: 1e-12 of the bias' STD in training. If
        the sum of the weights exceeds 1000, the tolerance grows with it."""
        return 1e-12 * self.target_std_deg_per_h * max(1.0, self.function.weight_sum / 1000)

    def excess_of_inputs(self, inputs: Numbers) -> Numbers:
        """Returns the greatest distance of an input from its trained range, relative to the width of the range, for
        each row of unscaled inputs (rows × terms). It is 0 inside the range, and if an input is not finite."""
        width = self.max - self.min
        distance = np.maximum(self.min - inputs, inputs - self.max)
        known = np.isfinite(inputs).all(axis=1, keepdims=True)
        is_outside = known & (distance > _ROUNDING * width)
        return np.where(is_outside, distance / np.maximum(width, np.finfo(float).tiny), 0.0).max(axis=1, initial=0.0)

    def bounded_inputs(self, inputs: Numbers) -> Numbers:
        """Returns the inputs at which all parts of the function but the linear one are evaluated.

        Moves each row outside the trained range towards the training mean, all inputs by the same fraction, until each
        is in its range. Then recomputes the products whose factors are inputs themselves."""
        rows = self.excess_of_inputs(inputs) > 0
        bounded = inputs.copy()
        if not rows.any():
            return bounded
        products = self._recomputed_products()
        simple = [i for i in range(len(self.terms)) if i not in products]
        deviation = inputs[rows] - self.mean
        limit = np.where(deviation > 0, self.max, self.min) - self.mean
        is_out = (inputs[rows] < self.min) | (inputs[rows] > self.max)
        ratio = np.where(is_out, limit / np.where(deviation == 0, 1.0, deviation), 1.0)[:, simple]
        fraction = np.clip(ratio.min(axis=1, initial=1.0), 0.0, 1.0)
        bounded[rows] = self.mean + fraction[:, None] * deviation
        for term, factors in products.items():
            bounded[rows, term] = np.prod(bounded[rows][:, factors], axis=1)
        return bounded

    def _recomputed_products(self) -> dict[int, list[int]]:
        """Returns index of a product → indices of its factors, for products whose factors are all inputs."""
        single = {term.factors[0]: i for i, term in enumerate(self.terms) if len(term.factors) == 1}
        return {i: [single[factor] for factor in term.factors] for i, term in enumerate(self.terms)
                if len(term.factors) > 1 and all(factor in single for factor in term.factors)}

    def predict_inputs(self, inputs: Numbers, outside: str = "continue") -> Numbers:
        """Returns the bias of each row of unscaled inputs (rows × terms), °/h; NaN if an input is not finite.

        `outside` controls rows outside the trained range. "continue": the linear part continues, and all other parts
        are evaluated at `bounded_inputs`. "refuse": NaN. "extrapolate": the whole function is extrapolated."""
        if outside not in OUTSIDE_POLICIES:
            raise ModelError(f'outside="{outside}" is not a policy, expected {", ".join(OUTSIDE_POLICIES)}')
        known = np.isfinite(inputs).all(axis=1)
        if outside == "refuse":
            known &= self.excess_of_inputs(inputs) == 0
        bounded = self.bounded_inputs(inputs) if outside == "continue" else inputs
        bias = np.full(len(inputs), np.nan)
        bias[known] = self.function.evaluate((inputs[known] - self.mean) / self.std,
                                       (bounded[known] - self.mean) / self.std)
        return bias * self.target_std_deg_per_h + self.target_mean_deg_per_h

    def inputs_of(self, of: Predictable) -> tuple[Numbers, pandas.Index]:
        """Returns the model's unscaled inputs, rows × terms, and the time of each row."""
        import pandas

        if isinstance(of, Clusters):
            if of.length_s != self.cluster_length_s:
                raise ModelError(f"the length of the clusters is {of.length_s:g} s, that of the model "
                                 f"{self.cluster_length_s:g} s")
            return of.inputs(self.terms), pandas.Index(of.start_s, name="start_s")
        columns, time = _columns(of, self)
        return inputs_each_second(self.terms, columns, self.cluster_length_s), time

    def predict(self, of: Predictable, outside: str = "continue") -> pandas.Series:
        """Returns the predicted bias, °/h. Subtract it to compensate.

        - For clusters: one value per cluster, indexed by its start.
        - For a run, or a DataFrame or Dataset with one row per second and a column for each of `names`: one value per
          second, from the means over the last cluster length. These means lag by half a cluster length. The value is
          NaN until there are enough rows, and while a reading is missing.

        If the model `is_led`, predictions for seconds are extrapolated by half a cluster length, from the current
        prediction and that of one cluster length before, as in `compensate`."""
        import pandas

        inputs, time = self.inputs_of(of)
        bias = self.predict_inputs(inputs, outside)
        if self.is_led and not isinstance(of, Clusters):
            bias = apply_lead(bias, max(1, round(self.cluster_length_s)))
        return pandas.Series(bias, index=time, name="bias_deg_per_h")

    def predict_std(self, of: Predictable) -> pandas.Series:
        """Returns the standard deviation of the function itself, °/h. Only a Gaussian process estimates it. Noise of
        the means and drift of the thermometers are not included. It grows outside the trained range."""
        import pandas

        if self._variance is None:
            raise ModelError(f"standard deviation: method {self.method} does not estimate it")
        inputs, time = self.inputs_of(of)
        scaled = (inputs - self.mean) / self.std
        return pandas.Series(self.target_std_deg_per_h * np.sqrt(self._variance(scaled)), index=time,
                             name="std_deg_per_h")

    def uncertainty(self, averaging_s: float | None = None) -> Uncertainty:
        """Returns the uncertainty of a mean of compensated bias over `averaging_s`, from the model's budget. Without
        `averaging_s`, uses the cluster length."""
        if "uncertainty" not in self.json:
            raise ModelError("the model has no budget")
        return mean_uncertainty(self.json["uncertainty"], averaging_s or self.cluster_length_s)

    def expanded_uncertainty(self, of: Predictable) -> pandas.Series:
        """Returns U of each prediction, °/h, for a mean over the cluster length. It is larger outside the trained
        range."""
        import pandas

        if "uncertainty" not in self.json:
            raise ModelError("the model has no budget")
        inputs, time = self.inputs_of(of)
        expanded = expanded_uncertainty_outside(self.json["uncertainty"], self.cluster_length_s,
                                                self.excess_of_inputs(inputs))
        expanded[~np.isfinite(inputs).all(axis=1)] = np.nan
        return pandas.Series(expanded, index=time, name="U_deg_per_h")


def _columns(of: Any, model: Model) -> tuple[dict[str, Numbers], pandas.Index]:
    """Returns the columns of the model's inputs by name, one row per second, and the time of each row."""
    import pandas

    if hasattr(of, "inputs_each_second"):  # a run
        of = of.inputs_each_second(*model.axis)
    elif not hasattr(of, "columns"):  # a Dataset of xarray
        of = of.to_dataframe()
    if not isinstance(of, pandas.DataFrame):
        raise ModelError(f"cannot predict from a {type(of).__name__}; pass a run, clusters, a DataFrame or a Dataset")
    if missing := [name for name in model.names if name not in of.columns]:
        raise ModelError(f'no column "{missing[0]}", expected one of: {", ".join(map(str, of.columns))}')
    return {name: of[name].to_numpy(dtype=np.float64) for name in model.names}, of.index


def _refuse_constant(name: str) -> float:
    """Refuses NaN and Infinity, which Python's JSON parser accepts."""
    raise ValueError(f"{name} is not a number")


def load_model(path: str | os.PathLike[str]) -> Model:
    """Reads a model file. Raises `ModelError`."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"), parse_constant=_refuse_constant)
    except OSError as error:
        raise ModelError(f"{path}: {error.strerror or error}, expected a model file") from None
    except ValueError as error:
        raise ModelError(f"{path}: {error}, expected a model file") from None
    if not isinstance(content, dict):
        raise ModelError(f"{path}: is not a JSON object, expected a model file")
    return Model(content, str(path))
