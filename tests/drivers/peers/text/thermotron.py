#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Thermotron 8800, as its Commands.html, PyMeasure and public telnet drivers describe it; and the 3800."""
from __future__ import annotations

import re
import sys

from text_server import Client, TextChamber, main, self_test

DONE, UNKNOWN, RANGE, STATE = "0", "1", "3", "4"  # a command is answered by 0 or an error code
COLD_BOOT, RUNNING, BY_COMPUTER = 0, 1, 5
MANUAL, STOPPED, PROGRAM = 16, 2, 1
COMMAND = re.compile(r"([A-Z]{3,4})(\d*)(?:,(-?\d+(?:\.\d+)?))?(\?)?")


class Thermotron(TextChamber):
    """Channel 1 is the air. A set point takes effect in manual mode; a program overrules it."""
    name = "thermotron"
    other_question = "PVAR1?"
    identity_questions = ("IDEN?", "VRSN?")
    other_family = {"IDEN?": "3800", "VRSN?": "1.07"}

    def __init__(self, *, program: bool = False, ramp: float = 0.0, alarm: int = 0, cold: bool = True,
                 **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.running_program, self.ramp, self.alarm = program, ramp, alarm
        self.stopped_by = COLD_BOOT if cold else BY_COMPUTER
        self.on = program

    def in_program(self) -> bool:
        return self.running_program

    def to_program(self) -> bool:
        with self.lock:
            self.running_program = self.on = True
        return True

    def busy(self) -> str:
        return STATE

    def reply(self, line: str) -> str:
        found = COMMAND.fullmatch(line.strip().upper())
        if not found:
            return self.not_known(line, UNKNOWN)
        word, channel, value, asks = found.groups()
        if asks:
            return self.asked(line, word, channel)
        return self.written(line, word, channel, value)

    def asked(self, line: str, word: str, channel: str) -> str:
        if word == "PVAR":
            return self.air_text("{:.3f}") if channel == "1" else "0.000" if channel else UNKNOWN
        if word == "SETP" and channel:
            return self.set_point_text("{:.3f}") if channel == "1" else "0.000"
        answers = {"IDEN": "THERMOTRON 8800", "VRSN": "5.11", "MRMP": f"{self.ramp:.3f}", "ALRM": str(self.alarm),
                   "THTL": f"{30.0 * self.on:.3f}", "DEVN": f"{self.air - self.set_point:.3f}", "OPTN": "0",
                   "CCHR": "C", "CCNF": "2", "CNAM": "TEMPERATURE", "AUXE": "0",
                   "MODE": str(PROGRAM if self.running_program else MANUAL if self.on else 0),
                   "SCOD": str(RUNNING if self.on else self.stopped_by), "STAT": str(2 * self.on)}
        return answers[word] if word in answers else self.not_known(line, UNKNOWN)

    def written(self, line: str, word: str, channel: str, value: str | None) -> str:
        if word == "SETP" and channel == "1" and value is not None:
            self.take_set_point(line, float(value), RANGE)
        elif word == "MRMP" and channel == "1" and value is not None:
            self.take(line, lambda: setattr(self, "ramp", float(value)))
        elif word == "RUNM" and not channel:
            if self.running_program:
                self.refuse(line, STATE)
            self.take_power(line, True)
        elif word == "STOP" and not channel:
            self.take(line, self.stop)
        elif word in ("HOLD", "RESM"):
            self.take(line, lambda: None)
        else:
            return self.not_known(line, UNKNOWN)
        return DONE

    def stop(self) -> None:
        self.running_program = self.on = False
        self.stopped_by = BY_COMPUTER


class Thermotron3800(TextChamber):
    """The controller 3800, as PyMeasure drives it: no command is acknowledged, and a set point waits for RUNM."""
    name = "thermotron3800"
    question_ends = b"\r\n"
    identity_questions = ("IDEN?",)
    other_family = {"IDEN?": "THERMOTRON 8800"}
    pause_after_write = 1.0

    def __init__(self, *, mode: int = STOPPED, **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.mode, self.pending = mode, self.set_point
        self.on = mode in (MANUAL, PROGRAM)

    def busy(self) -> str:
        return ""

    def in_program(self) -> bool:
        return self.mode == PROGRAM

    def to_program(self) -> bool:
        with self.lock:
            self.mode, self.on = PROGRAM, True
        return True

    def to_off(self) -> bool:
        with self.lock:
            self.mode, self.on = STOPPED, False
        return True

    def reply(self, line: str) -> str | None:
        asked = {"IDEN?": lambda: "THERMOTRON 3800", "PVAR1?": lambda: self.air_text("{:.1f}"),
                 "SETP1?": lambda: self.set_point_text("{:.1f}"), "MODE?": lambda: str(self.mode)}.get(line.strip())
        if asked:
            return asked()
        found = COMMAND.fullmatch(line.strip())
        word, channel, value, _ = found.groups() if found else ("", "", None, None)
        self.obey(line, word, channel, value or "")
        return None

    def obey(self, line: str, word: str, channel: str, value: str) -> None:
        """Carries out a command; an unknown one is ignored."""
        if word == "SETP" and channel == "1" and value:
            if self.lowest <= float(value) <= self.highest:
                self.take(line, lambda: setattr(self, "pending", float(value)))
            else:
                self.refuse(line, "")
        elif word == "RUNM":
            self.take(line, self.run)
        elif word == "STOP":
            self.take(line, self.stop)
        else:
            self.unknown.append(line)

    def run(self) -> None:
        self.mode, self.on, self.set_point = MANUAL, True, self.pending

    def stop(self) -> None:
        self.mode, self.on = STOPPED, False


def test(client: Client) -> None:
    client.expect("IDEN?", "THERMOTRON 8800")
    client.expect("SETP1?", "23.000")
    client.expect("SETP1,-40", DONE)
    client.expect("SETP1?", "-40.000")
    client.expect("SETP1,-400", RANGE)
    client.expect("SCOD?", "0")
    client.expect("RUNM", DONE)
    client.expect("SCOD?", "1")
    assert -40 < float(client.ask("PVAR1?")) <= 25.0
    client.expect("ALRM1?", "0")
    client.expect("STOP", DONE)
    client.expect("SCOD?", "5")
    client.expect("JUMP", UNKNOWN)


def test_3800(client: Client) -> None:
    client.expect("IDEN?", "THERMOTRON 3800")
    client.expect("SETP1?", "23.0")
    client.expect("SETP1,30.0", "")
    client.expect("SETP1?", "23.0")
    client.expect("MODE?", "2")
    client.expect("RUNM", "")
    client.expect("SETP1?", "30.0")
    client.expect("MODE?", "16")
    client.expect("STOP", "")
    client.expect("MODE?", "2")
    assert client.chamber.is_off()


if __name__ == "__main__":
    if "--self-test" in sys.argv:
        self_test(Thermotron3800, test_3800, "\r")
    main(Thermotron, test, "\r")
