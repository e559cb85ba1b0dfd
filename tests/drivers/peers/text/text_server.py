# SPDX-License-Identifier: Apache-2.0
"""A text instrument with a chamber around it, its faults on request, and a TCP server for it.

The instruments of this folder are written from public drivers and manual pages. They use no code and no description
file of gyrotherm.
"""
from __future__ import annotations

import argparse
import os
import pathlib
import random
import re
import select
import socket
import sys
import threading
import time
import tty
from dataclasses import dataclass, field
from typing import Callable, Iterator

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "controllers")]

from families import Chamber
from modbus_server import ROOM, Server

RATE = 3.0 / 60  # K/s at speed 1
DRIFT = 0.02  # K/s of the air of a unit that is off
DEVIATION = 0.15  # K by which settled air differs from the set point
IN_TESTS = 20.0  # speed: 1 K/s
OF_THE_UNIT = ("other_family", "exchanged")  # another instrument answers, always
HOSTILE = ("late", "doubled", "repeated", "partial", "pieces", "rest", "bytes", "busy", "foreign", "unit", "comma",
           "no_number", "overlong", "prefixed", "unterminated", "closed", "noise", "two_answers")
KINDS = (*HOSTILE, *OF_THE_UNIT)
FOREIGN = ("KEYSIGHT TECHNOLOGIES,34401A,MY44012345,13", "1;+2.0E+01,+2.1E+01", "WATLOW,F4", "A1 023.4", "{S1", "")
NO_NUMBERS = ("nan", "inf", "-inf", "1e999", "----", "")
NUMBER_IN_ANSWER = re.compile(r"-?\d+\.\d+")


class Refused(Exception):
    """The instrument refuses a command; the text is its answer."""


@dataclass(frozen=True)
class Heard:
    """A command that changes something; `refused` is the answer of a refusal, or empty."""
    at: float  # monotonic, s
    line: str
    refused: str = ""


@dataclass
class Faults:
    """Faults of the line and of the instrument. Each kind that is in `kinds` occurs in a share of the answers."""
    kinds: tuple[str, ...] = ()
    share: float = 0.4
    late: tuple[float, float] = (1.1, 3.2)  # s
    draw: random.Random = field(default_factory=lambda: random.Random(20261129))
    made: dict[str, int] = field(default_factory=dict)  # number of faults of each kind

    def drawn(self) -> str:
        """Returns the fault of the next answer, or nothing."""
        kinds = [kind for kind in self.kinds if kind not in OF_THE_UNIT]
        kind = self.draw.choice(kinds) if kinds and self.draw.random() < self.share else ""
        self.made[kind] = self.made.get(kind, 0) + 1
        return kind


