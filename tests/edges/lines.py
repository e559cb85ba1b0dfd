# SPDX-License-Identifier: Apache-2.0
"""Chamber lines that lose, delay and garble frames, or fail permanently (C2)."""
from __future__ import annotations

import functools
import pathlib
import random
import signal
import time
from typing import Any

from attack import GUARD_LIMIT, Scene, enter
from laboratory import OFF, Chamber, Laboratory
from records import Record
from rig import SAFE, hold, ramp

FASTEST = 30.0  # °C/min, limit of the rig
RESUME_DELAY = 3  # s
SUSPENDED_BY = 8  # lost readings in a row; suspend_after is 5 s

# Lines of the hostile examination: link, and fault of the line.
HOSTILE: dict[str, tuple[str, dict[str, Any]]] = {
    "rtu_every_other_lost": ("rtu_over_tcp", {"delay": 0.1, "every_other_lost": True}),
    "rtu_half_lost": ("rtu_over_tcp", {"delay": 0.1, "loss_of_requests": 0.3, "loss_of_answers": 0.3}),
    "rtu_late_0950_1200": ("rtu_over_tcp", {"late": (0.95, 1.2), "late_share": 0.5}),
    "rtu_late_0500_1500": ("rtu_over_tcp", {"late": (0.5, 1.5), "late_share": 1.0}),
    "rtu_late_0450": ("rtu_over_tcp", {"delay": 0.45}),
    "rtu_late_0700": ("rtu_over_tcp", {"delay": 0.7}),
    "rtu_noise": ("rtu", {"delay": 0.02, "noise_share": 0.5}),
    "rtu_mix_a": ("rtu", {"delay": 0.05, "loss_of_requests": 0.2, "noise_share": 0.2, "late": (0.3, 0.9),
                          "late_share": 0.2}),
    "rtu_mix_b": ("rtu_over_tcp", {"delay": 0.1, "loss_of_requests": 0.25, "loss_of_answers": 0.25, "noise_share": 0.2,
                                   "late": (0.9, 1.6), "late_share": 0.3}),
    "rtu_mix_c": ("rtu", {"delay": 0.1, "loss_of_answers": 0.4, "noise_share": 0.3, "late": (0.9, 1.6),
                          "late_share": 0.4}),
}


def drawn(seed: int) -> tuple[str, dict[str, Any]]:
    """Returns a randomly drawn bad line."""
    draw = random.Random(seed)
    earliest = draw.uniform(0.2, 1.2)
    return draw.choice(["rtu", "rtu_over_tcp", "rtu_over_tcp", "tcp"]), {
        "delay": draw.uniform(0.0, 0.15), "loss_of_requests": draw.choice([0.0, draw.uniform(0.1, 0.6)]),
        "loss_of_answers": draw.choice([0.0, draw.uniform(0.1, 0.5)]), "noise_share": draw.choice([0.0, 0.3]),
        "late": (earliest, earliest + draw.uniform(0.0, 1.0)), "late_share": draw.choice([0.0, draw.uniform(0.2, 1.0)])}


def jumps(chamber: Chamber) -> list[str]:
    """Describes the set points that differ from the previous one by more than the ramp limit allows, and from the air
    by more than 1 K."""
    own = [change for change in chamber.changes if change.by_program and change.value != SAFE]
    found = []
    for before, after in zip(own, own[1:]):
        allowed = FASTEST / 60 * min(max(after.at - before.at, 1.0) + 0.5, 6.0) + 0.02
        if abs(after.value - before.value) > allowed and abs(after.value - after.air) > 1.0:
            found.append(f"{before.value:.2f} → {after.value:.2f} °C in {after.at - before.at:.1f} s, "
                         f"air {after.air:.1f} °C")
    return found


