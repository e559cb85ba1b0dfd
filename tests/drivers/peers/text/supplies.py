# SPDX-License-Identifier: Apache-2.0
"""Laboratory power supplies with a resistor as their load, and a TCP server for them.

They are written from public drivers and manual pages. They use no code and no description file of gyrotherm.
"""
from __future__ import annotations

import re
import socket
import threading
from dataclasses import dataclass, field

LOAD = 48.0  # Ω


@dataclass
class Output:
    volts: float = 0.0
    amperes: float = 0.1  # limit
    over_volts: float = 40.0
    over_amperes: float = 20.0
    over_amperes_on: bool = False
    over_volts_on: bool = True
    on: bool = False
    tripped: str = ""  # "V" or "A"

    def current(self) -> float:
        return min(self.volts / LOAD, self.amperes) if self.on else 0.0

    def voltage(self) -> float:
        return self.current() * LOAD

    def limited(self) -> bool:
        return self.on and self.volts / LOAD > self.amperes


@dataclass
class Supply:
    """A supply. A model overrides `reply`, which returns an answer without its end, or None."""
    outputs: list[Output] = field(default_factory=lambda: [Output() for _ in range(3)])
    commands: list[str] = field(default_factory=list)  # lines that change something
    unknown: list[str] = field(default_factory=list)
    another: bool = False  # another instrument answers
    comma: bool = False  # the decimal mark of another locale
    locked: bool = False  # the panel ignores commands
    lock: threading.RLock = field(default_factory=threading.RLock)

    identity = ""
    question_end = answer_end = "\n"
    trips_at_limit = False  # the level of the over-current protection is the current limit

    def reply(self, line: str) -> str | None:
        raise NotImplementedError

    def answer(self, line: str) -> str | None:
        with self.lock:
            if line == "*IDN?":
                return "ACME,PS-1,0,1.0" if self.another else self.identity
            answer = self.reply(line)
            self.protect()
            return answer.replace(".", ",") if answer and self.comma else answer

    def protect(self) -> None:
        for output in self.outputs:
            if not output.on:
                continue
            if output.over_volts_on and output.voltage() > output.over_volts:
                output.on, output.tripped = False, "V"
            elif output.over_amperes_on and (output.limited() if self.trips_at_limit
                                             else output.current() > output.over_amperes):
                output.on, output.tripped = False, "A"

    def take(self, line: str, output: Output, **values: float | bool) -> None:
        """Carries out a command, unless the panel is locked."""
        self.commands.append(line)
        if self.locked:
            return
        for name, value in values.items():
            setattr(output, name, value)
        if output.on and output.tripped:
            output.on = False

    def lost(self, line: str) -> None:
        self.unknown.append(line)

    def trip(self, index: int = 0) -> None:
        """Makes the output trip by itself, as after a fault of the load."""
        with self.lock:
            self.outputs[index].on, self.outputs[index].tripped = False, "A"


NUMBER = r"(\d+(?:\.\d*)?)"


def exponent(value: float) -> str:
    return f"{value:+.8E}"


class E36312A(Supply):
    """Keysight E36312A: a channel list selects the output."""
    identity = "Keysight Technologies,E36312A,MY59001234,2.1.0-1.0.4-1.12"
    trips_at_limit = True

    def reply(self, line: str) -> str | None:
        found = re.fullmatch(r"([A-Z:]+)(\?)? ?([^(]*?),?\(@([123])\)", line)
        if not found:
            return self.lost(line)
        word, asks, value, output = found[1], found[2], found[3], self.outputs[int(found[4]) - 1]
        if asks:
            answers = {"VOLT": exponent(output.volts), "CURR": exponent(output.amperes),
                       "VOLT:PROT": exponent(output.over_volts), "CURR:PROT:STAT": f"{output.over_amperes_on:d}",
                       "OUTP": f"{output.on:d}", "MEAS:VOLT": exponent(output.voltage()),
                       "MEAS:CURR": exponent(output.current()), "VOLT:PROT:TRIP": f"{output.tripped == 'V':d}",
                       "CURR:PROT:TRIP": f"{output.tripped == 'A':d}"}
            return answers.get(word) or self.lost(line)
        if word == "OUTP:PROT:CLE":
            return self.take(line, output, tripped="")
        if word in ("OUTP", "CURR:PROT:STAT"):
            name = "on" if word == "OUTP" else "over_amperes_on"
            return self.take(line, output, **{name: value in ("1", "ON")})
        names = {"VOLT": "volts", "CURR": "amperes", "VOLT:PROT": "over_volts"}
        return self.take(line, output, **{names[word]: float(value)}) if word in names else self.lost(line)


