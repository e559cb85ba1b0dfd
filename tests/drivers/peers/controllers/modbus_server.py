# SPDX-License-Identifier: Apache-2.0
"""Modbus servers with their own plant, independent of gyrotherm's code and register maps."""
from __future__ import annotations

import os
import select
import socket
import struct
import threading
import time
import tty
from dataclasses import dataclass
from typing import Callable

READ_COILS, READ_HOLDING, READ_INPUT, WRITE_COIL, WRITE_ONE, LOOP_BACK, WRITE_MANY = 1, 3, 4, 5, 6, 8, 16
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, BUSY = 1, 2, 3, 4
ROOM = 23.0  # °C
LONGEST_STEP = 0.5  # s, maximum time step of the plant


class Refused(Exception):
    """The controller answers with an exception."""

    def __init__(self, code: int) -> None:
        super().__init__(f"exception {code}")
        self.code = code


class Silent(Exception):
    """The controller does not answer."""


@dataclass(frozen=True)
class Write:
    """A write that reached the controller. `refused` is the exception in the answer, or 0."""
    at: float  # monotonic, s
    function: int
    address: int
    words: tuple[int, ...]
    refused: int


def crc16(data: bytes) -> bytes:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return struct.pack("<H", crc)


def high_first(value: float) -> list[int]:
    return list(struct.unpack(">HH", struct.pack(">f", value)))


def low_first(value: float) -> list[int]:
    return high_first(value)[::-1]


def from_high_first(words: list[int]) -> float:
    return struct.unpack(">f", struct.pack(">HH", *words))[0]


def from_low_first(words: list[int]) -> float:
    return from_high_first(words[::-1])


def signed(word: int) -> int:
    return word - 65536 if word & 0x8000 else word


def fahrenheit(celsius: float) -> float:
    return celsius * 1.8 + 32


def from_fahrenheit(degrees: float) -> float:
    return (degrees - 32) / 1.8


