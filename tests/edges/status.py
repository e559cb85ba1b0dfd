# SPDX-License-Identifier: Apache-2.0
"""Status of and requests to a run that does not answer; hostile texts and files; permissions (M8, others)."""
from __future__ import annotations

import datetime
import functools
import os
import pathlib
import signal
import stat
import subprocess
import threading
import time
import unicodedata

from attack import Scene, attack, enter
from program import Ran, Run, kill, until
from rig import hold

TELL_LIMIT = 7.0  # s, until `tell` ends
IMMEDIATELY_S = 3.0
EVIL = "\x1b[31mEVIL\x1b]0;title\x07\x9b2J"


def stop_with_its_guard(scene: Scene, run: Run) -> list[int]:
    """Stops the guard first, so that it does not end the program that is stopped next."""
    guards = until(run.guards) or []
    for pid in guards:
        kill(pid, signal.SIGSTOP)
    run.signal(signal.SIGSTOP)
    return guards


@attack("status")
def stopped_program_in_status(scene: Scene) -> None:
    """The program is stopped. `status` does not show it as a healthy run, but reports that it does not respond, and the
    time of the status."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    well = run.status()
    scene.expect(well.get("answers") is True, f"a healthy run does not answer: {well.get('answers')}")
    ago = well.get("written_ago_s")
    scene.expect(isinstance(ago, (int, float)) and -1 <= ago <= 3, f"written_ago_s of a healthy run: {ago}")
    guards = stop_with_its_guard(scene, run)
    silent = until(lambda: run.status().get("answers") is False, every=0.3)
    status = run.status()
    scene.expect(silent, f"status reports answers = {status.get('answers')}, state = {status.get('state')}")
    scene.expect((status.get("written_ago_s") or 0) > 1.5, f"written_ago_s = {status.get('written_ago_s')}")
    try:
        written = datetime.datetime.fromisoformat(str(status.get("written")).replace("Z", "+00:00"))
        off = abs((datetime.datetime.now(datetime.timezone.utc) - written).total_seconds())
        scene.expect(off < 30, f"written = {status.get('written')}, {off:.0f} s off")
    except (ValueError, TypeError) as error:
        scene.expect(False, f"written = {status.get('written')}: {error}")
    words = scene.programs.finish([scene.programs.gyrotherm, "status", run.record], 10).text
    scene.expect("respond" in words, f"its text does not state that the program does not respond: {words}")
    run.signal(signal.SIGCONT)
    for pid in guards:
        kill(pid, signal.SIGCONT)
    scene.expect(until(lambda: run.status().get("answers") is True, every=0.3), "status does not report the recovery")


@attack("status", limit=240)
def tell_a_stopped_program(scene: Scene) -> None:
    """The program is stopped, and a dozen requests wait. Each `tell` ends within about 6 s."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    stop_with_its_guard(scene, run)
    command = [scene.programs.gyrotherm, "tell", run.record, "note", "no answer expected"]
    ran: list[Ran] = []
    speakers = [threading.Thread(target=lambda: ran.append(scene.programs.finish(command, 25))) for _ in range(13)]
    for speaker in speakers:
        speaker.start()
    for speaker in speakers:
        speaker.join(40)
    longest = max(one.seconds for one in ran)
    scene.fact(f"longest {longest:.1f} s")
    still = sum(one.code == -1000 for one in ran)
    scene.expect(longest <= TELL_LIMIT, f"tell took {longest:.1f} s, {still} of {len(ran)} had to be killed")
    scene.expect(all(one.code not in (0, -1000) for one in ran), f"exit codes {sorted(one.code for one in ran)}")