class Hmp(Supply):
    """R&S HMP4040: a command applies to the selected output, which a person may change."""
    identity = "HAMEG,HMP4040,012345678,HW50020001/SW2.51"
    trips_at_limit = True

    def __init__(self) -> None:
        super().__init__()
        self.outputs = [Output() for _ in range(4)]
        self.selected = 3  # a person has turned the panel to output 4

    def reply(self, line: str) -> str | None:
        answer = None
        for part in line.split(";"):
            answer = self.reply_part(line, part.removeprefix(":"))
        self.selected = 3
        return answer

    def reply_part(self, line: str, part: str) -> str | None:
        if found := re.fullmatch(r"INST:NSEL ([1-4])", part):
            self.selected = int(found[1]) - 1
            return None
        output = self.outputs[self.selected]
        answers = {"VOLT?": f"{output.volts:.3f}", "CURR?": f"{output.amperes:.4f}",
                   "VOLT:PROT?": f"{output.over_volts:.3f}", "FUSE?": f"{output.over_amperes_on:d}",
                   "OUTP?": f"{output.on:d}", "MEAS:VOLT?": f"{output.voltage():.3f}",
                   "MEAS:CURR?": f"{output.current():.4f}", "FUSE:TRIP?": f"{output.tripped == 'A':d}",
                   "VOLT:PROT:TRIP?": f"{output.tripped == 'V':d}"}
        if part in answers:
            return answers[part]
        if part == "VOLT:PROT:CLE":
            return self.take(line, output, tripped="")
        for word, name in (("OUTP", "on"), ("FUSE", "over_amperes_on")):
            if found := re.fullmatch(word + r" (ON|OFF|1|0)", part):
                return self.take(line, output, **{name: found[1] in ("ON", "1")})
        for word, name in (("VOLT:PROT", "over_volts"), ("VOLT", "volts"), ("CURR", "amperes")):
            if found := re.fullmatch(word + " " + NUMBER, part):
                return self.take(line, output, **{name: float(found[1])})
        return self.lost(line)


class Dp832(Supply):
    """Rigol DP832: answers YES or NO about a trip, or 1 or 0 as a newer manual states."""
    identity = "RIGOL TECHNOLOGIES,DP832A,DP8B123456789,00.01.16"

    def __init__(self, in_numbers: bool = False) -> None:
        super().__init__()
        self.in_numbers = in_numbers
        for output in self.outputs:
            output.over_volts_on = False

    def truth(self, value: bool) -> str:
        return ("1" if value else "0") if self.in_numbers else ("YES" if value else "NO")

    def reply(self, line: str) -> str | None:
        if re.fullmatch(r":OUTP:OVP:CLE CH([123]);:OUTP:OCP:CLE CH\1", line):
            return self.take(line, self.outputs[int(line[-1]) - 1], tripped="")
        if found := re.fullmatch(r":SOUR([123]):(VOLT|CURR)(?:\?| " + NUMBER + ")", line):
            output, name = self.outputs[int(found[1]) - 1], {"VOLT": "volts", "CURR": "amperes"}[found[2]]
            if found[3] is None:
                return f"{getattr(output, name):.3f}"
            return self.take(line, output, **{name: float(found[3])})
        found = re.fullmatch(r":([A-Z:]+)(\?)? CH([123])(?:,(.*))?", line)
        if not found:
            return self.lost(line)
        word, asks, output, value = found[1], found[2], self.outputs[int(found[3]) - 1], found[4] or ""
        if asks:
            answers = {"OUTP": "ON" if output.on else "OFF", "OUTP:OVP:VAL": f"{output.over_volts:.3f}",
                       "OUTP:OCP:VAL": f"{output.over_amperes:.3f}", "OUTP:OVP:QUES": self.truth(output.tripped == "V"),
                       "OUTP:OCP:QUES": self.truth(output.tripped == "A"),
                       "MEAS:ALL": f"{output.voltage():.4f},{output.current():.4f},"
                                   f"{output.voltage() * output.current():.3f}"}
            return answers.get(word) or self.lost(line)
        names = {"OUTP": "on", "OUTP:OVP": "over_volts_on", "OUTP:OCP": "over_amperes_on"}
        if word in names:
            return self.take(line, output, **{names[word]: value == "ON"})
        levels = {"OUTP:OVP:VAL": "over_volts", "OUTP:OCP:VAL": "over_amperes"}
        return self.take(line, output, **{levels[word]: float(value)}) if word in levels else self.lost(line)


