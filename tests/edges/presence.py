# SPDX-License-Identifier: Apache-2.0
"""A missing or blocked guard is detected and replaced (M7)."""
from __future__ import annotations

import functools
import os
import pathlib
import signal
import socket
import time

from attack import GUARD_LIMIT, Scene, attack, enter
from laboratory import Laboratory
from program import Run, kill, until

PUT_BACK_WITHIN = 8.0  # s


def expect_safe_death(scene: Scene, laboratory: Laboratory, run: Run, what: str) -> None:
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    scene.expect_safe(laboratory, died, GUARD_LIMIT, what)
    scene.expect_held(laboratory, 1)


def says(run: Run, before: str, *words: str) -> bool:
    """Returns whether the messages since `before` contain one of the texts."""
    return any(word in run.errors()[len(before):] for word in words)


def safe_state_file_lost(scene: Scene, *, how: str) -> None:
    """The safe-state file is removed or overwritten. It is restored and reported within seconds, and a killed program
    leaves a safe chamber."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    orders = pathlib.Path(f"{run.record}.safe-state")
    before, content = run.errors(), orders.read_bytes()
    if how == "removed":
        orders.unlink()
    elif how == "moved":
        orders.rename(scene.folder / "away")
    else:
        orders.write_bytes(b'schema = "gyrotherm-safe-state/1"\ngarbage\n')
    back = until(lambda: orders.exists() and orders.read_bytes() == content, PUT_BACK_WITHIN)
    scene.expect(back, f"the safe-state file was not put back within {PUT_BACK_WITHIN:g} s")
    scene.expect(until(lambda: says(run, before, "safe-state")), f"no message: {run.errors()[len(before):]!r}")
    expect_safe_death(scene, laboratory, run, f"killed after its safe-state file was {how}")


for _how in ("removed", "moved", "overwritten"):
    enter("presence", f"safe_state_file_{_how}", functools.partial(safe_state_file_lost, how=_how),
          long_only=_how == "moved")


@attack("presence")
def guard_killed(scene: Scene) -> None:
    """The guard is killed three times. Each time another one exists within seconds."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    for _ in range(3):
        guards = until(run.guards, PUT_BACK_WITHIN) or []
        for pid in guards:
            kill(pid)
        another = until(lambda: set(run.guards()) - set(guards), PUT_BACK_WITHIN)
        scene.expect(another, f"no other guard within {PUT_BACK_WITHIN:g} s")
    time.sleep(1)
    expect_safe_death(scene, laboratory, run, "killed after its guard was")


@attack("presence")
def guard_killed_and_its_program_gone(scene: Scene) -> None:
    """The guard is killed and its program file is gone. Status and messages show an alarm, and a guard exists again
    once the file is back."""
    laboratory = scene.laboratory()
    make_safe = scene.copy_programs()
    run = scene.hot_run(laboratory)
    before = run.errors()
    away = make_safe.with_name("away")
    make_safe.rename(away)
    for pid in until(run.guards, PUT_BACK_WITHIN) or []:
        kill(pid)
    alarm = until(lambda: any("guard" in fault for fault in run.status().get("faults_now", [])), every=0.5)
    scene.expect(alarm, f"status has no alarm of the missing guard: {run.status().get('faults_now')}")
    scene.expect(until(lambda: says(run, before, "guard")), f"no message: {run.errors()[len(before):]!r}")
    away.rename(make_safe)
    scene.expect(until(run.guards), "no guard after its program file was back")
    gone = until(lambda: not run.status().get("faults_now"), every=0.5)
    scene.expect(gone, f"the alarm stays although there is a guard: {run.status().get('faults_now')}")
    expect_safe_death(scene, laboratory, run, "killed after its guard was put back")