def goes_on_too_long(record: Record) -> list[str]:
    """Returns stretches without a chamber reading in which the run was not suspended in time."""
    found, missing = [], 0
    for slot, row in sorted(record.rows.items()):
        missing = missing + 1 if row["chamber_air_c"] is None else 0
        if missing == SUSPENDED_BY and row["state"] == "execute":
            found.append(f"second {slot}: {missing} s without a reading of the chamber, but the run is not suspended")
    return found


def expect_no_harm(scene: Scene, laboratory: Laboratory, record: Record, acknowledged: int) -> None:
    scene.expect_whole(record, laboratory, acknowledged)
    for kind, found in (("jumps of the set point", jumps(laboratory.chamber)),
                        ("not suspended", goes_on_too_long(record))):
        scene.expect(not found, f"{kind}: " + "; ".join(found[:4]))


def bad_line(scene: Scene, *, link: str, faults: dict[str, Any]) -> None:
    """The chamber's line loses, delays or garbles frames for a while. The run is suspended while the chamber is not
    readable, continues by a ramp once the line is good, and is never killed."""
    laboratory = scene.laboratory(link, air=30.0)
    chamber = laboratory.chamber
    chamber.delay = 0.02
    rig = scene.rig(laboratory, fastest=FASTEST, limits={"resume_delay": f'"{RESUME_DELAY} s"', "clear_after": '"3 s"'})
    run = scene.start(scene.profile(hold(30.0, 1), ramp(60.0, 6.0), hold(60.0, 3600)), rig)
    scene.need(run.wait_acknowledged(3), f"the run did not begin: {run.errors()[-600:]}")
    chamber.break_as(**faults)
    time.sleep(120 if scene.long else 30)
    alive = scene.expect(not run.ended(), f"the run ended on the bad line with {run.process.poll()}, the chamber at "
                                          f"{chamber.set_point:g} °C")
    chamber.heal()
    chamber.delay = 0.02
    time.sleep(30 if scene.long else 20)
    alive = alive and scene.expect(not run.ended(), f"the run ended after the bad line with {run.process.poll()}")
    scene.expect(not pathlib.Path(f"{run.record}.made-safe").exists(), "the guard has acted on a living program")
    code = scene.stop(run)
    record = scene.read(run.record)
    states = list(record.states().values())
    scene.fact(f"{states.count('execute')} of {len(states)} s executed")
    if alive:
        scene.expect(code == 5, f"exit {code} after SIGINT, expected 5")
        scene.expect(states[-1:] == ["execute"], f"it did not continue when the line was good again: {states[-3:]}")
    expect_no_harm(scene, laboratory, record, run.acknowledged())


for _name, (_link, _faults) in HOSTILE.items():
    enter("lines", _name, functools.partial(bad_line, link=_link, faults=_faults), limit=300)
for _seed in range(1, 11):
    _link, _faults = drawn(_seed)
    enter("lines", f"drawn_{_seed}", functools.partial(bad_line, link=_link, faults=_faults), limit=300,
          long_only=_seed > 4)


LOST: dict[str, tuple[str, dict[str, Any]]] = {
    "tcp_silent": ("tcp", {"silent": True}),
    "tcp_gone": ("tcp", {"gone": True}),
    "tcp_busy": ("tcp", {"exception": 6}),
    "tcp_answers_lost": ("tcp", {"loss_of_answers": 1.0}),
    "rtu_over_tcp_silent": ("rtu_over_tcp", {"silent": True}),
    "rtu_over_tcp_gone": ("rtu_over_tcp", {"gone": True}),
    "rtu_over_tcp_answers_lost": ("rtu_over_tcp", {"loss_of_answers": 1.0}),
    "rtu_over_tcp_very_late": ("rtu_over_tcp", {"delay": 4.0}),
    "rtu_silent": ("rtu", {"silent": True}),
    "rtu_noise_alone": ("rtu", {"noise_share": 1.0, "loss_of_answers": 0.8}),
}


