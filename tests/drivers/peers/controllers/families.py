# SPDX-License-Identifier: Apache-2.0
"""Two controllers of each family that a register map is shipped for, by what manuals and public drivers state.

The tables are written from those facts, not from the maps. A register that the real unit lacks is answered by
exception 2, or by silence where the family knows no exceptions. The air follows the set point only in a mode in which
the real controller would make it.
"""
from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any, Callable

from modbus_server import (BUSY, ILLEGAL_ADDRESS, ILLEGAL_VALUE, READ_HOLDING, ROOM, WRITE_COIL, WRITE_MANY, WRITE_ONE,
                           Controller, Refused, Silent, fahrenheit, from_fahrenheit, from_high_first, from_low_first,
                           high_first, low_first, signed)

FAST, SLOW = 1.0, 0.02  # K/s, conditioned air; air that drifts to ambient
MANUAL_HEAT = 240.0, 0.95  # °C and K/s, with a fixed output
OF_OTHERS = 55.0  # °C, target of another user's program
OFF = ROOM, SLOW


class Chamber(Controller):
    """Operations that the tests require of every family. `follows` is the set point in effect, or None."""
    open_loop = False  # a state that no register shows


    def follows(self) -> float | None:
        with self.lock:
            self.advance()
            to, rate = self.forced()
            return to if rate == FAST and not self.in_program() else None

    def is_off(self) -> bool:
        with self.lock:
            self.advance()
            return self.forced() == OFF

    def forced(self) -> tuple[float, float]:
        """Returns the target of the air. A fixed output, which no register shows, acts while the controller is on."""
        to, rate = self.drive()
        return MANUAL_HEAT if self.open_loop and rate == FAST else (to, rate)

    def kept(self) -> object:
        """Returns the settings except set point and mode. No run may change them."""
        return None

    def in_program(self) -> bool:
        return False

    def to_manual(self) -> bool:
        """Selects a mode that does not follow the set point. Returns false if no register shows the mode."""
        return False

    def to_off(self) -> bool:
        """Switches the controller off at its panel. Returns false if no register shows it."""
        return False

    def to_open_loop(self) -> None:
        """Fixes the output. No register shows it."""
        with self.lock:
            self.open_loop = True

    def to_program(self) -> bool:
        """Starts a program of another user. Returns false if the family has no programs."""
        return False


class Temperatures:
    """A temperature unit that is a setting of the controller."""
    in_fahrenheit = False

    def shown(self, celsius: float) -> float:
        return fahrenheit(celsius) if self.in_fahrenheit else celsius

    def meant(self, value: float) -> float:
        return from_fahrenheit(value) if self.in_fahrenheit else value


# Watlow F4T: manual of TestEquity, ChamberConnectLibrary.

F4T_OFF, F4T_AUTO, F4T_MANUAL = 62, 10, 54
F4T_NO, F4T_YES = 62, 63
F4T_RUNNING, F4T_PAUSED, F4T_TERMINATED, F4T_NOT_STARTED = 149, 146, 253, 251
PROFILE_REGISTERS = {16558, 16560, 16562, 16564, 16566}


@dataclass(frozen=True)
class LoopTable:
    """Addresses of the parameters of a control loop or cascade."""
    mode: int
    mode_active: int
    low: int
    high: int
    set_point: int
    output: int
    active_set_point: int
    air: int
    ramp_action: int
    other: dict[int, float] = field(default_factory=dict)  # floats that are never written


LOOP_1 = LoopTable(mode=2730, mode_active=2814, low=2774, high=2776, set_point=2782, output=2808,
                   active_set_point=2810, air=2820, ramp_action=2794, other={2798: 3.0, 27586: 0.0})
CASCADE_1 = LoopTable(mode=4010, mode_active=4012, low=4034, high=4036, set_point=4042, output=4178,
                      active_set_point=4188, air=4182, ramp_action=4054, other={4168: -20.0, 4170: 20.0})


