# SPDX-License-Identifier: Apache-2.0
"""Controllers of a single loop in small chambers, by what manuals and public drivers state. See families.py."""
from __future__ import annotations

from typing import Any, Callable

from families import FAST, MANUAL_HEAT, OFF, Chamber, Temperatures
from modbus_server import (ILLEGAL_ADDRESS, ILLEGAL_VALUE, READ_HOLDING, READ_INPUT, ROOM, Refused, from_high_first,
                           from_low_first, high_first, low_first, signed)

# Watlow EZ-ZONE PM: user guide (programmable memory blocks), communications manual; ornl-epics/watlow for data map 2.

EZ_OFF, EZ_AUTO, EZ_MANUAL = 62, 10, 54
EZ_YES, EZ_NO = 106, 59


class EzZonePm(Temperatures, Chamber):
    """Each parameter has two registers. In data map 2 an alarm limit has the address of the mode in data map 1."""

    def __init__(self, *, air: float = 25.0, in_fahrenheit: bool = True, data_map: int = 1, mode: int = EZ_OFF,
                 words: Callable[[float], list[int]] = low_first, input_error: int = 61) -> None:
        super().__init__(air)
        self.in_fahrenheit, self.data_map, self.mode, self.words = in_fahrenheit, data_map, mode, words
        self.number = from_low_first if words is low_first else from_high_first
        self.input_error, self.storing, self.stored, self.set_point = input_error, EZ_YES, 0, ROOM
        self.mode_at, self.set_point_at, self.alarm_at = (1880, 2160, 1480) if data_map == 1 else (2360, 2640, 1880)

    def registers(self) -> dict[int, int]:
        held: dict[int, int] = {}
        for address, value in {360: self.shown(self.air), self.set_point_at: self.shown(self.set_point),
                               self.set_point_at + 2: 0.0, self.alarm_at: 300.0, self.alarm_at + 2: 32.0}.items():
            held[address], held[address + 1] = self.words(value)
        if self.data_map == 2:  # an unrelated parameter
            held[2160], held[2161] = self.words(self.shown(ROOM))
        whole = {362: self.input_error, 368: 113, 398: 94, self.mode_at: self.mode,
                 2490: 30 if self.in_fahrenheit else 15, 2494: self.storing}
        for address, value in whole.items():
            held[address], held[address + 1] = value, 0
        return held

    def store(self, function: int, address: int, words: list[int]) -> None:
        if address == 2494 and words[0] in (EZ_YES, EZ_NO):
            self.storing = words[0]
            return
        if address == self.set_point_at and len(words) == 2:
            self.set_point = self.meant(self.number(words))
        elif address == self.mode_at and words[0] in (EZ_OFF, EZ_AUTO, EZ_MANUAL):
            self.mode = words[0]
        else:
            raise Refused(ILLEGAL_VALUE if address in self.registers() else ILLEGAL_ADDRESS)
        self.stored += self.storing == EZ_YES

    def kept(self) -> object:
        return self.in_fahrenheit

    def drive(self) -> tuple[float, float]:
        if self.mode == EZ_OFF:
            return OFF
        return (self.set_point, FAST) if self.mode == EZ_AUTO else MANUAL_HEAT

    def to_manual(self) -> bool:
        with self.lock:
            self.mode = EZ_MANUAL
        return True

    def to_off(self) -> bool:
        with self.lock:
            self.mode = EZ_OFF
        return True


# Eurotherm nanodac: ornl-epics/eurotherm (both of its generations). 3504: a driver with addresses from iTools, and
# MinimalModbus' eurotherm3500.

class Eurotherm(Chamber):
    """Each parameter is a scaled integer at its address, and a float, high word first, at 32768 + 2 * address."""
    decimals = 1

    def __init__(self, *, air: float = 25.0, lowest: float = -50.0, highest: float = 110.0, manual: bool = False,
                 inhibit: bool = False, rate: float = 0.0) -> None:
        super().__init__(air)
        self.lowest, self.highest, self.manual, self.inhibit, self.rate = lowest, highest, manual, inhibit, rate
        self.set_point = ROOM

    def numbers(self) -> dict[int, float]:
        raise NotImplementedError

    def states(self) -> dict[int, int]:
        raise NotImplementedError

    def registers(self) -> dict[int, int]:
        held = dict(self.states())
        for address, value in self.numbers().items():
            held[address] = round(value * 10 ** self.decimals)
            held[32768 + 2 * address], held[32769 + 2 * address] = high_first(value)
        return held

    def take(self, parameter: int, value: float) -> bool:
        """Stores a parameter. Returns false if it cannot be written."""
        raise NotImplementedError

    def store(self, function: int, address: int, words: list[int]) -> None:
        if address >= 32768 and address % 2 == 0 and len(words) == 2:
            taken = self.take((address - 32768) // 2, from_high_first(words))
        elif address < 32768 and len(words) == 1:
            taken = self.take(address, signed(words[0]) / (10 ** self.decimals if address in self.numbers() else 1))
        else:
            taken = False
        if not taken:
            raise Refused(ILLEGAL_VALUE if address in self.registers() else ILLEGAL_ADDRESS)

    def kept(self) -> object:
        return self.lowest, self.highest, self.rate

    def take_set_point(self, value: float) -> bool:
        if not self.lowest <= value <= self.highest:
            return False
        self.set_point = value
        return True

    def drive(self) -> tuple[float, float]:
        if self.inhibit:
            return OFF
        return MANUAL_HEAT if self.manual else (self.set_point, FAST)

    def to_manual(self) -> bool:
        with self.lock:
            self.manual = True
        return True

    def to_off(self) -> bool:
        with self.lock:
            self.inhibit = True
        return True


class Nanodac(Eurotherm):
    """Loop 1: main parameters from 512, set points from 5724. The registers 5721 and 5722 cannot be read."""
    reads = (READ_HOLDING, READ_INPUT)

    def __init__(self, *, inhibit: bool = True, **how: Any) -> None:
        super().__init__(inhibit=inhibit, **how)

    def numbers(self) -> dict[int, float]:
        return {256: self.air, 512: self.air, 514: self.set_point, 515: self.set_point,
                516: 50.0 if self.manual else 0.0, 5726: self.highest, 5727: self.lowest, 5730: self.rate}

    def states(self) -> dict[int, int]:
        return {257: 0, 513: int(self.manual), 517: int(self.inhibit), 522: 1, 531: 0}

    def take(self, parameter: int, value: float) -> bool:
        if parameter == 514:
            return self.take_set_point(value)
        if parameter not in (513, 517) or value not in (0, 1):
            return False
        setattr(self, "manual" if parameter == 513 else "inhibit", value == 1)
        return True


class Eurotherm3504(Eurotherm):
    """Loop 1. The inhibition is never written."""

    def numbers(self) -> dict[int, float]:
        return {1: self.air, 2: self.set_point, 4: 50.0 if self.manual else 0.0, 5: self.set_point, 24: self.set_point,
                35: self.rate, 85: 0.0, 111: self.highest, 112: self.lowest, 289: self.air}

    def states(self) -> dict[int, int]:
        return {78: 0, 268: int(self.inhibit), 273: int(self.manual), 10213: 0}

    def take(self, parameter: int, value: float) -> bool:
        if parameter == 2:
            return self.take_set_point(value)
        if parameter != 273 or value not in (0, 1):
            return False
        self.manual = value == 1
        return True
