#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Independent instruments, each on its own line. They fail on command and record all requests.

A Watlow F4T (data map 1) with a small thermal plant, on Modbus TCP, on RTU frames over TCP or on RTU at a
pseudo-terminal; two Lake Shore 218; a gyro that sends the frames of profiles/rigs/virtual.toml. No value is served
twice within a minute or more, so that each recorded reading can be traced to the moment at which it was served.

    laboratory.py [tcp|rtu_over_tcp|rtu]

serves them in a separate process. It prints their lines as one line of JSON. It answers each line of standard input,
such as {"set": "chamber.silent", "to": true}, {"get": "chamber.air"} or {"do": "chamber.change_set_point", "with": [40]},
by one line of JSON. It ends with its standard input.
"""
from __future__ import annotations

import functools
import heapq
import json
import os
import random
import selectors
import socket
import struct
import sys
import threading
import time
import tty
from dataclasses import dataclass, field
from typing import Any, Callable, Iterable

UNIT = 1
WORD_ORDER_LOW_FIRST = True  # cdab, like profiles/chambers/watlow_f4t.toml

SERIAL_NUMBER, PART_NUMBER, ALARM_1, RAMP_ACTION = 12, 16, 1356, 2794
LIMIT_ERROR, LIMIT_STATE, LIMIT_STATUS = 11250, 11264, 11288
CONTROL_MODE, CONTROL_MODE_ACTIVE = 2730, 2814
SET_POINT_LOW, SET_POINT_HIGH = 2774, 2776
SET_POINT, ACTIVE_SET_POINT, OUTPUT, AIR = 2782, 2810, 2808, 2820
UNIT_BY_TCP, UNIT_BY_RTU = 6730, 14080
PROFILE_START, PROFILE_RESUME, PROFILE_STOP, PROFILE_STATE = 16562, 16564, 16566, 16568

OFF, AUTO, MANUAL, CELSIUS, NO_ALARM = 62, 10, 54, 15, 61
FLOATS = {SET_POINT_LOW, SET_POINT_HIGH, SET_POINT, ACTIVE_SET_POINT, OUTPUT, AIR}
RUNNING, TERMINATE, TERMINATED = 149, 148, 253
READ_ONLY = {AIR, OUTPUT, ACTIVE_SET_POINT, CONTROL_MODE_ACTIVE, PROFILE_STATE, UNIT_BY_TCP, UNIT_BY_RTU, PART_NUMBER}


def as_float32(value: float) -> float:
    """Returns `value` rounded to a 32-bit float."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def split_float(value: float) -> tuple[int, int]:
    """Splits a 32-bit float into two registers, the low word first."""
    low, high = struct.unpack("<HH", struct.pack("<f", value))
    return low, high


def join_float(low: int, high: int) -> float:
    return struct.unpack("<f", struct.pack("<HH", low, high))[0]


@functools.cache
def crc_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0xA001 if byte & 1 else 0)
        table.append(byte)
    return tuple(table)


def modbus_crc(frame: bytes) -> bytes:
    crc = 0xFFFF
    for byte in frame:
        crc = crc >> 8 ^ crc_table()[(crc ^ byte) & 0xFF]
    return struct.pack("<H", crc)


def gyro_crc(frame: bytes) -> bytes:
    """Computes the CRC-16/IBM-3740 of a frame."""
    crc = 0xFFFF
    for byte in frame:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ (0x1021 if crc & 0x8000 else 0)) & 0xFFFF
    return struct.pack("<H", crc)


class Connection:
    """A client of a line, or a pseudo-terminal."""

    def __init__(self, descriptor: int, close: Callable[[], None]) -> None:
        self.descriptor = descriptor
        self.close = close
        self.received = bytearray()
        self.is_open = True


@dataclass(order=True)
class Due:
    """Bytes to be sent at an instant."""
    at: float
    order: int
    connection: Connection = field(compare=False)
    data: bytes = field(compare=False)