class F4T(Temperatures, Chamber):
    """Data map 1. Every parameter has two registers; a missing parameter gives exception 2."""
    table = LOOP_1

    def __init__(self, *, air: float = 25.0, in_fahrenheit: bool = False,
                 words: Callable[[float], list[int]] = low_first, rtu: bool = False, power: str = "",
                 part: str = "F4T1A1DAA1B2ABA", lag: float = 0.0, set_point_lag: float = 0.0, lowest: float = -50.0,
                 highest: float = 110.0, mode: int = F4T_OFF, profile: int = F4T_NOT_STARTED,
                 refuses_while_off: bool = False, limit_card: bool = False, absent_card: int = ILLEGAL_ADDRESS) -> None:
        super().__init__(air)
        self.in_fahrenheit, self.words, self.rtu, self.power, self.part = in_fahrenheit, words, rtu, power, part
        self.number = from_low_first if words is low_first else from_high_first
        self.lag, self.set_point_lag, self.lowest, self.highest = lag, set_point_lag, lowest, highest
        self.mode = self.mode_active = mode
        self.profile, self.refuses_while_off, self.limit_card = profile, refuses_while_off, limit_card
        self.absent_card = absent_card
        self.set_point = ROOM
        self.powered = not power
        self.key_down = False

    def registers(self) -> dict[int, int]:
        t = self.table
        held: dict[int, int] = {}
        for address, value in {t.low: self.lowest, t.high: self.highest, t.set_point: self.set_point,
                               t.active_set_point: self.target(), t.air: self.air}.items():
            held[address], held[address + 1] = self.words(self.shown(value))
        for address, value in {t.output: self.output(), **t.other}.items():
            held[address], held[address + 1] = self.words(self.shown(self.air) if address == 27586 else value)
        whole = {14080 if self.rtu else 6730: 30 if self.in_fahrenheit else 15, t.mode: self.mode,
                 t.mode_active: self.mode_active, t.ramp_action: 62, 90: 138, 16558: 1, 16560: 1, 16562: 61, 16564: 61,
                 16566: 61, 16568: self.profile, 16588: 0, 16590: 0, 16592: 87,
                 14664: 10, 14666: 5, 14668: 7, 14670: 11, 14672: 28, 14674: 2026}
        whole |= {1356 + 100 * n: 61 for n in range(6)}
        whole |= {16594 + 2 * n: F4T_NO for n in range(4)} | {6844 + 20 * n: F4T_NO for n in range(4)}
        if self.power == "event_1":
            whole[16594] = F4T_YES if self.powered else F4T_NO
        if self.power == "key_1":
            whole[33718] = whole[6844] = F4T_YES if self.powered else F4T_NO
        if self.limit_card:
            whole |= {11250: 61, 11264: 138, 11288: 61}
        for address, value in whole.items():
            held[address], held[address + 1] = value, 0
        held[12], held[13] = self.words_of_whole(1_000_000 + len(self.part) + (self.lag > 0))
        held |= {16 + i: ord(letter) for i, letter in enumerate(self.part)}
        return held | self.more()

    def more(self) -> dict[int, int]:
        return {}

    def words_of_whole(self, value: int) -> list[int]:
        both = [value >> 16, value & 0xFFFF]
        return both if self.words is high_first else both[::-1]

    def absent(self, address: int) -> bytes:
        raise Refused(self.absent_card if address in (11250, 11264, 11288) else BUSY if address == 33718 else
                      ILLEGAL_ADDRESS)

    def store(self, function: int, address: int, words: list[int]) -> None:
        t = self.table
        if address == t.set_point and len(words) == 2:
            self.take_set_point(self.meant(self.number(words)))
        elif address == t.mode and words[0] in (F4T_OFF, F4T_AUTO, F4T_MANUAL):
            self.mode = words[0]
            self.after_lag(lambda: setattr(self, "mode_active", self.mode))
        elif address == 16594 and words[0] in (F4T_NO, F4T_YES):
            if self.power == "event_1":
                self.powered = words[0] == F4T_YES
        elif address == 6850 and words[0] in (1456, 1457):
            self.press(words[0] == 1457)
        elif address in PROFILE_REGISTERS:
            self.take_profile_action(address, words[0])
        elif address in self.registers():
            raise Refused(ILLEGAL_VALUE)
        else:
            raise Refused(ILLEGAL_ADDRESS)

    def after_lag(self, action: Callable[[], None]) -> None:
        self.later(self.lag, action) if self.lag else action()

    def take_set_point(self, celsius: float) -> None:
        if not self.lowest <= celsius <= self.highest or (self.refuses_while_off and self.mode_active == F4T_OFF):
            raise Refused(ILLEGAL_VALUE)
        if self.set_point_lag:
            self.later(self.set_point_lag, lambda: setattr(self, "set_point", celsius))
        else:
            self.set_point = celsius

    def press(self, down: bool) -> None:
        if down and not self.key_down and self.power == "key_1":
            self.powered = not self.powered  # a second press stops
        self.key_down = down

    def take_profile_action(self, address: int, value: int) -> None:
        if address == 16566 and value == 148 and self.profile in (F4T_RUNNING, F4T_PAUSED):
            self.after_lag(lambda: setattr(self, "profile", F4T_TERMINATED))
        elif address == 16566 and value == 146 and self.profile == F4T_RUNNING:
            self.profile = F4T_PAUSED

    def in_program(self) -> bool:
        return self.profile in (F4T_RUNNING, F4T_PAUSED)

    def target(self) -> float:
        return OF_OTHERS if self.in_program() else self.set_point

    def output(self) -> float:
        return 60.0 if self.mode_active == F4T_MANUAL else 0.0

    def drive(self) -> tuple[float, float]:
        if not self.powered or (self.mode_active == F4T_OFF and not self.in_program()):
            return OFF
        if self.mode_active == F4T_MANUAL and not self.in_program():
            return MANUAL_HEAT
        return self.target(), FAST

    def to_manual(self) -> bool:
        with self.lock:
            self.mode = self.mode_active = F4T_MANUAL
        return True

    def to_program(self) -> bool:
        with self.lock:
            self.profile, self.powered = F4T_RUNNING, True
        return True

    def to_off(self) -> bool:
        with self.lock:
            if self.power:
                self.powered = False
            else:
                self.mode = self.mode_active = F4T_OFF
        return True


