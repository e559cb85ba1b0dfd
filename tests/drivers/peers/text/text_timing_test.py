#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Slow answers of a SimServ chamber and a 34970A: a run keeps one second, and `check --connect` reports what does not
fit.

    text_timing_test.py GYROTHERM [--places=N] [NAME…]
"""
from __future__ import annotations

import pathlib
import sys
from typing import Callable

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]

import text_chambers_test
from text_chambers_test import TextScene
from text_faults_test import ScannerBench

import controllers_test
from bench import CHANNELS, Bench, Fake
from program import Ran
from simserv import SimServ
from text_server import TextServer

ANSWER = 0.1  # s
SECONDS = 20


class Timing(TextScene):
    """A SimServ chamber with a 34970A."""

    def __init__(self, name: str, act: "Callable[[Timing], None]", answer: float, scan: float) -> None:
        super().__init__(name, act, Fake(SimServ, TextServer, "weiss_simserv"))  # type: ignore[arg-type]
        self.answer, self.scan = answer, scan

    def make_bench(self, folder: pathlib.Path) -> Bench:
        bench = ScannerBench(controllers_test.gyrotherm, folder, self.fake, self.air)
        bench.chamber.answer_time = self.answer  # type: ignore[attr-defined]
        bench.scanner.answer_time, bench.scanner.scan_time = ANSWER, self.scan
        return bench

    def checked(self) -> Ran:
        return self.bench.check(self.bench.rig())


def keeps_one_second(scene: Timing) -> None:
    """Each second has a sample with all readings."""
    checked = scene.checked()
    scene.assertEqual(checked.code, 0, checked.text)
    scene.assertNotIn("do NOT fit", checked.text)
    run = scene.begin()
    scene.assertTrue(run.wait_acknowledged(SECONDS, SECONDS + controllers_test.BEGINS), run.errors()[-900:])
    scene.kill_both(run)
    record = scene.read(run)
    slots = sorted(record.rows)
    scene.assertGreaterEqual(len(slots), SECONDS)
    scene.assertEqual(slots, list(range(len(slots))), "seconds are missing")
    scene.assertEqual(record.gaps, [])
    missing = [f"second {slot}: {name}" for slot, row in sorted(record.rows.items())
               for name in ("chamber_air_c", "chamber_set_point_c", *CHANNELS) if row[name] is None]
    scene.assertEqual(missing, [], f"readings are missing: {record.faults[:5]}")
    scene.facts.append(f"{len(slots)} s, each with {2 + len(CHANNELS)} readings")


def chamber_does_not_fit(scene: Timing) -> None:
    """`check --connect` names the chamber, the time of an exchange, and how many fit."""
    checked = scene.checked()
    scene.assertRegex(checked.text, r"chamber: [^\n]*WARNING: \d exchanges of 0\.4\d\d s [^\n]* do NOT fit into a "
                      r"second, in which 2 fit")
    scene.assertEqual(scene.chamber.heard, [], "check has written")


def scan_is_refused(scene: Timing, *parts: str) -> None:
    """`check --connect` refuses, and names the instrument, its time and the limit; a run does not begin."""
    checked = scene.checked()
    scene.assertEqual(checked.code, 3, checked.text)
    for part in ("FAULT thermometer 2: ", "HEWLETT-PACKARD,34970A" if "fit" in parts[-1] else "*OPC?;FETC?", *parts):
        scene.assertIn(part, checked.text)
    scene.facts.append(next(line.strip() for line in checked.text.splitlines() if parts[0] in line)[:150])


def longer_than_limit(scene: Timing) -> None:
    scan_is_refused(scene, " takes 1.3", "its time limit is 0.9 s")
    run = scene.bench.run(scene.bench.rig())
    scene.assertEqual(run.wait(controllers_test.BEGINS), 3, run.errors()[-900:])
    scene.assertEqual(scene.chamber.heard, [], "the chamber was commanded")


def longer_than_share(scene: Timing) -> None:
    scan_is_refused(scene, "a reading takes 0.8", "0.8 s fit")


def tests(_: bool) -> list[TextScene]:
    return [Timing("KeepsOneSecond", keeps_one_second, ANSWER, 0.4),
            Timing("ChamberDoesNotFit", chamber_does_not_fit, 0.4, 0.1),
            Timing("ScanLongerThanLimit", longer_than_limit, 0.0, 1.3),
            Timing("ScanLongerThanShare", longer_than_share, 0.0, 0.85)]


if __name__ == "__main__":
    sys.exit(controllers_test.main(tests))
