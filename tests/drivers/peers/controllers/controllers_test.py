#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The program against two controllers of each family, which share no line and no register map with it.

    controllers_test.py GYROTHERM [--long] [--places=N] [NAME…]

`gyrotherm-make-safe` must be beside GYROTHERM. NAME is a part of a test's name. The tests run in threads, because
nearly all of them wait nearly all the time. A test that fails while the machine stood still is repeated. A test of
`KNOWN` shows a defect that is not fixed yet: its failure is printed, and does not count.
"""
from __future__ import annotations

import concurrent.futures
import os
import pathlib
import shutil
import signal
import sys
import tempfile
import threading
import time
import unittest
from typing import Callable

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[2] / "support"), str(HERE.parents[2] / "edges")]

import program
from bench import FAKES, HOT, IDENTITY_MAPS, SAFE, Bench, Fake
from families import F4, F4T, OF_OTHERS, Chamber, Ezt570i, F4TCascade, Umc1200, Yinhe
from loop_controllers import Eurotherm3504, EzZonePm
from modbus_server import BUSY, ILLEGAL_ADDRESS, ROOM, ModbusTcp, RtuInTcp, high_first, low_first
from program import Run, until
from standstill import Standstill

STAGGER = 0.1  # s between the starts of two tests
ATTEMPTS = 3
BEGINS = 60  # s until a run has begun or is refused
ALARM_WITHIN = 60.0  # s
ALARMS = ("not_following", "foreign_set_point", "following", "air_rate", "restarted")
places = 40  # tests at a time
gyrotherm, base = pathlib.Path(), pathlib.Path()


class Scene(unittest.TestCase):
    """Tests one controller on its own bench."""

    def __init__(self, name: str, act: "Callable[[Scene], None]", fake: Fake, air: float | None = None) -> None:
        super().__init__("carry_out")
        self.name, self.act, self.fake, self.air = name, act, fake, air
        self.facts: list[str] = []

    def id(self) -> str:
        return self.name

    __str__ = id

    def shortDescription(self) -> str | None:
        return None

    def carry_out(self) -> None:
        folder = pathlib.Path(tempfile.mkdtemp(dir=base))
        self.bench = self.make_bench(folder)
        try:
            self.act(self)
        finally:
            self.bench.close()
            shutil.rmtree(folder, ignore_errors=True)

    def make_bench(self, folder: pathlib.Path) -> Bench:
        return Bench(gyrotherm, folder, self.fake, self.air)

    @property
    def chamber(self) -> Chamber:
        return self.bench.chamber

    # Steps of the tests.

    def check(self) -> None:
        """`check --connect` accepts the controller, states what it verified, and writes nothing."""
        checked = self.bench.check(self.bench.rig())
        self.assertEqual(checked.code, 0, checked.text)
        verified = checked.text.partition("verified: ")[2].partition("NOT verified")[0]
        self.assertIn(self.fake.verifies, verified, checked.text)
        self.assertEqual(self.chamber.log, [], "check has written")

    def begin(self, more: str = "") -> Run:
        """Starts a run and waits until the air has moved towards its set point."""
        run = self.bench.run(self.bench.rig(more=more))
        began = run.wait_acknowledged(1, BEGINS)
        self.assertTrue(began, f"the run did not begin: exit {run.process.poll()}, {run.errors()[-900:]}")
        self.assertIsNotNone(until(self.chamber.follows), "the controller does not follow its set point")
        before = self.chamber.air_now()
        moved = until(lambda: self.chamber.air_now() > before + 2, every=0.2)
        self.assertTrue(moved, f"the air stays at {before:.2f} °C; {run.errors()[-600:]}")
        self.assertIsNone(run.process.poll(), run.errors()[-600:])
        self.assertNotIn("alarm", run.errors())
        self.expect_only_its_registers()
        self.assertTrue(until(run.guards), "there is no guard")
        return run

    def expect_only_its_registers(self) -> None:
        absent = [w for w in self.chamber.log if w.refused == ILLEGAL_ADDRESS]
        self.assertEqual(absent, [], "registers that the unit lacks were written")

    def expect_safe(self, when: str) -> None:
        """Expects that the air moves to the safe set point, or that the controller is off."""
        sought = self.chamber.follows()
        self.assertTrue(self.chamber.is_off() or (sought is not None and abs(sought - SAFE) < 0.06),
                        f"{when}: follows {sought}, off: {self.chamber.is_off()}, air {self.chamber.air_now():.1f} °C")
        if sought is not None:
            before, now = self.chamber.air_now(), until(lambda: abs(self.chamber.air_now() - SAFE) < 0.5, every=0.2)
            self.assertTrue(now, f"{when}: the air went from {before:.1f} to {self.chamber.air_now():.1f} °C")

    def kill_both(self, run: Run) -> None:
        for pid in [*run.guards(), run.pid]:
            program.kill(pid)
        run.wait()

    def confirmed(self, run: Run) -> bool:
        return not pathlib.Path(f"{run.record}.safe-state").exists()


def follow_and_kill(scene: Scene) -> None:
    """Checks, runs, and is killed: the guard leaves the controller at the safe set point, or off."""
    kept = scene.chamber.kept()
    scene.check()
    run = scene.begin()
    run.signal(signal.SIGKILL)
    run.wait()
    scene.assertTrue(until(lambda: scene.confirmed(run), 90), f"not confirmed within 90 s: {run.errors()[-900:]}")
    scene.expect_safe("after the guard")
    scene.expect_only_its_registers()
    scene.assertEqual(scene.chamber.kept(), kept, "settings that are not its own are changed")


def expect_alarm(scene: Scene, run: Run, what: str) -> None:
    began = time.monotonic()
    found = until(lambda: [a for a in ALARMS if f"{a} (" in run.errors()] or run.ended(), ALARM_WITHIN)
    scene.assertTrue(found and not run.ended(), f"{what}: no alarm within {ALARM_WITHIN:g} s: {run.errors()[-900:]}")
    scene.facts.append(f"{', '.join(found)} after {time.monotonic() - began:.0f} s")
    time.sleep(1.5)
    since = time.monotonic()
    time.sleep(3)
    fought = scene.chamber.accepted(since=since)
    scene.assertEqual(fought, [], f"{what}: it is fought: {run.errors()[-600:]}")


def taken_over(scene: Scene, shown: bool, take_over: Callable[[], object], what: str,
               still: Callable[[], bool] = lambda: True) -> None:
    """Another user takes the controller away from a run: an alarm names it. Then program and guard die, and
    gyrotherm-make-safe by hand brings it back, or its exit code shows that it could not."""
    run = scene.begin()
    take_over()
    expect_alarm(scene, run, what)
    scene.assertTrue(still(), f"{what}: it was ended")
    scene.kill_both(run)
    made = scene.bench.programs.finish([scene.bench.programs.make_safe, run.record], 150)
    safe = scene.chamber.is_off() or scene.chamber.follows() is not None
    scene.facts.append(f"make-safe {made.code} after {made.seconds:.0f} s, {'off' if scene.chamber.is_off() else 'on'}")
    scene.assertEqual(made.code, 0 if safe else 3, f"{what}: {made.text}")
    if safe:
        scene.expect_safe("after gyrotherm-make-safe")
    else:
        scene.assertFalse(shown, f"{what}: make-safe could have seen it: {made.text}")
    scene.expect_only_its_registers()


def manual_is_noticed(scene: Scene) -> None:
    taken_over(scene, True, lambda: scene.assertTrue(scene.chamber.to_manual()), "manual mode")


def program_is_noticed(scene: Scene) -> None:
    taken_over(scene, True, lambda: scene.assertTrue(scene.chamber.to_program()), "a foreign program",
               still=lambda: scene.chamber.in_program())


def off_is_noticed(scene: Scene) -> None:
    """A controller that another user switched off remains off, even when it is made safe."""
    taken_over(scene, True, lambda: scene.assertTrue(scene.chamber.to_off()), "switched off",
               still=scene.chamber.is_off)
    scene.assertTrue(scene.chamber.is_off(), "it was switched on again")


def guard_brings_back(scene: Scene) -> None:
    """The program dies while another user controls the chamber: only the guard makes the chamber safe."""
    run = scene.begin()
    scene.assertTrue(scene.chamber.to_manual() or scene.chamber.to_program())
    run.signal(signal.SIGKILL)
    run.wait()
    scene.assertTrue(until(lambda: scene.confirmed(run), 90), f"not confirmed within 90 s: {run.errors()[-900:]}")
    scene.expect_safe("after the guard")
    scene.expect_only_its_registers()


def open_loop_is_noticed(scene: Scene) -> None:
    """A fixed output, which no register shows, is detected by the air temperature."""
    taken_over(scene, False, scene.chamber.to_open_loop, "an open loop that nothing shows")


def refused_under(map_name: str, keys: str = "") -> Callable[[Scene], None]:
    """The map of another family, with an identity check, is refused, and nothing is written."""
    def act(scene: Scene) -> None:
        rig = scene.bench.rig(map_name, keys=keys)
        checked = scene.bench.check(rig)
        scene.assertEqual(checked.code, 3, checked.text)
        run = scene.bench.run(rig)
        scene.assertIn(run.wait(BEGINS), (3, 4), run.errors())
        scene.assertEqual(scene.chamber.log, [], "a controller of another family was written to")
    return act


def read_back_late(scene: Scene) -> None:
    """A set point is acknowledged but shown late: the run does not begin and leaves the chamber unchanged."""
    run = scene.bench.run(scene.bench.rig())
    scene.assertEqual(run.wait(BEGINS), 3, run.errors())
    scene.assertIn("was written", run.errors())
    time.sleep(2)
    scene.assertAlmostEqual(scene.chamber.set_point, ROOM, 1)
    scene.assertTrue(scene.chamber.is_off())


def set_point_lost_while_off(scene: Scene) -> None:
    """A controller that shows no set point, and ignores it while off, receives it again after it was started."""
    scene.chamber.set_point = OF_OTHERS
    run = scene.bench.run(scene.bench.rig())
    scene.assertTrue(run.wait_acknowledged(5, BEGINS), run.errors()[-600:])
    scene.assertAlmostEqual(scene.chamber.set_point, HOT, 1)


def never_written_to(scene: Scene) -> None:
    """A run does not begin, even after several attempts."""
    for attempt in range(12):
        run = scene.bench.run(scene.bench.rig(), f"run{attempt}.db")
        run.wait_acknowledged(0, 10)
        scene.assertEqual(scene.chamber.log, [], f"attempt {attempt}: {run.errors()[-300:]}")
        scene.assertIn(run.wait(), (3, 4), run.errors())


def no_false_fault(scene: Scene) -> None:
    """Set points that are acknowledged and applied cause no faults."""
    run = scene.bench.run(scene.bench.rig())
    scene.assertTrue(run.wait_acknowledged(12, BEGINS), run.errors()[-600:])
    scene.assertNotIn("fault", run.errors())


def air_is_compared(scene: Scene) -> None:
    """The controller's air temperature is 40 K from all thermometers: `check --connect` prints a warning."""
    checked = scene.bench.check(scene.bench.rig())
    scene.assertRegex(checked.text, r"(?i)warning[^\n]*thermometer|fault[^\n]*thermometer")


