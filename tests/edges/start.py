# SPDX-License-Identifier: Apache-2.0
"""Starts that fail: an unwritable record, a start that is interrupted (M4), limits of the controller that the profile
does not know (M9)."""
from __future__ import annotations

import functools
import os
import pathlib
import re
import signal
import sqlite3
import subprocess
import time
from typing import Any, Callable

from attack import GUARD_LIMIT, Scene, Skipped, as_root, attack, enter
from laboratory import AUTO, OFF, Laboratory
from program import NOBODY, Ran, until
from rig import SAFE, hold, ramp

FOUND_AT = 35.0  # °C, set point before the run


def try_to_start(scene: Scene, laboratory: Laboratory, record: pathlib.Path, before: tuple[str, ...] = ()) -> Ran:
    """Starts a run that should end by itself within seconds."""
    profile, rig = scene.profile(hold(60.0, 3600)), scene.rig(laboratory)
    return scene.programs.finish([scene.programs.gyrotherm, "run", profile, "--rig", rig, "--out", record,
                                  "--accept-air"], 30, before)


def expect_untouched(scene: Scene, laboratory: Laboratory, ran: Ran, *codes: int) -> None:
    """Expects that it ended with one of the codes, and that nothing was written to the chamber."""
    scene.expect(ran.code in codes, f"exit {ran.code}, expected {codes}: {ran.text[-400:]}")
    time.sleep(2)  # a guard would act now
    written = [(w.address, w.value) for w in laboratory.chamber.writes()]
    scene.expect(not written, f"written to the chamber before the record was known to work: {written[:6]}")


def dangling_link(folder: pathlib.Path) -> pathlib.Path:
    (folder / "run.db").symlink_to(folder / "nowhere" / "run.db")
    return folder / "run.db"


def dangling_link_beside(folder: pathlib.Path) -> pathlib.Path:
    (folder / "run.db").symlink_to(folder / "another.db")
    return folder / "run.db"


def folder_that_is_not_there(folder: pathlib.Path) -> pathlib.Path:
    return folder / "nowhere" / "run.db"


def record_that_exists(folder: pathlib.Path) -> pathlib.Path:
    (folder / "run.db").write_bytes(b"of somebody")
    return folder / "run.db"


def log_that_exists(folder: pathlib.Path) -> pathlib.Path:
    """A log of another record would be replayed into the new one."""
    (folder / "run.db-wal").mkdir()
    return folder / "run.db"


def small_disk(folder: pathlib.Path) -> pathlib.Path:
    as_root()
    disk = folder / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "small", disk], check=False).returncode != 0:
        raise Skipped("a tmpfs cannot be mounted here")
    return disk / "run.db"


def read_only_disk(folder: pathlib.Path) -> pathlib.Path:
    record = small_disk(folder)
    subprocess.run(["mount", "-o", "remount,ro", record.parent], check=True)
    return record


PLACES: dict[str, Callable[[pathlib.Path], pathlib.Path]] = {
    "record_is_a_dangling_link": dangling_link,
    "record_is_a_link_to_nothing_beside": dangling_link_beside,
    "record_in_no_folder": folder_that_is_not_there,
    "record_exists": record_that_exists,
    "record_with_an_impossible_log": log_that_exists,
    "record_on_a_disk_of_64_kB": small_disk,
    "record_on_a_read_only_disk": read_only_disk,
}


def bad_place(scene: Scene, *, place: Callable[[pathlib.Path], pathlib.Path]) -> None:
    """The record cannot be written. The run ends before anything is written to the chamber."""
    laboratory = scene.laboratory()
    laboratory.chamber.begin_at(60.0, FOUND_AT)
    record = place(scene.folder)
    expect_untouched(scene, laboratory, try_to_start(scene, laboratory, record), 4)


for _name, _place in PLACES.items():
    enter("start", _name, functools.partial(bad_place, place=_place))