class Controller:
    """A controller with its chamber. A family overrides `registers`, `store` and `drive`.

    The air moves only as `drive` returns: to a temperature, at a rate in K/s.
    """

    unit = 1
    reads = (READ_HOLDING,)
    writes = (WRITE_ONE, WRITE_MANY)
    read_at_most = 125
    clients_at_most = 8
    loop_back = False

    def __init__(self, air: float = 25.0) -> None:
        self.lock = threading.RLock()
        self.air = air
        self.log: list[Write] = []
        self.requests: list[tuple[float, int, int, int]] = []  # monotonic s, function, address, count or value
        self._pending: list[tuple[float, Callable[[], None]]] = []
        self._moved = time.monotonic()

    # Overridden by each family.

    def registers(self) -> dict[int, int]:
        """Returns every holding register that can be read now."""
        raise NotImplementedError

    def store(self, function: int, address: int, words: list[int]) -> None:
        """Executes a write, or raises Refused or Silent."""
        raise NotImplementedError

    def drive(self) -> tuple[float, float]:
        """Returns the target of the air, °C, and the rate, K/s."""
        raise NotImplementedError

    def forced(self) -> tuple[float, float]:
        """Returns the actual target and rate of the air."""
        return self.drive()

    # Common to all families.

    def later(self, seconds: float, action: Callable[[], None]) -> None:
        """Calls a function later, as a controller does that acknowledges a command before it acts."""
        self._pending.append((time.monotonic() + seconds, action))

    def advance(self) -> None:
        now = time.monotonic()
        due = [action for at, action in self._pending if at <= now]
        self._pending = [(at, action) for at, action in self._pending if at > now]
        while self._moved < now:
            step = min(LONGEST_STEP, now - self._moved)
            to, rate = self.forced()
            self.air += max(-rate * step, min(rate * step, to - self.air))
            self._moved += step
        for action in due:
            action()

    def air_now(self) -> float:
        with self.lock:
            self.advance()
            return self.air

    def show(self) -> dict[int, int]:
        """Returns the present registers."""
        with self.lock:
            self.advance()
            return self.registers()

    def accepted(self, since: float = 0.0) -> list[Write]:
        """Returns the writes that were not refused."""
        with self.lock:
            return [w for w in self.log if not w.refused and w.at >= since]

    def answer(self, pdu: bytes) -> bytes:
        """Returns the reply to a request, both without address and check. Raises Silent."""
        with self.lock:
            self.advance()
            try:
                return self._answer(pdu)
            except Refused as refused:
                return bytes([pdu[0] | 0x80, refused.code])

    def _answer(self, pdu: bytes) -> bytes:
        function = pdu[0]
        address, value = struct.unpack(">HH", pdu[1:5]) if len(pdu) >= 5 else (0, 0)
        self.requests.append((time.monotonic(), function, address, value))
        if function == LOOP_BACK and self.loop_back:
            return pdu
        if function in self.reads:
            return self._read(function, address, value)
        if function in self.writes:
            words = [value] if function != WRITE_MANY else list(struct.unpack(f">{value}H", pdu[6:6 + 2 * value]))
            self._write(function, address, words)
            return pdu[:5]
        if function in (WRITE_COIL, WRITE_ONE, WRITE_MANY):
            self.log.append(Write(time.monotonic(), function, address, (value,), ILLEGAL_FUNCTION))
        raise Refused(ILLEGAL_FUNCTION)

    def _read(self, function: int, address: int, count: int) -> bytes:
        if not 1 <= count <= self.read_at_most:
            return self.too_long(count)
        held, addresses = self.registers(), range(address, address + count)
        if any(a not in held for a in addresses):
            return self.absent(address)
        return bytes([function, 2 * count]) + struct.pack(f">{count}H", *(held[a] & 0xFFFF for a in addresses))

    def _write(self, function: int, address: int, words: list[int]) -> None:
        refused = 0
        try:
            self.store(function, address, words)
        except Refused as exception:
            refused = exception.code
            raise
        finally:
            self.log.append(Write(time.monotonic(), function, address, tuple(words), refused))

    def too_long(self, count: int) -> bytes:
        raise Refused(ILLEGAL_VALUE)

    def absent(self, address: int) -> bytes:
        raise Refused(ILLEGAL_ADDRESS)

    def reply_length(self, function: int, true_length: int) -> int:
        """Returns the length that the MBAP header of a reply states."""
        return true_length


def has_hung_up(client: socket.socket) -> bool:
    """Returns whether the client has closed its end, even if the serving thread has not noticed."""
    try:
        return client.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


class Server:
    """Serves one instrument, with one thread per connection."""

    def __init__(self, clients_at_most: int = 8) -> None:
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        self.clients_at_most = clients_at_most
        self.clients: set[socket.socket] = set()
        self.closed = threading.Event()
        self.lock = threading.Lock()
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def line(self) -> str:
        return f"tcp://127.0.0.1:{self.port}"

    def _accept(self) -> None:
        while not self.closed.is_set():
            try:
                client, _ = self.socket.accept()
            except OSError:
                return
            with self.lock:
                taken = sum(not has_hung_up(other) for other in self.clients) < self.clients_at_most
                if taken:
                    self.clients.add(client)
            if not taken:
                client.close()
                continue
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            threading.Thread(target=self._talk, args=(client,), daemon=True).start()

    def _talk(self, client: socket.socket) -> None:
        try:
            self.talk(client)
        except OSError:
            pass
        finally:
            with self.lock:
                self.clients.discard(client)
            client.close()

    def talk(self, client: socket.socket) -> None:
        raise NotImplementedError

    def close(self) -> None:
        self.closed.set()
        for open_socket in [self.socket, *self.clients]:
            try:
                open_socket.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            open_socket.close()


class ModbusTcp(Server):
    framing = "tcp"

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        super().__init__(controller.clients_at_most)

    def talk(self, client: socket.socket) -> None:
        received = b""
        while data := client.recv(4096):
            received += data
            while len(received) >= 8:
                transaction, protocol, length, unit = struct.unpack(">HHHB", received[:7])
                if len(received) < 6 + length:
                    break
                pdu, received = received[7:6 + length], received[6 + length:]
                if protocol or unit != self.controller.unit:
                    continue
                try:
                    reply = self.controller.answer(pdu)
                except Silent:
                    continue
                stated = self.controller.reply_length(pdu[0], 1 + len(reply))
                client.sendall(struct.pack(">HHHB", transaction, 0, stated, unit) + reply)


