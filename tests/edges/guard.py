# SPDX-License-Identifier: Apache-2.0
"""The program dies while its chamber has a fault: the guard tries until the chamber has confirmed (H1)."""
from __future__ import annotations

import functools
import os
import pathlib
import shutil
import signal
import subprocess
import threading
import time
from typing import Any, Callable

from attack import GUARD_LIMIT, Scene, enter
from laboratory import AUTO, MANUAL, OFF, UNIT_BY_TCP, Chamber, Laboratory
from program import Run, open_descriptors, kill, until
from rig import SAFE

HEALED_AFTER = 40.0  # s, of a chamber that accepts nothing meanwhile

# Faults under which the safe set point can still be sent: link, faults, whether the chamber is also switched off.
WHILE_BROKEN: dict[str, tuple[str, dict[str, Any], bool]] = {
    "every_other_lost_0350": ("tcp", {"every_other_lost": True, "delay": 0.35}, False),
    "every_other_lost_0350_off": ("tcp", {"every_other_lost": True, "delay": 0.35}, True),
    "late_0550": ("tcp", {"delay": 0.55}, False),
    "late_0550_off": ("tcp", {"delay": 0.55}, True),
    "half_lost_0350_0600": ("tcp", {"loss_of_requests": 0.5, "late": (0.35, 0.6), "late_share": 1.0}, False),
    "half_of_answers_lost_0350_0600": ("tcp", {"loss_of_answers": 0.5, "late": (0.35, 0.6), "late_share": 1.0}, False),
    "mode_stuck_off": ("tcp", {"mode_stuck": True}, True),
    "rtu_every_other_lost": ("rtu_over_tcp", {"every_other_lost": True, "delay": 0.1}, False),
    "rtu_half_lost": ("rtu_over_tcp", {"loss_of_requests": 0.5, "delay": 0.05}, False),
    "rtu_late_0950_1200": ("rtu_over_tcp", {"late": (0.95, 1.2), "late_share": 0.5}, False),
    "rtu_noise_off": ("rtu", {"noise_share": 0.5, "delay": 0.1}, True),
    "heats_by_itself": ("tcp", {"heats_by_itself": 0.5}, False),
}

# Faults under which nothing can be done until they end.
UNTIL_HEALED: dict[str, tuple[str, dict[str, Any], bool]] = {
    "silent_for_40_s": ("tcp", {"silent": True}, False),
    "gone_for_40_s": ("tcp", {"gone": True}, False),
    "rtu_silent_for_40_s": ("rtu_over_tcp", {"silent": True}, True),
    "busy_for_40_s": ("tcp", {"exception": 6}, False),
    "ignores_for_40_s": ("tcp", {"writes_ignored": True}, False),
    "clamps_for_40_s": ("tcp", {"clamp_to": (40.0, 100.0)}, False),
}

SHORT = {"every_other_lost_0350", "late_0550", "half_lost_0350_0600", "mode_stuck_off", "rtu_every_other_lost",
         "rtu_late_0950_1200", "silent_for_40_s", "rtu_silent_for_40_s", "ignores_for_40_s"}


def has_confirmed(record: pathlib.Path) -> bool:
    """Returns whether the guard has removed the safe-state file, which it does after full confirmation."""
    return not pathlib.Path(f"{record}.safe-state").exists()


class GuardWatch(threading.Thread):
    """Checks twice a second that a guard exists while the safe-state file exists."""

    def __init__(self, scene: Scene, record: pathlib.Path, guards: Any) -> None:
        super().__init__(daemon=True)
        self.scene, self.record, self.guards = scene, record, guards
        self.left_after: float | None = None
        self.ends = threading.Event()
        self.began = time.monotonic()

    def run(self) -> None:
        while not self.ends.wait(0.5):
            if not has_confirmed(self.record) and not self.guards() and not has_confirmed(self.record):
                self.left_after = time.monotonic() - self.began
                return


def break_and_kill(scene: Scene, link: str, faults: dict[str, Any], off: bool, seed: int) -> tuple[Chamber, GuardWatch]:
    """Breaks the chamber of a hot run, kills the run at once, and returns the chamber and a started GuardWatch."""
    laboratory = scene.laboratory(link, seed=seed)
    run = scene.hot_run(laboratory, rig={"safe": {"off": "true" if off else "false"}})
    scene.expect_guarded(run)
    laboratory.chamber.break_as(**faults)
    run.signal(signal.SIGKILL)
    run.wait()
    watch = GuardWatch(scene, run.record, run.guards)
    watch.start()
    return laboratory.chamber, watch