def read_back_is_not_claimed(scene: Scene) -> None:
    """If a set point cannot be read, no message claims that it was read back."""
    run = scene.begin()
    run.signal(signal.SIGKILL)
    run.wait()
    scene.assertTrue(until(lambda: scene.confirmed(run), 90), run.errors()[-900:])
    scene.assertNotIn("read back", run.errors())


def refused_by_name(*parts: str) -> Callable[[Scene], None]:
    """With the controller's own map, `check --connect` refuses and names the setting, and a run writes nothing."""
    def act(scene: Scene) -> None:
        rig = scene.bench.rig()
        checked = scene.bench.check(rig)
        scene.assertEqual(checked.code, 3, checked.text)
        for part in parts:
            scene.assertIn(part, checked.text)
        run = scene.bench.run(rig)
        scene.assertIn(run.wait(BEGINS), (3, 4), run.errors())
        scene.assertEqual(scene.chamber.log, [], "it was written to")
    return act


def stores_nothing(scene: Scene) -> None:
    """After the run has begun, the controller stores no set point in its EEPROM."""
    run = scene.begin()
    with scene.chamber.lock:
        before = scene.chamber.stored
    run.signal(signal.SIGKILL)
    run.wait()
    scene.assertTrue(until(lambda: scene.confirmed(run), 90), run.errors()[-900:])
    scene.assertGreater(len(scene.chamber.accepted()), 3)
    scene.assertEqual((scene.chamber.stored, before <= 1), (before, True), scene.chamber.log)


