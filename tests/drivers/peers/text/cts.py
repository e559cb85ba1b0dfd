#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""CTS chambers by TCP, as labtoys, SweepMe and the DESY driver use them. No byte ends a question or an answer."""
from __future__ import annotations

import re

from text_server import Client, TextChamber, main

NUMBER = r"[-\d]\d{2}\.\d"  # five characters
COMMANDS = re.compile(rf"[AaUudR]\d(?: {NUMBER})?|s[123] [01]|p\d{{3}}|[SPOTC]")
NO_ERROR = "\0"


class Cts(TextChamber):
    """Channel 0 is the temperature. There is no refusal: a command that is not obeyed is not answered."""
    name = "cts"
    encoding = "latin-1"
    answer_end = ""

    def __init__(self, *, error: str = NO_ERROR, program: bool = False, capital: bool = False,
                 **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.error, self.capital = error, capital
        self.paused = False
        self.running_program = self.on = program

    def in_program(self) -> bool:
        return self.running_program

    def drive(self) -> tuple[float, float]:
        return super().drive() if not self.paused else (self.air, 0.0)

    def busy(self) -> str:
        return ""

    def next_line(self, received: bytes) -> tuple[str | None, bytes]:
        """Returns the command that begins the bytes. Bytes that begin none are dropped."""
        text = received.decode(self.encoding)
        if not text:
            return None, b""
        found = COMMANDS.match(text)
        if not found:
            self.unknown.append(text)
            return None, b""
        return found[0], received[found.end():]

    def shown(self, value: str) -> str:
        """Returns a number as five characters."""
        return value if value.startswith("-") else value.zfill(5)

    def reply(self, line: str) -> str | None:
        kind, channel = line[0], line[1:2]
        if line == "A0":
            return f"A0 {self.shown(self.air_text())} {self.shown(self.set_point_text())}"
        if kind == "A":
            return f"{line} 000.0 000.0"
        if kind == "a" and channel == "0" and len(line) == 8:
            self.take_set_point(line, float(line[3:]), "")
            return "A" if self.capital else "a"
        if line[:3] == "s1 ":
            self.take(line, lambda: self.set_running(line[3] == "1"))
        elif line[:3] == "s2 ":
            self.take(line, lambda: setattr(self, "error", NO_ERROR))
        elif line[:3] == "s3 ":
            self.take(line, lambda: setattr(self, "paused", line[3] == "0"))
        if kind == "s":
            return line[:2]
        if kind == "p":
            self.take(line, lambda: self.set_program(line != "p000"))
            return line
        if kind in "ud" and len(line) == 8:
            self.take(line, lambda: None)
            return kind
        flags = (self.on, self.error != NO_ERROR, not self.paused, False, False, False, False, False)
        answers = {"S": "S" + "".join(str(int(flag)) for flag in flags) + self.error,
                   "U1": "U1 999.9 999.9", "R1": f"R1 00{int(self.on)}0 {self.set_point:06.2f}",
                   "P": f"P{3 * self.running_program:03d}", "T": "T291126093000", "C": "C 2.14",
                   "O": f"O{int(self.on)}{int(self.error != NO_ERROR)}0000000000000"}
        return answers.get(line) or self.no_answer(line)

    def no_answer(self, line: str) -> None:
        self.unknown.append(line)

    def set_running(self, on: bool) -> None:
        self.on = on
        if not on:
            self.running_program = False

    def set_program(self, runs: bool) -> None:
        self.running_program = self.on = runs


class CtsOnSerialLine(Cts):
    """The same with frames: STX, address and data with bit 7, their XOR, ETX."""

    STX, ETX, ADDRESS, HIGH = 0x02, 0x03, 0x81, 0x80

    def checksum(self, data: bytes) -> int:
        result = 0
        for byte in data:
            result ^= byte
        return result | self.HIGH

    def encoded(self, answer: str) -> bytes:
        data = bytes([self.ADDRESS, *(byte | self.HIGH for byte in answer.encode(self.encoding))])
        return bytes([self.STX, *data, self.checksum(data), self.ETX])

    def next_line(self, received: bytes) -> tuple[str | None, bytes]:
        begin, end = received.find(self.STX), received.find(self.ETX)
        if begin < 0 or end < begin:
            return None, received[max(begin, 0):] if begin >= 0 else b""
        frame, rest = received[begin + 1:end], received[end + 1:]
        if len(frame) < 3 or frame[0] != self.ADDRESS or frame[-1] != self.checksum(frame[:-1]) or \
                any(not byte & self.HIGH for byte in frame):
            self.unknown.append(repr(frame))
            return "", rest
        return bytes(byte & 0x7F for byte in frame[1:-1]).decode(), rest


def test(client: Client) -> None:
    client.expect("A0", "A0 025.0 023.0")
    client.expect("a0 -40.0", "a")
    client.expect("A0", "A0 025.0 -40.0")
    client.expect("a0 500.0", "")
    client.expect("s1 1", "s1")
    client.expect("S", "S10100000\0")
    client.expect("U1", "U1 999.9 999.9")
    client.expect("s1 0", "s1")
    client.expect("S", "S00100000\0")
    client.expect("O", "O00" + 13 * "0")
    client.expect("xyz", "")
    framed = CtsOnSerialLine()
    assert framed.encoded("O") == bytes.fromhex("0281CFCE03")
    assert framed.next_line(bytes.fromhex("0281C1B0F003")) == ("A0", b"")
    assert framed.next_line(bytes.fromhex("0281F3B1A0B1D203")) == ("s1 1", b"")


if __name__ == "__main__":
    main(Cts, test, "")
