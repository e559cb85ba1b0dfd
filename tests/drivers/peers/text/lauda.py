#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lauda thermostats (PRO, ECO, Variocool, Integral), as hvl_ccb, two public drivers and the manuals describe them."""
from __future__ import annotations

import re
import time

from text_server import Client, TextChamber, main

DONE, BAD_COMMAND, BAD_FORM, BAD_VALUE, NO_MODULE = "OK", "ERR_3", "ERR_5", "ERR_6", "ERR_8"
NUMBER = re.compile(r"-?\d{1,3}(?:\.\d{1,2})?")


class Lauda(TextChamber):
    """A blank may be in the place of `_`. With a communication time-out the unit stops if it hears nothing."""
    name = "lauda"
    other_question = "IN_PV_00"
    identity_questions = ("TYPE",)

    def __init__(self, *, type_text: str = "RP245E", fault: bool = False, blank_padded: bool = False,
                 has_programmer: bool = True, program: int = 0, **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.has_programmer, self.program = has_programmer, program
        self.on = bool(program)
        self.type_text, self.fault, self.blank_padded = type_text, fault, blank_padded
        self.time_out = 0.0  # s
        self.heard_at = time.monotonic()

    def drive(self) -> tuple[float, float]:
        if self.time_out and time.monotonic() > self.heard_at + self.time_out:
            self.on = False
        return super().drive()

    def busy(self) -> str:
        return "ERR_2"

    def in_program(self) -> bool:
        return bool(self.program)

    def to_program(self) -> bool:
        with self.lock:
            self.program, self.on = 1, True
        return True

    def padded(self, text: str) -> str:
        return text.rjust(7) if self.blank_padded else text

    def reply(self, line: str) -> str:
        self.heard_at = time.monotonic()
        command = "_".join(line.strip().upper().split())
        asked = {"TYPE": lambda: self.type_text, "IN_PV_00": lambda: self.padded(self.air_text("{:.2f}")),
                 "IN_PV_01": lambda: self.padded(self.air_text("{:.2f}")), "IN_PV_02": lambda: "0.45",
                 "IN_PV_03": lambda: NO_MODULE,
                 "IN_SP_00": lambda: self.padded(self.set_point_text("{:.2f}")), "IN_SP_01": lambda: "4",
                 "IN_SP_04": lambda: f"{self.highest:.2f}", "IN_SP_05": lambda: f"{self.lowest:.2f}",
                 "IN_SP_08": lambda: f"{self.time_out:.0f}", "IN_MODE_00": lambda: "0", "IN_MODE_01": lambda: "0",
                 "IN_MODE_02": lambda: str(int(not self.on)), "IN_MODE_03": lambda: "0",
                 "IN_MODE_04": lambda: "0",
                 "STATUS": lambda: "-1" if self.fault else "0",
                 "STAT": lambda: "1000000" if self.fault else "0000000",
                 "VERSION_R": lambda: "1.34", "RMP_IN_04": lambda: "1",
                 "RMP_IN_05": lambda: str(self.program)}.get(command)
        if command.startswith(("RMP_", "IN_MODE_04")) and not self.has_programmer:
            return BAD_COMMAND  # a simple unit
        return asked() if asked else self.written(line, command)

    def written(self, line: str, command: str) -> str:
        name, _, value = command.rpartition("_")
        if command in ("START", "STOP"):
            self.take_power(line, command == "START")
        elif name in ("OUT_SP_00", "OUT_SP_01", "OUT_SP_04", "OUT_SP_05", "OUT_SP_08", "OUT_MODE_01"):
            if not NUMBER.fullmatch(value):
                self.refuse(line, BAD_FORM)
            if name == "OUT_SP_00":
                self.take_set_point(line, float(value), BAD_VALUE)
            elif name == "OUT_SP_08":
                self.take(line, lambda: setattr(self, "time_out", float(value)))
            else:
                self.take(line, lambda: None)
        elif command == "RMP_STOP":
            self.take(line, lambda: setattr(self, "program", 0))
        elif command in ("RMP_PAUSE", "RMP_CONT"):
            self.take(line, lambda: None)
        else:
            return self.not_known(line, BAD_COMMAND)
        return DONE


def test(client: Client) -> None:
    client.expect("TYPE", "RP245E")
    client.expect("IN_PV_00", "25.00")
    client.expect("OUT_SP_00_-40.00", DONE)
    client.expect("IN SP 00", "-40.00")
    client.expect("OUT_SP_00_400.00", BAD_VALUE)
    client.expect("OUT_SP_00_X", BAD_FORM)
    client.expect("IN_MODE_02", "1")
    client.expect("START", DONE)
    client.expect("IN_MODE_02", "0")
    client.expect("IN_PV_03", NO_MODULE)
    client.expect("STATUS", "0")
    client.expect("JUMP", BAD_COMMAND)
    client.expect("STOP", DONE)
    client.expect("IN_MODE_02", "1")


if __name__ == "__main__":
    main(Lauda, test)