class F4TCascade(F4T):
    """Data map 1 of a unit with a cascade: loop 1 is humidity, or does not exist."""
    table = CASCADE_1

    def __init__(self, *, part: str = "F4T1A1DAA1B7ABA", cascade: bool = False, **how: Any) -> None:
        super().__init__(part=part, **how)
        self.cascade = cascade

    def more(self) -> dict[int, int]:
        held = {4200: 62 if self.cascade else 63, 4201: 0}
        held[4180], held[4181] = self.words(self.shown(self.air - 1))
        held[4190], held[4191] = self.words(self.shown(self.set_point))
        if self.part[11] == "7":  # a further loop: humidity, %
            for address, value in {2774: 0.0, 2776: 100.0, 2782: 45.0, 2810: 45.0, 2820: 45.0}.items():
                held[address], held[address + 1] = self.words(value)
            held |= {2730: F4T_AUTO, 2731: 0, 2814: F4T_AUTO, 2815: 0, 2794: 62, 2795: 0}
        return held

    def drive(self) -> tuple[float, float]:
        to, rate = super().drive()
        if self.cascade and rate == FAST and not self.in_program():
            return to + 15, rate / 2  # the air leads the part
        return to, rate


class F4Like(Temperatures, Chamber):
    """16-bit registers common to the F4 and to the data maps 2 and 3 of the F4T."""

    def __init__(self, *, air: float = 25.0, in_fahrenheit: bool = False, decimals: int = 1, lag: float = 0.0,
                 lowest: float = -50.0, highest: float = 110.0, profile: bool = False) -> None:
        super().__init__(air)
        self.in_fahrenheit, self.decimals, self.lag, self.profile = in_fahrenheit, decimals, lag, profile
        self.lowest, self.highest, self.set_point, self.held = lowest, highest, ROOM, False

    def whole(self, celsius: float) -> int:
        return round(self.shown(celsius) * 10 ** self.decimals)

    def registers(self) -> dict[int, int]:
        return {100: self.whole(self.air), 101: 0, 300: self.whole(self.set_point), 606: self.decimals,
                901: 0 if self.in_fahrenheit else 1, 1209: 0, 1210: 0, 1217: 0, 4000: 1, 4001: 1} | \
            {2000 + 10 * n: int(n == 0) for n in range(7)}

    def store(self, function: int, address: int, words: list[int]) -> None:
        if address == 300 and len(words) == 1:
            celsius = self.meant(signed(words[0]) / 10 ** self.decimals)
            if celsius > self.highest:
                raise Refused(ILLEGAL_VALUE)
            self.set_point = celsius
        elif address == 1217 and words == [1]:
            self.later(self.lag, lambda: setattr(self, "profile", False))
        elif address in (1209, 1210) and words == [1]:
            self.held = address == 1210 and self.profile
        elif address in self.registers():
            raise Refused(ILLEGAL_VALUE)
        else:
            raise Refused(ILLEGAL_ADDRESS)

    def in_program(self) -> bool:
        return self.profile

    def drive(self) -> tuple[float, float]:
        if self.profile:
            return (self.air if self.held else OF_OTHERS), FAST
        return OFF if self.set_point < self.lowest else (self.set_point, FAST)


