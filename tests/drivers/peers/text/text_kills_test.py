#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""kill -9 at random moments of a run, with an independent instrument of each text protocol.

    text_kills_test.py GYROTHERM [--kills=N] [--seed=N] [--places=N] [NAME…]

A kill ends the program during its start, just after an acknowledged second, or at any other moment. Then the guard, or
after every fourth kill gyrotherm-make-safe without a guard, must make the chamber safe within 20 s. Each run begins
where the one before it left the chamber.
"""
from __future__ import annotations

import pathlib
import random
import signal
import statistics
import sys
import time

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]

import text_chambers_test
from text_chambers_test import CONFIRMED_WITHIN, FAKES, SAFE_WITHIN, TextScene

import controllers_test
from program import Run, until

PROTOCOLS = ("simserv", "ascii2", "espec", "thermotron", "cts", "julabo")
KILLS_A_BENCH = 9
STARTS_WITHIN = 4.0  # s from the start of the program, for kills during the start
LAST_SECOND = 12  # acknowledged second after which no kill is drawn
seed = 20261129


class Kills(TextScene):
    """Several kills, one after the other, on one bench."""

    def __init__(self, protocol: str, number: int, kills: int) -> None:
        super().__init__(f"Killed.{protocol}.{number}", lambda _: self.kill_all(), FAKES[protocol])
        self.draw, self.kills = random.Random(f"{seed} {protocol} {number}"), kills
        self.times: list[float] = []
        self.counts = {"start": 0, "acknowledged": 0, "guard too": 0, "before any command": 0}

    def kill_all(self) -> None:
        self.bench.profile = lambda seconds=600: self.profile()  # type: ignore[method-assign,misc]
        for number in range(self.kills):
            self.kill_one(number)
        self.assertEqual(self.chamber.unknown, [], "lines that the unit does not know were sent")
        self.facts.append(f"{len(self.times)} kills, safe after {statistics.median(self.times):.1f} s (median), "
                          f"{max(self.times):.1f} s (longest); {self.counts}")

    def kill_one(self, number: int) -> None:
        commands = len(self.chamber.heard)
        run = self.bench.run(self.bench.rig(), f"run{number}.db")
        moment = self.wait_for_moment(run)
        guard_too = number % 4 == 3 and run.acknowledged() >= 0
        if guard_too:
            self.kill_both(run)
        else:
            run.signal(signal.SIGKILL)
            run.wait()
        killed = time.monotonic()
        self.assertEqual(run.process.returncode, -signal.SIGKILL, f"{moment}: {run.errors()[-900:]}")
        self.counts["guard too"] += guard_too
        self.counts["before any command"] += len(self.chamber.heard) == commands
        if guard_too:
            made = self.bench.programs.finish([self.bench.programs.make_safe, run.record], 150)
            self.assertEqual(made.code, 0, f"{moment}: {made.text}")
            last = max((command.at for command in self.chamber.heard), default=killed)
            self.times.append(max(0.0, last - killed))
            self.assertLess(self.times[-1], SAFE_WITHIN, f"{moment}, guard too: {made.text}")
        else:
            safe = until(self.is_safe, SAFE_WITHIN)
            self.assertTrue(safe, f"{moment}: not safe in {SAFE_WITHIN:g} s, follows {self.chamber.follows()}: "
                            f"{run.errors()[-900:]}")
            self.times.append(time.monotonic() - killed)
            self.assertTrue(until(lambda: not run.guards(), CONFIRMED_WITHIN), f"{moment}: the guard does not end")
        self.assertTrue(self.confirmed(run), f"{moment}: not confirmed: {run.errors()[-900:]}")
        self.assertTrue(self.is_safe(), f"{moment}: safe for some time only")

    def wait_for_moment(self, run: Run) -> str:
        """Waits for a random moment of the run and returns its description."""
        if self.draw.random() < 0.25:
            self.counts["start"] += 1
            seconds = self.draw.uniform(0, STARTS_WITHIN)
            time.sleep(seconds)
            return f"killed {seconds:.3f} s after the start"
        self.counts["acknowledged"] += 1
        second = self.draw.randrange(LAST_SECOND)
        began = run.wait_acknowledged(second, controllers_test.BEGINS)
        self.assertTrue(began, f"second {second} was not acknowledged: {run.errors()[-900:]}")
        # A command is sent just after a second begins.
        seconds = self.draw.uniform(0, 0.1) if self.draw.random() < 0.5 else self.draw.uniform(0, 1)
        time.sleep(seconds)
        return f"killed {seconds:.3f} s after second {second}"


def tests(kills: int) -> list[TextScene]:
    """Divides the kills among the protocols, and among benches of at most KILLS_A_BENCH kills."""
    found: list[TextScene] = []
    for place, protocol in enumerate(PROTOCOLS):
        own = kills // len(PROTOCOLS) + (place < kills % len(PROTOCOLS))
        benches = -(-own // KILLS_A_BENCH)
        found += [Kills(protocol, number, own // benches + (number < own % benches)) for number in range(benches)]
    return found


def option(name: str, usual: int) -> int:
    return int(next((a.partition("=")[2] for a in sys.argv if a.startswith(f"--{name}=")), usual))


if __name__ == "__main__":
    seed = option("seed", seed)
    sys.exit(controllers_test.main(lambda long: tests(option("kills", len(PROTOCOLS)))))