def expect_off_if_required(scene: Scene, chamber: Chamber, off: bool) -> None:
    wanted = OFF if off else AUTO
    scene.expect(until(lambda: chamber.mode == wanted), f"conditioning is left in mode {chamber.mode}, "
                                                            f"expected {wanted}")


def expect_on_guard(scene: Scene, watch: GuardWatch) -> None:
    """Expects a guard until the chamber has confirmed, and none afterwards."""
    scene.expect(until(lambda: has_confirmed(watch.record)), "the good chamber has not confirmed it")
    scene.expect(until(lambda: not watch.guards()), "the guard stays although all is confirmed")
    watch.ends.set()
    watch.join(5)
    scene.expect(watch.left_after is None, f"the guard was gone {watch.left_after or 0:.1f} s after the program, and "
                                           "nothing was confirmed")


def safe_while_broken(scene: Scene, *, link: str, faults: dict[str, Any], off: bool) -> None:
    """The program is killed while the chamber hardly answers. The safe set point is written within 20 s, and the guard
    remains until the chamber has confirmed everything."""
    began = time.monotonic()
    chamber, watch = break_and_kill(scene, link, faults, off, seed=3)
    died = watch.began
    scene.expect_safe(scene.laboratories[0], died, GUARD_LIMIT, "the program killed, the chamber hardly answering")
    time.sleep(max(0.0, died + 28 - time.monotonic()))
    chamber.heal()
    chamber.heats_by_itself = 0.0
    scene.expect(abs(chamber.set_point - SAFE) < 0.01, f"the set point is {chamber.set_point:g} °C in the end")
    expect_on_guard(scene, watch)
    expect_off_if_required(scene, chamber, off)
    scene.fact(f"all in {time.monotonic() - began:.0f} s")


def safe_once_healed(scene: Scene, *, link: str, faults: dict[str, Any], off: bool) -> None:
    """The program is killed while the chamber accepts nothing. The guard remains, and the safe set point is written
    within 20 s after the chamber recovers."""
    chamber, watch = break_and_kill(scene, link, faults, off, seed=4)
    time.sleep(HEALED_AFTER)
    scene.expect(not has_confirmed(watch.record), "it counts as confirmed although the chamber took nothing")
    healed = time.monotonic()
    chamber.heal()
    scene.expect_safe(scene.laboratories[0], healed, GUARD_LIMIT, "the chamber can take it again")
    expect_on_guard(scene, watch)
    expect_off_if_required(scene, chamber, off)


for _carry_out, _cases in ((safe_while_broken, WHILE_BROKEN), (safe_once_healed, UNTIL_HEALED)):
    for _name, (_link, _faults, _off) in _cases.items():
        enter("guard", f"dead_{_name}", functools.partial(_carry_out, link=_link, faults=_faults, off=_off),
              long_only=_name not in SHORT)


def both_killed(scene: Scene, laboratory: Laboratory) -> tuple[Run, float]:
    """Returns a hot run without program and guard, and the time of their death."""
    run = scene.hot_run(laboratory)
    guards = until(run.guards) or []
    died = time.monotonic()
    for pid in guards:
        kill(pid)
    run.signal(signal.SIGKILL)
    run.wait()
    return run, died


def make_safe_by_hand(scene: Scene) -> None:
    """Program and guard are killed together. A manual gyrotherm-make-safe makes the chamber safe over a line that loses
    every second request."""
    laboratory = scene.laboratory()
    run, died = both_killed(scene, laboratory)
    laboratory.chamber.break_as(every_other_lost=True, delay=0.1)
    made = scene.programs.finish([scene.programs.make_safe, run.record], 90)
    scene.expect(made.code == 0, f"exit {made.code}: {made.text}")
    scene.expect_safe(laboratory, died, 2 * GUARD_LIMIT, "by hand")


enter("guard", "make_safe_by_hand", make_safe_by_hand)


