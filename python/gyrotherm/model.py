# SPDX-License-Identifier: Apache-2.0
"""A trained compensation model: reads a model file and evaluates it with NumPy, as the program does."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from .budget import Uncertainty, expanded_outside, of_mean_over
from .clusters import Clusters
from .errors import ModelError
from .functions import function_from_json, variance_from_json
from .record import Numbers
from .stream import inputs_each_second, led
from .terms import term_from_json

if TYPE_CHECKING:
    import pandas
    import xarray

    from .run import Run

SCHEMA = "gyrotherm-model/1"
OUTSIDE = ("continue", "refuse", "extrapolate")
_ROUNDING = 1e-9  # of a range: what the rounding of a mean may amount to
Predictable = Union["Run", Clusters, "pandas.DataFrame", "xarray.Dataset"]


class Model:
    """Predicts the bias in °/h, to be subtracted. `json` is the model file as it is."""

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
                raise ValueError("an input whose max is less than its min")
            if not (self.std > 0).all():
                raise ValueError("an input whose std is not above 0")
            self.target_mean_deg_per_h = float(content["target"]["mean_deg_per_h"])
            self.target_std_deg_per_h = float(content["target"]["std_deg_per_h"])
            if not self.target_std_deg_per_h > 0:
                raise ValueError("a target whose std is not above 0")
            self.is_led = bool(content.get("latency", {}).get("is_led", False))
            self.function = function_from_json(content["function"], len(self.terms))
            self._variance = variance_from_json(content["variance"], len(self.terms)) if "variance" in content else None
        except (KeyError, TypeError, ValueError) as error:
            raise ModelError(f"{file}: cannot be evaluated as a model: {error!r}") from error

    def __repr__(self) -> str:
        return f"<gyrotherm model: {self.method} on {', '.join(map(str, self.terms))}>"

    @property
    def names(self) -> tuple[str, ...]:
        """Thermometers (and "self", "aux:NAME") that the model needs."""
        named = {name for term in self.terms for f in term.factors for name in (f.first, f.second) if name}
        return tuple(sorted(named))

    @property
    def axis(self) -> tuple[str, str]:
        """Unit and axis of the training; empty if the record had only one."""
        first = self.json["trained_on"][0] if self.json.get("trained_on") else {}
        return first.get("unit", ""), first.get("axis", "")

    @property
    def rounding_deg_per_h(self) -> float:
        """Within what two evaluations of the model agree: 1e-12 of the bias' STD in training, and more as the weights
        add up to more than 1000."""
        return 1e-12 * self.target_std_deg_per_h * max(1.0, self.function.weight / 1000)

    def excess_of_inputs(self, inputs: Numbers) -> Numbers:
        """How far the worst of each row of unscaled inputs (rows × terms) is outside, as a part of its trained range;
        0 inside and where an input is not finite."""
        width = self.max - self.min
        beyond = np.maximum(self.min - inputs, inputs - self.max)
        known = np.isfinite(inputs).all(axis=1, keepdims=True)
        counts = known & (beyond > _ROUNDING * width)
        return np.where(counts, beyond / np.maximum(width, np.finfo(float).tiny), 0.0).max(axis=1, initial=0.0)

    def bounded_inputs(self, inputs: Numbers) -> Numbers:
        """Where all but the plane of the function is taken: rows outside the trained range are moved towards the mean
        of the training, all inputs by the same share, until each is in its range; a product whose factors are inputs
        is made of them anew."""
        rows = self.excess_of_inputs(inputs) > 0
        bounded = inputs.copy()
        if not rows.any():
            return bounded
        remade = self._remade_products()
        simple = [i for i in range(len(self.terms)) if i not in remade]
        away = inputs[rows] - self.mean
        room = np.where(away > 0, self.max, self.min) - self.mean
        is_out = (inputs[rows] < self.min) | (inputs[rows] > self.max)
        part = np.where(is_out, room / np.where(away == 0, 1.0, away), 1.0)[:, simple]
        share = np.clip(part.min(axis=1, initial=1.0), 0.0, 1.0)
        bounded[rows] = self.mean + share[:, None] * away
        for term, factors in remade.items():
            bounded[rows, term] = np.prod(bounded[rows][:, factors], axis=1)
        return bounded

    def _remade_products(self) -> dict[int, list[int]]:
        single = {term.factors[0]: i for i, term in enumerate(self.terms) if len(term.factors) == 1}
        return {i: [single[factor] for factor in term.factors] for i, term in enumerate(self.terms)
                if len(term.factors) > 1 and all(factor in single for factor in term.factors)}

    def predict_inputs(self, inputs: Numbers, outside: str = "continue") -> Numbers:
        """The bias of rows of unscaled inputs (rows × terms), °/h; NaN where an input is not finite. Outside the
        trained range the plane of the function continues and all else is taken at `bounded_inputs`; refuse: NaN;
        extrapolate: the whole function is used as it is."""
        if outside not in OUTSIDE:
            raise ModelError(f'outside="{outside}" is not a policy, expected {", ".join(OUTSIDE)}')
        known = np.isfinite(inputs).all(axis=1)
        if outside == "refuse":
            known &= self.excess_of_inputs(inputs) == 0
        bounded = self.bounded_inputs(inputs) if outside == "continue" else inputs
        bias = np.full(len(inputs), np.nan)
        bias[known] = self.function.at((inputs[known] - self.mean) / self.std,
                                       (bounded[known] - self.mean) / self.std)
        return bias * self.target_std_deg_per_h + self.target_mean_deg_per_h

    def inputs_of(self, of: Predictable) -> tuple[Numbers, pandas.Index]:
        """The model's unscaled inputs, rows × terms, and the time of each row."""
        import pandas

        if isinstance(of, Clusters):
            if of.length_s != self.cluster_length_s:
                raise ModelError(f"the clusters are of {of.length_s:g} s, the model of {self.cluster_length_s:g} s")
            return of.inputs(self.terms), pandas.Index(of.start_s, name="start_s")
        columns, time = _columns(of, self)
        return inputs_each_second(self.terms, columns, self.cluster_length_s), time

    def predict(self, of: Predictable, outside: str = "continue") -> pandas.Series:
        """The bias in °/h, to be subtracted. Of clusters: of each mean, by its start. Of a run, or a frame or Dataset
        with a row per second and a column for each of `names`: in each second from the means over the last cluster
        length (causal: it lags by half of that), NaN until there are enough rows and where a reading is missing. A model
        that `is_led` extrapolates by that half from the prediction of one cluster length before, as `compensate`."""
        import pandas

        inputs, time = self.inputs_of(of)
        bias = self.predict_inputs(inputs, outside)
        if self.is_led and not isinstance(of, Clusters):
            bias = led(bias, max(1, round(self.cluster_length_s)))
        return pandas.Series(bias, index=time, name="bias_deg_per_h")

    def predict_std(self, of: Predictable) -> pandas.Series:
        """The standard deviation of the function, °/h, as far as the model knows it (a Gaussian process): without the
        noise of a mean, and without what the thermometers do after the training. It grows outside the trained
        range."""
        import pandas

        if self._variance is None:
            raise ModelError(f"standard deviation: method {self.method} does not estimate it")
        inputs, time = self.inputs_of(of)
        scaled = (inputs - self.mean) / self.std
        return pandas.Series(self.target_std_deg_per_h * np.sqrt(self._variance(scaled)), index=time,
                             name="std_deg_per_h")

    def uncertainty(self, averaging_s: float | None = None) -> Uncertainty:
        """What the model's budget comes to for a mean of compensated bias over that time; its cluster length if none is
        given."""
        if "uncertainty" not in self.json:
            raise ModelError("the model has no budget")
        return of_mean_over(self.json["uncertainty"], averaging_s or self.cluster_length_s)

    def expanded_uncertainty(self, of: Predictable) -> pandas.Series:
        """U of a mean over the cluster length beside each prediction, °/h: wider where an input is outside the trained
        range."""
        import pandas

        if "uncertainty" not in self.json:
            raise ModelError("the model has no budget")
        inputs, time = self.inputs_of(of)
        expanded = expanded_outside(self.json["uncertainty"], self.cluster_length_s, self.excess_of_inputs(inputs))
        expanded[~np.isfinite(inputs).all(axis=1)] = np.nan
        return pandas.Series(expanded, index=time, name="U_deg_per_h")


