# SPDX-License-Identifier: Apache-2.0
"""Environment of an attack: laboratory, real program, folder, and list of failures."""
from __future__ import annotations

import functools
import os
import pathlib
import shutil
import signal
import time
from dataclasses import dataclass
from typing import Any, Callable, Iterator

import program
from laboratory import SET_POINT, Laboratory
from program import EVENT_LIMIT, Programs, Run, Terminal, until
from records import Record, holes, lost_seconds, read_record, wrong_readings
from rig import SAFE, Rig, hold, profile
from standstill import Standstill

GUARD_LIMIT = 20.0  # s; limit for a chamber without a program
START_LIMIT = 60.0  # s, on a busy machine


class Failed(Exception):
    """Ends the attack because a precondition did not occur."""


class Skipped(Exception):
    """Raised with the reason why the attack is impossible on this machine."""


@dataclass(frozen=True)
class Attack:
    name: str
    group: str
    carry_out: Callable[["Scene"], None]
    doc: str
    limit: float  # s; a longer attack has hung
    long_only: bool
    private_mounts: bool
    alone: bool  # needs the whole machine: counts as three


ATTACKS: dict[str, Attack] = {}


def enter(group: str, name: str, carry_out: Callable[["Scene"], None], *, limit: float = 180, long_only: bool = False,
          private_mounts: bool = False, alone: bool = False) -> None:
    """Registers an attack."""
    assert name not in ATTACKS, name
    inner = carry_out.func if isinstance(carry_out, functools.partial) else carry_out
    ATTACKS[name] = Attack(name, group, carry_out, (inner.__doc__ or "").strip(), limit, long_only, private_mounts,
                          alone)


def attack(group: str, **how: Any) -> Callable[[Callable[["Scene"], None]], Callable[["Scene"], None]]:
    """Returns a decorator that registers a function as an attack with the function's name."""
    def add(function: Callable[["Scene"], None]) -> Callable[["Scene"], None]:
        enter(group, function.__name__, function, **how)
        return function
    return add


