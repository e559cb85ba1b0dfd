#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The program against an independent power supply of each protocol.

    supplies_test.py GYROTHERM

Each protocol has a run that switches the unit off and on, and a run in which the supply trips. Further tests: another
instrument, a locked panel, the numbers of another locale, a silent supply, and a live output with other settings.
"""
from __future__ import annotations

import contextlib
import pathlib
import signal
import sqlite3
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "controllers"), str(HERE.parents[2] / "edges")]

import program
from bench import FAKES, SOURCE, Bench
from program import until
from records import read_record
from supplies import MODELS, Dp832, Supply, SupplyServer

AT = 25.0  # °C, the air of the chamber at the start
VOLTS, AMPERES = 24.0, 0.8
STARTED = 60.0  # s


def gyrotherm() -> pathlib.Path:
    return pathlib.Path(sys.argv[1])


class Scene:
    """A chamber, a supply and the program, in a folder of their own."""

    def __init__(self, name: str, supply: Supply, on_stop: str = "keep") -> None:
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix=f"gyrotherm-supply-{name}-"))
        self.bench = Bench(gyrotherm(), self.folder, FAKES["umc1200_miscounting"], AT)
        self.supply, self.server = supply, SupplyServer(supply)
        level = AMPERES if supply.trips_at_limit else 1.0
        self.rig = self.bench.rig(more=f"""
[[supply]]
description = "{SOURCE}/profiles/supplies/{name}.toml"
line = "{self.server.line}"
on_stop = "{on_stop}"
boot = "1 s"

[[supply.output]]
output = 2
voltage_v = {VOLTS}
current_a = {AMPERES}
over_voltage_v = 26.0
over_current_a = {level}
highest_a = 0.7
""")
        self.output = supply.outputs[1]

    def profile(self, off: int = 4, on: int = 5) -> pathlib.Path:
        path = self.folder / "profile.toml"
        path.write_text(f"""schema = "gyrotherm-profile/1"
name = "cold start"

[[segment]]
kind = "hold"
at = {AT:g}
time = "3 s"

[[segment]]
kind = "hold"
time = "{off} s"
power = "off"

