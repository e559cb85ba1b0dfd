# SPDX-License-Identifier: Apache-2.0
"""Several requests to a run within one second (C3)."""
from __future__ import annotations

import functools
import signal
import threading
import time
from typing import Callable

import program
from attack import GUARD_LIMIT, START_LIMIT, Scene, enter
from laboratory import Laboratory
from program import Run, Speaker, until
from rig import SAFE

SOON = 5.0  # s, for the effect of an answered request
MOMENTS = (0.05, 0.6, 0.3, 0.8, 0.15, 0.45)  # s after a tick, one per try

Answers = list[tuple[str, bool, str]]  # request, done, answer


def send_in_turn(run: Run, words: tuple[str, ...]) -> Answers:
    """Sends the requests or signals, each after the previous answer."""
    answers = []
    for word in words:
        if word.startswith("SIG"):
            run.signal(getattr(signal, word))
            answers.append((word, True, ""))
        else:
            answers.append((word, *run.tell(word, "of a hurry" if word == "note" else "")))
    return answers


def send_together(run: Run, words: tuple[str, ...]) -> Answers:
    """Sends all requests before it reads the first answer, like several operators."""
    speakers = [(word, Speaker(run.record, word, "of a hurry" if word == "note" else "")) for word in words]
    return [(word, *speaker.answer()) for word, speaker in speakers]


def tries(scene: Scene, words: tuple[str, ...], on_stop: str,
          judge: Callable[[Scene, Laboratory, Run, Answers, float], None], held: bool = False) -> None:
    """Sends the requests within one second, at several moments, one after the other and all together, each time to a
    new run."""
    for number, moment in enumerate(MOMENTS[:6 if scene.long else 2]):
        laboratory = scene.laboratory()
        run = scene.hot_run(laboratory, acknowledged=1, rig={"safe": {"on_stop": f'"{on_stop}"'}},
                            record=f"run-{number}.db")
        if held:
            scene.need(run.tell("pause")[0], "a pause was refused")
            scene.need(until(lambda: run.status().get("state") == "held", SOON, 0.3), "the run was not held")
        second = run.acknowledged()
        scene.need(until(lambda: run.acknowledged() > second, START_LIMIT, 0.01), "no further second")
        time.sleep(moment)
        began = time.monotonic()
        signals = any(word.startswith("SIG") for word in words)
        answers = send_together(run, words) if number % 2 and not signals else send_in_turn(run, words)
        judge(scene, laboratory, run, answers, began)
        run.signal(signal.SIGKILL)
        run.wait()
        for guard in run.guards():
            program.kill(guard)


def expect_consistent(scene: Scene, answers: Answers, after: str, *promises: str) -> None:
    """Expects that an answer "done" after the request `after` names the pending action."""
    behind = [word for word, _, _ in answers].index(after) + 1
    for word, done, answer in answers[behind:]:
        if word in ("pause", "stop", "resume") and done:
            scene.expect(any(p in answer for p in promises), f"\"{word}\" was answered \"done {answer}\", and that did "
                                                             f"not happen: {answers}")


def expect_aborted(scene: Scene, laboratory: Laboratory, run: Run, answers: Answers, since: float) -> None:
    """Expects that an abort answered "done" is executed, whichever requests follow, and that no answer contradicts it."""
    if ("stop", True) in [(word, done) for word, done, _ in answers] and ("abort", False) in [s[:2] for s in answers]:
        expect_stopped(scene, laboratory, run, answers, since, left_at=60.0)  # it had ended before the abort arrived
        return
    scene.expect(any(word == "abort" and done for word, done, _ in answers), f"abort not acknowledged: {answers}")
    scene.expect_safe(laboratory, since, SOON, f"{answers}")
    code = run.wait()
    scene.expect(code == 6, f"exit {code}, expected 6 after {answers}")
    expect_consistent(scene, answers, "abort", "safe", "abort")
    scene.expect_held(laboratory, 1)


def expect_stopped(scene: Scene, laboratory: Laboratory, run: Run, answers: Answers, since: float, *,
                   left_at: float) -> None:
    """Expects that a stop answered "done" ends the run and leaves the chamber as the rig file requires."""
    scene.expect(any(word == "stop" and done for word, done, _ in answers), f"the stop was not acknowledged: {answers}")
    code = run.wait(max(0.0, since + 2 * SOON - time.monotonic()))
    scene.expect(code == 0, f"exit {code}, expected 0 after {answers}")
    time.sleep(1)
    at = laboratory.chamber.set_point
    scene.expect(abs(at - left_at) < 0.01, f"chamber left at {at:g} °C instead of {left_at:g} °C after {answers}")
    expect_consistent(scene, answers, "stop", "stop", "end", "over")