class F4TMap2(F4Like):
    """Data map 2 of a unit without cascade. No register shows a profile or a mode."""

    def registers(self) -> dict[int, int]:
        return super().registers() | {104: 450, 105: 0, 319: 450, 616: 1, 4002: 0}


class F4TMap3(F4Like):
    """Data map 3 of a cascade unit. The part's temperature has its own number of decimals."""

    def __init__(self, part_decimals: int = 1, **how: Any) -> None:
        super().__init__(**how)
        self.part_decimals = part_decimals

    def registers(self) -> dict[int, int]:
        return super().registers() | {108: round(self.shown(self.air - 1) * 10 ** self.part_decimals), 109: 0,
                                      626: self.part_decimals}


class F4(F4Like):
    """Series F4. Register 0 shows the model, register 200 a running profile."""

    def __init__(self, *, serial: int = 4711, cascade: bool = False, only_one: bool = False, **how: Any) -> None:
        super().__init__(**how)
        self.serial, self.cascade = serial, cascade
        if only_one:
            self.writes = (WRITE_ONE,)

    def registers(self) -> dict[int, int]:
        held = super().registers() | {0: 5270, 1: self.serial >> 16, 2: self.serial & 0xFFFF, 5: 1107, 103: 0,
                                      200: 0 if not self.profile else 3 if self.held else 2,
                                      602: self.whole(self.lowest), 603: self.whole(self.highest), 600: 1, 608: 0,
                                      1218: 39, 1219: 250, 4100: int(self.profile), 4101: int(self.profile)}
        held |= {1916 + i: value for i, value in enumerate((10, 5, 7, 11, 28, 2026))}
        return held | ({1922: self.whole(self.set_point), 1925: 1} if self.cascade else {})

    def to_program(self) -> bool:
        with self.lock:
            self.profile = True
        return True


# Binder: public drivers and the interface specification that they quote.

class Binder(Chamber):
    """Exceptions 4 and 5 mean "not ready" and "write denied"; replies to a read may carry function 4."""
    clients_at_most = 1

    def __init__(self, *, air: float = 25.0, reply_function: int = READ_HOLDING, busy_every: int = 0) -> None:
        super().__init__(air)
        self.reply_function, self.busy_every, self.asked = reply_function, busy_every, 0

    def _read(self, function: int, address: int, count: int) -> bytes:
        self.asked += 1
        if self.busy_every and self.asked % self.busy_every == 0:
            raise Refused(BUSY)
        return bytes([self.reply_function]) + super()._read(function, address, count)[1:]