def make_safe_that_insists(scene: Scene) -> None:
    """Program and guard are killed together, and the chamber is silent. make-safe --insist, as systemd calls it,
    continues until the chamber has confirmed."""
    laboratory = scene.laboratory()
    run, _ = both_killed(scene, laboratory)
    laboratory.chamber.break_as(silent=True)
    made = subprocess.Popen([scene.programs.make_safe, "--insist", run.record], env=scene.programs.environment(),
                            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(HEALED_AFTER if scene.long else 28)
    scene.expect(made.poll() is None, f"it gave up after less than 28 s, with {made.poll()}")
    healed = time.monotonic()
    laboratory.chamber.heal()
    scene.expect_safe(laboratory, healed, GUARD_LIMIT, "the chamber answers again")
    code = until(lambda: made.poll() is not None and [made.poll()], 30)
    scene.expect(code == [0], f"exit {code}, expected 0")


enter("guard", "make_safe_that_insists", make_safe_that_insists)


def resume_that_fails(scene: Scene) -> None:
    """Program and guard are killed together, and the gyro is gone. The resume fails, and the hot chamber is made
    safe."""
    laboratory = scene.laboratory()
    run, _ = both_killed(scene, laboratory)
    laboratory.gyro.leave()
    began = time.monotonic()
    again = scene.resume(run)
    code = again.wait()
    scene.expect(code in (3, 4), f"exit {code}, expected 3: {again.errors()[-400:]}")
    scene.expect_safe(laboratory, began, time.monotonic() - began + GUARD_LIMIT, "a resume that failed")
    scene.expect(until(lambda: has_confirmed(run.record)), "the chamber has not confirmed it")


enter("guard", "resume_that_fails", resume_that_fails)


def orders_gone(scene: Scene, *, take_away: Callable[[pathlib.Path], Any]) -> None:
    """The program is killed while its chamber is silent, and its safe-state file is removed. That does not end the
    guard."""
    laboratory = scene.laboratory()
    (scene.folder / "records").mkdir()
    run = scene.hot_run(laboratory, record="records/run.db")
    scene.expect_guarded(run)
    laboratory.chamber.break_as(silent=True)
    take_away(run.record)
    run.signal(signal.SIGKILL)
    run.wait()
    time.sleep(HEALED_AFTER if scene.long else 14)
    healed = time.monotonic()
    laboratory.chamber.heal()
    scene.expect_safe(laboratory, healed, GUARD_LIMIT, "the chamber answers again, the safe-state file being gone")


enter("guard", "dead_silent_safe_state_file_removed",
      functools.partial(orders_gone, take_away=lambda record: pathlib.Path(f"{record}.safe-state").unlink()))
enter("guard", "dead_silent_folder_moved",
      functools.partial(orders_gone, take_away=lambda record: record.parent.rename(record.parent.with_name("moved"))))


def guard_program_changed(scene: Scene, *, change: Callable[[pathlib.Path], Any], at_once: bool) -> None:
    """The guard's file is removed or replaced, as by an upgrade, and the guard ends. The run starts its original guard
    program again. When the run is killed, immediately or later, that guard makes the chamber safe."""
    folder = scene.folder / "bin"
    folder.mkdir()
    for path in (scene.programs.gyrotherm, scene.programs.make_safe):
        shutil.copy2(path, folder)
    scene.programs.gyrotherm = folder / scene.programs.gyrotherm.name
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    scene.expect_guarded(run)
    change(scene.programs.make_safe)
    before = run.guards()
    for pid in before:
        kill(pid)
    again = until(lambda: [pid for pid in run.guards() if pid not in before], 10, 0.02)
    scene.need(again, "the guard was not started again")
    if not at_once:
        time.sleep(2)
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    run.wait()
    scene.expect_safe(laboratory, died, GUARD_LIMIT, "the guard of a file that has gone")


def replace_by_another(path: pathlib.Path) -> None:
    path.with_name("new").write_text("#!/bin/false\n")
    path.with_name("new").replace(path)


for _name, _change in (("removed", pathlib.Path.unlink), ("replaced", replace_by_another)):
    for _when, _at_once in (("", False), ("_and_killed_at_once", True)):
        enter("guard", f"program_{_name}{_when}",
              functools.partial(guard_program_changed, change=_change, at_once=_at_once),
              long_only=_name == "replaced" and _at_once)


def make_safe_that_is_stopped(scene: Scene) -> None:
    """A manual make-safe is stopped by Ctrl-Z while it owns the chamber. Then the chamber answers again."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    scene.expect_guarded(run)
    laboratory.chamber.break_as(silent=True)
    run.signal(signal.SIGKILL)
    run.wait()
    made = subprocess.Popen([scene.programs.make_safe, "--insist", run.record], env=scene.programs.environment(),
                            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                            process_group=0)
    scene.need(until(lambda: holds_the_chamber(made.pid, laboratory), every=0.05), "it never had the chamber")
    os.killpg(made.pid, signal.SIGSTOP)
    time.sleep(75 if scene.long else 5)
    healed = time.monotonic()
    laboratory.chamber.heal()
    scene.expect_safe(laboratory, healed, GUARD_LIMIT, "the chamber answers again, somebody's make-safe being stopped")
    os.killpg(made.pid, signal.SIGKILL)
    made.wait()


def holds_the_chamber(pid: int, laboratory: Laboratory) -> bool:
    """Returns whether a process owns the abstract socket that locks the chamber."""
    port = laboratory.lines["chamber"].rpartition(":")[2]
    with open("/proc/net/unix", encoding="utf-8", errors="replace") as table:
        held = {f"socket:[{line.split()[6]}]" for line in table if "gyrotherm-chamber" in line and port in line}
    return any(link in held for link in open_descriptors(pid))


enter("guard", "make_safe_that_is_stopped", make_safe_that_is_stopped)


def writes_unanswered(scene: Scene) -> None:
    """The program is killed while the answer to each write is lost, but not those to reads. The reported state
    counts."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    scene.expect_guarded(run)
    laboratory.chamber.writes_unanswered = True
    run.signal(signal.SIGKILL)
    run.wait()
    watch = GuardWatch(scene, run.record, run.guards)
    watch.start()
    scene.expect_safe(laboratory, watch.began, GUARD_LIMIT, "the answers to writes lost")
    expect_on_guard(scene, watch)


enter("guard", "dead_writes_unanswered", writes_unanswered)


def expect_air_to_fall(scene: Scene, chamber: Chamber, when: str) -> None:
    """Expects the air, read as by any client, to approach the safe set point within seconds, or to be there."""
    def air() -> float:
        with chamber.lock:
            chamber._integrate()
            return chamber.air
    before = air()
    time.sleep(3)
    after = air()
    scene.expect(abs(after - SAFE) <= 2 or abs(after - SAFE) < abs(before - SAFE),
                 f"{when}: the air moves away from {SAFE:g} °C, from {before:.2f} to {after:.2f} °C")


def manual_mode_killed(scene: Scene) -> None:
    """The controller is put into manual mode, and the program is killed. The guard writes the mode that follows set
    points, and leaves a chamber whose air falls."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory, at=40)
    scene.expect_guarded(run)
    laboratory.chamber.switch_to(MANUAL)
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    run.wait()
    watch = GuardWatch(scene, run.record, run.guards)
    watch.start()
    scene.expect_safe(laboratory, died, GUARD_LIMIT, "manual mode")
    expect_on_guard(scene, watch)
    scene.expect(laboratory.chamber.active_mode == AUTO, f"it is left in mode {laboratory.chamber.active_mode}")
    expect_air_to_fall(scene, laboratory.chamber, "the guard has left")


enter("guard", "manual_mode_killed", manual_mode_killed)


def manual_mode_stuck(scene: Scene, *, seconds: float) -> None:
    """The controller remains in manual mode. The guard stays while the air rises and tries to switch the chamber off.
    Once the controller obeys, it is off, and the guard ends."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory, at=40)
    scene.expect_guarded(run)
    laboratory.chamber.switch_to(MANUAL)
    laboratory.chamber.break_as(mode_stuck=True, manual_rate=0.3)
    run.signal(signal.SIGKILL)
    run.wait()
    watch = GuardWatch(scene, run.record, run.guards)
    watch.start()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        scene.need(not has_confirmed(run.record), "it counts as safe although the air rises")
        time.sleep(0.5)
    scene.expect(laboratory.chamber.mode == OFF, f"mode {laboratory.chamber.mode} is commanded, expected off")
    laboratory.chamber.heal()
    expect_on_guard(scene, watch)
    expect_air_to_fall(scene, laboratory.chamber, "the guard has left")


enter("guard", "manual_mode_stuck", functools.partial(manual_mode_stuck, seconds=75), limit=240)


def manual_mode_by_hand(scene: Scene) -> None:
    """A manual gyrotherm-make-safe ends manual mode and reports set point, mode and air."""
    laboratory = scene.laboratory()
    run, _ = both_killed(scene, laboratory)
    laboratory.chamber.switch_to(MANUAL)
    made = scene.programs.finish([scene.programs.make_safe, run.record], 60)
    scene.expect(made.code == 0, f"exit {made.code}: {made.text}")
    for part in ("set point read back; mode running; air ", "made safe by gyrotherm-make-safe"):
        scene.expect(part in made.text, f"\"{part}\" is not in {made.text}")
    scene.expect(laboratory.chamber.active_mode == AUTO, f"it is left in mode {laboratory.chamber.active_mode}")
    expect_air_to_fall(scene, laboratory.chamber, "make-safe has ended")


enter("guard", "manual_mode_by_hand", manual_mode_by_hand)


def manual_mode_aborted(scene: Scene) -> None:
    """A run whose chamber is in manual mode is suspended and then aborted by an operator. It ends when the air falls,
    and its message names set point, mode and air."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory, at=40)
    laboratory.chamber.switch_to(MANUAL)
    scene.expect(until(lambda: "not_following" in run.errors()), f"no alarm: {run.errors()[-400:]}")
    ran = scene.programs.finish([scene.programs.gyrotherm, "tell", run.record, "abort"], 20)
    scene.expect(ran.code == 0, f"tell: exit {ran.code}: {ran.text}")
    code = run.wait()
    scene.expect(code == 6, f"exit {code}, expected 6")
    for part in ("set point read back", "mode running", "towards 22 °C"):
        scene.expect(part in run.errors(), f"\"{part}\" is not in {run.errors()[-400:]}")
    expect_air_to_fall(scene, laboratory.chamber, "the run has ended")


enter("guard", "manual_mode_aborted", manual_mode_aborted)


def off_and_on_again(scene: Scene) -> None:
    """The chamber is switched on again half a second after the guard has switched it off. It is switched off again
    before the guard ends."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory, at=40, rig={"safe": {"off": "true", "observe": '"10 s"'}})
    scene.expect_guarded(run)
    run.signal(signal.SIGKILL)
    run.wait()
    scene.need(until(lambda: laboratory.chamber.active_mode == OFF, every=0.05), "it was not switched off")
    time.sleep(0.5)
    laboratory.chamber.switch_to(AUTO)
    scene.expect(until(lambda: laboratory.chamber.active_mode == OFF, every=0.05), "it was not switched off again")
    scene.expect(until(lambda: has_confirmed(run.record)), "nothing is confirmed")
    scene.expect(laboratory.chamber.active_mode == OFF, f"it is left in mode {laboratory.chamber.active_mode}")


enter("guard", "off_and_on_again", off_and_on_again)


def unit_register_refused(scene: Scene) -> None:
    """The unit register answers with exception 2 from the moment of the kill. The safe set point is sent in the last
    known unit."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    scene.expect_guarded(run)
    laboratory.chamber.break_as(refused={UNIT_BY_TCP})
    began = time.monotonic()
    run.signal(signal.SIGKILL)
    run.wait()
    scene.expect_safe(laboratory, began, GUARD_LIMIT, "the unit cannot be read")
    scene.expect(until(lambda: has_confirmed(run.record)), "nothing is confirmed")


enter("guard", "unit_register_refused", unit_register_refused)


def stopped_under_a_foreign_set_point(scene: Scene) -> None:
    """Ctrl-C while a third-party set point holds the run. The message names it, and the guard makes the chamber
    safe."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory, at=40)
    laboratory.chamber.change_set_point(55.0)
    scene.expect(until(lambda: "foreign_set_point (suspend)" in run.errors()), f"no alarm: {run.errors()[-400:]}")
    stopped = time.monotonic()
    run.signal(signal.SIGINT)
    code = run.wait()
    scene.expect(code == 5, f"exit {code}, expected 5")
    for part in ("55 °C", "gyrotherm-make-safe"):
        scene.expect(part in run.errors(), f"\"{part}\" is not in {run.errors()[-400:]}")
    scene.expect_safe(laboratory, stopped, GUARD_LIMIT, "stopped under a foreign set point")


enter("guard", "stopped_under_a_foreign_set_point", stopped_under_a_foreign_set_point)
