# SPDX-License-Identifier: Apache-2.0
"""Uncertainty budget of a model for means over any time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from .record import Numbers

_EXPONENTS = {"angle random walk": -0.5, "thermometer noise": -0.5, "counting of pulses": -1.0,
              "rate random walk": 0.5}  # of τ; all else stays


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of a mean of compensated bias over `averaging_s`."""

    averaging_s: float
    standard_deg_per_h: float  #: u_c
    degrees_of_freedom: float
    coverage_factor: float  #: k, for 95 %
    expanded_deg_per_h: float  #: U = k·u_c


def _t_probability(t: float, degrees_of_freedom: int) -> float:
    """Share of Student's distribution within ± t, of whole degrees of freedom (Abramowitz and Stegun 26.7.3 f.)."""
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
    """Student's t, of degrees of freedom cut to a whole number (GUM G.4.1).

    >>> round(coverage_factor(0.95, 10.9), 4), round(coverage_factor(0.95, math.inf), 4)
    (2.2281, 1.96)
    """
    z = NormalDist().inv_cdf(0.5 * (1 + share))
    if degrees_of_freedom > 1000:  # Abramowitz and Stegun 26.7.5; what is left out is below 1e-11
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


def of_mean_over(uncertainty: dict[str, Any], averaging_s: float) -> Uncertainty:
    """What the `uncertainty` of a model file comes to for a mean over another time: white noise goes with 1/√τ, the
    counting of pulses with 1/τ, rate random walk with √τ, all else stays; independent sources; Welch and
    Satterthwaite's degrees of freedom."""
    ratio = averaging_s / uncertainty["averaging_s"]
    contributions = []
    for row in uncertainty["budget"]:
        u = abs(row["sensitivity_deg_per_h_per_unit"]) * row["standard_uncertainty"]
        u *= ratio ** _EXPONENTS.get(row["source"], 0.0)
        contributions.append((u, row.get("degrees_of_freedom", math.inf)))
    variance = sum(u**2 for u, _ in contributions)
    of_it = sum((u**2 / variance) ** 2 / freedom for u, freedom in contributions) if variance > 0 else 0.0
    freedom = 1 / of_it if of_it > 0 else math.inf
    k = coverage_factor(0.95, freedom)
    return Uncertainty(averaging_s, math.sqrt(variance), freedom, k, k * math.sqrt(variance))


def expanded_outside(uncertainty: dict[str, Any], averaging_s: float, excess: Numbers) -> Numbers:
    """U of means whose worst input lies `excess` of its trained range outside, °/h. The variance of the model's form
    grows beyond the end as that of a straight line does: 3((1 + 2·excess)² − 1) of it is added."""
    inside = of_mean_over(uncertainty, averaging_s)
    form = sum((row["sensitivity_deg_per_h_per_unit"] * row["standard_uncertainty"]) ** 2
               for row in uncertainty["budget"] if row["source"] == "model form")
    added = 3 * ((1 + 2 * np.asarray(excess, dtype=np.float64)) ** 2 - 1) * form
    return np.asarray(inside.coverage_factor * np.sqrt(inside.standard_deg_per_h**2 + added))
