# SPDX-License-Identifier: Apache-2.0
"""Controller that answers slowly (M6)."""
from __future__ import annotations

import functools
import math
import time

from attack import Scene, enter
from records import holes, wrong_readings
from rig import hold, ramp

SECONDS = 120  # seconds that need a chamber reading
EXCUSED = 2.0  # s after a row in which a standstill is excused
GOOD = {0.05: 120, 0.1: 118, 0.15: 110}


def slow_answers(scene: Scene, *, answer_time: float) -> None:
    """Each answer takes long while the profile ramps. Nearly every second has its reading of the chamber."""
    seconds = SECONDS if scene.long else 45
    laboratory = scene.laboratory(air=30.0)
    laboratory.chamber.answer_time = answer_time
    run = scene.start(scene.profile(hold(30.0, 1), ramp(80.0, 6.0), hold(80.0, 3600)), scene.rig(laboratory))
    scene.need(run.wait_acknowledged(0), f"the run did not begin: {run.errors()[-600:]}")
    time.sleep(seconds + 2)
    set_point = laboratory.chamber.set_point
    scene.expect(not run.ended(), f"the run ended with {run.process.poll()}")
    scene.stop(run)
    record = scene.read(run.record)
    rows = [row for slot, row in record.rows.items() if 1 <= slot <= seconds]
    counted_rows = [row for row in rows if not scene.standstill.touches(row["utc_ns"] / 1e9, EXCUSED)]
    needed = math.floor(GOOD[answer_time] * len(counted_rows) / SECONDS)
    good = sum(row["chamber_air_c"] is not None for row in counted_rows)
    executed = sum(row["state"] == "execute" for row in rows)
    scene.fact(f"{good} of {len(counted_rows)} s with a reading")
    scene.need(len(counted_rows) >= seconds / 2, f"the machine stalled in {seconds - len(counted_rows)} of {seconds} s")
    scene.expect(good >= needed, f"{good} of {len(counted_rows)} s have a reading of the chamber, expected {needed}")
    scene.expect(executed >= needed, f"the profile continued in {executed} of {seconds} s, expected {needed}")
    scene.expect(set_point > 30 + (executed - 5) * 0.1 * 0.75, f"the ramp is only at {set_point:g} °C")
    scene.expect(not holes(record), f"holes: {holes(record)}")
    wrong = wrong_readings(record, laboratory)
    scene.expect(not wrong, f"{len(wrong)} wrong or old readings: " + "; ".join(wrong[:4]))


def checked(scene: Scene, *, answer_time: float, warns: bool) -> None:
    """check --connect reports whether a second suffices for such a slow controller."""
    laboratory = scene.laboratory(air=30.0)
    laboratory.chamber.answer_time = answer_time
    ran = scene.programs.finish([scene.programs.gyrotherm, "check", "--rig", scene.rig(laboratory), "--connect"], 60)
    scene.expect(ran.code == 0, f"exit {ran.code}: {ran.text[-400:]}")
    warned = [line for line in ran.text.splitlines() if "warning" in line.lower()]
    if warns:
        scene.expect(any("second" in line for line in warned), f"no warning that a second does not suffice: {ran.text}")
    else:
        scene.expect(not warned, f"a warning without a cause: {warned}")


for _time in GOOD:
    enter("slow", f"answers_of_{_time * 1000:.0f}_ms", functools.partial(slow_answers, answer_time=_time),
          alone=True, long_only=_time == 0.05)
enter("slow", "check_of_answers_of_50_ms", functools.partial(checked, answer_time=0.05, warns=False))
enter("slow", "check_of_answers_of_300_ms", functools.partial(checked, answer_time=0.3, warns=True))
