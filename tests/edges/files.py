# SPDX-License-Identifier: Apache-2.0
"""Attacks on a record's files while they are written (H3)."""
from __future__ import annotations

import contextlib
import functools
import os
import pathlib
import shutil
import signal
import sqlite3
import time
from dataclasses import dataclass
from typing import Callable

from attack import Scene, attack, enter
from program import Run, until
from records import part_path
from rig import hold

LENGTH = 22  # s, of the profile
AFTER = 5  # acknowledged seconds before the attack
REPORTED_WITHIN_S = 3.0  # s
GARBAGE = bytes(range(256)) * 8


@dataclass(frozen=True)
class Mishap:
    """Attack on the files, and the required reaction in addition to keeping all rows."""
    act: Callable[[pathlib.Path], None]
    is_reported: bool = True  # an alarm within seconds
    damaged: bool = False  # main file damaged: exit code not 0, no manifest


def log_of(record: pathlib.Path) -> pathlib.Path:
    return record.with_name(record.name + "-wal")


def away(path: pathlib.Path) -> pathlib.Path:
    return path.with_name(path.name + ".away")


def remove(*of: Callable[[pathlib.Path], pathlib.Path]) -> Callable[[pathlib.Path], None]:
    return lambda record: [path(record).unlink() for path in of] and None


def move(*of: Callable[[pathlib.Path], pathlib.Path]) -> Callable[[pathlib.Path], None]:
    return lambda record: [path(record).rename(away(path(record))) for path in of] and None


def main(record: pathlib.Path) -> pathlib.Path:
    return record


def copy_over(record: pathlib.Path) -> None:
    shutil.copyfile(record, away(record))
    away(record).rename(record)


def older_copy_over(record: pathlib.Path) -> None:
    older = record.with_name("older")
    older.rename(record)


def truncate(of: Callable[[pathlib.Path], pathlib.Path], share: float) -> Callable[[pathlib.Path], None]:
    return lambda record: os.truncate(of(record), int(of(record).stat().st_size * share))