def lost_for_good(scene: Scene, *, link: str, faults: dict[str, Any]) -> None:
    """The line to a hot chamber fails for longer than chamber_lost. The run aborts, and the chamber is safe within 20 s
    after it answers again."""
    laboratory = scene.laboratory(link)
    run = scene.hot_run(laboratory, rig={"limits": {"chamber_lost": '"20 s"'}})
    broken = time.monotonic()
    laboratory.chamber.break_as(**faults)
    time.sleep(45)
    healed = time.monotonic()
    laboratory.chamber.heal()
    scene.expect_safe(laboratory, broken, healed - broken + GUARD_LIMIT, "the line lost for good and good again")
    code = run.wait()
    scene.expect(code == 6, f"exit {code} after chamber_lost, expected 6")
    scene.expect_held(laboratory, 2)
    record = scene.read(run.record)
    scene.expect(any("abort" in state for state in record.states().values()), "the record has no abort")
    scene.expect_whole(record, laboratory, run.acknowledged())


for _name, (_link, _faults) in LOST.items():
    enter("lines", f"lost_{_name}", functools.partial(lost_for_good, link=_link, faults=_faults), limit=240,
          long_only=_name not in ("tcp_silent", "rtu_over_tcp_silent", "rtu_over_tcp_gone", "rtu_silent"))


def killed_on_a_bad_line(scene: Scene, *, link: str, faults: dict[str, Any]) -> None:
    """The program is killed while the line is bad. Its guard continues to try, and the chamber is safe within 20 s
    after the line is good."""
    laboratory = scene.laboratory(link)
    run = scene.hot_run(laboratory)
    broken = time.monotonic()
    laboratory.chamber.break_as(**faults)
    time.sleep(4)
    run.signal(signal.SIGKILL)
    time.sleep(25)
    healed = time.monotonic()
    laboratory.chamber.heal()
    scene.expect_safe(laboratory, broken, healed - broken + GUARD_LIMIT, "killed on a bad line that is good again")
    scene.expect_held(laboratory, 2)


for _name in ("rtu_every_other_lost", "rtu_half_lost", "rtu_late_0500_1500", "rtu_mix_b", "rtu_mix_c"):
    _link, _faults = HOSTILE[_name]
    enter("lines", f"killed_on_{_name}", functools.partial(killed_on_a_bad_line, link=_link, faults=_faults),
          long_only=_name in ("rtu_mix_b", "rtu_late_0500_1500"))


def another_chamber(scene: Scene, *, link: str, serial: int, held_by: str) -> None:
    """The chamber loses power, and another one, or the same, answers at its address, switched off. The run is held,
    nothing is sent to the chamber, and it is not switched on."""
    laboratory = scene.laboratory(link)
    chamber = laboratory.chamber
    run = scene.hot_run(laboratory)
    chamber.break_as(silent=True)
    time.sleep(9)
    changed, acknowledged = time.monotonic(), run.acknowledged()
    chamber.exchange(serial, 25.0)
    chamber.heal()
    time.sleep(15)
    scene.expect(not chamber.writes(changed), f"it was sent {[(w.address, w.value) for w in chamber.writes(changed)]}")
    scene.expect(chamber.mode == OFF, "it was switched on")
    scene.stop(run)
    record = scene.read(run.record)
    airs = {slot: air for slot, air in record.airs().items() if slot > acknowledged and air is not None}
    if held_by == "another_instrument":
        scene.expect(not airs, f"its air is stored: {airs}")
        scene.expect(any("111" in text and str(serial) in text for _, _, text in record.events), "no alarm names both")
    scene.expect(any(text.startswith(held_by + " (hold)") for _, _, text in record.events), f"no alarm {held_by}")
    scene.expect("held" in record.states().values(), "the run was not held")


for _link in ("tcp", "rtu_over_tcp", "rtu"):
    for _name, _serial, _held_by in (("another_chamber", 222, "another_instrument"),
                                     ("power_off_hands", 111, "restarted_off")):
        enter("lines", f"{_name}_{_link}", functools.partial(another_chamber, link=_link, serial=_serial,
                                                             held_by=_held_by), limit=120, long_only=_link == "rtu")
