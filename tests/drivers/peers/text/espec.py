#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""ESPEC P-300 and SCP-220, as ESPEC's ChamberConnectLibrary and akaeba/ATWG use them."""
from __future__ import annotations

import re

from text_server import Client, TextChamber, main

UNKNOWN, PARAMETER, RANGE = "NA:CMD ERR", "NA:PARA ERR", "NA:DATA OUT OF RANGE"
PROTECTED, NOT_READY, NO_HUMIDITY = "NA:PROTECT ON", "NA:DATA NOT READY", "NA:CONT NOT READY-1"
NO_PROGRAM = "NA:CONT NOT READY-2"
NUMBER = r"-?\d+(?:\.\d+)?"
SETTING = re.compile(rf"TEMP,((?:[SHL]{NUMBER})+)")


class Espec(TextChamber):
    """A chamber, with or without humidity. A set point outside the alarm limits is refused."""
    name = "espec"
    other_question = "TEMP?"
    identity_questions = ("TYPE?", "ROM?")
    other_family = {"TYPE?": "T,GLC,190.0", "ROM?": "GLC 2.1"}
    pause_after_answer, pause_after_write = 0.3, 0.5

    def __init__(self, *, humidity: bool = False, empty_humidity: bool = True, protected: bool = False,
                 alarms: tuple[int, ...] = (), sensor: str = "T", mode: str = "STANDBY", **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.humidity, self.empty_humidity, self.protected = humidity, empty_humidity, protected
        self.alarms, self.sensor, self.mode = alarms, sensor, mode
        self.alarm_low, self.alarm_high = self.lowest, self.highest

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
        return asked() if asked else self.command(line)

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
    client.expect("MODE, STANDBY", "OK:MODE,STANDBY")
    client.expect("MODE?", "STANDBY")
    assert client.chamber.is_off()


if __name__ == "__main__":
    main(Espec, test)
