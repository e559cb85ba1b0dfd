#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""ASCII-2 of Weiss and Vötsch chambers (SIMPAC, SIMCON/32), as basil, rf_votsch_climate_chamber and a public Vötsch
simulator use it."""
from __future__ import annotations

import re
from dataclasses import dataclass

from text_server import Client, TextChamber, main

DONE = "0"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Layout:
    """How many numbers and digits the strings of a unit have."""
    pairs: tuple[str, ...] = ("Temperature", "Humidity", "Fan", "", "", "", "")  # nominal and actual each
    digits_written: int = 32
    digits_read: int = 32
    names: tuple[str, ...] = ("", "Start", "Humidity", "", "", "", "", "Cond. prot.", "", "", "Compr. air", "Dryer")


VC3_7060 = Layout()
TEMPERATURE_ONLY = Layout(("Temperature", "Fan", ""))
WT120 = Layout(("Temperature",), 6, 6)


class Ascii2(TextChamber):
    """The second digit is the start. A write sets every nominal value and every digit."""
    name = "ascii2"
    question_ends = b"\r\n"
    answer_end = "\r"

    def __init__(self, *, layout: Layout = VC3_7060, address: int = 1, acknowledges: bool = True, panel: bool = False,
                 humidity: float = 45.0, fan: float = 80.0, others: frozenset[int] = frozenset({10}),
                 gradient: float = 0.0, **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.layout, self.address, self.acknowledges, self.panel = layout, f"${address:02d}", acknowledges, panel
        self.nominal = {name: value for name, value in (("Humidity", humidity), ("Fan", fan)) if name in layout.pairs}
        self.others = set(others)  # digits that are on beside the start
        self.gradient = gradient

    def kept(self) -> object:
        """Returns what a run must not change: the other nominal values and digits."""
        return dict(self.nominal), frozenset(self.others)

    def busy(self) -> str:
        return ""

    def digits(self, count: int) -> str:
        on = self.others | ({1} if self.on else set())
        return "".join("1" if n in on else "0" for n in range(count))

    def reply(self, line: str) -> str | None:
        if not line.startswith(self.address):
            return None  # another unit is asked
        command, rest = line[3:4], line[4:]
        if command == "I" and not rest.strip():
            return self.values()
        if command == "?":
            return self.configuration()
        if command == "E":
            return self.write(line, rest.split())
        if command == "U" and len(rest.split()) in (2, 4):
            self.take(line, lambda: None)
            return DONE if self.acknowledges else None
        if command == "P" and re.fullmatch(r"\d{4}", rest):
            self.take(line, lambda: None)
            return DONE if self.acknowledges else None
        self.unknown.append(line)
        return None

    def values(self) -> str:
        numbers = []
        for name in self.layout.pairs:
            if name == "Temperature":
                numbers += [self.set_point_text("{:06.1f}"), self.air_text("{:06.1f}")]
            else:
                nominal = self.nominal.get(name, 0.0)
                numbers += [f"{nominal:06.1f}", f"{nominal + 0.4 * (name == 'Humidity'):06.1f}"]
        return " ".join([*numbers, self.digits(self.layout.digits_read)])

    def write(self, line: str, words: list[str]) -> str | None:
        numbers, bits = words[:-1], words[-1] if words else ""
        fits = len(numbers) == len(self.layout.pairs) and all(NUMBER.fullmatch(word) for word in numbers) and \
            len(bits) == self.layout.digits_written and not set(bits) - {"0", "1"}
        if not fits:
            self.refuse(line, "")
        if self.panel:
            self.refuse(line, "")  # EXTERN is not selected at the panel
        given = dict(zip(self.layout.pairs, map(float, numbers)))
        if not self.lowest <= given["Temperature"] <= self.highest:
            self.refuse(line, "")

        def act() -> None:
            self.set_point = given["Temperature"]
            self.nominal = {name: given[name] for name in self.nominal}
            self.others = {n for n, bit in enumerate(bits) if bit == "1" and n != 1}
            self.on = bits[1] == "1"
        self.take(line, act)
        return DONE if self.acknowledges else None

    def configuration(self) -> str:
        """Returns the listing, whose lines end as an answer does."""
        e_string = " ".join(["CV" if name else "xx" for name in self.layout.pairs])
        lines = ["ASCII-2 PROTOCOL CONFIGURATION", "",
                 f"E-string: {self.address}E {e_string} {self.layout.digits_written} digits",
                 *[f"{name}: {self.lowest:06.1f} {self.highest:06.1f}" for name in self.layout.pairs if name],
                 *[f"DO{n:02d} {name}" for n, name in enumerate(self.layout.names) if name],
                 f"I-string: {2 * len(self.layout.pairs)} numbers {self.layout.digits_read} digits"]
        return "\r\n".join(lines)


def test(client: Client) -> None:
    unit = client.chamber
    assert isinstance(unit, Ascii2)
    digits = "00000000001" + 21 * "0"
    values = "0023.0 0025.0 0045.0 0045.4 0080.0 0080.0" + 8 * " 0000.0"
    client.expect("$01I", f"{values} {digits}")
    started = digits[:1] + "1" + digits[2:]
    client.expect(f"$01E -040.0 0045.0 0080.0 0000.0 0000.0 0000.0 0000.0 {started}", DONE)
    assert client.ask("$01I").startswith("-040.0 0025.0 0045.0")
    assert unit.on and unit.kept() == ({"Humidity": 45.0, "Fan": 80.0}, frozenset({10}))
    assert client.ask("$01?").startswith("ASCII-2 PROTOCOL CONFIGURATION")
    client.expect("$02I", "")
    client.expect(f"$01E 0023.0 {started}", "")
    client.expect(f"$01E 0023.0 0045.0 0080.0 0000.0 0000.0 0000.0 0000.0 {digits}", DONE)
    assert not unit.on


if __name__ == "__main__":
    main(Ascii2, test, "\r")