def overwrite(of: Callable[[pathlib.Path], pathlib.Path], at: float, share: float = 0.0,
              data: bytes = GARBAGE) -> Callable[[pathlib.Path], None]:
    """Overwrites a share of the file with `data`, at a relative offset. The length is unchanged."""
    def act(record: pathlib.Path) -> None:
        with open(of(record), "r+b") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(int(size * at))
            file.write((data * (size // len(data) + 1))[:max(min(len(data), size - int(size * at)), int(size * share))])
    return act


def append(record: pathlib.Path) -> None:
    with open(record, "ab") as file:
        file.write(GARBAGE)


def replace_by_link(record: pathlib.Path) -> None:
    record.rename(away(record))
    record.symlink_to(away(record))


def replace_by_link_to_copy(record: pathlib.Path) -> None:
    shutil.copyfile(record, away(record))
    record.unlink()
    record.symlink_to(away(record))


def replace_by_fifo(record: pathlib.Path) -> None:
    record.rename(away(record))
    os.mkfifo(record)


def replace_by_folder(record: pathlib.Path) -> None:
    record.rename(away(record))
    record.mkdir()


def folder_away_and_back(record: pathlib.Path) -> None:
    folder = record.parent
    folder.rename(away(folder))
    time.sleep(2.5)
    away(folder).rename(folder)


def copy_if_there(path: str, to: str) -> None:
    """Returns a copy of a file unless it has taken its final name meanwhile."""
    with contextlib.suppress(FileNotFoundError):
        shutil.copy2(path, to)


def folder_replaced_by_copy(record: pathlib.Path) -> None:
    folder = record.parent
    shutil.copytree(folder, away(folder), ignore=shutil.ignore_patterns("*.socket"), copy_function=copy_if_there)
    folder.rename(folder.with_name("before"))
    away(folder).rename(folder)


def overwrite_with_its_times(record: pathlib.Path) -> None:
    before = record.stat()
    overwrite(main, 0.0, 1.0)(record)
    os.utime(record, ns=(before.st_atime_ns, before.st_mtime_ns))


def another_writes(record: pathlib.Path) -> None:
    database = sqlite3.connect(record, timeout=1)
    try:
        database.execute("CREATE TABLE foreign_table(x)")
        database.commit()
    except sqlite3.OperationalError:
        pass  # locked, as required
    finally:
        database.close()


def another_reads(record: pathlib.Path) -> None:
    for address in (f"file:{record}", f"file:{record}?mode=ro", f"file:{record}?immutable=1"):
        database = sqlite3.connect(address, timeout=1, uri=True)
        try:
            database.execute("SELECT count(*) FROM sample").fetchone()
        except sqlite3.OperationalError:
            pass
        finally:
            database.close()


ZEROS = bytes(4096)
MISHAPS: dict[str, Mishap] = {
    "rm_main": Mishap(remove(main), damaged=True),
    "rm_log": Mishap(remove(log_of)),
    "rm_both": Mishap(remove(main, log_of), damaged=True),
    "mv_main": Mishap(move(main), damaged=True),
    "mv_log": Mishap(move(log_of)),
    "mv_both": Mishap(move(main, log_of), damaged=True),
    "copy_renamed_over": Mishap(copy_over, damaged=True),
    "older_copy_renamed_over": Mishap(older_copy_over, damaged=True),
    "truncate_main": Mishap(truncate(main, 0.0), damaged=True),
    "truncate_main_to_half": Mishap(truncate(main, 0.5), damaged=True),
    "truncate_log": Mishap(truncate(log_of, 0.0)),
    "truncate_log_to_half": Mishap(truncate(log_of, 0.5)),
    "overwrite_beginning_of_main": Mishap(overwrite(main, 0.0), damaged=True),
    "overwrite_middle_of_main": Mishap(overwrite(main, 0.5), damaged=True),
    "overwrite_main": Mishap(overwrite(main, 0.0, 1.0), damaged=True),
    "zero_beginning_of_main": Mishap(overwrite(main, 0.0, data=ZEROS), damaged=True),
    "zero_main": Mishap(overwrite(main, 0.0, 1.0, ZEROS), damaged=True),
    "overwrite_beginning_of_log": Mishap(overwrite(log_of, 0.0)),
    "overwrite_middle_of_log": Mishap(overwrite(log_of, 0.5)),
    "zero_log": Mishap(overwrite(log_of, 0.0, 1.0, ZEROS)),
    "append_to_main": Mishap(append, damaged=True),
    "replace_main_by_link_to_itself": Mishap(replace_by_link, is_reported=False),
    "replace_main_by_link_to_copy": Mishap(replace_by_link_to_copy, damaged=True),
    "replace_main_by_fifo": Mishap(replace_by_fifo, damaged=True),
    "replace_main_by_folder": Mishap(replace_by_folder, damaged=True),
    "chmod_0_main": Mishap(lambda record: record.chmod(0), is_reported=False),
    "folder_away_and_back": Mishap(folder_away_and_back, is_reported=False),
    "another_program_writes": Mishap(another_writes, is_reported=False),
    "another_program_reads": Mishap(another_reads, is_reported=False),
    "touch_main": Mishap(lambda record: record.touch(), is_reported=False),
    "overwrite_main_with_its_times": Mishap(overwrite_with_its_times, damaged=True),
    "folder_replaced_by_copy": Mishap(folder_replaced_by_copy, damaged=True),
    "hard_link_to_main": Mishap(lambda record: os.link(record, away(record)), is_reported=False),
}
SHORT_KILLED = ("rm_main", "copy_renamed_over", "truncate_main", "overwrite_main", "rm_both", "truncate_log",
                "overwrite_main_with_its_times")


def begin(scene: Scene) -> Run:
    """Run in a folder of its own, and a copy of its main file from its first seconds."""
    laboratory = scene.laboratory(air=30.0)
    (scene.folder / "records").mkdir()
    run = scene.start(scene.profile(hold(30.0, LENGTH)), scene.rig(laboratory), "records/run.db")
    scene.need(run.wait_acknowledged(2), f"the run did not begin: {run.errors()[-600:]}")
    shutil.copyfile(run.record, run.record.with_name("older"))
    scene.need(run.wait_acknowledged(AFTER), f"the run did not continue: {run.errors()[-600:]}")
    return run


def alarm(scene: Scene, run: Run) -> bool:
    """Returns whether the run reports trouble with its record."""
    status = scene.programs.status(run.record, 3)
    return bool(status.get("faults_now") or status.get("storage_trouble") or status.get("parts"))


def in_the_events(scene: Scene, run: Run, attacked_at: int) -> bool:
    """Returns whether an event of the next seconds is a fault or an interlock."""
    events = scene.read(run.record).events
    return any(attacked_at <= slot <= attacked_at + REPORTED_WITHIN_S + 1 and kind in ("fault", "interlock")
               for slot, kind, _ in events)


def expect_reported(scene: Scene, run: Run, mishap: Mishap, since: float) -> bool:
    """Waits for the alarm in `status`. Returns whether it came or none is due."""
    if not mishap.is_reported:
        return True
    return bool(until(lambda: alarm(scene, run), since + REPORTED_WITHIN_S - time.monotonic(), 0.2))


def attacked(scene: Scene, *, mishap: Mishap) -> None:
    """Attacks the record's files while they are written. No acknowledged second is lost, the alarm comes within 3 s,
    and a run with a damaged main file neither ends with 0 nor leaves a manifest."""
    run = begin(scene)
    laboratory = scene.laboratories[0]
    attacked_at = run.acknowledged()
    since = time.monotonic()
    mishap.act(run.record)
    in_status = expect_reported(scene, run, mishap, since)
    code = run.wait(LENGTH + 30)
    scene.expect(code is not None, f"the run did not end within {LENGTH + 30} s")
    if code is None:
        run.signal(signal.SIGKILL)
        run.wait()
    scene.expect(in_status or in_the_events(scene, run, attacked_at),
                 f"no alarm within {REPORTED_WITHIN_S:g} s, neither in status nor in the record's events")
    manifest = run.record.with_name(run.record.name + ".sha256")
    if mishap.damaged:
        scene.expect(code != 0, "it ended with 0 although its main file is damaged")
        scene.expect(not manifest.exists(), "there is a manifest over a damaged record")
    record = scene.read(run.record)
    scene.fact(f"exit {code}")
    scene.expect(run.acknowledged() >= LENGTH - 2, f"only {run.acknowledged() + 1} s were acknowledged")
    scene.expect_whole(record, laboratory, run.acknowledged())


def attacked_and_killed(scene: Scene, *, mishap: Mishap) -> None:
    """Attacks the record's files and kills the program some seconds later. No acknowledged second is lost."""
    run = begin(scene)
    mishap.act(run.record)
    time.sleep(4)
    run.signal(signal.SIGKILL)
    run.wait()
    scene.expect_whole(scene.read(run.record), scene.laboratories[0], run.acknowledged())


for _name, _mishap in MISHAPS.items():
    enter("files", _name, functools.partial(attacked, mishap=_mishap))
    enter("files", f"{_name}_and_killed", functools.partial(attacked_and_killed, mishap=_mishap),
          long_only=_name not in SHORT_KILLED)


@attack("files")
def second_part_too(scene: Scene) -> None:
    """Removes the main file and then its continuation. Nothing is lost."""
    run = begin(scene)
    run.record.unlink()
    scene.need(until(lambda: part_path(run.record, 2).exists()), "there is no RUN.2.db")
    time.sleep(2)
    part_path(run.record, 2).unlink()
    code = run.wait(LENGTH + 30)
    scene.expect(code not in (0, None), f"exit {code}")
    scene.expect_whole(scene.read(run.record), scene.laboratories[0], run.acknowledged())
