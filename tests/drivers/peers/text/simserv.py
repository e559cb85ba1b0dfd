#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""SimServ of Weiss Technik and Vötsch chambers, as IzaakWN/ClimateChamberMonitor, SengerM's package and VotschVc3.Core
use it."""
from __future__ import annotations

import time

from text_server import Client, TextChamber, main

DONE, UNKNOWN, ARGUMENTS, NOT_READ = "1", "-5", "-6", "-8"
OUTPUTS = ("START", "COND. PROT.", "OUTPUT 2", "OUTPUT 3", "OUTPUT 4", "COMPRESSED AIR")  # number 1 on
MESSAGES = ("Temperature limiter", "Fan", "Water")
IDENTITY = {1: "LabEvent T/210/70/5", 2: "19", 3: "58226153390010"}


class SimServ(TextChamber):
    """A temperature chamber without humidity. `11001` is acknowledged before its value is read back by `11002`."""
    name = "simserv"
    other_question = "11004¶1¶1"
    encoding = "latin-1"
    question_ends = b"\r"
    identity_questions = ("99997¶1¶1", "99997¶1¶2", "99997¶1¶3")
    exchanged = {"99997¶1¶1": "1¶LabEvent T/210/70/5", "99997¶1¶2": "1¶19", "99997¶1¶3": "1¶58226153390011"}

    def __init__(self, *, program: bool = False, has_programs: bool = True, gradient: float = 0.0, alarm: bool = False,
                 **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.has_programs, self.running_program, self.alarm = has_programs, program, alarm
        self.outputs = {number: 0 for number in range(2, len(OUTPUTS) + 1)}
        self.gradients = {"up": gradient, "down": gradient}
        self.ramped, self.ramped_at = self.air, time.monotonic()

    def target(self) -> float:
        """Returns the nominal value, which a gradient approaches slowly."""
        now = time.monotonic()
        gradient = self.gradients["up" if self.set_point > self.ramped else "down"]
        step = gradient / 60 * (now - self.ramped_at)
        sought = self.set_point - self.ramped
        self.ramped = self.set_point if not gradient else self.ramped + max(-step, min(step, sought))
        self.ramped_at = now
        return self.ramped

    def in_program(self) -> bool:
        return self.running_program

    def to_program(self) -> bool:
        with self.lock:
            self.running_program = self.on = True
        return True

    def busy(self) -> str:
        return NOT_READ

    def next_line(self, received: bytes) -> tuple[str | None, bytes]:
        line, rest = super().next_line(received.lstrip(b"\n"))
        return line, rest

    def reply(self, line: str) -> str:
        words = line.split("¶")
        number, chamber, given = words[0], words[1:2], words[2:]
        if len(number) != 5 or not number.isdigit():
            return self.not_known(line, UNKNOWN)
        if chamber != ["1"] or len(given) > 4:
            return ARGUMENTS
        handler = getattr(self, f"do_{number}", None)
        if handler is None:
            return self.not_known(line, UNKNOWN)
        try:
            value = handler(line, *given)
        except (TypeError, ValueError, KeyError, IndexError):
            return ARGUMENTS
        return DONE if value is None else f"{DONE}¶{value}"

    # Reads.

    def do_99997(self, _: str, which: str) -> str:
        return IDENTITY[int(which)]

    def do_10012(self, _: str, __: str = "1") -> str:
        return str(1 + 2 * self.on + 8 * self.alarm)

    def do_11018(self, _: str) -> str:
        return "1"

    def variable(self, which: str) -> None:
        if which != "1":
            raise ValueError(which)

    def do_11026(self, _: str, which: str) -> str:
        self.variable(which)
        return "Temperature"

    def do_11023(self, _: str, which: str) -> str:
        self.variable(which)
        return "°C"

    def do_11002(self, _: str, which: str) -> str:
        self.variable(which)
        return self.set_point_text()

    def do_11004(self, _: str, which: str) -> str:
        self.variable(which)
        return self.air_text("{:.4f}")

    def do_11007(self, _: str, which: str) -> str:
        self.variable(which)
        return f"{self.lowest:.1f}"

    def do_11009(self, _: str, which: str) -> str:
        self.variable(which)
        return f"{self.highest:.1f}"

    do_11014 = do_11016 = do_11007
    do_11015 = do_11017 = do_11009

    def do_11066(self, _: str, which: str) -> str:
        self.variable(which)
        return f"{self.gradients['up']:.1f}"

    def do_11070(self, _: str, which: str) -> str:
        self.variable(which)
        return f"{self.gradients['down']:.1f}"

    def do_14007(self, _: str) -> str:
        return str(len(OUTPUTS))

    def do_14010(self, _: str, which: str) -> str:
        return OUTPUTS[int(which) - 1]

    def do_14003(self, _: str, which: str) -> str:
        return str(int(self.on)) if which == "1" else str(self.outputs[int(which)])

    def do_17002(self, _: str) -> str:
        return str(len(MESSAGES))

    def do_17009(self, _: str, which: str) -> str:
        return str(int(self.alarm and int(which) == 1 and MESSAGES[0] != ""))

    def do_17005(self, _: str, which: str) -> str:
        return {1: "1", 2: "2", 3: "4"}[int(which)]

    def do_17007(self, _: str, which: str) -> str:
        return MESSAGES[int(which) - 1]

    def do_19204(self, _: str) -> str:
        return str(3 * self.running_program)

    def do_19210(self, _: str) -> str:
        return str(int(self.running_program))

    # Writes.

    def do_11001(self, line: str, which: str, value: str) -> None:
        self.variable(which)
        self.take_set_point(line, float(value), ARGUMENTS)

    def set_gradient(self, line: str, which: str, value: str, name: str) -> None:
        self.variable(which)
        self.take(line, lambda: self.gradients.update({name: float(value)}))

    def do_11068(self, line: str, which: str, value: str) -> None:
        self.set_gradient(line, which, value, "up")

    def do_11072(self, line: str, which: str, value: str) -> None:
        self.set_gradient(line, which, value, "down")

    def do_14001(self, line: str, which: str, value: str) -> None:
        if value not in ("0", "1"):
            raise ValueError(value)
        if which == "1":
            if self.running_program:
                self.refuse(line, NOT_READ)
            self.take_power(line, value == "1")
        else:
            if int(which) not in self.outputs:
                self.refuse(line, ARGUMENTS)
            self.take(line, lambda: self.outputs.update({int(which): int(value)}))

    def do_17012(self, line: str) -> None:
        self.take(line, lambda: setattr(self, "alarm", False))

    def do_19015(self, line: str) -> None:
        if not self.has_programs:
            self.refuse(line, UNKNOWN)
        if self.running_program:
            self.running_program = self.on = False
        self.take(line, lambda: None)


def test(client: Client) -> None:
    client.expect("99997¶1¶1", "1¶LabEvent T/210/70/5")
    client.expect("11001¶1¶1¶-40.0", "1")
    client.expect("11002¶1¶1", "1¶-40.0")
    client.expect("11004¶1¶2", ARGUMENTS)
    client.expect("11001¶1¶1¶500", ARGUMENTS)
    client.expect("14001¶1¶1¶1", "1")
    client.expect("14003¶1¶1", "1¶1")
    client.expect("10012¶1", "1¶3")
    client.expect("14001¶1¶8¶1", ARGUMENTS)
    client.expect("12345¶1", UNKNOWN)
    assert float(client.ask("11004¶1¶1").split("¶")[1]) <= 25.0
    client.expect("19015¶1", "1")
    client.expect("14001¶1¶1¶0", "1")
    client.expect("10012¶1¶1", "1¶1")


if __name__ == "__main__":
    main(SimServ, test, "\r")
