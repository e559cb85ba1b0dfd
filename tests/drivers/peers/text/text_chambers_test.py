#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The program against an independent instrument of each text protocol.

    text_chambers_test.py GYROTHERM [--long] [--places=N] [NAME…]

Each protocol has three tests. `Driven`: check, a run with a ramp and a soak, a pause, a lost line, and the program's
death. `Misbehaving`: answers that are late, doubled, partial, in pieces, refused or have a decimal comma; then the
death of program and guard. `RefusedAsOtherFamily`: an instrument of another family. --long adds other instruments and
rarer faults. A test of `KNOWN` shows a defect that is not fixed yet: its failure is printed, and does not count.
"""
from __future__ import annotations

import pathlib
import signal
import sys
import time
from typing import Callable

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "controllers"), str(HERE.parents[2] / "support"),
                str(HERE.parents[2] / "edges")]

import controllers_test
from ascii2 import Ascii2
from bench import SAFE, Fake
from controllers_test import BEGINS, Scene
from cts import Cts, CtsOnSerialLine
from espec import Espec, EspecOnBus, Program, Step
from f4t_scpi import F4tScpi
from huber import Huber
from julabo import Julabo
from lauda import Lauda
from program import Run, start, until
from records import Record, read_record
from simserv import SimServ
from text_server import Faults, TextChamber, TextOnTerminal, TextServer
from thermotron import Thermotron, Thermotron3800

SAFE_WITHIN = 20.0  # s from the death of the program to a safe unit
CONFIRMED_WITHIN = 90.0  # s
EARLY, LATE = 4.5, 1.3  # s from a reading to its second
WARM, HOT = 27.0, 31.0  # °C, of the profile
FAULTY = 6.0  # s of each fault
PHASES = ("late", "doubled", "partial", "pieces", "busy", "comma")


def text(make: Callable[[], TextChamber], map_name: str, keys: str = "", verifies: str = "") -> Fake:
    return Fake(make, TextServer, map_name, keys, verifies)


def on_terminal(settings: str) -> Callable[[TextChamber], TextOnTerminal]:
    return lambda chamber: TextOnTerminal(chamber, settings)


FAKES: dict[str, Fake] = {
    "simserv": text(SimServ, "weiss_simserv"),
    "ascii2": text(Ascii2, "weiss_ascii2"),
    "espec": text(Espec, "espec_p300"),
    "thermotron": text(Thermotron, "thermotron_8800"),
    "thermotron3800": text(Thermotron3800, "thermotron_3800"),
    "cts": text(Cts, "cts"),
    "julabo": text(Julabo, "julabo"),
    "huber": text(Huber, "huber"),
    "lauda": text(Lauda, "lauda"),
    "f4t_scpi": text(F4tScpi, "watlow_f4t_scpi"),
}
MORE: dict[str, Fake] = {  # other instruments of the same protocols
    "simserv_program": text(lambda: SimServ(program=True), "weiss_simserv"),
    "simserv_slow": text(lambda: SimServ(lag=1.2), "weiss_simserv"),
    "simserv_without_programs": text(lambda: SimServ(has_programs=False), "weiss_simserv"),
    "ascii2_slow": text(lambda: Ascii2(lag=1.5, humidity=60.0, others=frozenset({2, 11})), "weiss_ascii2"),
    "espec_humidity": text(lambda: Espec(humidity=True, lag=1.2), "espec_p300"),
    "espec_short_monitor": text(lambda: Espec(empty_humidity=False, mode="OFF"), "espec_p300"),
    "espec_serial": Fake(EspecOnBus, on_terminal("9600,8N1"), "espec_p300"),  # type: ignore[arg-type]
    "espec_program": text(lambda: Espec(mode="RUN"), "espec_p300"),
    "thermotron_program": text(lambda: Thermotron(program=True), "thermotron_8800"),
    "thermotron_slow": text(lambda: Thermotron(lag=1.2), "thermotron_8800"),
    "cts_capital": text(lambda: Cts(capital=True), "cts"),
    "cts_slow": text(lambda: Cts(lag=1.2), "cts"),
    "cts_serial": Fake(CtsOnSerialLine, on_terminal("19200,8N1"), "cts"),  # type: ignore[arg-type]
    "cts_program": text(lambda: Cts(program=True), "cts"),
    "julabo_external": text(lambda: Julabo(external=True), "julabo"),
    "julabo_slow": text(lambda: Julabo(lag=1.2), "julabo"),
    "huber_process": text(lambda: Huber(process=True), "huber"),
    "lauda_padded": text(lambda: Lauda(blank_padded=True, type_text="VC 600"), "lauda"),
    "lauda_slow": text(lambda: Lauda(lag=1.2), "lauda"),
    "lauda_simple": text(lambda: Lauda(has_programmer=False), "lauda"),
    "lauda_program": text(lambda: Lauda(program=2), "lauda"),
    "f4t_scpi_program": text(lambda: F4tScpi(program=True), "watlow_f4t_scpi"),
    "f4t_scpi_slow": text(lambda: F4tScpi(lag=1.2), "watlow_f4t_scpi"),
}


KNOWN = {"Driven.espec_serial": "check opens the line a second time without the pause that the unit needs"}
controllers_test.KNOWN.update(KNOWN)


class TextScene(Scene):
    """One instrument on a bench of its own."""

    @property
    def chamber(self) -> TextChamber:
        return self.bench.chamber  # type: ignore[return-value]

    @property
    def server(self) -> TextServer | TextOnTerminal:
        return self.bench.server  # type: ignore[return-value]

    def expect_only_its_registers(self) -> None:
        self.assertEqual(self.chamber.unknown, [], "lines that the unit does not know were sent")
        self.assertEqual(self.chamber.too_early, [], "lines were sent before the unit's pause was over")

    def profile(self) -> pathlib.Path:
        """Writes a profile with a ramp and a soak."""
        path = self.bench.folder / "profile.toml"
        path.write_text(f'''schema = "gyrotherm-profile/1"
name = "ramp and soak"

[[segment]]
kind = "hold"
at = "{WARM:g} °C"
time = "5 s"

[[segment]]
kind = "ramp"
to = "{HOT:g} °C"
rate = "20 °C/min"

[[segment]]
kind = "hold"
guaranteed_soak = true
soak_band = "1 °C"
soak_dwell = "2 s"
soak_slope = "60 °C/min"
time = "600 s"
deadline = "1200 s"
''', encoding="utf-8")
        return path

    def begin(self, more: str = "") -> Run:
        self.bench.profile = lambda seconds=600: self.profile()  # type: ignore[method-assign,misc]
        run = self.bench.run(self.bench.rig(more=more))
        began = run.wait_acknowledged(1, BEGINS)
        self.assertTrue(began, f"the run did not begin: exit {run.process.poll()}, {run.errors()[-900:]}")
        self.assertTrue(until(lambda: self.chamber.follows() is not None), "the unit does not follow its set point")
        self.expect_only_its_registers()
        self.assertTrue(until(run.guards), "there is no guard")
        return run

    def is_safe(self) -> bool:
        sought = self.chamber.follows()
        return self.chamber.is_off() or (sought is not None and abs(sought - SAFE) < 0.06)

    def read(self, run: Run) -> Record:
        record = read_record(run.record, self.bench.folder / f"copies{time.monotonic_ns()}")
        self.assertEqual(record.damaged, {})
        return record

    def expect_no_wrong_reading(self, run: Run, fewest: int) -> Record:
        record = self.read(run)
        found = wrong_values(record, "chamber_air_c", self.chamber.airs) + \
            wrong_values(record, "chamber_set_point_c", self.chamber.set_points)
        self.assertEqual(found, [], "wrong readings")
        read = sum(row["chamber_air_c"] is not None for row in record.rows.values())
        self.assertGreaterEqual(read, fewest, f"of {len(record.rows)} seconds")
        self.facts.append(f"{read} of {len(record.rows)} s read")
        return record

    def expect_alive(self, run: Run, what: str) -> None:
        self.assertIsNone(run.process.poll(), f"{what}: {run.errors()[-900:]}")

    def wait_for_readings(self, run: Run, what: str, seconds: float = 30.0) -> None:
        """Waits until the run executes and the unit is asked again."""
        count = len(self.chamber.airs)
        self.assertTrue(until(lambda: len(self.chamber.airs) > count + 2 or run.ended(), seconds), f"{what}: not asked")
        self.expect_alive(run, what)


def wrong_values(record: Record, column: str, sent: list[tuple[float, float]]) -> list[str]:
    """Returns the readings that the unit did not send about that second."""
    times: dict[float, list[float]] = {}
    for utc, value in list(sent):
        times.setdefault(round(value, 4), []).append(utc)
    found = []
    for slot, row in sorted(record.rows.items()):
        value, utc = row[column], row["utc_ns"] / 1e9
        if value is None:
            continue
        own = times.get(round(value, 4), [])
        if not any(utc - EARLY <= at <= utc + LATE for at in own):
            nearest = min((at - utc for at in own), key=abs, default=None)
            when = "never sent" if nearest is None else f"sent {nearest:+.2f} s from it"
            found.append(f"second {slot}: {column} {value!r} was {when}")
    return found


def driven(scene: TextScene) -> None:
    """A run from its check to its death; the guard makes the unit safe."""
    kept = scene.chamber.kept()
    scene.check()
    scene.expect_only_its_registers()
    run = scene.begin()
    warm = until(lambda: scene.chamber.air_now() > WARM + 1.5, every=0.2)
    scene.assertTrue(warm, f"the air stays at {scene.chamber.air_now():.2f} °C; {run.errors()[-600:]}")
    pause(scene, run)
    lose_line(scene, run)
    soaked = until(lambda: abs(scene.chamber.air_now() - HOT) < 0.6 or run.ended(), 90, every=0.2)
    scene.assertTrue(soaked, f"the air is at {scene.chamber.air_now():.2f} °C; {run.errors()[-600:]}")
    scene.expect_alive(run, "soak")
    scene.expect_only_its_registers()
    scene.assertFalse(scene.is_safe(), "it was safe before")
    run.signal(signal.SIGKILL)
    killed = time.monotonic()
    run.wait()
    scene.assertTrue(until(scene.is_safe, SAFE_WITHIN), f"not safe within {SAFE_WITHIN:g} s: {run.errors()[-900:]}")
    scene.facts.append(f"safe after {time.monotonic() - killed:.1f} s")
    scene.assertTrue(until(lambda: scene.confirmed(run), CONFIRMED_WITHIN),
                     f"not confirmed within {CONFIRMED_WITHIN:g} s: {run.errors()[-900:]}")
    scene.expect_safe("after the guard")
    scene.assertEqual(scene.chamber.kept(), kept, "settings that are not its own are changed")
    scene.expect_no_wrong_reading(run, 10)


def pause(scene: TextScene, run: Run) -> None:
    """A paused run keeps the set point; then it goes on."""
    done, answer = run.tell("pause")
    scene.assertTrue(done, answer)
    time.sleep(2.5)
    kept = scene.chamber.follows()
    time.sleep(3)
    now = scene.chamber.follows()
    scene.assertTrue(kept is not None and now is not None and abs(now - kept) < 0.06, f"paused: {kept} became {now}")
    done, answer = run.tell("resume")
    scene.assertTrue(done, answer)


def lose_line(scene: TextScene, run: Run) -> None:
    scene.server.cut()
    time.sleep(4)
    scene.expect_alive(run, "lost line")
    scene.server.mend()
    scene.wait_for_readings(run, "after the lost line")


def misbehaving(scene: TextScene) -> None:
    """No fault becomes a reading; then gyrotherm-make-safe makes the unit safe without a guard."""
    kept = scene.chamber.kept()
    run = scene.begin()
    for kind in PHASES:
        scene.chamber.faults = Faults((kind,))
        time.sleep(FAULTY)
        scene.expect_alive(run, kind)
    scene.chamber.faults = Faults()
    scene.wait_for_readings(run, "after the faults")
    acknowledged = run.acknowledged()
    scene.assertTrue(run.wait_acknowledged(acknowledged + 3, 30), run.errors()[-600:])
    scene.kill_both(run)
    killed = time.monotonic()
    made = scene.bench.programs.finish([scene.bench.programs.make_safe, run.record], 150)
    scene.assertEqual(made.code, 0, made.text)
    last = max((command.at for command in scene.chamber.heard), default=0.0) - killed
    scene.facts.append(f"make-safe took {made.seconds:.1f} s, its last command after {last:.1f} s")
    scene.assertTrue(0 < last < SAFE_WITHIN, "not commanded in time")
    scene.expect_safe("after gyrotherm-make-safe")
    scene.assertEqual(scene.chamber.unknown, [], "lines that the unit does not know were sent")
    scene.assertEqual(scene.chamber.kept(), kept, "settings that are not its own are changed")
    scene.expect_no_wrong_reading(run, 5)


def repeated(scene: TextScene) -> None:
    """An answer that comes once more while the next question is on its way is not taken for the next answer."""
    run = scene.begin()
    scene.chamber.faults = Faults(("repeated",))
    time.sleep(25)
    scene.expect_alive(run, "repeated")
    scene.chamber.faults = Faults()
    scene.kill_both(run)
    scene.expect_no_wrong_reading(run, 5)


def made_safe_in_time(scene: TextScene) -> None:
    """gyrotherm-make-safe on a line that still has faults."""
    run = scene.begin()
    scene.kill_both(run)
    scene.chamber.faults = Faults(("doubled", "pieces", "busy"), share=0.3)
    made = scene.bench.programs.finish([scene.bench.programs.make_safe, run.record], 150)
    scene.assertIn(made.code, (0, 3), made.text)
    scene.facts.append(f"make-safe {made.code} took {made.seconds:.1f} s")
    scene.assertTrue(scene.is_safe(), made.text)


def refused_as_other_family(scene: TextScene) -> None:
    """An instrument of another family is refused, and no command is sent to it."""
    scene.chamber.faults = Faults(("other_family",))
    checked = scene.bench.check(scene.bench.rig())
    scene.assertEqual(checked.code, 3, checked.text)
    run = scene.bench.run(scene.bench.rig())
    scene.assertIn(run.wait(BEGINS), (3, 4), run.errors())
    scene.assertEqual(scene.chamber.heard, [], "an instrument of another family was written to")


def exchanged(scene: TextScene) -> None:
    """After a lost line another unit answers: no command is sent to it, also not by the guard."""
    run = scene.begin()
    scene.server.cut()
    scene.chamber.faults = Faults(("exchanged",))
    time.sleep(2)
    commands = len(scene.chamber.heard)
    scene.server.mend()
    time.sleep(8)
    run.signal(signal.SIGKILL)
    run.wait()
    time.sleep(8)
    sent = [command.line for command in scene.chamber.heard[commands:]]
    scene.assertEqual(sent, [], f"another instrument was written to: {run.errors()[-900:]}")


UPLOADED = """schema = "gyrotherm-profile/1"
name = "ramp and soak"

