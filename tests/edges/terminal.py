# SPDX-License-Identifier: Apache-2.0
"""Blocked outputs: terminals, pipes, closed sessions (C1, M2, M5)."""
from __future__ import annotations

import functools
import pathlib
import signal
import time

from attack import GUARD_LIMIT, Scene, attack, enter
from program import Pipe, Run, Terminal, json_lines, kill, until
from laboratory import Laboratory
from rig import hold

CTRL_S, CTRL_Q = b"\x13", b"\x11"
LIMIT_REACTION_S = 5.0  # s, from the exceeded limit to the safe chamber


def waits(scene: Scene, short: float, long: float) -> float:
    """Returns the time for which the output is blocked, s."""
    return long if scene.long else short


def on_a_terminal(scene: Scene, laboratory: Laboratory, terminal: Terminal, **how: object) -> Run:
    """Starts a hot run. Its panel and messages go to a terminal, its acknowledgements to a file."""
    return scene.hot_run(laboratory, terminal=terminal, **how)


def expect_the_limit_holds(scene: Scene, laboratory: Laboratory, run: Run, stopped_at: float) -> None:
    """Expects ticks while the output was blocked. Then the chamber reports 120 °C and must be safe within 5 s."""
    scene.expect_ticks(laboratory, stopped_at, time.monotonic())
    beyond = time.monotonic()
    laboratory.chamber.shown_air = 120.0
    scene.expect_safe(laboratory, beyond, LIMIT_REACTION_S, "air outside its limit")
    laboratory.chamber.shown_air = None  # the run ends when the air has been seen on its way to the safe set point
    code = run.wait()
    scene.expect(code == 6, f"exit {code} after an interlock, expected 6")
    if code is None:
        run.signal(signal.SIGKILL)
        run.wait()
    scene.expect_whole(scene.read(run.record), laboratory, run.acknowledged())


@attack("terminal", limit=900)
def ctrl_s(scene: Scene) -> None:
    """Ctrl-S stops the terminal of a hot run. Ticks, record and limits are unaffected."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    terminal.start_reading()
    run = on_a_terminal(scene, laboratory, terminal)
    terminal.press(CTRL_S)
    stopped_at = time.monotonic()
    time.sleep(waits(scene, 15, 600))
    expect_the_limit_holds(scene, laboratory, run, stopped_at)


@attack("terminal", limit=900)
def ctrl_s_on_the_way(scene: Scene) -> None:
    """Ctrl-S while the chamber ramps to 60 °C. The ramp, the record and the limits are unaffected."""
    laboratory, terminal = scene.laboratory(air=55.0), scene.terminal()
    terminal.start_reading()
    run = scene.start(scene.profile(hold(60.0, 3600)), scene.rig(laboratory), terminal=terminal)
    scene.need(run.wait_acknowledged(2), f"the run did not begin: {terminal.shown[-600:]!r}")
    terminal.press(CTRL_S)
    stopped_at = time.monotonic()
    time.sleep(waits(scene, 15, 120))
    scene.expect(abs(laboratory.chamber.set_point - 60) < 0.01,
                 f"the ramp stopped at {laboratory.chamber.set_point:g} °C")
    expect_the_limit_holds(scene, laboratory, run, stopped_at)


@attack("terminal", limit=900)
def unread_terminal(scene: Scene) -> None:
    """The terminal is full and not read, as with a stalled ssh session. Ticks, record and limits are unaffected."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    run = on_a_terminal(scene, laboratory, terminal)
    if not scene.long:
        terminal.fill()
    stopped_at = time.monotonic()
    time.sleep(waits(scene, 15, 600))
    expect_the_limit_holds(scene, laboratory, run, stopped_at)


@attack("terminal")
def resume_on_an_unread_terminal(scene: Scene) -> None:
    """A killed run is resumed on a full terminal that is not read. It continues, and its limits act."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    run = scene.hot_run(laboratory)
    for pid in until(run.guards) or []:
        kill(pid)
    run.signal(signal.SIGKILL)
    run.wait()
    acknowledged = run.acknowledged()
    terminal.fill()
    again = scene.resume(run, terminal=terminal)
    scene.need(again.wait_acknowledged(acknowledged + 5, 40), "the run did not continue")
    beyond = time.monotonic()
    laboratory.chamber.shown_air = 120.0
    scene.expect_safe(laboratory, beyond, LIMIT_REACTION_S, "air outside its limit")
    laboratory.chamber.shown_air = None
    code = again.wait()
    scene.expect(code == 6, f"an interlock ends a run with 6, not {code}")


@attack("terminal")
def unread_terminal_for_everything(scene: Scene) -> None:
    """Acknowledgements, panel and messages go to one full terminal that is not read. The limits act."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    record = scene.folder / "run.db"
    laboratory.chamber.begin_at(60)
    run = scene.start(scene.profile(hold(60.0, 3600)), scene.rig(laboratory), terminal=terminal, stdout=terminal.slave)
    scene.need(until(lambda: scene.programs.status(record).get("acknowledged", -1) >= 2, every=0.5), "it did not begin")
    terminal.fill()
    stopped_at = time.monotonic()
    time.sleep(waits(scene, 15, 120))
    scene.expect_ticks(laboratory, stopped_at, time.monotonic())
    beyond = time.monotonic()
    laboratory.chamber.shown_air = 120.0
    scene.expect_safe(laboratory, beyond, LIMIT_REACTION_S, "air outside its limit")
    laboratory.chamber.shown_air = None  # the run ends when the air has been seen on its way to the safe set point
    code = run.wait()
    scene.expect(code == 6, f"an interlock ends a run with 6, not {code}")


