# SPDX-License-Identifier: Apache-2.0
"""Statistics of a residual."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Figures:
    """Statistics of a residual over clusters, °/h.

    `std` divides by n − 1, as in the paper. `rmse` includes the mean."""

    std: float
    mean: float
    rmse: float
    max_abs: float
    count: int


def figures(residual_deg_per_h: ArrayLike) -> Figures:
    """Returns the statistics of a residual (bias minus prediction, one value per cluster). Ignores NaN.
    >>> f = figures([1.0, -1.0, float("nan")])
    >>> f.count, f.mean, f.rmse, round(f.std, 4)
    (2, 0.0, 1.0, 1.4142)
    """
    values = np.asarray(residual_deg_per_h, dtype=np.float64).ravel()
    values = values[np.isfinite(values)]
    if values.size == 0:
        return Figures(0.0, 0.0, 0.0, 0.0, 0)
    return Figures(std=float(values.std(ddof=1)) if values.size > 1 else 0.0, mean=float(values.mean()),
                   rmse=float(np.sqrt(np.mean(values**2))), max_abs=float(np.abs(values).max()), count=values.size)