@attack("start")
def record_in_a_read_only_folder(scene: Scene) -> None:
    """The folder belongs to another user. The run ends before anything is written to the chamber."""
    laboratory = scene.laboratory()
    laboratory.chamber.begin_at(60.0, FOUND_AT)
    folder = scene.folder / "read-only"
    folder.mkdir(mode=0o555)
    before = NOBODY if os.geteuid() == 0 else ()
    scene.copy_programs()
    expect_untouched(scene, laboratory, try_to_start(scene, laboratory, folder / "run.db", before), 4)


@attack("start")
def resume_of_an_edited_record(scene: Scene) -> None:
    """A record was edited after its program had died. Resume refuses it before anything is written to the chamber."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory, acknowledged=4)
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    scene.expect_safe(laboratory, died, GUARD_LIMIT, "the program killed")
    time.sleep(2)
    database = sqlite3.connect(run.record)
    database.execute("UPDATE sample SET chamber_air_c = 21.5 WHERE slot = 2")
    database.commit()
    database.close()
    since = time.monotonic()
    again = scene.programs.finish([scene.programs.gyrotherm, "resume", run.record, "--accept"], 30)
    scene.expect(again.code == 4, f"exit {again.code}, expected 4: {again.text[-400:]}")
    time.sleep(2)
    written = [(w.address, w.value) for w in laboratory.chamber.writes(since)]
    scene.expect(not written, f"resume of an edited record wrote to the chamber: {written[:6]}")


def broken_off(scene: Scene, *, breaks: Callable[[Laboratory], Any], mode: int) -> None:
    """The start fails after the chamber may have been moved. Set point and control mode are restored."""
    laboratory = scene.laboratory()
    laboratory.chamber.begin_at(60.0, FOUND_AT, mode)
    breaks(laboratory)
    ran = try_to_start(scene, laboratory, scene.folder / "run.db")
    scene.expect(ran.code in (3, 4), f"exit {ran.code}, expected 3: {ran.text[-400:]}")
    time.sleep(12)  # a guard would act now
    at, left = laboratory.chamber.set_point, laboratory.chamber.mode
    scene.expect(abs(at - FOUND_AT) < 0.01, f"the set point was {FOUND_AT:g} °C and is left at {at:g} °C")
    scene.expect(left == mode, f"the control mode was {mode} and is left at {left}")
    scene.expect(not pathlib.Path(f"{scene.folder}/run.db.safe-state").exists(), "the safe-state file is left")


def gyro_is_silent(laboratory: Laboratory) -> None:
    laboratory.gyro.silent = True


def gyro_is_gone(laboratory: Laboratory) -> None:
    laboratory.gyro.leave()


def mode_is_stuck(laboratory: Laboratory) -> None:
    laboratory.chamber.mode_stuck = True


for _breaks, _mode, _name in ((gyro_is_silent, OFF, "gyro_silent_at_the_start"),
                              (gyro_is_silent, AUTO, "gyro_silent_at_the_start_of_one_that_is_on"),
                              (gyro_is_gone, OFF, "gyro_gone_at_the_start"),
                              (mode_is_stuck, OFF, "mode_that_never_switches_on")):
    enter("start", _name, functools.partial(broken_off, breaks=_breaks, mode=_mode))


def silent_for_a_moment(scene: Scene, *, who: str) -> None:
    """An instrument does not answer for the first 0.7 s of a run. The run begins."""
    laboratory = scene.laboratory()
    instrument = getattr(laboratory, who)
    instrument.silent = True
    laboratory.chamber.begin_at(60)
    run = scene.start(scene.profile(hold(60.0, 3600)), scene.rig(laboratory))
    time.sleep(0.7)
    instrument.silent = False
    scene.expect(run.wait_acknowledged(2, 30), f"the run did not begin: exit {run.process.poll()}, {run.errors()}")
    scene.stop(run)


for _who in ("chamber", "thermometer_1", "thermometer_2", "gyro"):
    enter("start", f"{_who}_silent_for_a_moment", functools.partial(silent_for_a_moment, who=_who))


def names_the_limit(text: str) -> bool:
    return re.search(r"\b30\b", text) is not None and ("limit" in text or "controller" in text)


def limited(scene: Scene) -> tuple[Laboratory, pathlib.Path, pathlib.Path]:
    laboratory = scene.laboratory(air=25.0)
    laboratory.chamber.begin_at(25.0, 25.0)
    laboratory.chamber.set_limits(-75.0, 30.0)
    return laboratory, scene.profile(hold(25.0, 5), ramp(40.0, 5.0), hold(40.0, 60)), scene.rig(laboratory)


@attack("start")
def controller_limit_at_check(scene: Scene) -> None:
    """The controller accepts at most 30 °C and the profile requires 40 °C. check --connect reports it and ends with 3
    or 4."""
    laboratory, profile, rig = limited(scene)
    ran = scene.programs.finish([scene.programs.gyrotherm, "check", profile, "--rig", rig, "--connect"], 30)
    scene.expect(ran.code in (3, 4), f"exit {ran.code}, expected 3 or 4")
    scene.expect(names_the_limit(ran.text), f"it does not name the controller's limit of 30 °C: {ran.text[-600:]}")
    scene.expect(not laboratory.chamber.writes(), "check has written to the chamber")


@attack("start")
def controller_limit_at_run(scene: Scene) -> None:
    """The controller accepts at most 30 °C and the profile requires 40 °C. run refuses before the first write."""
    laboratory, profile, rig = limited(scene)
    ran = scene.programs.finish([scene.programs.gyrotherm, "run", profile, "--rig", rig, "--out",
                                 scene.folder / "run.db", "--accept-air"], 25)
    expect_untouched(scene, laboratory, ran, 3, 4)
    scene.expect(names_the_limit(ran.text), f"it does not name the controller's limit of 30 °C: {ran.text[-600:]}")


@attack("start")
def safe_set_point_beyond_the_controller(scene: Scene) -> None:
    """The controller would refuse the safe set point. run refuses before the first write."""
    laboratory = scene.laboratory()
    laboratory.chamber.begin_at(60.0, 60.0)
    laboratory.chamber.set_limits(SAFE + 8, 180.0)
    ran = try_to_start(scene, laboratory, scene.folder / "run.db")
    expect_untouched(scene, laboratory, ran, 3, 4)


def checked_with_a_silent(scene: Scene, *, instrument: str) -> None:
    """check --connect asks every instrument although one is silent, and names that one and its line."""
    laboratory = scene.laboratory()
    getattr(laboratory, instrument).silent = True
    ran = scene.programs.finish([scene.programs.gyrotherm, "check", "--rig", scene.rig(laboratory), "--connect"], 60)
    scene.expect(ran.code == 3, f"exit {ran.code}, expected 3: {ran.text[-400:]}")
    faults = [line for line in ran.text.splitlines() if "FAULT" in line]
    scene.expect(len(faults) == 1, f"{len(faults)} faults, expected one: {faults}")
    line = laboratory.lines[instrument]
    scene.expect(all(line in fault for fault in faults), f"{line} is not named: {faults}")
    for other in laboratory.lines:
        if other not in (instrument, "gyro"):
            answered = {"chamber": "F4T", "thermometer_1": "LSCI", "thermometer_2": "LSCI"}[other]
            scene.expect(answered in ran.text, f"{other} is not reported: {ran.text[-600:]}")


for _instrument in ("chamber", "thermometer_1", "thermometer_2", "gyro"):
    enter("start", f"check_with_a_silent_{_instrument}",
          functools.partial(checked_with_a_silent, instrument=_instrument))


@attack("start")
def a_start_says_what_it_waits_for(scene: Scene) -> None:
    """A run whose chamber is silent reports what it is connecting to while it waits."""
    laboratory = scene.laboratory()
    laboratory.chamber.silent = True
    began = time.monotonic()
    run = scene.start(scene.profile(hold(60.0, 10)), scene.rig(laboratory))
    reported = until(lambda: "connecting to" in run.errors() or run.ended())
    scene.fact(f"reported after {time.monotonic() - began:.1f} s")
    scene.expect(reported and not run.ended(), "it does not report what it waits for before it fails")
    scene.expect(laboratory.lines["chamber"] in run.errors(), f"without the line: {run.errors()[-300:]}")
    scene.expect(run.wait(60) not in (None, 0), "it did not end")