class Line(threading.Thread):
    """The instrument's end of a line. Accepts connections, passes received bytes on, and sends answers when due."""

    def __init__(self, instrument: "Instrument", host: str) -> None:
        super().__init__(daemon=True)
        self.instrument = instrument
        self.host = host
        self.selector = selectors.DefaultSelector()
        self.connections: list[Connection] = []
        self.due: list[Due] = []
        self.order = 0
        self.ends = False
        self.port_holder: socket.socket | None = None  # listens while the instrument exists
        self.is_listening = False
        self.port = 0
        self.keeps_open = -1

    def listen(self) -> str:
        """Begins to serve on TCP. Returns the line for a rig file."""
        self._hold_port()
        while self._is_driven():
            self._close_port()
            self.port = 0
            self._hold_port()
        self._open_port()
        self.start()
        return f"tcp://{'127.0.0.1' if self.host == '0.0.0.0' else self.host}:{self.port}"

    def serve_terminal(self) -> str:
        """Begins to serve on a pseudo-terminal. Returns the line for a rig file."""
        master, self.keeps_open = os.openpty()
        tty.setraw(self.keeps_open)
        name = os.ttyname(self.keeps_open)
        os.set_blocking(master, False)
        self._take(Connection(master, lambda: os.close(master)))
        self.start()
        return f"serial:{name}"

    def send(self, connection: Connection, data: bytes, at: float) -> None:
        """Sends `data` at `at`. Only for the line's own thread."""
        self.order += 1
        heapq.heappush(self.due, Due(at, self.order, connection, data))

    def broadcast(self, data: bytes) -> None:
        for connection in self.connections:
            self.send(connection, data, 0)

    def run(self) -> None:
        while not self.ends:
            self._follow_gone()
            for key, _ in self.selector.select(self._rest()):
                if key.data is None:
                    self._accept()
                else:
                    self._receive(key.data)
            self.instrument.tick(self)
            self._send_due()
        for connection in list(self.connections):
            self._drop(connection)
        self._close_port()
        if self.keeps_open >= 0:
            os.close(self.keeps_open)
        self.selector.close()

    def close(self) -> None:
        self.ends = True
        self.join(timeout=5)

    def _rest(self) -> float:
        rest = self.instrument.rest()
        return max(0.0, min(rest, self.due[0].at - time.monotonic()) if self.due else rest)

    def _hold_port(self) -> None:
        """Reserves the port, which still refuses connections."""
        self.port_holder = socket.socket()
        self.port_holder.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.port_holder.bind((self.host, self.port))
        self.port_holder.setblocking(False)
        self.port = self.port_holder.getsockname()[1]

    def _is_driven(self) -> bool:
        """Returns whether a program locks a chamber at this port after the previous chamber there has gone."""
        with open("/proc/net/unix", encoding="utf-8") as names:
            return any(f"gyrotherm-chamber/tcp-this.machine-{self.port}-" in line for line in names)

    def _open_port(self) -> None:
        assert self.port_holder is not None
        self.port_holder.listen(16)
        self.selector.register(self.port_holder, selectors.EVENT_READ, None)
        self.is_listening = True

    def _close_port(self) -> None:
        if self.port_holder is None:
            return
        if self.is_listening:
            self.selector.unregister(self.port_holder)
        self.port_holder.close()
        self.port_holder, self.is_listening = None, False

    def _follow_gone(self) -> None:
        """Closes or reopens the port when `gone` changes. A pseudo-terminal cannot refuse connections; it is silent."""
        if not self.port or self.instrument.gone != self.is_listening:
            return
        if self.instrument.gone:
            self._close_port()
            self._hold_port()
            for connection in list(self.connections):
                self._drop(connection)
            self.instrument.left.set()
        else:
            self._open_port()
            self.instrument.left.clear()

    def _accept(self) -> None:
        assert self.port_holder is not None
        try:
            client, _ = self.port_holder.accept()
        except OSError:
            return
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._take(Connection(client.fileno(), client.close))

    def _take(self, connection: Connection) -> None:
        self.connections.append(connection)
        self.selector.register(connection.descriptor, selectors.EVENT_READ, connection)

    def _receive(self, connection: Connection) -> None:
        try:
            data = os.read(connection.descriptor, 4096)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._drop(connection)
            return
        connection.received += data
        self.instrument.hear(self, connection)

    def _send_due(self) -> None:
        while self.due and self.due[0].at <= time.monotonic():
            due = heapq.heappop(self.due)
            if not due.connection.is_open:
                continue
            try:
                os.write(due.connection.descriptor, due.data)
            except BlockingIOError:
                pass  # a slow reader loses it
            except OSError:
                self._drop(due.connection)

    def _drop(self, connection: Connection) -> None:
        if connection.is_open:
            connection.is_open = False
            self.connections.remove(connection)
            self.selector.unregister(connection.descriptor)
            connection.close()