class Scene:
    """Folder, instruments and programs of one attack. close() ends all of them."""

    def __init__(self, gyrotherm: pathlib.Path, folder: pathlib.Path, long: bool, hanging_disk: str = "") -> None:
        self.folder = folder
        self.long = long
        self.programs = Programs(gyrotherm, folder, hanging_disk)
        self.failures: list[str] = []
        self.facts: list[str] = []
        self.laboratories: list[Laboratory] = []
        self.runs: list[Run] = []
        self.closing: list[Callable[[], None]] = []
        self.copies = 0
        self.standstill = Standstill()

    # Checks.

    def expect(self, holds: Any, what: str) -> bool:
        """Records a failure unless the condition holds, and continues."""
        if not holds:
            self.failures.append(what)
        return bool(holds)

    def need(self, holds: Any, what: str) -> None:
        """Ends the attack unless the condition holds."""
        if not holds:
            raise Failed(what)

    def fact(self, text: str) -> None:
        """Adds a line to the verdict."""
        self.facts.append(text)

    # Setup.

    def laboratory(self, link: str = "tcp", *, host: str = "127.0.0.1", seed: int = 1, air: float = 60.0) -> Laboratory:
        """Returns instruments with the chamber at `air` and switched off."""
        laboratory = Laboratory(link, host, seed)
        self.laboratories.append(laboratory)
        laboratory.chamber.begin_at(air)
        return laboratory

    def rig(self, laboratory: Laboratory, name: str = "rig.toml", **what: Any) -> pathlib.Path:
        framing = "rtu_over_tcp" if laboratory.link == "rtu_over_tcp" else ""
        return Rig(laboratory.lines, framing=framing, **what).write(self.folder, name)

    def profile(self, *segments: str, name: str = "profile.toml") -> pathlib.Path:
        path = self.folder / name
        path.write_text(profile(*segments), encoding="utf-8")
        return path

    def start(self, profile: pathlib.Path, rig: pathlib.Path, record: str = "run.db", *, json: bool = True,
              **how: Any) -> Run:
        """Starts `gyrotherm run`. Its output files are next to the record."""
        path = self.folder / record
        options = ["--json"] if json else []
        # The thermometers of the laboratory do not follow its chamber.
        command = ["run", profile, "--rig", rig, "--out", path, "--accept-air", *options]
        run = program.start(self.programs, command, path,
                            **{"name": path.stem} | how)
        self.runs.append(run)
        return run

    def resume(self, run: Run, *options: str, **how: Any) -> Run:
        again = program.start(self.programs, ["resume", run.record, "--json", *options], run.record,
                              **{"name": f"{run.record.stem}-again{len(self.runs)}"} | how)
        self.runs.append(again)
        return again

    def hot_run(self, laboratory: Laboratory, *, at: float = 60.0, seconds: int = 3600,
                rig: dict[str, Any] | None = None, acknowledged: int = 2, **how: Any) -> Run:
        """Returns a run that holds the chamber at `at` and has acknowledged its first seconds."""
        laboratory.chamber.begin_at(at)
        run = self.start(self.profile(hold(at, seconds)), self.rig(laboratory, **(rig or {})), **how)
        self.need(run.wait_acknowledged(acknowledged, START_LIMIT),
                  f"the run did not begin: exit {run.process.poll()}, {run.errors()[-600:]}")
        self.need(abs(laboratory.chamber.set_point - at) < 0.01,
                  f"the chamber was not sent to {at} °C but {laboratory.chamber.set_point}")
        return run

    def copy_programs(self) -> pathlib.Path:
        """Starts copies of both programs from now on. Another user may run them, and a test may remove them. Returns
        the path of the make-safe copy."""
        folder = self.folder / "bin"
        folder.mkdir()
        for path in (self.programs.gyrotherm, self.programs.make_safe):
            shutil.copy2(path, folder / path.name)
        self.programs.gyrotherm = folder / self.programs.gyrotherm.name
        return self.programs.make_safe

    def terminal(self) -> Terminal:
        terminal = Terminal()
        self.closing.append(terminal.close)
        return terminal

    # Repeated checks.

    def safe_after(self, laboratory: Laboratory, since: float, within: float) -> float | None:
        """Waits until the safe set point is written after `since`. Returns the delay, or None after `within`."""
        def written() -> float | None:
            for write in laboratory.chamber.writes(since):
                if write.address == SET_POINT and abs(write.value - SAFE) < 0.01:
                    if abs(laboratory.chamber.set_point - SAFE) < 0.01:
                        return write.at
            return None
        at = until(written, max(0.0, since + within - time.monotonic()) + 0.1)
        return None if at is None or at - since > within else at - since

    def expect_safe(self, laboratory: Laboratory, since: float, within: float, what: str) -> bool:
        """Expects the safe set point within `within` of `since`, and that it is still held."""
        after = self.safe_after(laboratory, since, within)
        if after is not None:
            self.fact(f"safe after {after:.1f} s")
            return True
        chamber = laboratory.chamber
        late = [w.at - since for w in chamber.writes(since) if w.address == SET_POINT and abs(w.value - SAFE) < 0.01]
        detail = f"22 °C was written after {late[0]:.1f} s" if late else "22 °C was never written"
        return self.expect(False, f"{what}: not safe within {within:.0f} s ({detail}; now {chamber.set_point:g} °C)")

    def expect_held(self, laboratory: Laboratory, seconds: float) -> None:
        """Expects the safe set point to remain for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if not self.expect(abs(laboratory.chamber.set_point - SAFE) < 0.01,
                               f"the set point left 22 °C again: {laboratory.chamber.set_point:g} °C"):
                return
            time.sleep(0.1)

    def expect_ticks(self, laboratory: Laboratory, since: float, until_: float, longest: float = 2.5) -> None:
        """Expects requests to the chamber without a pause longer than `longest`."""
        times = [since, *laboratory.chamber.requests(since, until_), until_]
        rest = max(b - a for a, b in zip(times, times[1:]))
        self.fact(f"longest pause {rest:.1f} s")
        self.expect(rest <= longest, f"the ticks stopped: {rest:.1f} s without a request to the chamber, "
                                     f"{len(times) - 2} requests in {until_ - since:.0f} s")

    def read(self, record: pathlib.Path) -> Record:
        """Returns the record of a run that has ended."""
        self.copies += 1
        return read_record(record, self.folder / f"copy-{self.copies}")

    def expect_nothing_lost(self, record: Record, acknowledged: int) -> None:
        lost = lost_seconds(record, acknowledged)
        self.fact(f"{acknowledged + 1} s acknowledged")
        self.expect(not lost, f"{len(lost)} of {acknowledged + 1} acknowledged seconds are lost: {format_ranges(lost)}"
                              f" (damaged: {record.damaged or 'none'})")

    def expect_whole(self, record: Record, laboratory: Laboratory, acknowledged: int) -> None:
        """Expects every acknowledged second once, each with the readings of its own second."""
        self.expect_nothing_lost(record, acknowledged)
        broken = holes(record)
        self.expect(not broken, f"seconds that are neither a row nor a gap, or both: {format_ranges(broken)}")
        wrong = wrong_readings(record, laboratory)
        self.fact(f"{len(record.rows)} rows compared")
        self.expect(not wrong, f"{len(wrong)} wrong or old readings: " + "; ".join(wrong[:4]))

    def expect_guarded(self, run: Run) -> None:
        self.expect(until(run.guards), "there is no guard")

    def stop(self, run: Run, within: float = EVENT_LIMIT) -> int | None:
        """Ends a run in order, by SIGINT. Returns its exit code."""
        run.signal(signal.SIGINT)
        code = run.wait(within)
        if code is None:
            run.signal(signal.SIGKILL)
            self.expect(False, f"it did not end within {within:g} s after SIGINT")
        return code

    def close(self) -> None:
        for close in self.closing:
            close()
        program.sweep(self.folder)
        for run in self.runs:
            run.wait()
        for laboratory in self.laboratories:
            laboratory.close()


def as_root() -> None:
    if os.geteuid() != 0:
        raise Skipped("needs root")


def with_tools(*names: str) -> None:
    for name in names:
        if shutil.which(name) is None:
            raise Skipped(f"{name} is not installed")


def format_ranges(numbers: list[int]) -> str:
    """Formats numbers as "3…7, 9"."""
    return ", ".join(f"{a}" if a == b else f"{a}…{b}" for a, b in group_consecutive(numbers)) or "none"


def group_consecutive(numbers: list[int]) -> Iterator[tuple[int, int]]:
    """Groups consecutive numbers."""
    first = last = None
    for number in sorted(numbers):
        if last is not None and number == last + 1:
            last = number
            continue
        if first is not None and last is not None:
            yield first, last
        first = last = number
    if first is not None and last is not None:
        yield first, last