class BinderMb1(Binder):
    """The mode is a bit field at 1A22, where commands are written. The basic mode returns to idle by itself."""
    IDLE, PROGRAM, MANUAL, BASIC = 0, 0x0400, 0x0800, 0x1000

    def __init__(self, *, manual_at: int = 0x1581, other_bits: int = 0, active_at: int = 0x1077, mode: int = 0,
                 lag: float = 0.0, **how: Any) -> None:
        super().__init__(**how)
        self.manual_at, self.other_bits, self.active_at = manual_at, other_bits, active_at
        self.mode, self.lag = mode, lag
        self.set_points = {0x1581: ROOM, 0x156F: ROOM}

    def registers(self) -> dict[int, int]:
        held = {0x1A22: self.mode | self.other_bits, 0x1A23: 0, 0x1007: 0x0100, 0x123D: 0, 0x123E: 0, 0x1081: 0,
                0x158B: 0}
        for address, value in {0x11A9: self.air, 0x11CD: 0.0, self.active_at: self.active(), **self.set_points}.items():
            held[address], held[address + 1] = low_first(value)
        return held | {0x1228 + i: 0x20 for i in range(20)}

    def active(self) -> float:
        return OF_OTHERS if self.mode == self.PROGRAM else self.set_points[self.manual_at]

    def store(self, function: int, address: int, words: list[int]) -> None:
        if address in self.set_points and len(words) == 2:
            celsius = from_low_first(words)
            if not -70 <= celsius <= 180:
                raise Refused(3)
            self.set_points[address] = celsius
        elif address == 0x1A22 and words[0] in (self.IDLE, self.PROGRAM, self.MANUAL, self.BASIC):
            self.later(self.lag, lambda: self.enter(words[0]))
        elif address == 0x1A23:
            pass
        else:
            raise Refused(ILLEGAL_ADDRESS if address not in self.registers() else 5)

    def enter(self, mode: int) -> None:
        self.mode = mode
        if mode == self.BASIC:
            self.later(1.0, lambda: self.mode == self.BASIC and setattr(self, "mode", self.IDLE))

    def in_program(self) -> bool:
        return self.mode == self.PROGRAM

    def drive(self) -> tuple[float, float]:
        return (self.active(), FAST) if self.mode in (self.PROGRAM, self.MANUAL) else OFF

    def to_program(self) -> bool:
        with self.lock:
            self.mode = self.PROGRAM
        return True

    def to_off(self) -> bool:
        with self.lock:
            self.mode = self.IDLE
        return True


class BinderMb2(Binder):
    """Commanded contacts are at 1158, active contacts at 1292; bit 1 is idle."""
    IDLE = 2

    def __init__(self, *, contacts: int = IDLE, program: bool = False, lag: float = 0.0, denies: bool = False,
                 **how: Any) -> None:
        super().__init__(**how)
        self.denies = denies  # a set point while a program runs
        self.contacts = self.contacts_now = contacts
        self.lag, self.set_point = lag, ROOM
        self.started: float | None = time.monotonic() - 100 if program else None

    def kept(self) -> object:
        return self.contacts & ~self.IDLE

    def registers(self) -> dict[int, int]:
        elapsed = 0 if self.started is None else int(time.monotonic() - self.started) + 1
        held = {0x10A4: 0, 0x10A5: 0, 0x10A6: elapsed >> 16, 0x10A7: elapsed & 0xFFFF, 0x10A8: 0, 0x10A9: 0,
                0x1140: 2026, 0x1141: 11, 0x1142: 28, 0x1143: 7, 0x1144: 5, 0x1145: 10,
                0x1146: 0, 0x1147: 0, 0x1148: 1, 0x1149: 0, 0x114A: 0, 0x114B: 0,
                0x1158: self.contacts, 0x1292: self.contacts_now}
        held |= {0x134A + i: value for i, value in enumerate((2026, 11, 28, 7, 5, 10))}
        for address, value in {0x1004: self.air, 0x1006: self.air - 0.3, 0x100A: 0.0, 0x10B2: self.active(),
                               0x10B4: 0.0, 0x114C: self.set_point, 0x114E: 0.0, 0x1150: 100.0,
                               0x10D2: self.air}.items():
            held[address], held[address + 1] = low_first(value)
        return held

    def active(self) -> float:
        return OF_OTHERS if self.in_program() else self.set_point

    def store(self, function: int, address: int, words: list[int]) -> None:
        if address == 0x114C and len(words) == 2:
            if self.denies and self.in_program():
                raise Refused(5)  # write denied
            self.set_point = from_low_first(words)
        elif address == 0x1158:
            self.contacts = words[0]
            self.later(self.lag, lambda: setattr(self, "contacts_now", self.contacts))
        elif address == 0x114A and words == [1]:
            self.later(self.lag, lambda: setattr(self, "started", None))
        else:
            raise Refused(ILLEGAL_ADDRESS if address not in self.registers() else 5)

    def in_program(self) -> bool:
        return self.started is not None

    def drive(self) -> tuple[float, float]:
        return OFF if self.contacts_now & self.IDLE and not self.in_program() else (self.active(), FAST)

    def to_program(self) -> bool:
        with self.lock:
            self.started = time.monotonic()
        return True

    def to_off(self) -> bool:
        with self.lock:
            self.contacts |= self.IDLE
            self.contacts_now = self.contacts
        return True


