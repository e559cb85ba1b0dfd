#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Julabo circulators through a serial server, as their manuals and public drivers describe them."""
from __future__ import annotations

import re

from text_server import Client, TextChamber, main

NUMBER = r"-?\d{1,3}(?:\.\d+)?"
REMOTE_STOP, REMOTE_START, MANUAL_STOP = "02 REMOTE STOP", "03 REMOTE START", "00 MANUAL STOP"
INVALID, NOT_ALLOWED, OUTSIDE = "-08 INVALID COMMAND", "-09 COMMAND NOT ALLOWED IN CURRENT OPERATING MODE", \
    "-11 VALUE EXCEEDS PERMITTED LIMITS"


class Julabo(TextChamber):
    """No command is acknowledged; an error appears in the status. Only a unit in remote mode obeys."""
    name = "julabo"
    other_question = "in_pv_00"
    question_ends = b"\r\n"
    identity_questions = ("version",)
    other_family = {"version": "F25-ME V3.4"}
    pause_after_answer, pause_after_write = 0.01, 0.25

    def __init__(self, *, remote: bool = True, external: bool = False, version: str = "JULABO FL300 VERSION 1.2",
                 **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.remote, self.external, self.version = remote, external, version
        self.error = ""

    def busy(self) -> str:
        return ""

    def reply(self, line: str) -> str | None:
        words = line.strip().lower().split()
        if words and words[0].startswith("out_"):
            self.write(line, *words)
            return None
        asked = {"in_pv_00": lambda: self.air_text("{:.2f}"),
                 "in_pv_01": lambda: f"{40.0 * self.on:.1f}",
                 "in_pv_02": lambda: self.air_text("{:.2f}") if self.external else "---.--",
                 "in_pv_03": lambda: f"{self.air:.2f}", "in_pv_04": lambda: "120.00",
                 "in_sp_00": lambda: self.set_point_text("{:.2f}"), "in_sp_01": lambda: "20.00",
                 "in_sp_02": lambda: "30.00", "in_sp_03": lambda: f"{self.highest:.2f}",
                 "in_sp_04": lambda: f"{self.lowest:.2f}", "in_sp_06": lambda: "0",
                 "in_mode_01": lambda: "0", "in_mode_02": lambda: "0", "in_mode_04": lambda: "0",
                 "in_mode_05": lambda: str(int(self.on)),
                 "version": lambda: self.version, "status": self.status}.get(line.strip().lower())
        if asked:
            return asked()
        self.error = INVALID
        self.unknown.append(line)
        return None

    def status(self) -> str:
        """Returns an error once, else the state."""
        error, self.error = self.error, ""
        return error or (REMOTE_START if self.on else REMOTE_STOP if self.remote else MANUAL_STOP)

    def write(self, line: str, command: str, value: str = "", *_: str) -> None:
        if not self.remote:
            self.fail(line, NOT_ALLOWED)
        if not re.fullmatch(NUMBER, value):
            self.fail(line, INVALID)
        if command == "out_sp_00":
            if not self.lowest <= float(value) <= self.highest:
                self.fail(line, OUTSIDE)
            self.take_set_point(line, float(value), "")
        elif command == "out_mode_05" and value in ("0", "1"):
            self.take_power(line, value == "1")
        else:
            self.fail(line, INVALID)

    def fail(self, line: str, error: str) -> None:
        self.error = error
        self.refuse(line, "")


def test(client: Client) -> None:
    client.expect("version", "JULABO FL300 VERSION 1.2")
    client.expect("IN_PV_00", "25.00")
    client.expect("out_sp_00 -40.00", "")
    client.expect("in_sp_00", "-40.00")
    client.expect("status", REMOTE_STOP)
    client.expect("out_mode_05 1", "")
    client.expect("in_mode_05", "1")
    client.expect("status", REMOTE_START)
    client.expect("out_sp_00 900", "")
    assert client.ask("status").startswith("-11")
    client.expect("in_pv_02", "---.--")
    client.expect("out_mode_05 0", "")
    client.expect("in_mode_05", "0")


if __name__ == "__main__":
    main(Julabo, test, "\r")
