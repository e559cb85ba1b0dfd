#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Huber thermostats by PB commands, as numat/huber uses them. Every answer repeats the address and the value."""
from __future__ import annotations

import re
import time

from text_server import Client, TextChamber, main

ABSENT = 0x7FFF
COMMAND = re.compile(r"\{M([0-9A-F]{2})([0-9A-F]{4}|\*{4})")
SET_POINT, BATH, ERROR, WARNING, PROCESS, STATUS, POWER = 0x00, 0x01, 0x05, 0x06, 0x07, 0x0A, 0x14


class Huber(TextChamber):
    """A value that the unit does not take is answered by the present one. There is no refusal."""
    name = "huber"
    other_question = "{M01****"

    def __init__(self, *, process: bool = False, error: int = 0, warning: int = 0, **more: object) -> None:
        super().__init__(**{"lag": 0.0, **more})  # type: ignore[arg-type]
        self.process, self.error, self.warning = process, error, warning

    def busy(self) -> str:
        return ""

    def reply(self, line: str) -> str | None:
        found = COMMAND.fullmatch(line.strip())
        if not found:
            self.unknown.append(line)
            return None
        address, value = int(found[1], 16), found[2]
        if value != "****":
            self.write(line, address, int(value, 16))
        return f"{{S{address:02X}{self.value(address) & 0xFFFF:04X}"

    def noted(self, celsius: float, times: list[tuple[float, float]]) -> int:
        """Returns a temperature in 0.01 K, and notes it."""
        hundredths = round(celsius * 100)
        times.append((time.time(), hundredths / 100))
        return hundredths

    def value(self, address: int) -> int:
        if address == SET_POINT:
            return self.noted(self.set_point, self.set_points)
        if address == BATH or (address == PROCESS and self.process):
            return self.noted(self.air, self.airs)
        status = 0x3 * self.on | 0x10 * self.on | 0x100 * bool(self.error) | 0x200 * bool(self.warning)
        return {ERROR: self.error, WARNING: self.warning, STATUS: status, POWER: int(self.on), 0x03: 350 * self.on,
                0x26: 2800 * self.on, 0x48: 2800, 0x0F: 620, 0x5C: 180,
                0x30: round(self.lowest * 100), 0x31: round(self.highest * 100)}.get(address, ABSENT)

    def write(self, line: str, address: int, word: int) -> None:
        value = word - 0x10000 if word & 0x8000 else word
        if address == SET_POINT:
            if not self.lowest <= value / 100 <= self.highest:
                return
            self.take_set_point(line, value / 100, "")
        elif address == POWER and value in (0, 1):
            self.take_power(line, bool(value))
        elif address in (ERROR, WARNING) and value == 1:
            self.take(line, lambda: setattr(self, "error" if address == ERROR else "warning", 0))


def test(client: Client) -> None:
    client.expect("{M01****", "{S0109C4")
    client.expect("{M00F060", "{S00F060")
    client.expect("{M00****", "{S00F060")
    client.expect("{M007000", "{S00F060")
    client.expect("{M140001", "{S140001")
    client.expect("{M0A****", "{S0A0013")
    client.expect("{M07****", "{S077FFF")
    client.expect("{M140000", "{S140000")
    client.expect("{X", "")


if __name__ == "__main__":
    main(Huber, test)