# CSZ EZT-570i: its communication manual.

class Ezt570i(Temperatures, Chamber):
    """No exceptions: an absent register, and a request too early, get no answer; function 16 is ignored. No register
    shows the unit of temperature that is set at its panel."""
    read_at_most = 60
    loop_back = True
    PERIOD = 0.25  # s between exchanges; 0.5 in the manual

    def __init__(self, *, air: float = 25.0, events: int = 0, profile: int = 0, product_control: int = 0,
                 online: bool = True, lowest: float = -70.0, highest: float = 180.0,
                 in_fahrenheit: bool = False) -> None:
        super().__init__(air)
        self.in_fahrenheit = in_fahrenheit
        self.events, self.profile, self.product_control, self.online = events, profile, product_control, online
        self.lowest, self.highest, self.set_point, self.start_step = lowest, highest, ROOM, 0
        self._asked = 0.0

    def answer(self, pdu: bytes) -> bytes:
        now, before, self._asked = time.monotonic(), self._asked, time.monotonic()
        if now - before < self.PERIOD:
            raise Silent
        return super().answer(pdu)

    def registers(self) -> dict[int, int]:
        held = dict.fromkeys(range(180), 0)
        return held | {0: int(self.online), 1: 26 * 256 + 11, 2: 28 * 256 + 6, 3: 7 * 256 + 5, 4: 10, 6: 60,
                       12: self.product_control, 22: self.events, 24: self.profile, 37: self.start_step,
                       46: self.whole(OF_OTHERS), 60: self.whole(self.set_point), 61: self.whole(self.air),
                       64: self.whole(self.highest), 65: self.whole(self.lowest), 180: int(not self.online)}

    def kept(self) -> object:
        return self.events & ~1, self.product_control, self.lowest, self.highest

    def whole(self, celsius: float) -> int:
        return round(self.shown(celsius) * 10)

    def absent(self, address: int) -> bytes:
        raise Silent

    def too_long(self, count: int) -> bytes:
        raise Silent

    def store(self, function: int, address: int, words: list[int]) -> None:
        if not self.online:
            raise Silent
        if function == WRITE_MANY:
            return
        if address == 60:
            self.set_point = self.meant(signed(words[0]) / 10)
        elif address == 22:
            self.events = words[0]
        elif address == 24 and words[0] in (0, 1):
            self.profile = 0
            self.events &= ~1 if words[0] == 1 else ~0
        elif address == 24 and words[0] == 2 and self.profile:
            self.profile = 2
        elif address == 24 and words[0] == 4 and (self.start_step or self.profile == 2):
            self.profile, self.start_step = 4 | 32, 0
        elif address == 37:
            self.start_step = words[0]

    def in_program(self) -> bool:
        return self.profile != 0

    def drive(self) -> tuple[float, float]:
        if not self.online or not self.events & 1:
            return OFF
        if self.profile:
            return (self.air if self.profile & 2 else OF_OTHERS), FAST
        return self.set_point + 15 * (self.product_control not in (0, 4)), FAST

    def to_program(self) -> bool:
        with self.lock:
            self.profile = 4 | 32
        return True

    def to_off(self) -> bool:
        with self.lock:
            self.events &= ~1
        return True


