# SPDX-License-Identifier: Apache-2.0
"""Functions of a model file: four forms of the scaled inputs, and the variance of a Gaussian process."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable

import numpy as np

from .errors import ModelError
from .record import Numbers

_MAX_DIFFERENCES = 4_000_000  # per block: 32 MB


def squared_distances(points: Numbers, centres: Numbers) -> Numbers:
    """Returns ‖z − c‖², points × centres. Computed from the differences to avoid cancellation.
    >>> squared_distances(np.array([[0.0, 0.0]]), np.array([[3.0, 4.0]])).tolist()
    [[25.0]]
    """
    squares = np.zeros((len(points), len(centres)))
    for point, centre in zip(points.T, centres.T):
        squares += np.subtract.outer(point, centre) ** 2
    return squares


def _sum_of_gaussians(points: Numbers, centres: Numbers, widths: Numbers, weights: Numbers) -> Numbers:
    """Returns Σ_k w_k exp(−‖z − c_k‖²/(2 s_k²)) at each point."""
    rows = max(1, _MAX_DIFFERENCES // max(1, len(centres)))
    parts = [np.exp(squared_distances(points[i:i + rows], centres) / (-2 * widths**2)) @ weights
             for i in range(0, len(points), rows)]
    return np.concatenate(parts) if parts else np.zeros(0)


@dataclass(frozen=True)
class Function:
    """A trained function of scaled inputs."""

    form: str
    #: takes the inputs of the linear part and the inputs of all other parts, which differ outside the trained range
    evaluate: Callable[[Numbers, Numbers], Numbers]
    weight_sum: float  #: Σ|w|; the rounding error is proportional to it


def _matrix(entry: dict[str, Any], key: str, columns: int, rows: int | None = None) -> Numbers:
    matrix = np.asarray(entry[key], dtype=np.float64)
    if matrix.size == 0:
        matrix = matrix.reshape(0, columns)
    if matrix.ndim != 2 or matrix.shape[1] != columns or rows not in (None, len(matrix)):
        raise ValueError(f"{key}: {' × '.join(map(str, matrix.shape))} numbers, expected {rows or 'rows'} × {columns}")
    return matrix


def _vector(entry: dict[str, Any], key: str, size: int | None = None) -> Numbers:
    vector = np.asarray(entry[key], dtype=np.float64)
    if vector.ndim != 1 or size not in (None, vector.size):
        raise ValueError(f"{key}: {vector.size} numbers, expected {size}")
    return vector


def _positive_vector(entry: dict[str, Any], key: str, size: int) -> Numbers:
    vector = _vector(entry, key, size)
    if not (vector > 0).all():
        raise ValueError(f"{key}: expected numbers above 0")
    return vector


def function_from_json(function: dict[str, Any], inputs: int) -> Function:
    """Returns the function of a model file. Raises `ValueError` if the sizes of its parts do not match, or if a width
    or length is not positive."""
    form, b = function["form"], float(function["b"])
    if form == "svr":
        beta = _vector(function, "beta")
        vectors = _matrix(function, "support_vectors", inputs, beta.size)
        sigma = float(function["parameters"]["sigma"])
        if not sigma > 0:
            raise ValueError("sigma: expected a number above 0")
        widths = np.full(beta.size, sigma)
        return Function(form, lambda z, bounded: _sum_of_gaussians(bounded, vectors, widths, beta) + b,
                        float(np.abs(beta).sum()))
    if form == "linear":
        weights = _vector(function, "weights", inputs)
        return Function(form, lambda z, bounded: z @ weights + b, float(np.abs(weights).sum()))
    if form == "expansion":
        weights, lengths = _vector(function, "weights"), _positive_vector(function, "lengths", inputs)
        widths = _positive_vector(function, "widths", weights.size)
        centres = _matrix(function, "centres", inputs, weights.size) / lengths
        slope = _vector(function, "slope", inputs) if "slope" in function else np.zeros(inputs)

        def evaluate(z: Numbers, bounded: Numbers) -> Numbers:
            return _sum_of_gaussians(bounded / lengths, centres, widths, weights) + b + z @ slope

        return Function(form, evaluate, float(np.abs(weights).sum() + np.abs(slope).sum()))
    if form == "network":
        out = _vector(function, "out")
        hidden, offsets = _matrix(function, "weights", inputs, out.size), _vector(function, "offsets", out.size)
        return Function(form, lambda z, bounded: np.tanh(bounded @ hidden.T + offsets) @ out + b,
                        float(np.abs(out).sum()))
    raise ModelError(f'the function has the form "{form}", expected svr, linear, expansion or network')


def variance_from_json(variance: dict[str, Any], inputs: int) -> Callable[[Numbers], Numbers]:
    """Returns the variance of a Gaussian process as a function of the scaled inputs, relative to the target's variance:
    φᵀSφ + σ_f² − |w|², φ = (z, w), w = L⁻¹k."""
    lengths, signal = _positive_vector(variance, "lengths", inputs), float(variance["signal"])
    centres = _matrix(variance, "centres", inputs) / lengths
    count = len(centres)
    posterior = _matrix(variance, "posterior", inputs + count, inputs + count)
    root = _matrix(variance, "root", count, count)

    def evaluate(z: Numbers) -> Numbers:
        kernel = signal**2 * np.exp(-0.5 * squared_distances(z / lengths, centres))
        known = np.isfinite(kernel).all(axis=1)
        w = np.full(kernel.shape, np.nan)
        w[known] = np.linalg.solve(np.tril(root), kernel[known].T).T if count else kernel[known]
        features = np.hstack([z, w])
        explained = np.einsum("ij,ij->i", w, w)
        value = np.einsum("ij,ij->i", features @ posterior, features) + np.maximum(signal**2 - explained, 0)
        return np.maximum(value, 0)

    return evaluate