class TextChamber(Chamber):
    """An instrument. A protocol overrides `reply`, `busy` and what it needs of the rest.

    The air follows the set point while the unit is on, at a few kelvin per minute times `speed`.
    """

    name = ""  # protocol
    encoding = "ascii"
    question_ends = b"\r\n"  # each of these bytes ends a question
    answer_end = "\r\n"
    identity_questions: tuple[str, ...] = ()
    other_family: dict[str, str] = {}  # answers of another family to them; without one it is silent
    exchanged: dict[str, str] = {}  # answers of another unit of the same family; without any: of another family
    pause_after_answer = pause_after_write = 0.0  # s, as the manual demands
    answer_time = 0.0  # s from a line to its answer
    other_question = ""  # its answer precedes or follows another one as a fault

    def __init__(self, *, air: float = 25.0, speed: float = IN_TESTS, lag: float = 0.6, lowest: float = -40.0,
                 highest: float = 90.0, faults: Faults | None = None) -> None:
        super().__init__(air)
        self.speed, self.lag, self.lowest, self.highest = speed, lag, lowest, highest
        self.faults = faults or Faults()
        self.on = False
        self.set_point = ROOM  # as it is read back
        self.heard: list[Heard] = []
        self.unknown: list[str] = []  # lines that no command begins
        self.too_early: list[str] = []  # lines that came before the pause was over
        self.airs: list[tuple[float, float]] = []  # UTC s and °C, each value that was sent
        self.set_points: list[tuple[float, float]] = []
        self.serves = True  # otherwise the line is cut

    # Overridden by each protocol.

    def reply(self, line: str) -> str | None:
        """Returns the answer without its end; nothing if there is none."""
        raise NotImplementedError

    def busy(self) -> str:
        """Returns the refusal of an instrument that is busy."""
        raise NotImplementedError

    def time_of(self, line: str) -> float:
        """Returns the time from a line to its answer, in s."""
        return self.answer_time

    # Common to all.

    def drive(self) -> tuple[float, float]:
        return (self.target() + DEVIATION, RATE * self.speed) if self.on else (ROOM, DRIFT)

    def target(self) -> float:
        return self.set_point

    def is_off(self) -> bool:
        return not self.on

    def follows(self) -> float | None:
        with self.lock:
            self.advance()
            return self.target() if self.on else None

    def to_off(self) -> bool:
        with self.lock:
            self.on = False
        return True

    @property
    def log(self) -> list[Heard]:  # type: ignore[override]
        return self.heard

    @log.setter
    def log(self, value: list[Heard]) -> None:
        """Ignores the list of the Modbus controllers."""

    def air_text(self, form: str = "{:.1f}") -> str:
        """Returns the air as it is sent, and notes it."""
        text = form.format(self.air)
        self.airs.append((time.time(), float(text)))
        return text

    def set_point_text(self, form: str = "{:.1f}") -> str:
        text = form.format(self.set_point)
        self.set_points.append((time.time(), float(text)))
        return text

    def take(self, line: str, action: Callable[[], None]) -> None:
        """Takes a command that is acknowledged now and acts after the lag."""
        self.heard.append(Heard(time.monotonic(), line))
        self.later(self.lag, action) if self.lag else action()

    def take_set_point(self, line: str, celsius: float, refusal: str) -> None:
        if not self.lowest <= celsius <= self.highest:
            self.refuse(line, refusal)
        self.take(line, lambda: setattr(self, "set_point", celsius))

    def take_power(self, line: str, on: bool) -> None:
        self.take(line, lambda: setattr(self, "on", on))

    def refuse(self, line: str, refusal: str) -> None:
        self.heard.append(Heard(time.monotonic(), line, refusal or "silence"))
        raise Refused(refusal)

    def not_known(self, line: str, refusal: str) -> str:
        self.unknown.append(line)
        return refusal

    def answer_line(self, line: str) -> str | None:
        """Returns the answer to a line at this moment."""
        with self.lock:
            self.advance()
            if line in self.identity_questions:
                if "other_family" in self.faults.kinds:
                    return self.other_family.get(line)
                if "exchanged" in self.faults.kinds:
                    return (self.exchanged or self.other_family).get(line)
            try:
                return self.reply(line)
            except Refused as refused:
                return str(refused) or None

    def encoded(self, answer: str) -> bytes:
        return (answer + self.answer_end).encode(self.encoding)

    def next_line(self, received: bytes) -> tuple[str | None, bytes]:
        """Returns the first complete line, if any, and what follows it."""
        ends = [received.find(bytes([end])) for end in self.question_ends]
        at = min((end for end in ends if end >= 0), default=-1)
        if at < 0:
            return None, received
        return received[:at].decode(self.encoding, errors="replace"), received[at + 1:]