def foreign_manager(scene: Scene, *, socket_is_there: bool, watchdog_pid: int = 0) -> None:
    """The environment has NOTIFY_SOCKET and WATCHDOG_USEC of a service manager that does not watch this program. It has
    a guard of its own."""
    laboratory = scene.laboratory()
    path = scene.folder / "notify"
    if socket_is_there:
        manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        manager.bind(str(path))
        scene.closing.append(manager.close)
    environment = {"NOTIFY_SOCKET": str(path), "WATCHDOG_USEC": "8000000"}
    if watchdog_pid:
        environment["WATCHDOG_PID"] = str(watchdog_pid)
    run = scene.hot_run(laboratory, **environment)
    expect_safe_death(scene, laboratory, run, "killed under a foreign service manager")


enter("presence", "foreign_manager", functools.partial(foreign_manager, socket_is_there=True))
enter("presence", "foreign_manager_without_socket", functools.partial(foreign_manager, socket_is_there=False),
      long_only=True)
enter("presence", "foreign_manager_of_another_process",
      functools.partial(foreign_manager, socket_is_there=True, watchdog_pid=os.getppid()), long_only=True)


@attack("presence")
def guard_stopped(scene: Scene) -> None:
    """The guard is stopped by SIGSTOP, and 15 s later the program is killed. The chamber is safe within 20 s."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    guards = until(run.guards, PUT_BACK_WITHIN) or []
    for pid in guards:
        kill(pid, signal.SIGSTOP)
    time.sleep(15)
    expect_safe_death(scene, laboratory, run, "killed while its guard was stopped")


def killed_while_its_guard_is_replaced(scene: Scene, *, by: int) -> None:
    """The guard is killed or stopped, its replacement takes 3 s to start, and meanwhile the program is killed. The
    chamber is safe within 20 s."""
    laboratory = scene.laboratory()
    make_safe = scene.copy_programs()
    slow = make_safe.with_name("slow") / make_safe.name
    slow.parent.mkdir()
    begins_late, begun = slow.with_name("begins-late"), slow.with_name("begun")
    make_safe.rename(slow)
    wrapper = f"#!/bin/sh\nif [ -e '{begins_late}' ]; then : > '{begun}'; sleep 3; fi\nexec '{slow}' \"$@\"\n"
    make_safe.write_text(wrapper, encoding="utf-8")
    make_safe.chmod(0o755)
    run = scene.hot_run(laboratory)
    guards = until(run.guards, PUT_BACK_WITHIN) or []
    begins_late.touch()
    for pid in guards:
        kill(pid, by)
    scene.need(until(begun.exists, 2 * PUT_BACK_WITHIN), "the guard was not replaced")
    time.sleep(0.5)
    expect_safe_death(scene, laboratory, run, "killed while its guard was replaced")


for _name, _signal in (("killed", signal.SIGKILL), ("stopped", signal.SIGSTOP)):
    enter("presence", f"killed_while_its_{_name}_guard_is_replaced",
          functools.partial(killed_while_its_guard_is_replaced, by=_signal))


@attack("presence")
def guard_without_orders(scene: Scene) -> None:
    """A guard's line ends before it has received orders. While the program lives the guard does not act; once it is
    dead the safe-state file contains the orders."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    guard = [scene.programs.make_safe, "--guard", run.record]
    ran = scene.programs.finish(guard, 30)
    scene.expect(ran.code == 2, f"exit {ran.code}, expected 2: {ran.text}")
    scene.expect(abs(laboratory.chamber.set_point - 60) < 0.01, "it took the chamber from a program that lives")
    scene.expect(not run.ended(), "it ended a program that lives")
    for pid in run.guards():
        kill(pid)
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    run.wait()
    ran = scene.programs.finish(guard, 40)
    scene.expect(ran.code == 0, f"exit {ran.code}, expected 0: {ran.text}")
    scene.expect_safe(laboratory, died, 2 * GUARD_LIMIT, "a guard without orders")


@attack("presence")
def whole_group_killed(scene: Scene) -> None:
    """All processes that the terminal has started are killed together. The guard is not among them."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    terminal.start_reading()
    run = scene.hot_run(laboratory, terminal=terminal)
    died = time.monotonic()
    os.killpg(os.getpgid(run.pid), signal.SIGKILL)
    scene.expect_safe(laboratory, died, GUARD_LIMIT, "process group killed")