[[segment]]
kind = "hold"
at = "25 °C"
time = "1 min"

[[segment]]
kind = "ramp"
to = "-10 °C"
rate = "5 °C/min"

[[segment]]
kind = "hold"
time = "1 h 5 min"
"""
STORED = [Step(25.0, 1), Step(-10.0, 7, ramp=True), Step(-10.0, 65),
          Step(25.0, 18, ramp=True), Step(25.0, 1)]  # the warm end


def uploaded(scene: TextScene) -> None:
    """The controller stores the profile and runs it; the guard ends the program and makes the unit safe."""
    chamber = scene.chamber
    assert isinstance(chamber, Espec)
    chamber.programs[1] = Program([Step(40.0, 60)], "OF OTHERS", "OFF")
    chamber.edited = 1, Program()  # an upload that was not ended
    path = scene.bench.folder / "profile.toml"
    path.write_text(UPLOADED, encoding="utf-8")
    record = scene.bench.folder / "run.db"
    rig = scene.bench.rig()
    rig.write_text(rig.read_text(encoding="utf-8").replace('lowest = "5 °C"', 'lowest = "-20 °C"'), encoding="utf-8")
    run = start(scene.bench.programs, ["run", path, "--rig", rig, "--out", record, "--upload", "--json"], record,
                name=record.stem)
    scene.assertTrue(run.wait_acknowledged(2, BEGINS), f"the run did not begin: {run.errors()[-900:]}")
    stored = chamber.programs[1]
    scene.assertEqual((stored.steps, stored.name, stored.end, stored.start), (STORED, "RAMPANDSOAK", "HOLD", 25.0))
    scene.assertTrue(chamber.in_program(), "the program does not run")
    scene.expect_only_its_registers()
    scene.assertTrue(until(run.guards), "there is no guard")
    run.signal(signal.SIGKILL)
    run.wait()
    scene.assertTrue(until(scene.is_safe, SAFE_WITHIN), f"not safe within {SAFE_WITHIN:g} s: {run.errors()[-900:]}")
    scene.assertFalse(chamber.in_program(), "the program still runs")


def tests_of(name: str, fake: Fake) -> list[Scene]:
    acts: list[tuple[str, Callable[..., None]]] = [("Driven", driven), ("Misbehaving", misbehaving)]
    if fake.make().identity_questions:  # type: ignore[attr-defined]
        acts.append(("RefusedAsOtherFamily", refused_as_other_family))
    return [TextScene(f"{act}.{name}", carry_out, fake) for act, carry_out in acts]


def tests(long: bool) -> list[Scene]:
    fakes = FAKES | (MORE if long else {})
    found = [test for name, fake in fakes.items() for test in tests_of(name, fake)]
    found.append(TextScene("Uploaded.espec", uploaded, FAKES["espec"]))
    if long:
        found += [TextScene(f"Repeated.{name}", repeated, fake) for name, fake in FAKES.items()]
        found += [TextScene(f"Exchanged.{name}", exchanged, fake) for name, fake in FAKES.items()
                  if fake.make().exchanged or fake.make().other_family]  # type: ignore[attr-defined]
        found += [TextScene(f"MadeSafeInTime.{name}", made_safe_in_time, fake) for name, fake in FAKES.items()]
    return sorted(found, key=lambda test: test.id().startswith("Refused"))


if __name__ == "__main__":
    sys.exit(controllers_test.main(tests))
