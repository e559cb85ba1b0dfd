#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the data sets of the benchmark.

make_sets.py FOLDER                the synthetic gyro sets
make_sets.py FOLDER --public FROM  public regression tables found in FROM, standardised

A set is FOLDER/NAME.bin: int32 n, int32 d, float64 X (n rows of d), float64 y (n), little endian.
"""
import argparse
import hashlib
import pathlib
import sys

import numpy as np

STEP_S = 10.0
CLUSTER_S = 100
LEVELS_C = (-40, 60, -40, 60, 0, 40, -20, 60, 20, -40, 60)
RATES_C_PER_MIN = (0.25, 0.5, 1.0, 2.0)
INPUTS = 13
# name: clusters, seed, beginning of the SHA-256 of the file with numpy 1.24
SYNTHETIC = {
    "gyro600": (600, 607, "e0601017dc5926b7"),
    "gyro2216": (2216, 2223, "49476bc3f367acb0"),
    "gyro10000": (10000, 10007, "faf324f03c2e41b3"),
}
SEXES = {"M": ("1", "0", "0"), "F": ("0", "1", "0"), "I": ("0", "0", "1")}


def air_profile(duration_s, rng):
    """Returns the air temperature in °C per step for ramps and soaks that start at 20 °C."""
    air = np.empty(len(np.arange(0, duration_s, STEP_S)))
    at, here, leg = 0, 20.0, 0
    while at < len(air):
        target = LEVELS_C[leg] if leg < len(LEVELS_C) else rng.uniform(-40, 60)
        rate_c_per_s = rng.choice(RATES_C_PER_MIN) / 60.0
        ramp = max(1, int(abs(target - here) / rate_c_per_s / STEP_S))
        soak = int(rng.uniform(1200, 5400) / STEP_S)
        steps = min(ramp, len(air) - at)
        air[at:at + steps] = here + (target - here) * np.arange(1, steps + 1) / ramp
        at += steps
        here = target
        steps = min(soak, len(air) - at)
        air[at:at + steps] = target
        at += steps
        leg += 1
    return air


def lagged(air, time_constant_s):
    """Returns the air temperature after a first-order lag that starts in equilibrium."""
    out = np.empty_like(air)
    share = 1 - np.exp(-STEP_S / time_constant_s)
    state = air[0]
    for i, value in enumerate(air):
        state += share * (value - state)
        out[i] = state
    return out


def per_minute(values):
    return np.gradient(values, STEP_S) * 60


def standardised(values):
    return (values - values.mean(0)) / values.std(0)


def synthetic(clusters, inputs, seed):
    """Returns simulated thermometers, gradients and rates of a block, and a smooth bias with 2 % of white noise."""
    rng = np.random.default_rng(seed)
    air = air_profile(clusters * CLUSTER_S, rng)
    lags = np.array([lagged(air, tau) for tau in np.geomspace(60, 7200, max(6, inputs // 2 + 2))])
    rows = []
    for j in range(inputs):
        q = j // 3
        here, next_, after = (lags[(q + k) % len(lags)] for k in range(3))
        rows.append((here + 0.15 * after, here - next_, per_minute(here))[j % 3])
    x = np.array(rows)
    x += 0.02 * rng.standard_normal(x.shape) * x.std(1, keepdims=True) * np.sqrt(CLUSTER_S / STEP_S) * 0.3

    steps = int(CLUSTER_S / STEP_S)

    def means(values):
        return values[..., :clusters * steps].reshape(*values.shape[:-1], clusters, steps).mean(-1)

    t = standardised(means(lags[2]))
    g1 = standardised(means(lags[1] - lags[4]))
    g2 = standardised(means(lags[3] - lags[-1]))
    r = standardised(means(per_minute(lags[3])))
    y = (0.8 * t - 0.35 * t**2 + 0.12 * t**3 + 0.6 * np.tanh(1.3 * g1) + 0.4 * g1 * t + 0.3 * np.sin(1.7 * g2)
         + 0.25 * r + 0.15 * r * g2)
    y = y / y.std() + 0.02 * rng.standard_normal(clusters)
    return standardised(means(x).T), standardised(y)


def public(path):
    """Reads a table with the target in the last column. A column with M, F or I (sex) becomes three columns. Skips
    other rows as headers."""
    rows = []
    for line in path.read_text(errors="replace").splitlines():
        fields = line.replace('"', "").replace(",", " ").split()
        fields = [out for field in fields for out in SEXES.get(field, (field,))]
        try:
            rows.append([float(field) for field in fields])
        except ValueError:
            continue
    width = max((len(row) for row in rows), default=0)
    table = np.array([row for row in rows if len(row) == width])
    if width < 2 or len(table) < 50 or not np.isfinite(table).all() or table[:, -1].std() == 0:
        return None
    x = table[:, :-1]
    return standardised(x[:, x.std(0) > 0]), standardised(table[:, -1])


def write(path, x, y):
    data = np.array(x.shape, "<i4").tobytes() + x.astype("<f8").tobytes() + y.astype("<f8").tobytes()
    path.write_bytes(data)
    return hashlib.sha256(data).hexdigest()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--public", type=pathlib.Path)
    options = arguments.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    if options.public is None:
        for name, (clusters, seed, expected) in SYNTHETIC.items():
            digest = write(options.folder / f"{name}.bin", *synthetic(clusters, INPUTS, seed))
            if not digest.startswith(expected):
                print(f"{name}: data differ from the reference (numpy {np.__version__} draws otherwise): figures stay "
                      "comparable within this run only", file=sys.stderr)
        return
    for path in sorted(options.public.iterdir()):
        if path.suffix not in (".data", ".csv", ".txt") or not path.is_file():
            continue
        table = public(path)
        if table is None:
            print(f"{path}: no table of numbers, left out", file=sys.stderr)
            continue
        write(options.folder / f"{path.stem}.bin", *table)
        print(path.stem)


if __name__ == "__main__":
    main()