# Samwon and its clone.

class Temi(Chamber):
    """D registers, whose addresses on the wire are one less. No known register shows whether the unit runs."""
    read_at_most = 64
    loop_back = True

    def __init__(self, *, air: float = 25.0, in_force_at: int = 1, running: bool = False, fix: bool = True) -> None:
        super().__init__(air)
        self.in_force_at, self.running, self.fix, self.fix_next, self.set_point = in_force_at, running, fix, fix, ROOM

    def registers(self) -> dict[int, int]:
        held = {0: round(self.air * 10), 1: 0, 2: 0, 4: 0, 99: 1, 100: 1 if self.running else 4,
                101: round(self.set_point * 10), 102: 0, 103: int(self.fix_next)}
        held[self.in_force_at] = round(self.drive()[0] * 10)
        return held

    def store(self, function: int, address: int, words: list[int]) -> None:
        if address == 101 and len(words) == 1:
            self.set_point = signed(words[0]) / 10
        elif address == 100 and words[0] in (1, 4):
            self.running, self.fix = words[0] == 1, self.fix_next if words[0] == 1 else self.fix
        elif address == 103 and words[0] in (0, 1):
            self.fix_next = words[0] == 1
        elif address not in (99, 102):
            raise Refused(ILLEGAL_ADDRESS)

    def in_program(self) -> bool:
        return self.running and not self.fix

    def drive(self) -> tuple[float, float]:
        return OFF if not self.running else (self.set_point if self.fix else OF_OTHERS, FAST)


class X100(Chamber):
    """The clone: hundredths, no address offset, at most 16 registers per read. It acknowledges all valid writes."""
    read_at_most = 16
    STOPPED, CONSTANT, PROGRAM = 0, 1, 2

    def __init__(self, *, air: float = 25.0, state: int = STOPPED, lag: float = 0.5, panel: int = 1) -> None:
        super().__init__(air)
        self.state, self.lag, self.panel, self.set_point = state, lag, panel, ROOM

    def registers(self) -> dict[int, int]:
        return dict.fromkeys(range(512), 0) | {
            1: round(self.air * 100), 2: round(self.drive()[0] * 100), 10: self.state, 25: 1, 41: 5, 100: 1, 101: 0,
            102: round(self.set_point * 100), 104: self.panel, 35: 0xB1E0}

    def too_long(self, count: int) -> bytes:
        raise Silent

    def store(self, function: int, address: int, words: list[int]) -> None:
        if address == 102:
            self.set_point = signed(words[0]) / 100
        elif address == 104:
            if self.state == self.STOPPED:  # otherwise acknowledged but not stored
                self.panel = words[0]
        elif address == 101:
            if words[0] not in (1, 4):
                raise Refused(ILLEGAL_VALUE)
            run = words[0] == 1
            self.later(self.lag, lambda: self.run(run))
        elif not 0 <= address < 512:
            raise Refused(ILLEGAL_ADDRESS)

    def run(self, on: bool) -> None:
        if not on:
            self.state = self.STOPPED
        elif self.state == self.STOPPED:
            self.state = self.CONSTANT if self.panel == 1 else self.PROGRAM

    def in_program(self) -> bool:
        return self.state == self.PROGRAM

    def drive(self) -> tuple[float, float]:
        return {self.STOPPED: OFF, self.CONSTANT: (self.set_point, FAST), self.PROGRAM: (OF_OTHERS, FAST)}[self.state]

    def to_program(self) -> bool:
        with self.lock:
            self.state = self.PROGRAM
        return True

    def to_off(self) -> bool:
        with self.lock:
            self.state = self.STOPPED
        return True


# Three controllers supported by the driver of a battery tester. Their set points and states cannot be read.