def _columns(of: Any, model: Model) -> tuple[dict[str, Numbers], pandas.Index]:
    """Columns of seconds by the names of the model's inputs, and their times."""
    import pandas

    if hasattr(of, "inputs_each_second"):  # a run
        of = of.inputs_each_second(*model.axis)
    elif not hasattr(of, "columns"):  # a Dataset of xarray
        of = of.to_dataframe()
    if not isinstance(of, pandas.DataFrame):
        raise ModelError(f"cannot predict of a {type(of).__name__}: give a run, clusters, a DataFrame or a Dataset")
    if missing := [name for name in model.names if name not in of.columns]:
        raise ModelError(f'no column "{missing[0]}"; there are {", ".join(map(str, of.columns))}')
    return {name: of[name].to_numpy(dtype=np.float64) for name in model.names}, of.index


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a number")


def load_model(path: str | os.PathLike[str]) -> Model:
    """Reads a model file. Raises `ModelError`."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"), parse_constant=_no_number)
    except OSError as error:
        raise ModelError(f"{path}: {error.strerror or error}, expected a model file") from None
    except ValueError as error:
        raise ModelError(f"{path}: {error}, expected a model file") from None
    if not isinstance(content, dict):
        raise ModelError(f"{path}: is not a JSON object, expected a model file")
    return Model(content, str(path))
