#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""ESPEC P-300 and SCP-220, as ESPEC's ChamberConnectLibrary and akaeba/ATWG use them.

The programs of a P-300 are those of ChamberConnectLibrary and of three scripts of users.
"""
from __future__ import annotations

import re
import time
from dataclasses import dataclass, field

from text_server import Client, Heard, TextChamber, main

UNKNOWN, PARAMETER, RANGE = "NA:CMD ERR", "NA:PARA ERR", "NA:DATA OUT OF RANGE"
PROTECTED, NOT_READY, NO_HUMIDITY = "NA:PROTECT ON", "NA:DATA NOT READY", "NA:CONT NOT READY-1"
NO_PROGRAM = "NA:CONT NOT READY-2"
NUMBER = r"-?\d+(?:\.\d+)?"
SETTING = re.compile(rf"TEMP,((?:[SHL]{NUMBER})+)")
STEP = re.compile(rf"STEP(\d+),(.*)")
EDITED = re.compile(r"PRGM DATA WRITE,PGM(\d+),(.*)")
STORED = re.compile(r"PRGM DATA\?,RAM:(\d+)(?:,(STEP(\d+)|DETAIL))?")
NOT_EDITING, EDITING, IN_ORDER, INCOMPLETE, RUNNING = (f"NA:PRGM WRITE ERR-{n}" for n in (2, 4, 8, 11, 10))


@dataclass
class Step:
    """A step of a program: time in minutes of a ramp to its temperature, or of a hold at it."""
    temperature: float
    minutes: int
    ramp: bool = False
    guaranty: bool = False


@dataclass
class Program:
    steps: list[Step] = field(default_factory=list)
    name: str = ""
    end: str = ""
    start: float | None = None


class Espec(TextChamber):
    """A chamber, with or without humidity. A set point outside the alarm limits is refused."""
    name = "espec"
    other_question = "TEMP?"
    identity_questions = ("TYPE?", "ROM?")
    other_family = {"TYPE?": "T,GLC,190.0", "ROM?": "GLC 2.1"}
    pause_after_answer, pause_after_write = 0.3, 0.5
    program_speed = 1.0  # of the clock of a stored program

    def __init__(self, *, humidity: bool = False, empty_humidity: bool = True, protected: bool = False,
                 alarms: tuple[int, ...] = (), sensor: str = "T", mode: str = "STANDBY", **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.humidity, self.empty_humidity, self.protected = humidity, empty_humidity, protected
        self.alarms, self.sensor, self.mode = alarms, sensor, mode
        self.alarm_low, self.alarm_high = self.lowest, self.highest
        self.programs: dict[int, Program] = {}
        self.edited: tuple[int, Program] | None = None
        self.run: tuple[Program, float, float] | None = None  # program, its start (monotonic s) and first temperature

    @property
    def on(self) -> bool:
        return self.mode in ("CONSTANT", "RUN")

    @on.setter
    def on(self, value: bool) -> None:
        self.mode = "CONSTANT" if value else "STANDBY"

    def in_program(self) -> bool:
        return self.mode == "RUN"

    def to_program(self) -> bool:
        with self.lock:
            self.mode = "RUN"
        return True

    def target(self) -> float:
        """Returns the set point of the stored program that runs, else that of the constant mode."""
        if not self.run or self.mode != "RUN":
            return self.set_point
        program, began, before = self.run
        minutes = (time.monotonic() - began) * self.program_speed / 60
        for step in program.steps:
            if minutes < step.minutes:
                part = minutes / step.minutes if step.ramp else 1.0
                return before + (step.temperature - before) * part
            minutes, before = minutes - step.minutes, step.temperature
        return before

    def busy(self) -> str:
        return NOT_READY

    def reply(self, line: str) -> str:
        asked = {"TYPE?": self.type, "ROM?": lambda: "JMIC -S1.00", "TEMP?": self.temp, "HUMI?": self.humi,
                 "MON?": self.monitor, "MODE?": lambda: self.mode, "MODE?,DETAIL": lambda: self.mode,
                 "ALARM?": lambda: ",".join(map(str, (len(self.alarms), *self.alarms))), "%?": lambda: "1,56.2",
                 "SET?": lambda: "REF9", "REF?": lambda: "1,ON1" if self.on else "0",
                 "CONSTANT SET?,TEMP": lambda: f"{self.set_point_text()},ON",
                 "KEYPROTECT?": lambda: "OFF", "SRQ?": lambda: f"0{int(bool(self.alarms))}000000",
                 "PRGM MON?": self.program_monitor}.get(re.sub(r",\s+", ",", line))
        if stored := STORED.fullmatch(re.sub(r",\s+", ",", line)):
            return self.stored(int(stored[1]), stored[2] or "", int(stored[3] or 0))
        return asked() if asked else self.command(line)

    def stored(self, slot: int, what: str, number: int) -> str:
        """Returns what PRGM DATA? shows of a stored program."""
        program = self.programs.get(slot)
        if not program or number > len(program.steps):
            return NOT_READY
        if what == "DETAIL":
            start = "" if program.start is None else f",{program.start:.1f}"
            return f"{self.alarm_high:.1f},{self.alarm_low:.1f},TEMP{'SV' if start else 'PV'}{start}"
        if not number:
            return f"{len(program.steps)},<{program.name}>,COUNT,A(0.0.0),B(0.0.0),END({program.end})"
        step = program.steps[number - 1]
        humidity = ",HUMI OFF" if self.humidity else ""
        return (f"{number},TEMP{step.temperature:.1f},TEMP RAMP {'ON' if step.ramp else 'OFF'}{humidity},"
                f"TIME{step.minutes // 60}:{step.minutes % 60:02d},GRANTY {'ON' if step.guaranty else 'OFF'},REF9,"
                f"PAUSE OFF")

    def type(self) -> str:
        sensors = f"{self.sensor},{self.sensor}" if self.humidity else self.sensor
        return f"{sensors},P-300,190.0"

    def temp(self) -> str:
        return f"{self.air_text()},{self.set_point_text()},{self.alarm_high:.1f},{self.alarm_low:.1f}"

    def humi(self) -> str:
        return "49,OFF,100,0" if self.humidity else NO_HUMIDITY

    def monitor(self) -> str:
        humidity = "49," if self.humidity else "," if self.empty_humidity else ""
        return f"{self.air_text()},{humidity}{self.mode},{len(self.alarms)}"

    def program_monitor(self) -> str:
        return "1,3,55.0,1:30,0,0" if self.mode == "RUN" else NO_PROGRAM

    def command(self, line: str) -> str:
        """Returns the answer to a command, whose blanks after commas do not count."""
        command = re.sub(r"\s*,\s*", ",", line.strip())
        packed = command.replace(" ", "")
        if self.protected:
            self.refuse(line, PROTECTED)
        if command.startswith("TEMP,"):
            self.set_temp(line, packed)
        elif edited := EDITED.fullmatch(command):
            self.edit(line, int(edited[1]), edited[2])
        elif erased := re.fullmatch(r"PRGM ERASE,RAM:(\d+)", command):
            if int(erased[1]) not in self.programs:
                self.refuse(line, NOT_READY)
            self.take(line, lambda: self.programs.pop(int(erased[1]), None) and None)
        elif started := re.fullmatch(r"PRGM,RUN,RAM:(\d+),STEP1", command):
            self.start_program(line, int(started[1]))
        elif command in ("MODE,OFF", "MODE,STANDBY", "MODE,CONSTANT"):
            self.set_mode(line, command.partition(",")[2])
        elif command in ("POWER,ON", "POWER,OFF"):
            self.set_mode(line, "CONSTANT" if command.endswith("ON") else "OFF")
        elif command.startswith("PRGM,END"):
            if self.mode != "RUN":
                self.refuse(line, NO_PROGRAM)
            last = {"CONST": "CONSTANT", "STANDBY": "STANDBY", "OFF": "OFF", "HOLD": "RUN"}
            self.set_mode(line, last.get(command.rpartition(",")[2], "RUN"))
        elif command.startswith("HUMI,"):
            self.refuse(line, NO_HUMIDITY)
        elif command.startswith("MODE,"):
            self.refuse(line, PARAMETER)
        else:
            return self.not_known(line, UNKNOWN)
        return f"OK:{command}"

    def start_program(self, line: str, slot: int) -> None:
        program = self.programs.get(slot)
        if not program:
            self.refuse(line, NOT_READY)
        first = self.air if program.start is None else program.start
        self.run = program, time.monotonic(), first
        self.take(line, lambda: setattr(self, "mode", "RUN"))

    def edit(self, line: str, slot: int, what: str) -> None:
        """Edits a program: EDIT START, the steps in order, NAME, END, PRE MODE, PRE TSV, EDIT END or CANCEL."""
        if what == "EDIT START":
            if self.edited or not 1 <= slot <= 40:
                self.refuse(line, EDITING)
            self.edited = slot, Program()
        elif not self.edited or self.edited[0] != slot:
            self.refuse(line, NOT_EDITING)
        else:
            self.edit_part(line, slot, self.edited[1], what)
        self.heard.append(Heard(time.monotonic(), line))

    def edit_part(self, line: str, slot: int, program: Program, what: str) -> None:
        word, _, rest = what.partition(",")
        if what == "EDIT CANCEL":
            self.edited = None
        elif what == "EDIT END":
            if not program.steps or program.end not in ("HOLD", "CONST", "STANDBY", "OFF"):
                self.refuse(line, INCOMPLETE)
            self.programs[slot], self.edited = program, None
        elif step := STEP.fullmatch(what):
            if int(step[1]) != len(program.steps) + 1:
                self.refuse(line, IN_ORDER)
            program.steps.append(self.step(line, step[2]))
        elif word == "NAME" and 0 < len(rest) <= 15:
            program.name = rest
        elif word == "END":
            program.end = rest
        elif what in ("PRE MODE,TEMP,SV", "PRE MODE,TEMP,PV"):
            program.start = self.set_point if what.endswith("SV") else None
        elif word.startswith("PRE TSV") or (word == "PRE TSV"):
            program.start = float(rest)
        else:
            self.refuse(line, PARAMETER)

    def step(self, line: str, text: str) -> Step:
        found = {key: re.search(form, text) for key, form in
                 {"temperature": rf"TEMP({NUMBER})", "ramp": r"TRAMP(ON|OFF)", "time": r"TIME(\d+):(\d\d?)",
                  "guaranty": r"GRANTY ?(ON|OFF)"}.items()}
        if not found["temperature"] or not found["time"]:
            self.refuse(line, PARAMETER)
        step = Step(float(found["temperature"][1]), 60 * int(found["time"][1]) + int(found["time"][2]),
                    bool(found["ramp"]) and found["ramp"][1] == "ON",
                    bool(found["guaranty"]) and found["guaranty"][1] == "ON")
        if not self.alarm_low <= step.temperature <= self.alarm_high or (step.ramp and step.guaranty):
            self.refuse(line, RANGE)
        return step

    def set_mode(self, line: str, mode: str) -> None:
        self.take(line, lambda: setattr(self, "mode", mode))

    def set_temp(self, line: str, packed: str) -> None:
        """Takes set point and alarm limits, all or none."""
        if not SETTING.fullmatch(packed):
            self.refuse(line, PARAMETER)
        new = {letter: float(value) for letter, value in re.findall(rf"([SHL])({NUMBER})", packed[5:])}
        high, low = new.get("H", self.alarm_high), new.get("L", self.alarm_low)
        sought = new.get("S", self.set_point)
        if not low <= sought <= high or low < self.lowest - 20 or high > self.highest + 20:
            self.refuse(line, RANGE)
        self.alarm_high, self.alarm_low = high, low
        self.take(line, lambda: setattr(self, "set_point", sought))


class EspecOnBus(Espec):
    """The same on RS-485: a question begins with the address, and `OK:` repeats it."""

    def __init__(self, *, address: int = 1, **more: object) -> None:
        super().__init__(**more)
        self.prefix = f"{address},"

    def next_line(self, received: bytes) -> tuple[str | None, bytes]:
        line, rest = super().next_line(received)
        if line and not line.startswith(self.prefix):
            return "", rest  # another unit is asked
        return line and line.removeprefix(self.prefix), rest

    def encoded(self, answer: str) -> bytes:
        return super().encoded(answer.replace("OK:", f"OK:{self.prefix}", 1))


def test(client: Client) -> None:
    client.expect("TYPE?", "T,P-300,190.0")
    client.expect("MODE?", "STANDBY")
    client.expect("TEMP?", "25.0,23.0,90.0,-40.0")
    client.expect("TEMP, S-40.0", "OK:TEMP,S-40.0")
    client.expect("TEMP,S-40.1", RANGE)
    client.expect("TEMP, S25.0 H100.0 L-50.0", "OK:TEMP,S25.0 H100.0 L-50.0")
    client.expect("TEMP?", "25.0,25.0,100.0,-50.0")
    client.expect("MON?", "25.0,,STANDBY,0")
    client.expect("MODE, CONSTANT", "OK:MODE,CONSTANT")
    client.expect("MODE?", "CONSTANT")
    client.expect("ALARM?", "0")
    client.expect("MODE, NONSENSE", PARAMETER)
    client.expect("HUMI?", NO_HUMIDITY)
    client.expect("PRGM MON?", NO_PROGRAM)
    client.expect("JUMP", UNKNOWN)
    client.expect("PRGM DATA?,RAM:3", NOT_READY)
    client.expect("PRGM DATA WRITE, PGM3, STEP1, TEMP20.0, TIME0:05", NOT_EDITING)
    for part in ("EDIT START", "STEP1,TEMP25.0,TRAMPOFF,TIME0:05,GRANTY ON", "STEP2,TEMP-10.0,TRAMPON,TIME1:10",
                 "NAME,TEST", "END,HOLD", "PRE MODE,TEMP,SV", "PRE TSV,25.0", "EDIT END"):
        client.expect(f"PRGM DATA WRITE,PGM3,{part}", f"OK:PRGM DATA WRITE,PGM3,{part}")
    client.expect("PRGM DATA?,RAM:3", "2,<TEST>,COUNT,A(0.0.0),B(0.0.0),END(HOLD)")
    client.expect("PRGM DATA?,RAM:3,STEP2", "2,TEMP-10.0,TEMP RAMP ON,TIME1:10,GRANTY OFF,REF9,PAUSE OFF")
    client.expect("PRGM DATA?,RAM:3,STEP3", NOT_READY)
    client.expect("PRGM, RUN, RAM:3, STEP1", "OK:PRGM,RUN,RAM:3,STEP1")
    client.expect("MODE?", "RUN")
    client.expect("PRGM, END, CONST", "OK:PRGM,END,CONST")
    client.expect("PRGM ERASE,RAM:3", "OK:PRGM ERASE,RAM:3")
    client.expect("PRGM DATA?,RAM:3", NOT_READY)
    client.expect("MODE, STANDBY", "OK:MODE,STANDBY")
    client.expect("MODE?", "STANDBY")
    assert client.chamber.is_off()


if __name__ == "__main__":
    main(Espec, test)
