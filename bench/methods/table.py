#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints a Markdown table of all methods over several gyros: table.py REPORT.json …

There is one report per gyro, and results are means over the gyros. Differences are paired by gyro: the RMSE relative to
the true bias (for real gyros, the RMSE of the residual) minus that of the reference method. The table has the mean
difference and its standard error. A method wins or loses if the difference exceeds two standard errors on every day.
"""

import json
import math
import statistics
import sys

YARDSTICK = "ridge-u-temperatures"


def error_of(found):
    truth = found.get("to_truth")
    return truth["rmse_deg_per_h"] if truth else found["rmse_deg_per_h"]


def with_error(values):
    """Returns the mean of the values and its standard error."""
    mean = statistics.fmean(values)
    return mean, statistics.stdev(values) / math.sqrt(len(values))


def thousandths(value, signed=False):
    return f"{1000 * value:{'+' if signed else ''}.2f}"


class Gyro:
    """Results of each method on each day in one report."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        self.days = ["the same day"] + [run["name"] for run in report["later"]]
        self.floors = [report["random"]["noise_floor_deg_per_h"]] + [
            run["noise_floor_deg_per_h"] for run in report["later"]]
        self.methods = {m["name"]: [m["random"]] + m["later"] for m in report["methods"]}
        self.recommended = report["recommendation"]["recommended"]
        self.simulated = report["rig"]["virtual"]


def verdict(gyros, name, days):
    outcomes = set()
    for day in range(days):
        mean, error = with_error([error_of(g.methods[name][day]) - error_of(g.methods[YARDSTICK][day]) for g in gyros])
        outcomes.add("wins" if mean < -2 * error else "loses" if mean > 2 * error else "–")
    return outcomes.pop() if len(outcomes) == 1 else "–"


def methods_table(gyros, names):
    days = gyros[0].days
    head = ["method"]
    for day in days:
        head += [f"{day}: STD", "RMSE", "error", f"less {YARDSTICK}", "in 95 %"]
    lines = [head + ["verdict"], ["---"] * (len(head) + 1)]
    for name in names:
        row = [name]
        for day in range(len(days)):
            found = [g.methods[name][day] for g in gyros]
            difference = with_error([error_of(g.methods[name][day]) - error_of(g.methods[YARDSTICK][day])
                                     for g in gyros])
            row += [thousandths(statistics.fmean(f["std_deg_per_h"] for f in found)),
                    thousandths(statistics.fmean(f["rmse_deg_per_h"] for f in found)),
                    thousandths(statistics.fmean(map(error_of, found))),
                    "" if name == YARDSTICK else f"{thousandths(difference[0], True)} ± {thousandths(difference[1])}",
                    f"{100 * statistics.fmean(f['coverage']['seen'] for f in found):.0f}"
                    if all(f.get("coverage") for f in found) else "–"]
        lines.append(row + ["yardstick" if name == YARDSTICK else verdict(gyros, name, len(days))])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def recommended_table(gyros):
    lines = ["| gyro | recommended | " + " | ".join(f"{day}: RMSE, over the floor, in 95 %" for day in gyros[0].days) +
             " |", "|" + "---|" * (2 + len(gyros[0].days))]
    for number, gyro in enumerate(gyros):
        cells = []
        for day, floor in enumerate(gyro.floors):
            found = gyro.methods[gyro.recommended][day]
            share = f"{100 * found['coverage']['seen']:.0f} %" if found.get("coverage") else "–"
            over = f"{found['rmse_deg_per_h'] / floor:.2f}" if floor else "–"
            cells.append(f"{thousandths(found['rmse_deg_per_h'])}, {over}, {share}")
        lines.append(f"| {number} | {gyro.recommended} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main(paths):
    gyros = [Gyro(path) for path in paths]
    if len(gyros) < 2 or any(g.days != gyros[0].days for g in gyros):
        sys.exit("expected reports of at least two gyros, verified after the same numbers of days")
    names = [name for name in gyros[0].methods if all(name in g.methods for g in gyros)]
    names.sort(key=lambda name: statistics.fmean(error_of(g.methods[name][-1]) for g in gyros))
    kind = "SIMULATED, " if any(g.simulated for g in gyros) else ""
    print(f"{kind}{len(gyros)} gyros, 10⁻³ °/h\n")
    print(methods_table(gyros, names))
    if all(g.recommended for g in gyros):
        print("\n" + recommended_table(gyros))


if __name__ == "__main__":
    main(sys.argv[1:])