class Tti(Supply):
    """Aim-TTi CPX400DP: unit letters, echoed names, and a limit register that is one reading late."""
    identity = "THURLBY THANDAR, CPX400DP, 123456, 1.02-1.00"
    question_end = answer_end = "\r\n"

    def __init__(self) -> None:
        super().__init__()
        self.outputs = [Output(over_amperes_on=True) for _ in range(2)]
        self.registers = [0, 0]

    def register(self, index: int) -> int:
        """Returns the register as it was at the last question."""
        output = self.outputs[index]
        bits = {"V": 4, "A": 8}.get(output.tripped, 0) | (2 if output.limited() else 1 if output.on else 0)
        before, self.registers[index] = self.registers[index], bits
        return before

    def reply(self, line: str) -> str | None:
        if line == "TRIPRST;*OPC?":
            for output in self.outputs:
                self.take(line, output, tripped="")
            return "1"
        if found := re.fullmatch(r"LSR([12])\?", line):
            return str(self.register(int(found[1]) - 1))
        if found := re.fullmatch(r"([VI])([12])O\?", line):
            output = self.outputs[int(found[2]) - 1]
            return f"{output.voltage():.3f}V" if found[1] == "V" else f"{output.current():.4f}A"
        if found := re.fullmatch(r"(V|I|OVP|OCP|OP)([12])(\?| (\S+);\*OPC\?)", line):
            word, output = found[1], self.outputs[int(found[2]) - 1]
            names = {"V": "volts", "I": "amperes", "OVP": "over_volts", "OCP": "over_amperes", "OP": "on"}
            if found[3] != "?":
                self.take(line, output, **{names[word]: found[4] == "1" if word == "OP" else float(found[4])})
                return "1"
            echoed = {"V": f"V{found[2]} ", "I": f"I{found[2]} ", "OVP": f"VP{found[2]} ", "OCP": f"CP{found[2]} "}
            return f"{output.on:d}" if word == "OP" else f"{echoed[word]}{getattr(output, names[word]):.3f}"
        return self.lost(line)


MODELS = {"keysight_e36312a": E36312A, "rs_hmp": Hmp, "rigol_dp800": Dp832, "tti": Tti}


class SupplyServer:
    """Serves a supply on a free port of this machine."""

    def __init__(self, supply: Supply) -> None:
        self.supply = supply
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.line = f"tcp://127.0.0.1:{self.socket.getsockname()[1]}"
        self.closed, self.silent = threading.Event(), threading.Event()
        self.clients: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while not self.closed.is_set():
            try:
                client, _ = self.socket.accept()
            except OSError:
                return
            self.clients.append(client)
            threading.Thread(target=self._talk, args=(client,), daemon=True).start()

    def _talk(self, client: socket.socket) -> None:
        received = b""
        end = self.supply.question_end.encode()
        try:
            while data := client.recv(4096):
                received += data
                while end in received:
                    line, received = received.split(end, 1)
                    answer = self.supply.answer(line.decode("ascii", "replace"))
                    if answer is not None and not self.silent.is_set():
                        client.sendall((answer + self.supply.answer_end).encode())
        except OSError:
            return

    def close(self) -> None:
        self.closed.set()
        self.socket.close()
        for client in self.clients:
            client.close()
