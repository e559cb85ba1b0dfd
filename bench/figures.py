# SPDX-License-Identifier: Apache-2.0
"""Output and common measurements of the Python benchmarks. Each result is a tab-separated line on stdout: name, value,
goal, ok or short. Progress goes to stderr."""
from __future__ import annotations

import os
import pathlib
import sqlite3
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def print_progress(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def print_figure(name: str, value: float, goal: str = "", is_met: bool = True) -> None:
    verdict = "" if not goal else "ok" if is_met else "short"
    print(f"{name}\t{value:.4g}\t{goal}\t{verdict}", flush=True)


def at_most(name: str, value: float, goal: float) -> None:
    print_figure(name, value, f"<= {goal:g}", value <= goal)


def at_least(name: str, value: float, goal: float) -> None:
    print_figure(name, value, f">= {goal:g}", value >= goal)


def quantile(values: list[float], part: float) -> float:
    """Returns the quantile of the values for the probability `part`."""
    return sorted(values)[min(len(values) - 1, int(part * len(values)))]


def processor_s(pid: int) -> float:
    """Returns the processor time that a process has used so far, s."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def ticks_ms(record: pathlib.Path, first: int, last: int) -> list[float]:
    """Returns the delay of each tick after the beginning of its second, ms, for the slots `first` to `last`."""
    with sqlite3.connect(f"file:{record}?immutable=1", uri=True) as database:
        rows = database.execute("SELECT slot, utc_ns FROM sample WHERE slot BETWEEN ? AND ?", (first, last)).fetchall()
        began = min(utc - slot * 10**9 for slot, utc in database.execute("SELECT slot, utc_ns FROM sample"))
    return [(utc - slot * 10**9 - began) / 1e6 for slot, utc in rows]