[[segment]]
kind = "hold"
time = "{on} s"
power = "on"
""", encoding="utf-8")
        return path

    def check(self) -> program.Ran:
        command = [gyrotherm(), "check", self.profile(), "--rig", self.rig, "--connect"]
        return self.bench.programs.finish(command, 60)

    def run(self, off: int = 4, on: int = 5) -> program.Run:
        path = self.folder / "run.db"
        command = ["run", self.profile(off, on), "--rig", self.rig, "--out", path, "--json"]
        return program.start(self.bench.programs, command, path, name="run")

    def cause(self, run: program.Run) -> str:
        return str(run.status())

    def close(self) -> None:
        self.bench.close()
        self.server.close()


class Supplies(unittest.TestCase):
    def scene(self, name: str, supply: Supply, **keys: str) -> Scene:
        scene = Scene(name, supply, **keys)
        self.addCleanup(scene.close)
        return scene

    def switched(self, name: str, supply: Supply) -> None:
        scene = self.scene(name, supply)
        checked = scene.check()
        self.assertEqual(checked.code, 0, checked.text)
        self.assertIn(supply.identity, checked.text)
        self.assertEqual(supply.commands, [], "check --connect must change nothing")
        run = scene.run()
        code = run.wait(STARTED)
        self.assertEqual(code, 0, run.errors() + run.output())
        self.assertTrue(scene.output.on, "the profile ends with the unit on")
        self.assertEqual(scene.output.volts, VOLTS)
        self.assertEqual(supply.unknown, [])
        switches = [line for line in supply.commands if "OP" in line.split(" ")[0] or "OUTP" in line]
        self.assertGreaterEqual(len(switches), 3, "on, off, on")
        self.assertFalse(any(" 0.000" in line for line in supply.commands), "off is never 0 V")
        events = [text for _, _, text in read_record(scene.folder / "run.db", scene.folder / "copy").events]
        self.assertEqual(sum(text.startswith("supply 1 is off: ") for text in events), 1, events)
        self.assertEqual(sum(text.startswith("supply 1 is on: ") for text in events), 2, events)
        self.assertFalse(any("the profile asks" in text for text in events), "no person is asked")
        for other in (output for output in supply.outputs if output is not scene.output):
            self.assertFalse(other.on, "another output was switched")

    def tripped(self, name: str, supply: Supply) -> None:
        scene = self.scene(name, supply)
        run = scene.run(off=3, on=60)
        self.assertTrue(run.wait_acknowledged(9), run.errors())
        supply.trip(1)
        self.assertTrue(until(lambda: "has tripped" in scene.cause(run), 20), scene.cause(run))
        commands = len(supply.commands)
        self.assertTrue(run.wait_acknowledged(run.acknowledged() + 4))
        self.assertEqual(len(supply.commands), commands, "nothing switches it on again")
        done, answer = run.tell("resume", "the load is repaired")
        self.assertTrue(done, answer)
        self.assertTrue(until(lambda: scene.output.on, 20), scene.cause(run))
        run.tell("abort")
        self.assertIsNotNone(run.wait(STARTED))
        self.assertTrue(scene.output.on, "on_stop is keep")

    def test_killed_and_resumed(self) -> None:
        scene = self.scene("rigol_dp800", Dp832())
        run = scene.run(off=20, on=6)
        self.assertTrue(run.wait_acknowledged(6), run.errors())
        self.assertFalse(scene.output.on)
        run.signal(signal.SIGKILL)
        run.wait(20)
        commands = list(scene.supply.commands)
        until(lambda: not run.guards(), 90)  # the guard makes the chamber safe and ends
        self.assertEqual(scene.supply.commands, commands, "the guard switches no supply")
        resumed = program.start(scene.bench.programs, ["resume", run.record, "--accept", "--json"], run.record,
                                name="resume")
        self.assertTrue(resumed.wait_acknowledged(10), resumed.errors())
        self.assertEqual(scene.supply.commands, commands, "the state is read, not restored")
        self.assertEqual(resumed.wait(180), 0, resumed.errors())
        self.assertTrue(scene.output.on)

    def test_cold_starts_on_the_virtual_rig(self) -> None:
        folder = pathlib.Path(tempfile.mkdtemp(prefix="gyrotherm-cold-starts-"))
        programs, path = program.Programs(gyrotherm(), folder), folder / "run.db"
        ran = programs.finish([gyrotherm(), "run", SOURCE / "profiles/cold-starts.toml", "--rig",
                               SOURCE / "profiles/rigs/virtual-supply.toml", "--out", path], 600)
        self.assertEqual(ran.code, 0, ran.text)
        with contextlib.closing(sqlite3.connect(path)) as record:
            texts = [text for text, in record.execute("SELECT text FROM event")]
        self.assertEqual(sum(text.startswith("supply 1 is off: ") for text in texts), 3, texts)
        self.assertEqual(sum(text.startswith("supply 1 is on: ") for text in texts), 4, texts)
        self.assertFalse(any("the profile asks" in text or "held" in text for text in texts), texts)

    def test_another_instrument(self) -> None:
        scene = self.scene("rigol_dp800", Dp832())
        scene.supply.another = True
        checked = scene.check()
        self.assertNotEqual(checked.code, 0)
        self.assertIn("ACME,PS-1", checked.text)
        run = scene.run()
        self.assertNotEqual(run.wait(STARTED), 0)
        self.assertEqual(scene.supply.commands, [])

    def test_comma(self) -> None:
        scene = self.scene("rigol_dp800", Dp832())
        scene.supply.comma = True
        run = scene.run()
        self.assertNotEqual(run.wait(STARTED), 0)
        self.assertFalse(scene.output.on)

    def test_live_output_with_other_settings(self) -> None:
        scene = self.scene("rigol_dp800", Dp832())
        scene.output.volts, scene.output.amperes, scene.output.on = 12.0, 1.0, True
        run = scene.run()
        self.assertNotEqual(run.wait(STARTED), 0)
        self.assertIn("instead of 24 V", run.errors() + run.output())
        self.assertEqual(scene.supply.commands, [])
        self.assertEqual(scene.output.volts, 12.0)

    def test_locked_panel_and_abort(self) -> None:
        scene = self.scene("rigol_dp800", Dp832(in_numbers=True), on_stop="off")
        run = scene.run(off=30)
        self.assertTrue(run.wait_acknowledged(1), run.errors())
        scene.supply.locked = True
        self.assertTrue(until(lambda: "is not switched off" in scene.cause(run), 30), scene.cause(run))
        scene.supply.locked = False
        self.assertTrue(until(lambda: not scene.output.on, 20))
        self.assertTrue(until(lambda: run.status().get("state", "") == "execute", 40), scene.cause(run))
        run.tell("abort")
        self.assertIsNotNone(run.wait(STARTED))
        self.assertFalse(scene.output.on)

    def test_silent_supply(self) -> None:
        scene = self.scene("rigol_dp800", Dp832())
        run = scene.run(off=3, on=6)
        self.assertTrue(run.wait_acknowledged(1), run.errors())
        scene.server.silent.set()
        self.assertTrue(until(lambda: "is not switched off" in scene.cause(run), 30), scene.cause(run))
        scene.server.silent.clear()
        self.assertEqual(run.wait(90), 0, run.errors())


def add_tests() -> None:
    for name, model in MODELS.items():
        setattr(Supplies, f"test_switched_{name}", lambda self, n=name, m=model: self.switched(n, m()))
        setattr(Supplies, f"test_tripped_{name}", lambda self, n=name, m=model: self.tripped(n, m()))


def main() -> int:
    add_tests()
    names = unittest.TestLoader().getTestCaseNames(Supplies)
    assert len(names) == 15, names

    def run_one(name: str) -> unittest.TestResult:
        result = unittest.TestResult()
        Supplies(name).run(result)
        return result

    failures = 0
    with ThreadPoolExecutor(8) as pool:
        for name, result in zip(names, pool.map(run_one, names)):
            troubles = [text for _, text in result.failures + result.errors]
            failures += bool(troubles)
            print(f"{name}: {'FAILED' if troubles else 'passed'}", *troubles, sep="\n", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
