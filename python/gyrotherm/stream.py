# SPDX-License-Identifier: Apache-2.0
"""Inputs of a model for each second, as in `compensate`: means over the last cluster length, with rates and lags."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .clusters import SECONDS_PER_MINUTE, lags
from .record import Numbers
from .terms import Factor, Term, evaluate


def sliding_means(values: Numbers, length: int) -> Numbers:
    """Returns the mean of the last `length` values at each position; NaN for the first positions.

    A window consists of the end of one block of `length` values and the beginning of the next, and the sums of both are
    computed separately. No value is ever subtracted, so rounding errors do not accumulate and a NaN does not persist.
    >>> sliding_means(np.array([1.0, 2.0, np.nan, 4.0, 5.0, 6.0]), 2).tolist()
    [nan, 1.5, nan, nan, 4.5, 5.5]
    """
    blocks = -(-values.size // length)
    padded = np.full(blocks * length, np.nan)
    padded[:values.size] = values
    table = padded.reshape(blocks, length)
    head_sums = np.cumsum(table, axis=1)
    tail_sums = np.zeros_like(table)  # of the previous block, after each position
    tail_sums[1:, :-1] = np.cumsum(table[:-1, :0:-1], axis=1)[:, ::-1]
    tail_sums[0, :-1] = np.nan
    return ((head_sums + tail_sums) / length).ravel()[:values.size]


def _lag_each_second(means: Numbers, length: int, time_constant_s: int) -> Numbers:
    """Returns the lag at each second. Each second has a series of means one cluster length apart that ends with it;
    `length` such series are computed side by side."""
    blocks = -(-means.size // length)
    padded = np.full(blocks * length, np.nan)
    padded[:means.size] = means
    elapsed = np.full(blocks, float(length))
    constants = np.full(length, float(time_constant_s))
    return lags(padded.reshape(blocks, length), elapsed, constants).ravel()[:means.size]


def inputs_each_second(terms: Sequence[Term], columns: dict[str, Numbers], length_s: float) -> Numbers:
    """Returns the values of terms, seconds × terms, from temperatures in °C, one row per second."""
    length = max(1, round(length_s))
    means = {name: sliding_means(values, length) for name, values in columns.items()}
    known: dict[Factor, Numbers] = {}

    def value_of(factor: Factor) -> Numbers:
        if factor not in known:
            mean = means[factor.first]
            if factor.kind == "rate":
                before = np.concatenate([np.full(min(length, mean.size), np.nan), mean[:-length]])[:mean.size]
                known[factor] = (mean - before) * (SECONDS_PER_MINUTE / length_s)
            elif factor.kind == "lag":
                known[factor] = _lag_each_second(mean, length, factor.time_constant_s)
            elif factor.kind == "gradient":
                known[factor] = mean - means[factor.second]
            else:
                known[factor] = mean
        return known[factor]

    return np.column_stack(evaluate(terms, value_of))


def apply_lead(predicted: Numbers, length: int) -> Numbers:
    """Extrapolates the prediction of each second by `length`/2 seconds, along the line through the prediction of
    `length` seconds before. Leaves a prediction unchanged if there is no earlier one.
    >>> apply_lead(np.array([np.nan, 1.0, 2.0, 4.0]), 1).tolist()
    [nan, 1.0, 2.5, 5.0]
    """
    before = np.concatenate([np.full(min(length, predicted.size), np.nan), predicted[:-length]])[:predicted.size]
    return np.where(np.isfinite(before), predicted + 0.5 * (predicted - before), predicted)