class Conversation:
    """What one client sends, and the answers with their faults."""

    def __init__(self, chamber: TextChamber) -> None:
        self.chamber = chamber
        self.received, self.free_at = b"", 0.0

    def replies(self, data: bytes) -> Iterator[tuple[float, bytes | None]]:
        """Returns the pieces of all answers, each with the delay before it, in s. Nothing closes the connection."""
        now = time.monotonic()
        self.received += data
        while True:
            line, self.received = self.chamber.next_line(self.received)
            if line is None:
                return
            if not line:
                continue
            if now < self.free_at:
                self.chamber.too_early.append(line)
            commands = len(self.chamber.heard)
            pieces = self.faulty(line)
            is_command = len(self.chamber.heard) > commands
            pause = self.chamber.pause_after_write if is_command else self.chamber.pause_after_answer
            # A quarter less, because this server notices lines late while the machine is busy.
            self.free_at = now + 0.75 * pause
            if pieces:
                yield self.chamber.time_of(line), b""
            yield from pieces

    def faulty(self, line: str) -> list[tuple[float, bytes | None]]:
        """Returns the pieces of one answer."""
        chamber = self.chamber
        kind = chamber.faults.drawn()
        if kind == "busy":
            return [(0.0, chamber.encoded(chamber.busy()))] if chamber.busy() else []
        answer = chamber.answer_line(line)
        if answer is None:
            return []
        if kind == "comma":
            answer = answer.replace(".", ",")
        whole = chamber.encoded(answer)
        half = max(1, len(whole) // 2)
        if kind == "late":
            return [(chamber.faults.draw.uniform(*chamber.faults.late), whole)]
        if kind == "doubled":
            return [(0.0, whole + whole)]
        if kind == "repeated":
            return [(0.0, whole), (0.02, whole)]
        if kind == "partial":
            return [(0.0, whole[:half])]
        if kind == "pieces":
            return [(0.0, whole[:half]), (0.02, whole[half:])]
        return self.hostile(kind, answer, whole)

    def hostile(self, kind: str, answer: str, whole: bytes) -> list[tuple[float, bytes | None]]:
        """Returns the pieces of an answer with one of the rarer faults."""
        chamber, draw = self.chamber, self.chamber.faults.draw
        cut = draw.randrange(1, max(2, len(whole)))
        if kind == "rest":
            return [(0.0, whole[:cut]), (draw.uniform(0.2, 2.5), whole[cut:])]
        if kind == "bytes":
            return [(0.002, bytes([byte])) for byte in whole]
        if kind == "foreign":
            return [(0.0, chamber.encoded(draw.choice(FOREIGN)))]
        if kind == "unit":
            return [(0.0, chamber.encoded(answer + draw.choice(["F", " K"])))]
        if kind == "no_number":
            return [(0.0, chamber.encoded(NUMBER_IN_ANSWER.sub(draw.choice(NO_NUMBERS), answer)))]
        if kind == "overlong":
            return [(0.0, chamber.encoded(NUMBER_IN_ANSWER.sub(lambda number: 300 * "9" + number[0], answer)))]
        if kind == "prefixed":
            return [(0.0, draw.choice([b"x", b"#", b";", b"\x07"]) + whole)]
        if kind == "unterminated":
            return [(0.0, whole[:len(whole) - len(chamber.answer_end)])]
        if kind == "closed":
            return [(0.0, None)]
        if kind == "noise":
            return [(0.0, draw.randbytes(draw.randrange(1000, 6000))), (0.01, whole)]
        if kind == "two_answers" and chamber.other_question:
            other = chamber.encoded(chamber.answer_line(chamber.other_question) or answer)
            return [(0.0, whole + other if draw.random() < 0.5 else other + whole)]
        return [(0.0, whole)]


class TextServer(Server):
    """Serves one instrument on a free TCP port."""
    framing = ""  # the description file states it

    def __init__(self, chamber: TextChamber, port: int = 0) -> None:
        self.chamber = chamber
        super().__init__(chamber.clients_at_most)
        if port:
            self.close()
            self.socket = socket.create_server(("127.0.0.1", port))
            self.port = port
            self.closed = threading.Event()
            threading.Thread(target=self._accept, daemon=True).start()

    def talk(self, client: socket.socket) -> None:
        if not self.chamber.serves:
            return
        conversation = Conversation(self.chamber)
        while data := client.recv(4096):
            for delay, piece in conversation.replies(data):
                if delay:
                    self.closed.wait(delay)
                if piece is None:
                    client.shutdown(socket.SHUT_RDWR)
                    return
                client.sendall(piece)

    def cut(self) -> None:
        """Closes all connections, and each new one at once."""
        self.chamber.serves = False
        with self.lock:
            for client in self.clients:
                client.shutdown(socket.SHUT_RDWR)

    def mend(self) -> None:
        self.chamber.serves = True


class TextOnTerminal:
    """Serves one instrument on a pseudo-terminal."""
    framing = ""

    def __init__(self, chamber: TextChamber, settings: str) -> None:
        self.chamber = chamber
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.line = f"serial:{os.ttyname(self.slave)}?{settings}"
        self.closed = threading.Event()
        self.thread = threading.Thread(target=self._talk, daemon=True)
        self.thread.start()

    def _talk(self) -> None:
        conversation = Conversation(self.chamber)
        while not self.closed.is_set():
            if not select.select([self.master], [], [], 0.2)[0]:
                continue
            try:
                data = os.read(self.master, 4096)
            except OSError:
                return
            if not self.chamber.serves:
                continue
            for delay, piece in conversation.replies(data):
                if delay:
                    self.closed.wait(delay)
                os.write(self.master, piece or b"")

    def cut(self) -> None:
        """Loses all that is sent from now on."""
        self.chamber.serves = False

    def mend(self) -> None:
        self.chamber.serves = True

    def close(self) -> None:
        self.closed.set()
        self.thread.join(5)
        os.close(self.master)
        os.close(self.slave)


class Client:
    """Asks an instrument in its self-test."""

    def __init__(self, server: TextServer, end: str = "\r\n") -> None:
        self.chamber, self.end = server.chamber, end
        self.socket = socket.create_connection(("127.0.0.1", server.port), timeout=2)

    def ask(self, line: str) -> str:
        """Returns what arrives within 0.3 s, without the end of the answer."""
        self.socket.sendall((line + self.end).encode(self.chamber.encoding))
        received, until = b"", time.monotonic() + 2
        while time.monotonic() < until:
            self.socket.settimeout(0.3)
            try:
                piece = self.socket.recv(4096)
            except TimeoutError:
                break
            if not piece:
                break
            received += piece
            if self.chamber.answer_end and received.endswith(self.chamber.answer_end.encode()):
                break
        return received.decode(self.chamber.encoding, errors="replace").removesuffix(self.chamber.answer_end)

    def expect(self, line: str, answer: str) -> None:
        found = self.ask(line)
        if found != answer:
            raise AssertionError(f"{line!r} was answered {found!r}, not {answer!r}")


def self_test(make: Callable[..., TextChamber], test: Callable[[Client], None], end: str) -> None:
    """Asks the instrument through its server, also with each fault."""
    server = TextServer(make(lag=0.0))
    client = Client(server, end)
    test(client)
    client.socket.close()
    for kind in KINDS:
        server.chamber.faults = Faults((kind,), share=1.0, late=(0.01, 0.05))
        client = Client(server, end)
        client.ask(server.chamber.identity_questions[0] if server.chamber.identity_questions else "x")
        client.socket.close()
    server.close()


def main(make: Callable[..., TextChamber], test: Callable[[Client], None], end: str = "\r\n") -> None:
    """Serves the instrument until it is interrupted, or tests it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--lag", type=float, default=0.6, help="seconds from an acknowledgement to its read-back")
    parser.add_argument("--share", type=float, default=0.4, help="share of the answers that have a fault")
    for kind in KINDS:
        parser.add_argument(f"--{kind.replace('_', '-')}", action="store_true")
    given = parser.parse_args()
    if given.self_test:
        self_test(make, test, end)
        print(f"{make.__name__}: passed")
        return
    kinds = tuple(kind for kind in KINDS if getattr(given, kind))
    server = TextServer(make(speed=given.speed, lag=given.lag, faults=Faults(kinds, given.share)), given.port)
    print(server.line, flush=True)
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        server.close()