def request_size(frame: bytes) -> int:
    """Returns the size of an RTU request with its CRC, or 0 if it is not known yet."""
    if len(frame) < 8:
        return 0
    return 9 + frame[6] if frame[1] == WRITE_MANY else 8


def answer_frames(controller: Controller, received: bytes, send: Callable[[bytes], object]) -> bytes:
    """Answers each complete RTU frame. Returns the remaining bytes."""
    while (size := request_size(received)) and len(received) >= size:
        frame, received = received[:size], received[size:]
        if crc16(frame[:-2]) != frame[-2:]:
            return b""
        if frame[0] != controller.unit:
            continue
        try:
            reply = frame[:1] + controller.answer(frame[1:-2])
        except Silent:
            continue
        send(reply + crc16(reply))
    return received


class RtuInTcp(Server):
    framing = "rtu_over_tcp"

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        super().__init__(controller.clients_at_most)

    def talk(self, client: socket.socket) -> None:
        received = b""
        while data := client.recv(4096):
            received = answer_frames(self.controller, received + data, client.sendall)


class RtuOnTerminal:
    """Serves RTU frames on a pseudo-terminal."""
    framing = "rtu"

    def __init__(self, controller: Controller, settings: str = "9600,8N1") -> None:
        self.controller = controller
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.line = f"serial:{os.ttyname(self.slave)}?{settings}"
        self.closed = threading.Event()
        self.thread = threading.Thread(target=self._talk, daemon=True)
        self.thread.start()

    def _talk(self) -> None:
        received = b""
        while not self.closed.is_set():
            if not select.select([self.master], [], [], 0.2)[0]:
                received = b""  # a silence ends an incomplete frame
                continue
            try:
                received += os.read(self.master, 4096)
            except OSError:
                return
            received = answer_frames(self.controller, received, lambda data: os.write(self.master, data))

    def close(self) -> None:
        self.closed.set()
        self.thread.join(2)
        os.close(self.master)
        os.close(self.slave)


class Thermometers(Server):
    """An RH Systems PT12 in the chamber, with nine connected inputs."""

    INPUTS, CONNECTED = 12, 9

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self.asked = 0
        super().__init__()

    def talk(self, client: socket.socket) -> None:
        received = b""
        while data := client.recv(256):
            received += data
            while b"\r" in received:
                question, _, received = received.partition(b"\r")
                received = received.lstrip(b"\n")
                client.sendall(self.reply(question.strip().decode().upper()).encode() + b"\r\n")

    def reply(self, question: str) -> str:
        if question == "ID?":
            return "PT12"
        if question == "SN?":
            return "T-0815"
        if question == "T?":
            self.asked += 1
            air = self.controller.air_now()
            shown = [f"{air + 0.01 * i + 0.001 * (self.asked * 7 % 5):.3f}" for i in range(self.CONNECTED)]
            return ",".join(shown + ["NaN"] * (self.INPUTS - self.CONNECTED))
        return ""


class Gyro(Server):
    """A vertical gyro at rest at latitude 45°. It sends the Earth rate, 10.6 °/h, in pulses of 0.1″ once a second."""

    PULSES = 106

    def talk(self, client: socket.socket) -> None:
        number, count, next_at = 0, 0, time.monotonic()
        while not self.closed.is_set():
            number, count, next_at = number + 1, count + self.PULSES + number % 3 - 1, next_at + 1
            time.sleep(max(0.0, next_at - time.monotonic()))
            frame = b"\xA5\x5A" + struct.pack("<HIiBB", number & 0xFFFF, number * 1_000_000 & 0xFFFFFFFF, count, 0, 0)
            client.sendall(frame + struct.pack("<H", crc_of_pulse_count(frame)))


def crc_of_pulse_count(data: bytes) -> int:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc
