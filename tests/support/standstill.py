# SPDX-License-Identifier: Apache-2.0
"""Whether the machine itself stood still: then a test that takes time may fail though the program is without fault."""
from __future__ import annotations

import threading
import time

STEP = 0.02  # s between two looks at the clock
NOTICEABLE = 0.2  # s; an instrument that answers so much later is another one


class Standstill(threading.Thread):
    """Looks at the clock all the time, and keeps when it could not."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.stretches: list[tuple[float, float]] = []  # UTC of the last look before and the first one after
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
        """For how long it stood still; s."""
        return sum(end - begin for begin, end in self.stretches)

    def touches(self, utc: float, seconds: float) -> bool:
        """Whether it stood still for a part of so many seconds from `utc` on."""
        return any(begin < utc + seconds and end > utc for begin, end in self.stretches)
