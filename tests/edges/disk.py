# SPDX-License-Identifier: Apache-2.0
"""Disks that do not answer (H4): a library blocks every sync, or the file system is frozen."""
from __future__ import annotations

import functools
import signal
import subprocess
import time
from typing import Any

from attack import GUARD_LIMIT, START_LIMIT, Scene, Skipped, as_root, attack, enter, with_tools
from laboratory import Laboratory
from program import Run
from rig import hold

LIMIT_REACTION_S = 5.0  # s; limit for a chamber outside its limits


class HangingDisk:
    """Run whose syncs, and those of its guard, block while a file exists."""

    def __init__(self, scene: Scene) -> None:
        if not scene.programs.hanging_disk:
            raise Skipped("no library: --hanging-disk")
        self.file = scene.folder / "hangs"
        self.environment = {"LD_PRELOAD": scene.programs.hanging_disk, "GYROTHERM_HANG": str(self.file),
                            "ASAN_OPTIONS": "verify_asan_link_order=0"}
        self.folder = scene.folder

    def hang(self) -> None:
        self.file.touch()

    def answer(self) -> None:
        self.file.unlink(missing_ok=True)


class FrozenDisk:
    """Separate file system that is frozen. A process that writes to it cannot be killed."""

    def __init__(self, scene: Scene) -> None:
        as_root()
        with_tools("mkfs.ext4", "fsfreeze", "mount")
        image, self.folder = scene.folder / "disk.img", scene.folder / "disk"
        self.environment: dict[str, str] = {}
        image.write_bytes(b"")
        subprocess.run(["truncate", "-s", "32M", image], check=True)
        subprocess.run(["mkfs.ext4", "-q", image], check=True)
        self.folder.mkdir()
        if subprocess.run(["mount", "-o", "loop", image, self.folder], check=False).returncode != 0:
            raise Skipped("a loop device cannot be mounted here")
        scene.closing.append(self.close)

    def hang(self) -> None:
        subprocess.run(["fsfreeze", "-f", self.folder], check=True, timeout=30)

    def answer(self) -> None:
        subprocess.run(["fsfreeze", "-u", self.folder], check=False, timeout=30, stderr=subprocess.DEVNULL)

    def close(self) -> None:
        self.answer()
        time.sleep(0.5)


Disk = HangingDisk | FrozenDisk


def begin(scene: Scene, laboratory: Laboratory, disk: Disk, record: str) -> Run:
    return scene.hot_run(laboratory, record=str(disk.folder / record), **disk.environment)


def goes_on(scene: Scene, *, kind: type[Disk]) -> None:
    """The disk blocks for a while. Ticks continue, limits hold, and nothing is lost."""
    laboratory, disk = scene.laboratory(), kind(scene)
    run = begin(scene, laboratory, disk, "run.db")
    disk.hang()
    hung = time.monotonic()
    time.sleep(60 if scene.long else 12)
    scene.expect_ticks(laboratory, hung, time.monotonic())
    beyond = time.monotonic()
    laboratory.chamber.shown_air = 120.0
    scene.expect_safe(laboratory, beyond, LIMIT_REACTION_S, "air outside its limit")
    laboratory.chamber.shown_air = None
    disk.answer()
    code = run.wait()
    scene.expect(code == 6, f"an interlock ends a run with 6, not {code}")
    scene.expect_whole(scene.read(run.record), laboratory, run.acknowledged())


def dies(scene: Scene, *, kind: type[Disk], number: int) -> None:
    """The program dies or is stopped while its disk blocks. The chamber is safe within 20 s."""
    disk = kind(scene)
    for repetition in range(5 if scene.long else 1):
        laboratory = scene.laboratory()
        run = begin(scene, laboratory, disk, f"run-{repetition}.db")
        disk.hang()
        time.sleep(3)
        died = time.monotonic()
        run.signal(number)
        scene.expect_safe(laboratory, died, GUARD_LIMIT, f"repetition {repetition}: the program gone, its disk hanging")
        disk.answer()
        scene.expect_held(laboratory, 1)
        run.signal(signal.SIGKILL)
        run.wait()