def blocked_then_dies(scene: Scene, *, how: str, number: int) -> None:
    """The terminal is stopped or full, and then the program is killed or stopped. Its guard acts within 20 s."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    if how == "ctrl_s":
        terminal.start_reading()
    run = on_a_terminal(scene, laboratory, terminal)
    scene.expect_guarded(run)
    if how == "ctrl_s":
        terminal.press(CTRL_S)
    else:
        terminal.fill()
    time.sleep(3)
    died = time.monotonic()
    run.signal(number)
    scene.expect_safe(laboratory, died, GUARD_LIMIT, "program gone, terminal blocked")
    scene.expect_held(laboratory, 2)


for _how in ("ctrl_s", "unread"):
    for _number, _word in ((signal.SIGKILL, "killed"), (signal.SIGSTOP, "stopped")):
        enter("terminal", f"{_how}_then_{_word}", functools.partial(blocked_then_dies, how=_how, number=_number))


@attack("terminal", limit=600)
def full_pipe_for_messages(scene: Scene) -> None:
    """Standard error is a full pipe that is not read. Ticks, record and limits are unaffected."""
    laboratory, pipe = scene.laboratory(), Pipe()
    scene.closing.append(pipe.close)
    run = scene.hot_run(laboratory, stderr=pipe)
    pipe.fill()
    stopped_at = time.monotonic()
    time.sleep(waits(scene, 15, 120))
    laboratory.chamber.change_set_point(59.0)  # causes a message
    time.sleep(5)
    laboratory.chamber.change_set_point(60.0)
    time.sleep(5)
    expect_the_limit_holds(scene, laboratory, run, stopped_at)


@attack("terminal", limit=600)
def full_pipe_for_acknowledgements(scene: Scene) -> None:
    """The reader of --json pauses for a while. The run continues, and the next line reports the number of missed
    lines."""
    laboratory, pipe = scene.laboratory(), Pipe()
    scene.closing.append(pipe.close)
    record = scene.folder / "run.db"
    laboratory.chamber.begin_at(60)
    pipe.fill(but=120)
    run = scene.start(scene.profile(hold(60.0, 3600)), scene.rig(laboratory), stdout=pipe.writes)
    pipe.let_go()
    scene.need(until(lambda: scene.programs.status(record).get("acknowledged", -1) >= 2, every=0.5),
               f"it did not begin: {run.errors()}")
    stopped_at = time.monotonic()
    time.sleep(waits(scene, 30, 120))
    scene.expect_ticks(laboratory, stopped_at, time.monotonic())
    scene.expect(not run.ended(), f"the run has ended: {run.process.poll()}")
    lines = json_lines(pipe.read_for(6).decode(errors="replace"))
    acknowledged = [line["acknowledged"] for line in lines if "acknowledged" in line]
    scene.expect(acknowledged == sorted(set(acknowledged)), f"not in order: {acknowledged}")
    before, expected = -1, 0
    for line in lines:
        if "acknowledged" in line:
            expected = line["acknowledged"] - before - 1
            if "missed" in line:
                scene.expect(line["missed"] == expected, f"{line} after {before}, expected missed = {expected}")
            else:
                scene.expect(expected == 0, f"{line} after {before} does not report {expected} missed lines")
            before = line["acknowledged"]
    scene.expect(before >= run.status().get("acknowledged", 0) - 2, f"the reader is not up to date: {lines[-3:]}")
    scene.stop(run)
    scene.expect_whole(scene.read(record), laboratory, max(acknowledged, default=-1))


@attack("terminal")
def full_pipe_for_acknowledgements_then_killed(scene: Scene) -> None:
    """The pipe of --json is full, and then the program is killed. Its guard acts within 20 s."""
    laboratory, pipe = scene.laboratory(), Pipe()
    scene.closing.append(pipe.close)
    laboratory.chamber.begin_at(60)
    run = scene.start(scene.profile(hold(60.0, 3600)), scene.rig(laboratory), stdout=pipe.writes)
    scene.need(until(lambda: run.status().get("acknowledged", -1) >= 2, every=0.5), f"it did not begin: {run.errors()}")
    pipe.fill()
    time.sleep(3)
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    scene.expect_safe(laboratory, died, GUARD_LIMIT, "program gone, pipe full")


@attack("terminal")
def closed_outputs(scene: Scene) -> None:
    """Standard output and standard error are /dev/full. The run continues, and its record is complete."""
    laboratory = scene.laboratory()
    record = scene.folder / "run.db"
    laboratory.chamber.begin_at(60)
    with open("/dev/full", "wb") as full:
        run = scene.start(scene.profile(hold(60.0, 3600)), scene.rig(laboratory), stdout=full, stderr=full)
    scene.need(until(lambda: scene.programs.status(record).get("acknowledged", -1) >= 8, every=0.5), "no progress")
    acknowledged = scene.programs.status(record).get("acknowledged", -1)
    scene.stop(run)
    scene.expect_whole(scene.read(record), laboratory, acknowledged)


def hung_up(scene: Scene, *, on_hangup: str) -> None:
    """The terminal of a run is closed. The run continues with its guard, or makes the chamber safe, as its rig file
    specifies."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    safe = {"on_hangup": f'"{on_hangup}"'} if on_hangup else {}
    run = on_a_terminal(scene, laboratory, terminal, rig={"safe": safe})
    hung = time.monotonic()
    terminal.hang_up()
    if on_hangup == "safe":
        scene.expect_safe(laboratory, hung, LIMIT_REACTION_S, "a closed terminal with on_hangup = \"safe\"")
        scene.expect(run.wait() == 6, f"exit {run.process.poll()}, expected 6")
        return
    time.sleep(8)
    scene.expect(not run.ended(), f"the run ended with {run.process.poll()} at a closed terminal, the chamber at "
                                  f"{laboratory.chamber.set_point:g} °C")
    scene.expect_ticks(laboratory, hung, time.monotonic())
    scene.expect(run.guards(), "there is no guard after the terminal was closed")
    run.signal(signal.SIGKILL)
    scene.expect_safe(laboratory, time.monotonic(), GUARD_LIMIT, "killed after its terminal was closed")
    scene.expect_whole(scene.read(run.record), laboratory, run.acknowledged())


