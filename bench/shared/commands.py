#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the benefit of a type prior for a new unit with the commands of gyrotherm, on the records of
bench/shared/compare. Prints U of the budget, the intervals and the share of means within them, with and without the
prior, as Markdown (10⁻³ °/h, mean ± standard error).

bench/shared/commands.py GYROTHERM RECORDS FOLDER [--units 12]

RECORDS contains rate-N.db and random-N.db. Priors and models are written to FOLDER.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
from pathlib import Path

LENGTHS = {"1": 36, "2": 72, "4": 144, "8": 288, "61.6": 0}  # hours and clusters; 0: all


def call(program: str, *arguments: object) -> str:
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def judge(program: str, model: Path, random: Path) -> dict[str, float]:
    uncertainty = json.loads(model.read_text())["uncertainty"]
    rows = [row["standard_uncertainty"] for row in uncertainty["budget"] if row["source"] == "coefficients"]
    coverage = json.loads(call(program, "verify", model, random, "--json", "--unverified").splitlines()[0])["coverage"]
    return {"U": 1e3 * uncertainty["combined"]["U_deg_per_h"], "coefficients": 1e3 * rows[0] if rows else 0,
            "half-width": 1e3 * coverage["mean_half_width_deg_per_h"], "share": 100 * coverage["seen"]}


def cell(values: list[float]) -> str:
    error = statistics.stdev(values) / len(values) ** 0.5
    return f"{statistics.mean(values):.1f} ± {error:.1f}"


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("program")
    arguments.add_argument("records", type=Path)
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--units", type=int, default=12)
    asked = arguments.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    units = range(1, asked.units + 1)
    found: dict[tuple[str, str], list[dict[str, float]]] = {}
    for unit in units:
        others = [asked.records / f"{run}-{other}.db" for other in units if other != unit for run in ("rate", "random")]
        prior, random = asked.folder / f"prior-{unit}.json", asked.records / f"random-{unit}.db"
        if not prior.exists():
            call(asked.program, "type-prior", *others, "--out", prior)
        for hours, clusters in LENGTHS.items():
            part = ["--clusters", f"0:{clusters}"] if clusters else []
            for name, how in (("type prior", ["--prior", prior]), ("ridge-u", ["--method", "ridge-u"])):
                model = asked.folder / f"{name.replace(' ', '-')}-{unit}-{hours}.json"
                try:
                    call(asked.program, "train", asked.records / f"rate-{unit}.db", *how, *part, "--out", model, "--force",
                         "--unverified")
                except RuntimeError as error:  # too few clusters for folds
                    print(f"{name}, unit {unit}, {hours} h: {error}", flush=True)
                    continue
                found.setdefault((name, hours), []).append(judge(asked.program, model, random))
    print("| own hours | " + " | ".join(LENGTHS) + " |\n|" + "---|" * (len(LENGTHS) + 1))
    for name in ("type prior", "ridge-u"):
        for figure in ("U", "coefficients", "half-width", "share"):
            cells = [found.get((name, hours), []) for hours in LENGTHS]
            print(f"| {name}: {figure} | "
                  + " | ".join(cell([one[figure] for one in each]) if len(each) > 1 else "–" for each in cells) + " |")


if __name__ == "__main__":
    main()
