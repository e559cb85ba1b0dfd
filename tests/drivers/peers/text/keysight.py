#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A Keysight 34970A with eight Pt100 in four wires, as the user's guide, a public set-up script and dvg_devices use
it."""
from __future__ import annotations

import time

from text_server import Client, TextChamber, main

INPUTS = 8
SETTINGS = ("ABOR", "UNIT:TEMP C,(@101:108)", "SENS:TEMP:NPLC 1,(@101:108)", "FORM:READ:UNIT OFF", "FORM:READ:TIME OFF",
            "FORM:READ:CHAN OFF", "FORM:READ:ALAR OFF", "TRIG:SOUR IMM", "TRIG:COUN 1")
OVERLOAD = "+9.90000000E+37"
READINGS = "*OPC?;FETC?"
SCAN = f"INIT;{READINGS}"


class Keysight34970A(TextChamber):
    """`INIT` begins a scan and `*OPC?` answers after its last channel. `FETC?` answers the readings of the latest scan."""
    name = "34970a"
    question_ends = b"\n"
    answer_end = "\n"
    identity_questions = ("*IDN?",)
    other_family = {"*IDN?": "HEWLETT-PACKARD,34401A,0,11-5-2"}
    other_question = SCAN

    def __init__(self, *, scan_time: float = 0.1, source: TextChamber | None = None, **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.scan_time, self.source = scan_time, source or self
        self.errors, self.configured, self.listed = 0, False, False
        self.scan: list[float] = []
        self.scan_began = 0.0
        self.scans: list[tuple[float, list[float]]] = []  # UTC s and °C, each scan that was made

    def busy(self) -> str:
        return ""

    def time_of(self, line: str) -> float:
        left = self.scan_began + self.scan_time - time.monotonic() if line.endswith(READINGS) else 0.0
        return max(self.answer_time, left)

    def reply(self, line: str) -> str | None:
        if line == "*IDN?":
            return "HEWLETT-PACKARD,34970A,0,13-2-2"
        if line == "SYST:ERR?":
            errors, self.errors = self.errors, 0
            return '-113,"Undefined header"' if errors else '+0,"No error"'
        if line == SCAN:
            self.begin_scan()
        if line.endswith(READINGS):
            return "1;" + ",".join(f"{value:+.8E}" for value in self.scan) if self.scan else None
        if line == "*CLS":
            self.errors = 0
        elif line == "CONF:TEMP FRTD,85,(@101:108)":
            self.configured = True
        elif line == "ROUT:SCAN (@101:108)":
            self.listed = True
        elif line == "INIT":
            self.begin_scan()
        elif line not in SETTINGS:
            self.errors += 1
            self.unknown.append(line)
        return None

    def begin_scan(self) -> None:
        if not (self.configured and self.listed):
            return
        air = self.air if self.source is self else self.source.air_now()
        self.scan = [round(air + 0.01 * i + 0.001 * (len(self.scans) % 7), 6) for i in range(INPUTS)]
        self.scan_began = time.monotonic()
        self.scans.append((time.time(), self.scan))


def test(client: Client) -> None:
    client.expect("*IDN?", "HEWLETT-PACKARD,34970A,0,13-2-2")
    client.expect(READINGS, "")
    client.expect("CONF:TEMP FRTD,85,(@101:108)", "")
    client.expect("ROUT:SCAN (@101:108)", "")
    client.expect("SYST:ERR?", '+0,"No error"')
    client.expect("INIT", "")
    begin, _, readings = client.ask(READINGS).partition(";")
    assert client.ask(SCAN).startswith("1;")
    assert begin == "1" and len(readings.split(",")) == INPUTS and abs(float(readings.split(",")[0]) - 25.0) < 0.5
    client.expect("NONSENSE", "")
    client.expect("SYST:ERR?", '-113,"Undefined header"')


if __name__ == "__main__":
    main(Keysight34970A, test, "\n")