SETTINGS: dict[str, tuple[Fake, tuple[str, ...]]] = {
    "cascade_on": (Fake(lambda: F4TCascade(cascade=True), ModbusTcp, "watlow_f4t_cascade"), ("cascade",)),
    "product_control_on": (Fake(lambda: Ezt570i(product_control=2), RtuInTcp, "csz_ezt570i"), ("product_control",)),
    "offline": (Fake(lambda: Ezt570i(online=False), RtuInTcp, "csz_ezt570i"), ("online",)),
    "whole_degrees_fahrenheit": (Fake(lambda: F4(in_fahrenheit=True, decimals=0), RtuInTcp, "watlow_f4"),
                                 ("set_point", "0.555556 K")),
    "limits_narrower_than_rig": (Fake(lambda: F4T(lowest=10, highest=38), ModbusTcp, "watlow_f4t"), ("38 °C",)),
    "other_word_order": (Fake(lambda: F4T(words=high_first), ModbusTcp, "watlow_f4t"), ("word order",)),
    "absent_card_not_ready": (Fake(lambda: F4T(absent_card=BUSY), ModbusTcp, "watlow_f4t"), ("read 11250",)),
    "no_control_loop": (Fake(lambda: F4T(part="F4T1A1DAA1B5ABA"), ModbusTcp, "watlow_f4t"), ("no control loop",)),
    "ez_zone_data_map_2": (Fake(lambda: EzZonePm(data_map=2), ModbusTcp, "watlow_ez_zone_pm"), ("data map 1",)),
    "ez_zone_other_word_order": (Fake(lambda: EzZonePm(words=high_first), ModbusTcp, "watlow_ez_zone_pm"),
                                 ("word order",)),
    "eurotherm_limits": (Fake(lambda: Eurotherm3504(highest=38), ModbusTcp, "eurotherm_3504"), ("38 °C",)),
    "hundredths": (Fake(lambda: Umc1200(scale=100), ModbusTcp, "umc1200"), ("air_temperature",)),
    "yinhe_low_word_first": (Fake(lambda: Yinhe(words=low_first, drifts=False), ModbusTcp, "yinhe"),
                             ("air_temperature",)),
}