class Instrument:
    """Interface between a line and its instrument. Every line supports `silent` and `gone`."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.silent = False
        self.gone = False
        self.left = threading.Event()  # set while its TCP line refuses connections

    def leave(self) -> None:
        """Disconnects. Returns once its TCP line refuses connections."""
        self.gone = True
        if not self.left.wait(10):
            raise TimeoutError("the line still accepts connections after 10 s")

    def hear(self, line: Line, connection: Connection) -> None:
        """Consumes a client's bytes in `connection.received`."""

    def tick(self, line: Line) -> None:
        """Called after each wait and after each event."""

    def rest(self) -> float:
        """Returns the longest wait of the line for an event, in s."""
        return 0.1


@dataclass(frozen=True)
class Exchange:
    """A request that reached the chamber, and whether it was answered."""
    at: float  # s, monotonic
    utc: float
    function: int
    address: int
    words: tuple[int, ...]  # written, or served
    fate: str  # answered, refused, request lost, answer lost

    @property
    def writes(self) -> bool:
        return self.function in (6, 16)

    @property
    def value(self) -> float:
        """Returns the written number."""
        return join_float(*self.words) if self.address in FLOATS and len(self.words) == 2 else float(self.words[0])


@dataclass(frozen=True)
class SetPointChange:
    at: float  # s, monotonic
    value: float
    air: float
    by_program: bool


