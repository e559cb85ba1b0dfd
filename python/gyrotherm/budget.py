# SPDX-License-Identifier: Apache-2.0
"""Uncertainty budget of a model for means over any averaging time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from .record import Numbers

_EXPONENTS = {"angle random walk": -0.5, "thermometer noise": -0.5, "counting of pulses": -1.0,
              "rate random walk": 0.5}  # exponent of τ; other sources: 0


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of a mean of compensated bias over `averaging_s`."""

    averaging_s: float
    standard_deg_per_h: float  #: u_c
    degrees_of_freedom: float
    coverage_factor: float  #: k, for 95 %
    expanded_deg_per_h: float  #: U = k·u_c


def _t_probability(t: float, degrees_of_freedom: int) -> float:
    """Returns the probability of |T| ≤ t for Student's T (Abramowitz and Stegun 26.7.3 and 26.7.4)."""
    angle = math.atan(t / math.sqrt(degrees_of_freedom))
    cosine, odd = math.cos(angle), degrees_of_freedom % 2
    term = total = 0.0
    if degrees_of_freedom > 1:
        term = total = cosine if odd else 1.0
    for k in range(3 if odd else 2, degrees_of_freedom - 1, 2):
        term *= cosine**2 * (k - 1) / k
        total += term
    total *= math.sin(angle)
    return 2 / math.pi * (angle + total) if odd else total


def coverage_factor(share: float, degrees_of_freedom: float) -> float:
    """Returns Student's t for a coverage probability. Truncates the degrees of freedom to an integer (GUM G.4.1).
    >>> round(coverage_factor(0.95, 10.9), 4), round(coverage_factor(0.95, math.inf), 4)
    (2.2281, 1.96)
    """
    z = NormalDist().inv_cdf(0.5 * (1 + share))
    if degrees_of_freedom > 1000:  # Abramowitz and Stegun 26.7.5; truncation error below 1e-11
        n = degrees_of_freedom if math.isinf(degrees_of_freedom) else math.floor(degrees_of_freedom * (1 + 1e-9))
        return (z + (z**3 + z) / (4 * n) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * n**2)
                + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * n**3))
    whole = max(1, math.floor(degrees_of_freedom * (1 + 1e-9)))
    low, high = 0.0, 1.0
    while _t_probability(high, whole) < share:
        high *= 2
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if _t_probability(middle, whole) < share else (low, middle)
    return high


def mean_uncertainty(uncertainty: dict[str, Any], averaging_s: float) -> Uncertainty:
    """Returns the uncertainty of a mean over `averaging_s`, from the `uncertainty` of a model file.

    White noise scales with 1/√τ, quantisation with 1/τ and rate random walk with √τ; other sources are constant. The
    sources are independent. The degrees of freedom are those of Welch and Satterthwaite."""
    ratio = averaging_s / uncertainty["averaging_s"]
    contributions = []
    for row in uncertainty["budget"]:
        u = abs(row["sensitivity_deg_per_h_per_unit"]) * row["standard_uncertainty"]
        u *= ratio ** _EXPONENTS.get(row["source"], 0.0)
        contributions.append((u, row.get("degrees_of_freedom", math.inf)))
    variance = sum(u**2 for u, _ in contributions)
    inverse = sum((u**2 / variance) ** 2 / freedom for u, freedom in contributions) if variance > 0 else 0.0
    freedom = 1 / inverse if inverse > 0 else math.inf
    k = coverage_factor(0.95, freedom)
    return Uncertainty(averaging_s, math.sqrt(variance), freedom, k, k * math.sqrt(variance))


def expanded_uncertainty_outside(uncertainty: dict[str, Any], averaging_s: float, excess: Numbers) -> Numbers:
    """Returns U of each mean, °/h. `excess` is the greatest distance of an input from its trained range, relative to
    the width of the range.

    Outside the range the variance of the model form grows like that of a straight line: 3((1 + 2·excess)² − 1) times
    the variance is added."""
    inside = mean_uncertainty(uncertainty, averaging_s)
    form = sum((row["sensitivity_deg_per_h_per_unit"] * row["standard_uncertainty"]) ** 2
               for row in uncertainty["budget"] if row["source"] == "model form")
    added = 3 * ((1 + 2 * np.asarray(excess, dtype=np.float64)) ** 2 - 1) * form
    return np.asarray(inside.coverage_factor * np.sqrt(inside.standard_deg_per_h**2 + added))
