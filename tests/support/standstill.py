# SPDX-License-Identifier: Apache-2.0
"""Detects delays of the whole machine. During such a delay a test in real time may fail although the program is
correct."""
from __future__ import annotations

import threading
import time

STEP = 0.02  # s between two readings of the clock
NOTICEABLE = 0.2  # s; a longer delay changes the behaviour of an instrument


class Standstill(threading.Thread):
    """Thread that reads the clock every 20 ms and stores the intervals in which it was not scheduled."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.stretches: list[tuple[float, float]] = []  # UTC before and after each delay, s
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
        """Returns the total duration of the delays, in s."""
        return sum(end - begin for begin, end in self.stretches)

    def touches(self, utc: float, seconds: float) -> bool:
        """Returns whether a delay overlaps the interval of `seconds` that starts at `utc`."""
        return any(begin < utc + seconds and end > utc for begin, end in self.stretches)