class Tt5166(Chamber):
    """Unit 0. Reads one register in hundredths, writes one register in tenths; coils 0 and 1 start and stop."""
    unit = 0
    read_at_most = 1
    writes = (WRITE_COIL, WRITE_ONE)

    def __init__(self, *, air: float = 25.0, zero_every: int = 0, ignores_while_off: bool = False) -> None:
        super().__init__(air)
        self.zero_every, self.ignores_while_off, self.asked = zero_every, ignores_while_off, 0
        self.running, self.set_point = False, ROOM

    def registers(self) -> dict[int, int]:
        self.asked += 1
        stray = self.zero_every and self.asked % self.zero_every == 0
        return {0: 0 if stray else round(self.air * 100), 3: 450}

    def store(self, function: int, address: int, words: list[int]) -> None:
        if function == WRITE_COIL:
            if address not in (0, 1) or words != [0xFF00]:
                raise Refused(ILLEGAL_ADDRESS)
            self.running = address == 0
        elif address == 38:
            if self.running or not self.ignores_while_off:
                self.set_point = signed(words[0]) / 10
        elif address != 39:
            raise Refused(ILLEGAL_ADDRESS)

    def drive(self) -> tuple[float, float]:
        return (self.set_point, FAST) if self.running else OFF


class Umc1200(Chamber):
    """Unit 0. Only function 16 writes: the set points of temperature and humidity in one block."""
    unit = 0
    writes = (WRITE_MANY,)

    def __init__(self, *, air: float = 25.0, scale: int = 10, miscounts: bool = True, zero_every: int = 0) -> None:
        super().__init__(air)
        self.scale, self.miscounts, self.zero_every, self.asked = scale, miscounts, zero_every, 0
        self.running, self.set_point = False, ROOM

    def registers(self) -> dict[int, int]:
        self.asked += 1
        stray = self.zero_every and self.asked % self.zero_every == 0
        return {0: 0 if stray else round(self.air * self.scale), 1: 450}

    def store(self, function: int, address: int, words: list[int]) -> None:
        if address == 43 and len(words) == 2:
            self.set_point = signed(words[0]) / self.scale
        elif address == 47 and words[0] in (0, 1):
            self.running = words[0] == 1
        else:
            raise Refused(ILLEGAL_ADDRESS)

    def reply_length(self, function: int, true_length: int) -> int:
        return 11 if self.miscounts and function == WRITE_MANY else true_length

    def drive(self) -> tuple[float, float]:
        return (self.set_point, FAST) if self.running else OFF


class Yinhe(Chamber):
    """Floats, written only by function 16. The unit needs 200 ms between two commands."""
    writes = (WRITE_MANY,)

    def __init__(self, *, air: float = 25.37, words: Callable[[float], list[int]] = high_first, zero_every: int = 0,
                 period: float = 0.0, drifts: bool = True) -> None:
        super().__init__(air)
        self.words, self.zero_every, self.period, self.drifts = words, zero_every, period, drifts
        self.asked, self._last = 0, 0.0
        self.running, self.set_point = False, ROOM

    def answer(self, pdu: bytes) -> bytes:
        now, before, self._last = time.monotonic(), self._last, time.monotonic()
        if now - before < self.period:
            raise Silent
        return super().answer(pdu)

    def registers(self) -> dict[int, int]:
        self.asked += 1
        stray = self.zero_every and self.asked % self.zero_every == 0
        held = {}
        held[160], held[161] = [0, 0] if stray else self.words(self.air)
        held[162], held[163] = self.words(45.0)
        return held

    def store(self, function: int, address: int, words: list[int]) -> None:
        number = from_high_first if self.words is high_first else from_low_first
        if address == 1742 and len(words) == 2:
            self.set_point = number(words)
        elif address == 200 and words[0] in (0, 1):
            self.running = words[0] == 1
        elif address != 1744:
            raise Refused(ILLEGAL_ADDRESS)

    def drive(self) -> tuple[float, float]:
        if not self.running and not self.drifts:
            return self.air, FAST
        return (self.set_point, FAST) if self.running else OFF