OTHERS: dict[str, tuple[Callable[[Scene], None], Fake, float | None]] = {
    "ReadBackLate.f4t": (read_back_late, Fake(lambda: F4T(set_point_lag=1.0), ModbusTcp, "watlow_f4t"), None),
    "SetPointLostWhileOff.tt5166": (set_point_lost_while_off, FAKES["tt5166_zeros"], HOT),
    "NeverWrittenTo.yinhe_low_word_first": (
        never_written_to, Fake(lambda: Yinhe(words=low_first), ModbusTcp, "yinhe"), None),
    "AirIsCompared.ezt_fahrenheit": (
        air_is_compared, Fake(lambda: Ezt570i(in_fahrenheit=True, air=12), RtuInTcp, "csz_ezt570i"), None),
    "ReadBackIsNotClaimed.tt5166": (read_back_is_not_claimed, FAKES["tt5166_plain"], None),
    "StoresNothing.ez_zone": (stores_nothing, FAKES["ez_zone_fahrenheit"], None),
    "NoFalseFault.ezt": (no_false_fault, FAKES["ezt_held_profile"], None),
}
KNOWN = {
    "NoFalseFault.ezt": "a set point that waits for the unit's period is reported as not confirmed",
}
SLOW = ("csz_ezt570i",)  # maps whose units take half a second for each exchange: one test in the normal suite


def tests_of(number: int, name: str, fake: Fake, long: bool) -> list[Scene]:
    """Returns the tests of one controller. The normal suite has one that runs and one that is refused."""
    chamber = fake.make()
    manual, programs, off = chamber.to_manual(), chamber.to_program(), chamber.to_off()
    acts = [("FollowAndKill", follow_and_kill)]
    acts += [("ManualIsNoticed", manual_is_noticed)] * manual + [("ProgramIsNoticed", program_is_noticed)] * programs
    acts += [("OffIsNoticed", off_is_noticed)] * off + [("GuardBringsBack", guard_brings_back)] * programs
    acts += [] if programs else [("OpenLoopIsNoticed", open_loop_is_noticed)]
    others = [m for m, framings in IDENTITY_MAPS.items() if m != fake.map and fake.server.framing in framings]
    if not long:
        noticed = [a for a in acts if a[0] != "OpenLoopIsNoticed" and f"{a[0]}.{name}" not in KNOWN]
        acts = noticed[:2][-1:] if number % 2 else noticed[:1]
        acts = acts if number % 2 == 0 or fake.map not in SLOW else []
        others = [others[number % len(others)]]
    return [Scene(f"{act}.{name}", carry_out, fake) for act, carry_out in acts] + \
        [Scene(f"RefusedUnder.{other}.{name}", refused_under(other), fake) for other in others]