@attack("status")
def note_that_is_no_text(scene: Scene) -> None:
    """A note that is not UTF-8 is refused, and every event of the record can be read as text."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory)
    for bytes_ in (b"\xff\xfe broken", b"cut \xc3", b"\xed\xa0\x80 half a pair", b"\xc0\xaf overlong"):
        command = [os.fsencode(scene.programs.gyrotherm), b"tell", os.fsencode(run.record), b"note", bytes_]
        ran = subprocess.run(command, capture_output=True, timeout=20, check=False,
                             env=scene.programs.environment(), stdin=subprocess.DEVNULL)
        scene.expect(ran.returncode in (2, 3), f"the note {bytes_!r} was not refused: exit {ran.returncode}")
    scene.expect(run.tell("note", "grüße, 22 °C")[0], "a note in good UTF-8 was refused")
    time.sleep(2)
    scene.stop(run)
    events = scene.read(run.record).events
    scene.expect(any("grüße" in text for _, _, text in events), "the good note is not in the record")


def escape_sequences(scene: Scene, *, identity: str) -> None:
    """An instrument sends escape sequences. None of them reaches the terminal unescaped."""
    laboratory = scene.laboratory()
    laboratory.thermometer_2.identity = identity
    rig, profile = scene.rig(laboratory), scene.profile(hold(60.0, 2))
    gyrotherm = scene.programs.gyrotherm
    for command in ([gyrotherm, "check", "--rig", rig, "--connect"],
                    [gyrotherm, "check", "--rig", rig, "--connect", "--json"],
                    [gyrotherm, "run", profile, "--rig", rig, "--out", scene.folder / "run.db", "-v", "--accept-air"]):
        ran = scene.programs.finish(command, 40)
        raw = [letter for letter in ran.text if unicodedata.category(letter) == "Cc" and letter not in "\n\t"]
        scene.expect(not raw, f"{command[1]}: control characters reach the output: {ran.text[-300:]!r}")
        scene.expect("EVIL" in ran.text, f"{command[1]} does not show the identity: {ran.text[-300:]!r}")


enter("status", "escape_sequences_of_an_instrument",
      functools.partial(escape_sequences, identity=f"LSCI,MODEL218E,{EVIL},042109"))
enter("status", "escape_sequences_of_a_foreign_instrument",
      functools.partial(escape_sequences, identity=f"OTHER,{EVIL}"))


@attack("status")
def fifos_beside_a_record(scene: Scene) -> None:
    """FIFOs have the names of the files that status and make-safe read. Both end immediately."""
    laboratory = scene.laboratory()
    laboratory.chamber.begin_at(60)
    run = scene.start(scene.profile(hold(60.0, 3)), scene.rig(laboratory))
    scene.need(run.wait(60) == 0, f"the run did not end well: {run.errors()[-400:]}")
    for ending in (".safe-state", ".made-safe", ".status"):
        path = pathlib.Path(f"{run.record}{ending}")
        path.unlink(missing_ok=True)
        os.mkfifo(path)
        for command in ([scene.programs.gyrotherm, "status", run.record],
                        [scene.programs.gyrotherm, "status", "--json", run.record],
                        [scene.programs.gyrotherm, "status", "--verify", run.record],
                        [scene.programs.make_safe, run.record], [scene.programs.make_safe, "--kill", run.record]):
            ran = scene.programs.finish(command, 8)
            scene.expect(ran.code != -1000 and ran.seconds < IMMEDIATELY_S,
                         f"{command[0].name} {command[1]} hangs on a FIFO as {ending}")
        path.unlink()


@attack("status")
def fifo_as_a_record(scene: Scene) -> None:
    """The record itself is a FIFO. Every command that reads records ends immediately."""
    record = scene.folder / "run.db"
    os.mkfifo(record)
    for words in (["status"], ["status", "--verify"], ["export"], ["resume"]):
        ran = scene.programs.finish([scene.programs.gyrotherm, *words, record], 8)
        scene.expect(ran.code not in (0, -1000) and ran.seconds < IMMEDIATELY_S, f"{words}: exit {ran.code}")


def mode_of_file(path: pathlib.Path) -> int | None:
    """Returns the permissions of a regular file; None for another file, or if it has been renamed meanwhile."""
    try:
        found = path.lstat().st_mode
    except FileNotFoundError:
        return None
    return stat.S_IMODE(found) if stat.S_ISREG(found) else None


def modes(scene: Scene, *, umask: str) -> None:
    """A record, its parts, its status and its manifest are writable by their owner and readable by their group,
    regardless of the umask."""
    laboratory = scene.laboratory(air=30.0)
    run = scene.start(scene.profile(hold(30.0, 14)), scene.rig(laboratory),
                      before=("sh", "-c", f'umask {umask}; exec "$@"', "sh"))
    scene.need(run.wait_acknowledged(2), f"the run did not begin: {run.errors()[-400:]}")
    run.record.with_name("run.db-wal").unlink()  # causes a second part
    scene.need(run.wait(60) == 0, f"the run did not end well: {run.errors()[-400:]}")
    again = scene.start(scene.profile(hold(30.0, 300)), scene.rig(laboratory), "another.db",
                        before=("sh", "-c", f'umask {umask}; exec "$@"', "sh"))
    scene.need(again.wait_acknowledged(2), f"the run did not begin: {again.errors()[-400:]}")
    found = {path.name: mode for name in ("run*", "another*") for path in scene.folder.glob(name)
             if path.suffix not in (".out", ".err", ".socket") and (mode := mode_of_file(path)) is not None}
    scene.fact(", ".join(f"{name} {mode:o}" for name, mode in sorted(found.items())))
    for name in ("run.db", "run.2.db", "run.db.sha256", "another.db", "another.db.status", "another.db.safe-state"):
        scene.expect(name in found, f"{name} is missing: {sorted(found)}")
    wrong = {name: f"{mode:04o}" for name, mode in found.items() if mode != 0o640}
    scene.expect(not wrong, f"not 0640: {wrong}")
    scene.stop(again)


enter("status", "modes_with_umask_000", functools.partial(modes, umask="000"))
enter("status", "modes_with_umask_022", functools.partial(modes, umask="022"), long_only=True)
