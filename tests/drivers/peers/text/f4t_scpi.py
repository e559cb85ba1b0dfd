#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Watlow F4T by SCPI, as TestEquity's manuals, te107_control and WatlowF4TscpiLibrary describe it."""
from __future__ import annotations

import re

from text_server import Client, TextChamber, main

NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
IDENTITY = "WATLOW ELECTRIC MANUFACTURING COMPANY,F4T1A2EAA1B1AAA,0000815,04.07:0012"


class F4tScpi(TextChamber):
    """A command is not answered, not even if it is wrong. Event 1 is the power."""
    name = "f4t_scpi"
    other_question = ":SOURCE:CLOOP1:PVALUE?"
    question_ends = b"\r\n"
    answer_end = "\n"
    identity_questions = ("*IDN?",)
    other_family = {"*IDN?": "KEYSIGHT TECHNOLOGIES,34970A,MY44012345,13-2-2"}
    exchanged = {"*IDN?": IDENTITY.replace("0000815", "0000816")}

    def __init__(self, *, fahrenheit: bool = False, ramp: str = "OFF", program: bool = False,
                 identity: str = IDENTITY, input_error: bool = False, **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.fahrenheit, self.ramp, self.identity, self.input_error = fahrenheit, ramp, identity, input_error
        self.running_program = self.on = program

    def in_program(self) -> bool:
        return self.running_program

    def to_program(self) -> bool:
        with self.lock:
            self.running_program = self.on = True
        return True

    def busy(self) -> str:
        return ""

    def reply(self, line: str) -> str | None:
        header, _, value = line.strip().upper().partition(" ")
        header = re.sub(r"^:?SOUR(?:CE)?:", ":SOURCE:", header)
        header = re.sub(r"^:?UNITS?:TEMP(?:ERATURE)?", ":UNIT:TEMPERATURE", header)
        header = re.sub(r"^:?(OUTP(?:UT)?)(\d):STAT(?:E)?", r":OUTPUT\2:STATE", header)
        header = re.sub(r"^:?PROG(?:RAM)?:(SEL(?:ECTED)?:)?", r":PROGRAM:\1", header)
        return self.asked(line, header) if header.endswith("?") else self.written(line, header, value.strip())

    def asked(self, line: str, header: str) -> str | None:
        unit = "F" if self.fahrenheit else "C"
        answers = {"*IDN?": lambda: self.identity, ":UNIT:TEMPERATURE?": lambda: unit,
                   ":UNIT:TEMPERATURE:DISPLAY?": lambda: unit,
                   ":SOURCE:CLOOP1:PVALUE?": lambda: self.air_text("{:.2f}"),
                   ":SOURCE:CLOOP1:PVAL?": lambda: self.air_text("{:.2f}"),
                   ":SOURCE:CLOOP1:SPOINT?": lambda: self.set_point_text("{:.2f}"),
                   ":SOURCE:CLOOP1:ERROR?": lambda: "ERROR" if self.input_error else "NONE",
                   ":SOURCE:CLOOP1:RACTION?": lambda: self.ramp, ":SOURCE:CLOOP1:RSCALE?": lambda: "MINUTES",
                   ":SOURCE:CLOOP1:RRATE?": lambda: "5.00", ":SOURCE:CLOOP1:RTIME?": lambda: "0.00",
                   ":SOURCE:CLOOP1:IDLE?": lambda: "23.00",
                   ":OUTPUT1:STATE?": lambda: "ON" if self.on else "OFF", ":OUTPUT2:STATE?": lambda: "OFF",
                   ":PROGRAM:NUMBER?": lambda: "1", ":PROGRAM:NAME?": lambda: '""',
                   ":PROGRAM:SELECTED:STATE?": lambda: "START" if self.running_program else "STOP"}
        if header not in answers:
            self.unknown.append(line)
            return None
        return answers[header]()

    def written(self, line: str, header: str, value: str) -> None:
        if header == ":SOURCE:CLOOP1:SPOINT" and NUMBER.fullmatch(value):
            self.take_set_point(line, float(value), "")
        elif header == ":SOURCE:CLOOP1:RACTION" and value in ("OFF", "STARTUP", "SETPOINT", "BOTH"):
            self.take(line, lambda: setattr(self, "ramp", value))
        elif header == ":UNIT:TEMPERATURE" and value in ("C", "F"):
            self.take(line, lambda: setattr(self, "fahrenheit", value == "F"))
        elif header == ":OUTPUT1:STATE" and value in ("ON", "OFF"):
            self.take_power(line, value == "ON")
        elif header == ":PROGRAM:SELECTED:STATE" and value in ("START", "STOP", "PAUSE", "RESUME"):
            self.take(line, lambda: setattr(self, "running_program", value not in ("STOP",) and self.running_program))
        else:
            self.unknown.append(line)


def test(client: Client) -> None:
    assert client.ask("*IDN?").startswith("WATLOW")
    client.expect(":UNIT:TEMPERATURE?", "C")
    client.expect(":SOURCE:CLOOP1:PVALUE?", "25.00")
    client.expect(":SOURCE:CLOOP1:SPOINT -40.0", "")
    client.expect(":SOUR:CLOOP1:SPOINT?", "-40.00")
    client.expect(":SOURCE:CLOOP1:SPOINT 400", "")
    client.expect(":SOURCE:CLOOP1:SPOINT?", "-40.00")
    client.expect(":OUTPUT1:STATE ON", "")
    client.expect(":OUTPUT1:STATE?", "ON")
    client.expect(":SOURCE:CLOOP1:ERROR?", "NONE")
    client.expect("NONSENSE?", "")
    client.expect(":OUTPUT1:STATE OFF", "")
    client.expect(":OUTPUT1:STATE?", "OFF")


if __name__ == "__main__":
    main(F4tScpi, test, "\n")