def make_safe_by_hand(scene: Scene, *, kind: type[Disk]) -> None:
    """Program and guard die while the disk blocks. make-safe --kill still commands the chamber."""
    laboratory, disk = scene.laboratory(), kind(scene)
    run = begin(scene, laboratory, disk, "run.db")
    for guard in run.guards():
        subprocess.run(["kill", "-STOP", str(guard)], check=False)
    disk.hang()
    time.sleep(2)
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    made = subprocess.Popen([scene.programs.make_safe, "--kill", run.record], stdin=subprocess.DEVNULL,
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                            env=scene.programs.environment(disk.environment))
    scene.expect_safe(laboratory, died, GUARD_LIMIT, "make-safe --kill, the disk hanging")
    disk.answer()
    scene.expect(made.wait(20) == 0, f"make-safe ended with {made.returncode}")


def messages(scene: Scene, *, then: str) -> None:
    """Messages go to a frozen disk, the record to another one. Ticks and limits are unaffected, and a killed program
    leaves a safe chamber."""
    laboratory, disk = scene.laboratory(), FrozenDisk(scene)
    with open(disk.folder / "messages", "wb") as file:
        run = scene.hot_run(laboratory, stderr=file)
    disk.hang()
    hung = time.monotonic()
    laboratory.chamber.change_set_point(59.0)  # causes a message
    time.sleep(6)
    laboratory.chamber.change_set_point(60.0)
    time.sleep(10)
    scene.expect_ticks(laboratory, hung, time.monotonic())
    since = time.monotonic()
    if then == "killed":
        run.signal(signal.SIGKILL)
        scene.expect_safe(laboratory, since, GUARD_LIMIT, "killed, its messages on a frozen disk")
    else:
        laboratory.chamber.shown_air = 120.0
        scene.expect_safe(laboratory, since, LIMIT_REACTION_S, "air outside its limit")
        laboratory.chamber.shown_air = None
    disk.answer()
    code = run.wait()
    scene.expect(code == (-signal.SIGKILL if then == "killed" else 6), f"exit {code}")
    scene.expect_whole(scene.read(run.record), laboratory, run.acknowledged())


for _kind, _word in ((HangingDisk, "hanging"), (FrozenDisk, "frozen")):
    _how: dict[str, Any] = {"limit": 300, "long_only": _kind is FrozenDisk}
    enter("disk", f"{_word}_disk_goes_on", functools.partial(goes_on, kind=_kind), **_how)
    enter("disk", f"{_word}_disk_killed", functools.partial(dies, kind=_kind, number=signal.SIGKILL), **_how)
    enter("disk", f"{_word}_disk_stopped", functools.partial(dies, kind=_kind, number=signal.SIGSTOP), **_how)
    enter("disk", f"{_word}_disk_make_safe", functools.partial(make_safe_by_hand, kind=_kind), **_how)
for _then in ("beyond_limit", "killed"):
    enter("disk", f"messages_on_frozen_disk_{_then}", functools.partial(messages, then=_then), long_only=True)


@attack("disk", limit=120)
def hanging_disk_at_the_start(scene: Scene) -> None:
    """The disk blocks before the run has begun. Nothing is written to the chamber, or it is guarded."""
    laboratory, disk = scene.laboratory(), HangingDisk(scene)
    disk.hang()
    laboratory.chamber.begin_at(60.0, set_point=35.0)
    run = scene.start(scene.profile(hold(60.0, 3600)), scene.rig(laboratory), **disk.environment)
    time.sleep(6)
    moved = bool(laboratory.chamber.writes())
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    if moved:
        scene.expect_safe(laboratory, died, GUARD_LIMIT, "killed, its disk hanging since before the start")
    scene.fact("the chamber was moved" if moved else "the chamber was not moved")
    disk.answer()
    run.wait(START_LIMIT)