enter("terminal", "hangup_goes_on", functools.partial(hung_up, on_hangup=""))
enter("terminal", "hangup_goes_on_as_told", functools.partial(hung_up, on_hangup="go_on"), long_only=True)
enter("terminal", "hangup_makes_safe", functools.partial(hung_up, on_hangup="safe"))


def expect_standstill(scene: Scene, run: Run, terminal: Terminal) -> None:
    """Expects that the run acknowledges three more seconds without output to the terminal."""
    def is_terminal_stopped() -> bool:
        shown = len(terminal.shown)
        scene.need(run.wait_acknowledged(run.acknowledged() + 3), "the run stopped together with its terminal")
        return len(terminal.shown) == shown
    scene.need(until(is_terminal_stopped), "Ctrl-S does not stop the terminal")


@attack("terminal", limit=600)
def back_after_ctrl_q(scene: Scene) -> None:
    """Ctrl-Q after Ctrl-S. The panel continues, and each message in between is printed or counted as missed."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    terminal.start_reading()
    run = on_a_terminal(scene, laboratory, terminal)
    scene.need(until(lambda: len(terminal.pictures()) > 2), f"the panel is not redrawn: {terminal.shown[-600:]!r}")
    terminal.press(CTRL_S)
    expect_standstill(scene, run, terminal)
    done, _ = run.tell("note", "sent while the terminal was stopped")
    scene.expect(done, "a note was refused")
    expect_standstill(scene, run, terminal)
    shown = len(terminal.shown)
    terminal.press(CTRL_Q)
    came = until(lambda: b"request by" in terminal.shown[shown:] or b"missed" in terminal.shown[shown:])
    scene.expect(came, f"nothing of the note after Ctrl-Q: {bytes(terminal.shown[shown:])[-300:]!r}")
    later = len(terminal.shown)
    scene.expect(until(lambda: len(terminal.pictures(later)) > 2), "the panel is not redrawn after Ctrl-Q")
    scene.stop(run)
    scene.expect_whole(scene.read(run.record), laboratory, run.acknowledged())


@attack("terminal")
def interrupt_at_a_blocked_terminal(scene: Scene) -> None:
    """Ctrl-C at a run whose terminal is blocked. It ends cleanly, and the chamber keeps its set point."""
    laboratory, terminal = scene.laboratory(), scene.terminal()
    run = on_a_terminal(scene, laboratory, terminal)
    terminal.fill()
    time.sleep(3)
    terminal.press(b"\x03")
    code = run.wait()
    scene.expect(code == 5, f"exit {code} after Ctrl-C at a full terminal, expected 5")
    time.sleep(1)
    scene.expect(abs(laboratory.chamber.set_point - 60) < 0.01,
                 f"the chamber was left at {laboratory.chamber.set_point:g} °C instead of its set point")
    scene.expect(not pathlib.Path(f"{run.record}.safe-state").exists(), "the safe-state file is still there")
    scene.expect_whole(scene.read(run.record), laboratory, run.acknowledged())
