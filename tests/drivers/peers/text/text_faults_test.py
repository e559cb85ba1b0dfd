#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Seeded schedules of faulty answers during runs: every value in a record is one that the instrument sent in that
second.

    text_faults_test.py GYROTHERM [--schedules=N] [--seed=N] [--places=N] [NAME…]

A schedule is a draw of two to four kinds of faults, a share of the answers that have one, and ten seconds. The
instruments are independent of gyrotherm: the chambers of `PROTOCOLS` and a 34970A. The air always moves, so that a
value of another second differs.
"""
from __future__ import annotations

import pathlib
import random
import sys
import time

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]

import text_chambers_test
from text_chambers_test import FAKES, TextScene

import controllers_test
from bench import CHANNELS, SOURCE, Bench, Fake
from keysight import INPUTS, Keysight34970A
from program import Run, until
from records import Record
from simserv import SimServ
from text_server import HOSTILE, Faults, TextServer

SCANNER = "34970a"
SECONDS = 10.0  # of a schedule
REST = 4.0  # s between two schedules
# s from the answer to the record's second, in which the reading began, and the opposite
EARLY, LATE = 0.3, 1.3
INTERLOCK = 6  # exit code of a run that a persistent fault has ended
seed = 20261129


class ScannerBench(Bench):
    """A SimServ chamber whose air a 34970A measures."""

    def __init__(self, gyrotherm: pathlib.Path, folder: pathlib.Path, fake: Fake, air: float | None = None) -> None:
        super().__init__(gyrotherm, folder, fake, air)
        self.scanner = Keysight34970A(source=self.chamber)  # type: ignore[arg-type]
        self.scanner_server = TextServer(self.scanner)

    def rig(self, map_name: str = "", *, keys: str = "", more: str = "", name: str = "rig.toml") -> pathlib.Path:
        path = super().rig(map_name, keys=keys, more=more, name=name)
        inputs = ", ".join(f'"{channel}"' for channel in CHANNELS[:INPUTS])
        text = path.read_text(encoding="utf-8")
        every = ", ".join(f'"{channel}"' for channel in CHANNELS)
        assert every in text
        text = text.replace(f"channels = [{every}]", f'''channels = ["{CHANNELS[-1]}"]

[[thermometer]]
driver = "text"
description = "{SOURCE}/profiles/thermometers/keysight_34970a.toml"
line = "{self.scanner_server.line}"
channels = [{inputs}]''')
        path.write_text(text, encoding="utf-8")
        return path

    def close(self) -> None:
        super().close()
        self.scanner_server.close()


class Schedules(TextScene):
    """Several schedules in runs with one instrument."""

    def __init__(self, instrument: str, schedules: int) -> None:
        fake = FAKES.get(instrument, Fake(SimServ, TextServer, "weiss_simserv"))
        super().__init__(f"Faulty.{instrument}", lambda _: self.run_all(), fake)
        self.instrument, self.schedules = instrument, schedules
        self.draw = random.Random(f"{seed} {instrument}")
        self.seconds = self.readings = self.ended = 0
        self.made: dict[str, int] = {}

    def make_bench(self, folder: pathlib.Path) -> Bench:
        make = ScannerBench if self.instrument == SCANNER else Bench
        return make(controllers_test.gyrotherm, folder, self.fake, self.air)

    @property
    def faulty(self) -> object:
        return self.bench.scanner if self.instrument == SCANNER else self.chamber  # type: ignore[attr-defined]

    def profile(self) -> pathlib.Path:
        """Writes a profile whose set point always moves at 20 °C/min."""
        path = self.bench.folder / "profile.toml"
        hold = '[[segment]]\nkind = "hold"\nat = "24 °C"\ntime = "2 s"\n\n'
        ramps = "".join(f'[[segment]]\nkind = "ramp"\nto = "{to} °C"\nrate = "20 °C/min"\n\n' for to in (50, 24) * 60)
        path.write_text(f'schema = "gyrotherm-profile/1"\nname = "moving"\n\n{hold}{ramps}', encoding="utf-8")
        return path

    def run_all(self) -> None:
        number, left = 0, self.schedules
        while left > 0:
            self.chamber.airs.clear()
            self.chamber.set_points.clear()
            run = self.start(number)
            left = self.carry_out_schedules(run, left)
            self.faulty.faults = Faults()  # type: ignore[attr-defined]
            self.expect_truth(run)
            self.kill_both(run)
            self.ended += left > 0
            number += 1
            self.assertLess(self.ended, 3 + self.schedules // 3, "the faults end nearly every run")
        made = ", ".join(f"{kind} {count}" for kind, count in sorted(self.made.items()) if kind)
        self.facts.append(f"{self.schedules} schedules, {self.readings} readings in {self.seconds} s, 0 wrong; "
                          f"{self.ended} runs ended by an interlock; {made}")

    def start(self, number: int) -> Run:
        self.bench.profile = lambda seconds=600: self.profile()  # type: ignore[method-assign,misc]
        run = self.bench.run(self.bench.rig(), f"run{number}.db")
        began = run.wait_acknowledged(1, controllers_test.BEGINS)
        self.assertTrue(began, f"the run did not begin: exit {run.process.poll()}, {run.errors()[-900:]}")
        return run

    def carry_out_schedules(self, run: Run, left: int) -> int:
        """Returns how many schedules are left after the run has ended, or 0."""
        while left > 0 and not run.ended():
            left -= 1
            kinds = tuple(self.draw.sample(HOSTILE, self.draw.randint(2, 4)))
            share = self.draw.choice([0.05, 0.2, 0.5])
            faults = Faults(kinds, share, draw=random.Random(self.draw.random()))
            self.faulty.faults = faults  # type: ignore[attr-defined]
            until(run.ended, SECONDS)
            self.faulty.faults = Faults()  # type: ignore[attr-defined]
            for kind, count in faults.made.items():
                self.made[kind] = self.made.get(kind, 0) + count
            until(run.ended, REST)
        if run.ended():
            self.assertEqual(run.process.returncode, INTERLOCK, run.errors()[-900:])
        return left

    def expect_truth(self, run: Run) -> None:
        record = self.read(run)
        found = self.wrong_inputs(record) if self.instrument == SCANNER else (
            self.wrong(record, "chamber_air_c", self.chamber.airs) +
            self.wrong(record, "chamber_set_point_c", self.chamber.set_points))
        self.assertEqual(found, [], f"wrong readings: {found[:5]}")
        self.seconds += len(record.rows)

    def wrong(self, record: Record, column: str, sent: list[tuple[float, float]]) -> list[str]:
        """Returns the values that the instrument did not send in their second."""
        found, sent = [], list(sent)
        for slot, row in sorted(record.rows.items()):
            value, utc = row[column], row["utc_ns"] / 1e9
            if value is None:
                continue
            self.readings += 1
            times = [at - utc for at, one in sent if abs(one - value) < 5e-5]
            if not any(-EARLY <= time <= LATE for time in times):
                nearest = min(times, key=abs, default=None)
                found.append(f"second {slot}: {column} {value!r} was " +
                             ("never sent" if nearest is None else f"sent {nearest:+.2f} s from it"))
        return found

    def wrong_inputs(self, record: Record) -> list[str]:
        scans = list(self.bench.scanner.scans)  # type: ignore[attr-defined]
        return [text for i, channel in enumerate(CHANNELS[:INPUTS])
                for text in self.wrong(record, channel, [(at, scan[i]) for at, scan in scans])]


def tests(schedules: int) -> list[TextScene]:
    names = [*FAKES, SCANNER]
    found = []
    for place, name in enumerate(names):
        own = schedules // len(names) + (place < schedules % len(names))
        if own:
            found.append(Schedules(name, own))
    return found


def option(name: str, usual: int) -> int:
    return int(next((a.partition("=")[2] for a in sys.argv if a.startswith(f"--{name}=")), usual))


if __name__ == "__main__":
    seed = option("seed", seed)
    sys.exit(controllers_test.main(lambda long: tests(option("schedules", len(FAKES) + 1))))