def expect_held(scene: Scene, laboratory: Laboratory, run: Run, answers: Answers, since: float) -> None:
    """Expects that the run is held after a pause answered "done"."""
    scene.expect(answers[-1][1], f"the pause was refused: {answers}")
    time.sleep(max(0.0, since + 2.5 - time.monotonic()))
    shown = run.status().get("state")
    scene.expect(shown == "held", f"the run is \"{shown}\" and not \"held\" after {answers}")


ABORTS = {
    "abort_then_pause": ("abort", "pause"),
    "abort_then_stop": ("abort", "stop"),
    "abort_then_resume": ("abort", "resume"),
    "abort_then_note": ("abort", "note"),
    "abort_then_pause_then_stop": ("abort", "pause", "stop"),
    "pause_then_abort": ("pause", "abort"),
    "stop_then_abort": ("stop", "abort"),
    "abort_between_pauses": ("pause", "abort", "pause"),
    "abort_then_sigint": ("abort", "SIGINT"),
    "abort_then_sigterm": ("abort", "SIGTERM"),
    "abort_then_sighup": ("abort", "SIGHUP"),
    "pause_abort_sigint": ("pause", "abort", "SIGINT"),
}
SHORT = {"abort_then_pause", "abort_then_stop", "stop_then_abort", "abort_then_sigint"}


def aborted(scene: Scene, *, words: tuple[str, ...]) -> None:
    """An acknowledged abort is executed, whatever else arrives in its second and whatever the value of `on_stop`."""
    tries(scene, words, "hold", expect_aborted)


for _name, _words in ABORTS.items():
    enter("requests", _name, functools.partial(aborted, words=_words), long_only=_name not in SHORT)


def stopped(scene: Scene, *, on_stop: str) -> None:
    """An acknowledged stop is executed although a pause arrives in its second."""
    left_at = SAFE if on_stop == "safe" else 60.0
    tries(scene, ("stop", "pause"), on_stop, functools.partial(expect_stopped, left_at=left_at))


enter("requests", "stop_then_pause", functools.partial(stopped, on_stop="hold"))
enter("requests", "stop_then_pause_safe", functools.partial(stopped, on_stop="safe"), long_only=True)


def expect_paused_or_resumed(scene: Scene, laboratory: Laboratory, run: Run, answers: Answers, since: float) -> None:
    """The pause is done. The resume is done, or refused because of the pause, but not with the reason that the run is
    not held."""
    (_, paused, _), (_, resumed, answer) = answers
    scene.expect(paused, f"the pause was refused: {answers}")
    scene.expect("not held" not in answer, f"resume refused with a reason that contradicts the pause: {answers}")
    time.sleep(max(0.0, since + 2.5 - time.monotonic()))
    shown, promised = run.status().get("state"), "execute" if resumed else "held"
    scene.expect(shown == promised, f"the run is \"{shown}\" and not \"{promised}\" after {answers}")


def paused_and_resumed(scene: Scene) -> None:
    """After a pause and a resume within one second the run is in the state that the answers name."""
    tries(scene, ("pause", "resume"), "safe", expect_paused_or_resumed)


def resumed_and_paused(scene: Scene) -> None:
    """A held run that is resumed and paused within one second is held."""
    tries(scene, ("resume", "pause"), "safe", expect_held, held=True)


def resumed_and_aborted(scene: Scene) -> None:
    """A held run that is resumed and aborted within one second is made safe."""
    tries(scene, ("resume", "abort"), "hold", expect_aborted, held=True)


enter("requests", "pause_then_resume", paused_and_resumed)
enter("requests", "resume_then_pause", resumed_and_paused, long_only=True)
enter("requests", "resume_then_abort", resumed_and_aborted)


def killed_after_abort(scene: Scene) -> None:
    """The program is killed at the moment at which it has acknowledged an abort. Its guard makes the chamber safe."""
    def judge(scene: Scene, laboratory: Laboratory, run: Run, answers: Answers, since: float) -> None:
        scene.expect(answers[0][1], f"abort not acknowledged: {answers}")
        scene.expect_safe(laboratory, since, GUARD_LIMIT, f"{answers}")
    tries(scene, ("abort", "SIGKILL"), "hold", judge)


enter("requests", "abort_then_killed", killed_after_abort)


def abort_before_a_crowd(scene: Scene) -> None:
    """The program is stopped for a moment. An abort is the first of several requests that it then reads together."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    run.signal(signal.SIGSTOP)
    first = Speaker(run.record, "abort")
    crowd = [threading.Thread(target=lambda: Speaker(run.record, "note", "of one in a crowd").answer(), daemon=True)
             for _ in range(20)]
    for one in crowd:
        one.start()
    time.sleep(1)
    since = time.monotonic()
    run.signal(signal.SIGCONT)
    done, answer = first.answer()
    scene.expect(done, f"the abort was not acknowledged: {answer}")
    scene.expect_safe(laboratory, since, SOON, "an abort before a crowd")


enter("requests", "abort_before_a_crowd", abort_before_a_crowd)