class Chamber(Instrument):
    """A Watlow F4T and the air in it. Every public attribute may be set while it runs."""

    def __init__(self, rtu: bool, seed: int) -> None:
        super().__init__()
        self.rtu = rtu
        self.random = random.Random(seed)
        # Line.
        self.loss_of_requests = 0.0  # share
        self.loss_of_answers = 0.0
        self.every_other_lost = False
        self.delay = 0.0  # s, each answer
        self.late = (0.0, 0.0)  # s, range for late answers
        self.late_share = 0.0
        self.noise_share = 0.0  # RTU answers with noise around them
        # Controller.
        self.answer_time = 0.0  # s, per request
        self.exception = 0  # exception code of every answer
        self.refused: set[int] = set()  # registers that answer with exception 2
        self.mode_stuck = False  # active mode ignores the commanded mode
        self.writes_unanswered = False  # executed, never acknowledged
        self.writes_ignored = False  # acknowledged, not executed
        self.profile_stuck = False  # a profile continues although it was ended
        self.clamps = False  # limits set points instead of refusing them
        self.profile_goal: float | None = None  # °C, own profile that overrules set points
        self.clamp_to: tuple[float, float] | None = None  # narrower than the reported limits
        # Plant.
        self.air = 22.0  # °C
        self.room = 23.0
        self.time_constant = 4.0  # s
        self.fastest = 3.0  # K/s
        self.heats_by_itself = 0.0  # K/s
        self.manual_rate = 0.5  # K/s, at the output of manual mode
        self.shown_air: float | None = None
        # History.
        self.exchanges: list[Exchange] = []
        self.changes: list[SetPointChange] = []
        self.airs: list[tuple[float, float]] = []  # UTC of the request, served value
        self._words: dict[int, int] = {}
        self._integrated = time.monotonic()
        self._busy_until = 0.0
        self._requests = 0
        self._served = 0
        self._switch_on_values()

    def _switch_on_values(self) -> None:
        for offset, letter in enumerate("F4T1A1AAEAA1AAA"):
            self._words[PART_NUMBER + offset] = ord(letter)
        for address, value in {ACTIVE_SET_POINT: 22.0, OUTPUT: 0.0, SET_POINT: 22.0, SET_POINT_LOW: -75.0,
                               SET_POINT_HIGH: 180.0, AIR: 22.0}.items():
            self._keep_float(address, value)
        unit = UNIT_BY_RTU if self.rtu else UNIT_BY_TCP
        for address, value in {CONTROL_MODE: OFF, CONTROL_MODE_ACTIVE: OFF, unit: CELSIUS, PROFILE_STATE: OFF,
                               PROFILE_START: 61, PROFILE_RESUME: 61, PROFILE_STOP: 61}.items():
            self._keep(address, value)
        for alarm in range(4):
            self._keep(ALARM_1 + 100 * alarm, NO_ALARM)
        for address, value in {SERIAL_NUMBER: 111, RAMP_ACTION: OFF, LIMIT_ERROR: NO_ALARM, LIMIT_STATE: NO_ALARM,
                               LIMIT_STATUS: NO_ALARM}.items():
            self._keep(address, value)

    def exchange(self, serial: int, air: float) -> None:
        """Replaces the chamber by another one, at `air` and switched off."""
        with self.lock:
            self._keep(SERIAL_NUMBER, serial)
            self.begin_at(air)

    def _keep(self, address: int, value: int) -> None:
        """Stores a 16-bit value in the first of the two registers of a parameter."""
        self._words[address] = value
        self._words.setdefault(address + 1, 0)

    def _keep_float(self, address: int, value: float) -> None:
        self._words[address], self._words[address + 1] = split_float(value)

    def _float(self, address: int) -> float:
        return join_float(self._words[address], self._words[address + 1])

    # Functions for tests.

    @property
    def set_point(self) -> float:
        with self.lock:
            return self._float(SET_POINT)

    @property
    def mode(self) -> int:
        """Returns the commanded control mode."""
        with self.lock:
            return self._words[CONTROL_MODE]

    @property
    def active_mode(self) -> int:
        with self.lock:
            return self._words[CONTROL_MODE_ACTIVE]

    def begin_at(self, air: float, set_point: float | None = None, mode: int = OFF) -> None:
        """Sets plant and controller to the state before a run."""
        with self.lock:
            self.air = air
            self._integrated = time.monotonic()
            self._keep_float(SET_POINT, air if set_point is None else set_point)
            self._keep(CONTROL_MODE, mode)
            self._keep(CONTROL_MODE_ACTIVE, mode)

    def set_limits(self, low: float, high: float) -> None:
        with self.lock:
            self._keep_float(SET_POINT_LOW, low)
            self._keep_float(SET_POINT_HIGH, high)

    def change_set_point(self, value: float) -> None:
        """Changes the set point at the panel."""
        with self.lock:
            self._set_set_point(value, by_program=False)

    def switch_off(self) -> None:
        """Switches conditioning off at the panel."""
        with self.lock:
            self._keep(CONTROL_MODE, OFF)
            self._keep(CONTROL_MODE_ACTIVE, OFF)

    def switch_to(self, mode: int) -> None:
        """Chooses a mode at the panel."""
        with self.lock:
            self._integrate()
            self._keep(CONTROL_MODE, mode)
            self._keep(CONTROL_MODE_ACTIVE, mode)

    def raise_alarm(self, number: int, active: bool = True) -> None:
        with self.lock:
            self._keep(ALARM_1 + 100 * (number - 1), 1 if active else NO_ALARM)

    def heal(self) -> None:
        """Repairs line and controller. The plant is unchanged."""
        with self.lock:
            self.loss_of_requests = self.loss_of_answers = self.delay = self.late_share = self.noise_share = 0.0
            self.every_other_lost = self.silent = self.gone = False
            self.answer_time, self.exception, self.clamp_to = 0.0, 0, None
            self.refused = set()
            self.mode_stuck = self.writes_ignored = self.writes_unanswered = False
            self.profile_stuck = self.clamps = False
            self._follow_mode()

    def break_as(self, **faults: Any) -> None:
        """Sets several attributes at once."""
        with self.lock:
            for name, value in faults.items():
                if not hasattr(self, name):
                    raise AttributeError(name)
                setattr(self, name, value)

    def writes(self, since: float = 0.0) -> list[Exchange]:
        """Returns all commands, whether or not their answers arrived."""
        with self.lock:
            return [e for e in self.exchanges if e.writes and e.at >= since and e.fate != "request lost"]

    def requests(self, since: float = 0.0, until: float = 1e18) -> list[float]:
        """Returns the times of all requests, whatever their fate."""
        with self.lock:
            return [e.at for e in self.exchanges if since <= e.at < until]

    # Requests.

    def hear(self, line: Line, connection: Connection) -> None:
        with self.lock:
            take = self._take_rtu if self.rtu else self._take_tcp
            while (frame := take(connection.received)) is not None:
                self._serve(line, connection, *frame)

    @staticmethod
    def _take_tcp(received: bytearray) -> tuple[bytes, bytes] | None:
        """Splits one frame into its head and its PDU."""
        if len(received) < 8:
            return None
        length = struct.unpack(">H", received[4:6])[0]
        if len(received) < 6 + length:
            return None
        frame = bytes(received[:6 + length])
        del received[:6 + length]
        return frame[:7], frame[7:]

    @staticmethod
    def _take_rtu(received: bytearray) -> tuple[bytes, bytes] | None:
        while len(received) >= 8:
            size = 8 if received[1] != 16 else 9 + received[6]
            if len(received) < size:
                return None
            frame = bytes(received[:size])
            if modbus_crc(frame[:-2]) == frame[-2:]:
                del received[:size]
                return frame[:1], frame[1:-2]
            del received[:1]
        return None

    def _serve(self, line: Line, connection: Connection, head: bytes, pdu: bytes) -> None:
        if head[-1] != UNIT:
            return
        now, utc = time.monotonic(), time.time()
        self._requests += 1
        lost = (self.silent or self.gone or (self.every_other_lost and self._requests % 2 == 1) or
                self.random.random() < self.loss_of_requests)
        answer_lost = (self.random.random() < self.loss_of_answers or
                       (self.writes_unanswered and pdu[0] in (6, 16)))
        late = self.random.uniform(*self.late) if self.random.random() < self.late_share else 0.0
        if lost:
            self._remember(now, utc, pdu, "request lost", b"")
            return
        answer = self.answer(pdu, utc, answer_lost)
        fate = "answer lost" if answer_lost else "refused" if answer[0] & 0x80 else "answered"
        self._remember(now, utc, pdu, fate, answer)
        if answer_lost:
            return
        self._busy_until = max(now, self._busy_until) + self.answer_time
        line.send(connection, self._framed(head, answer), max(self._busy_until, now) + self.delay + late)

    def _framed(self, head: bytes, pdu: bytes) -> bytes:
        if not self.rtu:
            return head[:4] + struct.pack(">H", len(pdu) + 1) + head[6:7] + pdu
        frame = head + pdu
        frame += modbus_crc(frame)
        if self.random.random() < self.noise_share:
            noise = bytes(self.random.randrange(256) for _ in range(self.random.randint(1, 12)))
            return noise + frame if self.random.random() < 0.5 else frame + noise
        return frame

    def _remember(self, now: float, utc: float, pdu: bytes, fate: str, answer: bytes) -> None:
        function, address = pdu[0], struct.unpack(">H", pdu[1:3])[0]
        data = pdu[6:] if function == 16 else pdu[3:5] if function == 6 else answer[2:] if answer else b""
        words = struct.unpack(f">{len(data) // 2}H", data[:len(data) // 2 * 2])
        self.exchanges.append(Exchange(now, utc, function, address, words, fate))

    def answer(self, pdu: bytes, utc: float, answer_lost: bool) -> bytes:
        """Executes a request and returns the answer."""
        function = pdu[0]
        if self.exception:
            return bytes([function | 0x80, self.exception])
        if function in (3, 4):
            return self._read(pdu, utc, answer_lost)
        if function in (6, 16):
            return self._write(pdu)
        if function == 8:
            return pdu
        return bytes([function | 0x80, 1])

    def _read(self, pdu: bytes, utc: float, answer_lost: bool) -> bytes:
        address, count = struct.unpack(">HH", pdu[1:5])
        wanted = range(address, address + count)
        if not 1 <= count <= 125 or any(a not in self._words or a in self.refused for a in wanted):
            return bytes([pdu[0] | 0x80, 2])
        if AIR in wanted or OUTPUT in wanted:
            self._integrate()
            served = self.next_air()
            self._keep_float(AIR, served)
            if not answer_lost:
                self.airs.append((utc, served))
        self._keep_float(ACTIVE_SET_POINT, self._float(SET_POINT))
        return bytes([pdu[0], 2 * count]) + struct.pack(f">{count}H", *(self._words[a] for a in wanted))

    def next_air(self) -> float:
        """Returns the next air temperature. Readings differ by 1e-5 °C, so each one is unique."""
        self._served += 1
        air = self.air if self.shown_air is None else self.shown_air
        return as_float32(round(air, 2) + self._served % 1000 * 1e-5)

    def _write(self, pdu: bytes) -> bytes:
        function, address = pdu[0], struct.unpack(">H", pdu[1:3])[0]
        data = pdu[3:5] if function == 6 else pdu[6:]
        words = struct.unpack(f">{len(data) // 2}H", data)
        if any(a not in self._words for a in range(address, address + len(words))) or address in READ_ONLY:
            return bytes([function | 0x80, 2])
        if not self.writes_ignored and not self._obey(address, words):
            return bytes([function | 0x80, 3])
        return pdu[:5]

    def _obey(self, address: int, words: Iterable[int]) -> bool:
        """Writes a register. Returns False for a refused value."""
        words = list(words)
        if address == SET_POINT and len(words) == 2:
            value, low, high = join_float(*words), self._float(SET_POINT_LOW), self._float(SET_POINT_HIGH)
            if not low <= value <= high and not self.clamps:
                return False
            if self.clamp_to:
                low, high = self.clamp_to
            self._set_set_point(min(max(value, low), high), by_program=True)
            return True
        if address == CONTROL_MODE and words[0] not in (OFF, AUTO, MANUAL):
            return False
        for offset, word in enumerate(words):
            self._words[address + offset] = word
        if address == CONTROL_MODE:
            self._follow_mode()
        if address == PROFILE_STOP and words[0] == TERMINATE and not self.profile_stuck:
            self.end_profile()
        return True

    def start_profile(self, goal: float) -> None:
        """Starts a profile at the panel."""
        with self.lock:
            self._integrate()
            self.profile_goal = goal
            self._keep(PROFILE_STATE, RUNNING)

    def end_profile(self) -> None:
        self._integrate()
        self.profile_goal = None
        self._keep(PROFILE_STATE, TERMINATED)

    def _follow_mode(self) -> None:
        if not self.mode_stuck:
            self._integrate()
            self._keep(CONTROL_MODE_ACTIVE, self._words[CONTROL_MODE])

    def _set_set_point(self, value: float, by_program: bool) -> None:
        self._integrate()
        self._keep_float(SET_POINT, value)
        shown = self.air if self.shown_air is None else self.shown_air
        self.changes.append(SetPointChange(time.monotonic(), value, shown, by_program))

    def _integrate(self) -> None:
        """Lets the air follow the set point up to now, or the ambient temperature while conditioning is off."""
        step = 0.1
        now = time.monotonic()
        while self._integrated < now:
            dt = min(step, now - self._integrated)
            on = self._words[CONTROL_MODE_ACTIVE] != OFF
            wanted = self._float(SET_POINT) if self.profile_goal is None else self.profile_goal
            goal, constant = (wanted, self.time_constant) if on else (self.room, 600.0)
            rate = max(-self.fastest, min(self.fastest, (goal - self.air) / constant))
            if self._words[CONTROL_MODE_ACTIVE] == MANUAL:
                rate = self.manual_rate
            self.air += (rate + self.heats_by_itself) * dt
            self._integrated += dt


class Thermometers(Instrument):
    """A Lake Shore 218: eight inputs, each with a temperature that identifies the input and the exchange."""

    INPUTS = 8
    IDENTITY = "LSCI,MODEL218E,21EA4F,042109"
    OUT_OF_RANGE = "+1500.000"

    def __init__(self, base: float) -> None:
        super().__init__()
        self.base = base  # °C, input 1; each further one + 0.1 K
        self.lost: set[int] = set()  # inputs, from 0
        self.identity = self.IDENTITY
        self.served: list[tuple[float, tuple[str, ...]]] = []  # UTC, and the sent text

    def lose(self, *inputs: int) -> None:
        with self.lock:
            self.lost = set(inputs)

    def hear(self, line: Line, connection: Connection) -> None:
        while b"\r\n" in connection.received:
            question, _, rest = bytes(connection.received).partition(b"\r\n")
            connection.received[:] = rest
            if self.silent:
                continue
            with self.lock:
                if question == b"*IDN?":
                    line.send(connection, self.identity.encode() + b"\r\n", 0)
                elif question in (b"CRDG? 0", b"CRDG?"):
                    line.send(connection, self.readings().encode() + b"\r\n", 0)

    def readings(self) -> str:
        number = len(self.served)
        texts = tuple(self.OUT_OF_RANGE if i in self.lost else f"{self.base + 0.1 * i + number % 97 * 0.001:+08.3f}"
                      for i in range(self.INPUTS))
        self.served.append((time.time(), texts))
        return ",".join(texts)


class Gyro(Instrument):
    """Gyro that sends one frame per second. Its counts identify the frame."""

    def __init__(self) -> None:
        super().__init__()
        self.sent: list[tuple[float, int]] = []  # UTC, and the frame's count
        self._began = time.monotonic()
        self._number = 0

    @staticmethod
    def pulses_of(number: int) -> int:
        """Returns the pulses of the second that ends with frame `number`."""
        return 100 + number * 37 % 64

    def tick(self, line: Line) -> None:
        while time.monotonic() >= self._began + self._number:
            self._number += 1
            before = self.sent[-1][1] if self.sent else 0
            count = before + self.pulses_of(self._number)
            self.sent.append((time.time(), count))
            if not self.silent:
                line.broadcast(self._frame(self._number, count))

    def rest(self) -> float:
        return min(0.1, self._began + self._number - time.monotonic())

    @staticmethod
    def _frame(number: int, count: int) -> bytes:
        frame = b"\xA5\x5A" + struct.pack("<HIiBB", number & 0xFFFF, number * 1_000_000 & 0xFFFFFFFF, count, 0, 0)
        return frame + gyro_crc(frame)

    def hear(self, line: Line, connection: Connection) -> None:
        connection.received.clear()


class Laboratory:
    """All instruments of a rig, each on its own line."""

    LINKS = ("tcp", "rtu_over_tcp", "rtu")

    def __init__(self, link: str = "tcp", host: str = "127.0.0.1", seed: int = 1) -> None:
        self.link = link
        self.chamber = Chamber(rtu=link != "tcp", seed=seed)
        self.thermometer_1 = Thermometers(base=24.0)  # A … H
        self.thermometer_2 = Thermometers(base=26.0)  # shell
        self.gyro = Gyro()
        self._lines = {"chamber": Line(self.chamber, host), "thermometer_1": Line(self.thermometer_1, "127.0.0.1"),
                       "thermometer_2": Line(self.thermometer_2, "127.0.0.1"), "gyro": Line(self.gyro, "127.0.0.1")}
        self.lines = {name: line.serve_terminal() if name == "chamber" and link == "rtu" else line.listen()
                      for name, line in self._lines.items()}

    def close(self) -> None:
        for line in self._lines.values():
            line.ends = True
        for line in self._lines.values():
            line.close()


def carry_out_request(laboratory: Laboratory, message: dict[str, Any]) -> Any:
    path = message.get("set") or message.get("get") or message["do"]
    owner_name, _, name = path.partition(".")
    owner = getattr(laboratory, owner_name)
    if "set" in message:
        if not hasattr(owner, name):
            raise AttributeError(path)
        setattr(owner, name, message["to"])
        return None
    if "get" in message:
        return getattr(owner, name)
    return getattr(owner, name)(*message.get("with", []))


def main() -> int:
    link = sys.argv[1] if len(sys.argv) > 1 else "tcp"
    if link not in Laboratory.LINKS:
        print(__doc__, file=sys.stderr)
        return 2
    laboratory = Laboratory(link)
    print(json.dumps(laboratory.lines), flush=True)
    for line in sys.stdin:
        try:
            answer = {"done": carry_out_request(laboratory, json.loads(line))}
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            answer = {"refused": str(error)}
        print(json.dumps(answer, default=lambda thing: getattr(thing, "__dict__", str(thing))), flush=True)
    laboratory.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
