# SPDX-License-Identifier: Apache-2.0
"""Detects whether the machine itself stood still. A test that takes time may then fail although the program is
correct."""
from __future__ import annotations

import threading
import time

STEP = 0.02  # s between two readings of the clock
NOTICEABLE = 0.2  # s; such a delay changes an instrument's behaviour


class Standstill(threading.Thread):
    """Reads the clock all the time, and stores the stretches in which it could not."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.stretches: list[tuple[float, float]] = []  # UTC of the readings around each standstill
        self.start()

    def run(self) -> None:
        before, utc_before = time.monotonic(), time.time()
        while True:
            time.sleep(STEP)
            now, utc = time.monotonic(), time.time()
            if now - before - STEP >= NOTICEABLE:
                self.stretches.append((utc_before, utc))
            before, utc_before = now, utc

    def total(self) -> float:
        """Returns the duration of all standstills, in s."""
        return sum(end - begin for begin, end in self.stretches)

    def touches(self, utc: float, seconds: float) -> bool:
        """Returns whether it stood still during part of the given seconds from `utc` on."""
        return any(begin < utc + seconds and end > utc for begin, end in self.stretches)