def tests(long: bool) -> list[Scene]:
    """Returns the tests of the normal suite, or all tests, the longest ones first."""
    found = [test for number, (name, fake) in enumerate(FAKES.items()) for test in tests_of(number, name, fake, long)]
    found += [Scene(f"RefusedByName.{name}", refused_by_name(*parts), fake) for name, (fake, parts) in SETTINGS.items()]
    found += [Scene(name, *how) for name, how in OTHERS.items() if long or name not in KNOWN]
    return sorted(found, key=lambda test: (test.id().startswith("Refused"), test.fake.map not in SLOW))


class Parallel(unittest.TestSuite):
    """Runs tests in threads. Repeats tests that failed while the machine was not responding."""

    def run(self, result: unittest.TestResult, debug: bool = False) -> unittest.TestResult:
        standstill, lock = Standstill(), threading.Lock()

        def one(numbered: tuple[int, Scene]) -> None:
            number, test = numbered
            time.sleep(STAGGER * min(number, places))
            for attempt in range(ATTEMPTS):
                test.facts = [f"attempt {attempt + 1}"] * (attempt > 0)
                began, still, own = time.monotonic(), standstill.total(), unittest.TestResult()
                test.run(own)
                if own.wasSuccessful() or standstill.total() == still:
                    break
            known = not own.wasSuccessful() and KNOWN.get(test.id())
            verdict = "ok" if own.wasSuccessful() else "known" if known else "FAILED"
            facts = "".join(f"; {fact}" for fact in test.facts + [known] * bool(known))
            with lock:
                print(f"{test.id():<64} {verdict:<6} {time.monotonic() - began:6.1f} s{facts}", flush=True)
                result.testsRun += 1
                if not known:
                    result.failures += own.failures
                    result.errors += own.errors

        with concurrent.futures.ThreadPoolExecutor(places) as pool:
            list(pool.map(one, enumerate(self)))
        return result


def sweep_when_this_ends(base: pathlib.Path) -> None:
    """Removes everything at the end, even if this process is killed: a child process waits for its end."""
    reads, writes = os.pipe()
    if os.fork() == 0:
        os.close(writes)
        os.setsid()
        os.read(reads, 1)
        for folder in base.iterdir():
            program.sweep(folder)
        shutil.rmtree(base, ignore_errors=True)
        os._exit(0)
    os.close(reads)


def main(tests: Callable[[bool], list[Scene]]) -> int:
    """Runs the tests that are named on the command line, or all."""
    global gyrotherm, base, places
    options = [word for word in sys.argv[1:] if word.startswith("--")]
    words = [word for word in sys.argv[1:] if word not in options]
    places = int(next((o.partition("=")[2] for o in options if o.startswith("--places=")), places))
    if not words or not pathlib.Path(words[0]).is_file():
        print("expected the path of gyrotherm, with gyrotherm-make-safe beside it", file=sys.stderr)
        return 2
    gyrotherm = pathlib.Path(words[0]).resolve()
    chosen = [t for t in tests("--long" in options) if not words[1:] or any(w in t.id() for w in words[1:])]
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # under nohup it would be ignored by every program started here
    os.umask(0o022)
    base = pathlib.Path(tempfile.mkdtemp(prefix="gyrotherm-peers-"))
    sweep_when_this_ends(base)
    began = time.monotonic()
    result = Parallel(chosen).run(unittest.TestResult())
    for test, why in result.failures + result.errors:
        print(f"\n{test.id()}\n{why}")
    failed = len(result.failures) + len(result.errors)
    print(f"\n{result.testsRun} tests, {failed} failed, in {time.monotonic() - began:.0f} s")
    return 1 if failed or not result.testsRun else 0


if __name__ == "__main__":
    sys.exit(main(tests))
