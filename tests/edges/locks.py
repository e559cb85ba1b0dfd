# SPDX-License-Identifier: Apache-2.0
"""Locks of a chamber under attack by other users, folders and names (H2, P17, M10). No user keeps a chamber hot, and no
two programs drive it.

Each attack has a /run and a /tmp of its own, so that it meets nothing of this machine's.
"""
from __future__ import annotations

import functools
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from typing import Any, Callable, Iterable

from attack import GUARD_LIMIT, START_LIMIT, Failed, Scene, Skipped, as_root, enter, with_tools
from laboratory import Laboratory
from program import NOBODY, Ran, Run, kill, process_state, until
from rig import SAFE, Rig, hold

LOCK_PLACES = ("/run/lock/gyrotherm", "/run/gyrotherm", "/run/user/*/gyrotherm", "/tmp/gyrotherm*")
FOLDER = pathlib.Path("/run/lock/gyrotherm")

# Mounts a fresh /run and /tmp over the machine's, keeps the folder $1, and continues with the following script.
FRESH = """set -e
folder=$1; shift
mount -t tmpfs -o mode=755 fresh /run
mkdir -m 1777 /run/lock
mkdir /run/keep
mount --bind "$folder" /run/keep
mount -t tmpfs -o mode=1777 fresh /tmp
mkdir -p "$folder"
mount --bind /run/keep "$folder"
exec "$@"
"""


class Machine:
    """A clean machine with one chamber, a first program with a profile at 60 °C, and a second one at 45 °C."""

    def __init__(self, scene: Scene) -> None:
        as_root()
        with_tools("unshare", "setpriv", "flock", "mount", "setsid")
        if os.readlink("/proc/self/ns/mnt") == os.readlink(f"/proc/{os.getppid()}/ns/mnt"):
            raise Skipped("needs a mount namespace of its own")
        self.scene = scene
        scene.copy_programs()
        mounted = subprocess.run(["sh", "-c", FRESH, "sh", str(scene.folder), "true"], check=False, timeout=30)
        if mounted.returncode != 0:
            raise Skipped("a /run and a /tmp of its own cannot be mounted here")
        self.laboratory: Laboratory = scene.laboratory(host="0.0.0.0")
        self.hot = scene.profile(hold(60.0, 3600))
        self.other = scene.profile(hold(45.0, 3600), name="other.toml")
        self.attackers: list[subprocess.Popen[bytes]] = []
        self.stolen: set[str] = set()  # names taken before the guard acts

    def rig(self, host: str = "127.0.0.1", name: str = "rig.toml") -> pathlib.Path:
        lines = dict(self.laboratory.lines)
        lines["chamber"] = lines["chamber"].replace("127.0.0.1", host)
        return Rig(lines).write(self.scene.folder, name)

    def first(self, host: str = "127.0.0.1", **how: Any) -> Run:
        self.laboratory.chamber.begin_at(60.0)
        return self.scene.start(self.hot, self.rig(host), **how)

    def second(self, host: str = "127.0.0.1", before: tuple[str, ...] = (), record: pathlib.Path | None = None,
               **environment: str) -> Ran:
        """Returns the result of a second program, within 15 s."""
        record = record or self.scene.folder / "second.db"
        return self.scene.programs.finish([self.scene.programs.gyrotherm, "run", self.other, "--rig",
                                           self.rig(host, "second.toml"), "--out", record, "--accept-air"], 15, before,
                                          **environment)

    def as_nobody(self, *command: str) -> None:
        """Runs a command as user nobody. It may fail."""
        subprocess.run([*NOBODY, *command], check=False, timeout=20, stdin=subprocess.DEVNULL,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def nobody_begins(self, *command: str) -> subprocess.Popen[bytes]:
        """Starts a command as user nobody that runs until the end of the attack."""
        process = subprocess.Popen([*NOBODY, *command], env=self.scene.programs.environment(), start_new_session=True,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.attackers.append(process)
        return process

    def lock_files(self) -> list[pathlib.Path]:
        found = []
        for pattern in LOCK_PLACES:
            for folder in pathlib.Path("/").glob(pattern[1:]):
                found += [p for p in (folder.iterdir() if folder.is_dir() else [folder]) if p.is_file()]
        return [p for p in found if not p.is_relative_to(self.scene.folder)]

    def names(self) -> set[str]:
        """Returns the abstract names with the chamber's port at which streams listen. Each socket type has names of its
        own, and parallel attacks have theirs."""
        listening, stream = "00010000", "0001"
        port = self.laboratory.lines["chamber"].rpartition(":")[2]
        rows = [line.split() for line in pathlib.Path("/proc/net/unix").read_text(errors="replace").splitlines()[1:]]
        return {row[7][1:] for row in rows
                if len(row) > 7 and row[3:5] == [listening, stream] and row[7].startswith("@") and port in row[7]}

    def learn(self) -> tuple[list[pathlib.Path], list[str]]:
        """Returns the names that the program locks and listens at. Lets it run for a moment, then removes
        everything."""
        run = self.first(record="learnt.db", name="learnt")
        self.scene.need(run.wait_acknowledged(0, START_LIMIT), f"it did not begin: {run.errors()[-600:]}")
        files, names = self.lock_files(), sorted(self.names())
        run.signal(signal.SIGINT)
        self.scene.need(run.wait() == 5, "it did not end")
        for file in files:
            file.unlink(missing_ok=True)
            if file.parent.name.startswith("gyrotherm"):
                shutil.rmtree(file.parent, ignore_errors=True)
        return files, names


def expect_reported(scene: Scene, text: str, user: str, pid: int) -> None:
    """Expects that a refused program reports the owner of the chamber."""
    scene.expect(re.search(rf"\b{pid}\b", text), f"the message does not name the owner's process {pid}: {text[-400:]}")
    scene.expect(user in text, f"the message does not name the owner's user {user}: {text[-400:]}")


def expect_refused(machine: Machine, ran: Ran, holder: Run, user: str = "root") -> None:
    """Expects the second program to end with 3, to name the first, and to send nothing."""
    scene = machine.scene
    sent = {change.value for change in machine.laboratory.chamber.changes if change.value not in (60.0, SAFE)}
    scene.expect(not sent, f"two programs drive the chamber: the second sent {len(sent)} other set points")
    if scene.expect(ran.code == 3, f"the second program ended with {ran.code} and not with 3: {ran.text[-400:]}"):
        expect_reported(scene, ran.text, user, holder.pid)


def expect_safe_death(machine: Machine, run: Run) -> None:
    """Kills the first program and expects a safe chamber within 20 s."""
    guards = until(run.guards) or [] if machine.stolen else []
    for pid in guards:
        kill(pid, signal.SIGSTOP)
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    if machine.stolen:
        run.wait()
        machine.scene.need(bool(until(lambda: machine.stolen <= machine.names())), "the attackers were too slow")
    for pid in guards:
        kill(pid, signal.SIGCONT)
    machine.scene.expect_safe(machine.laboratory, died, GUARD_LIMIT, "the program killed")
    machine.scene.expect_held(machine.laboratory, 1)


def need_begun(machine: Machine, run: Run) -> None:
    """Requires that the first program drives the chamber. Another user must not prevent it from starting."""
    scene = machine.scene
    scene.need(run.wait_acknowledged(2, 30), f"the first program did not begin: {run.errors()[-400:]}")
    scene.need(abs(machine.laboratory.chamber.set_point - 60) < 0.01, "the chamber was not sent to 60 °C")


Preparation = Callable[[Machine, list[pathlib.Path], list[str]], None]


def attacked(scene: Scene, *, before: Preparation | None = None,
             during: Callable[[Machine], None] | None = None) -> None:
    """Another user prepares or attacks the locks. A second program is refused, and a killed one leaves a safe
    chamber."""
    machine = Machine(scene)
    if before:
        before(machine, *machine.learn())
    run = machine.first()
    need_begun(machine, run)
    if during:
        during(machine)
    expect_refused(machine, machine.second(), run)
    scene.need(not run.ended(), f"the first program has ended: {run.process.poll()} {run.errors()[-300:]}")
    expect_safe_death(machine, run)


# Attacks by user nobody before the first program starts.

def folder_by_nobody(machine: Machine, files: list[pathlib.Path], names: list[str], *, mode: str) -> None:
    machine.as_nobody("mkdir", "-m", mode, str(FOLDER))
    machine.as_nobody("mkdir", "-m", mode, "/tmp/gyrotherm-lock")


def folder_as_link(machine: Machine, files: list[pathlib.Path], names: list[str]) -> None:
    machine.as_nobody("mkdir", "-m", "1777", "/tmp/elsewhere")
    machine.as_nobody("ln", "-s", "/tmp/elsewhere", str(FOLDER))


def files_by_nobody(machine: Machine, files: list[pathlib.Path], names: list[str], *, mode: str) -> None:
    """Creates the lock files as user nobody, in a folder like the program's own."""
    for file in files:
        os.makedirs(file.parent, exist_ok=True)
        file.parent.chmod(0o1777)
        machine.as_nobody("sh", "-c", f"touch '{file}'; chmod {mode} '{file}'")


def files_held_by_nobody(machine: Machine, files: list[pathlib.Path], names: list[str]) -> None:
    folder_by_nobody(machine, files, names, mode="1777")
    files_by_nobody(machine, files, names, mode="0666")
    for file in files:
        machine.nobody_begins("flock", str(file), "sleep", "600")
    time.sleep(0.5)


def files_as_links(machine: Machine, files: list[pathlib.Path], names: list[str]) -> None:
    folder_by_nobody(machine, files, names, mode="1777")
    for file in files:
        machine.as_nobody("ln", "-s", "/tmp/elsewhere", str(file))


def files_as_fifos(machine: Machine, files: list[pathlib.Path], names: list[str]) -> None:
    folder_by_nobody(machine, files, names, mode="1777")
    for file in files:
        machine.as_nobody("mkfifo", "-m", "0666", str(file))


def files_as_folders(machine: Machine, files: list[pathlib.Path], names: list[str]) -> None:
    folder_by_nobody(machine, files, names, mode="1777")
    for file in files:
        machine.as_nobody("mkdir", "-m", "0777", str(file))


SQUAT = """
import os, socket, sys, time
os.setgroups([])
os.setgid(65534)
os.setuid(65534)
kinds = (socket.SOCK_STREAM, socket.SOCK_SEQPACKET, socket.SOCK_DGRAM)
wanted, kept = [(name, kind) for name in sys.argv[1:] for kind in kinds], []
while wanted:
    for name, kind in list(wanted):
        try:
            own = socket.socket(socket.AF_UNIX, kind)
            own.bind(chr(0) + name)
            if kind != socket.SOCK_DGRAM:
                own.listen(128)
            kept.append(own)
            wanted.remove((name, kind))
        except OSError:
            pass
    time.sleep(0.0001)
time.sleep(600)
"""


def squat(machine: Machine, names: Iterable[str], interpreter: pathlib.Path = pathlib.Path(sys.executable)) -> None:
    """User nobody takes these names, or waits for them. Begins as root, because nobody may not have permission to run
    this Python."""
    environment = machine.scene.programs.environment({"PYTHONHOME": sys.base_prefix})
    machine.attackers.append(subprocess.Popen([interpreter, "-c", SQUAT, *names], env=environment,
                                              start_new_session=True, stdin=subprocess.DEVNULL,
                                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))


def names_by_nobody(machine: Machine, files: list[pathlib.Path], names: list[str]) -> None:
    if not names:
        machine.scene.fact("the program listens at no abstract name")
    squat(machine, names)
    taken = until(lambda: set(names) <= machine.names())
    machine.scene.need(bool(taken), "user nobody could not take the names")


# Attacks by user nobody while the program runs.

def start_lock_thieves(machine: Machine, number: int = 8) -> None:
    """Waits for the locks, to take them when the program dies."""
    for file in machine.lock_files():
        for _ in range(number):
            machine.nobody_begins("flock", str(file), "sleep", "600")
    time.sleep(0.5)


def removal(machine: Machine) -> None:
    for file in machine.lock_files():
        machine.as_nobody("rm", "-f", str(file))
        machine.as_nobody("mv", str(file.parent), f"{file.parent}-away")


def lies(machine: Machine) -> None:
    """Writes another owner into the lock files."""
    for file in machine.lock_files():
        machine.as_nobody("sh", "-c", f"printf 'gyrotherm-lock/1\\npid: 1\\nboot: x\\nrecord: y\\n' > '{file}'")


def start_reserved_name_thieves(machine: Machine) -> None:
    squat(machine, machine.names())
    time.sleep(0.5)


def start_name_thieves(machine: Machine) -> None:
    """Takes lock names with processes that have the program's name and are faster than its guard."""
    likeness = machine.scene.folder / "likeness" / "gyrotherm"
    likeness.parent.mkdir(mode=0o755)
    shutil.copy2(os.path.realpath(sys.executable), likeness)
    machine.stolen = machine.names()
    squat(machine, machine.stolen, likeness)
    time.sleep(0.5)
    machine.scene.need(machine.attackers[-1].poll() is None, "the process with the name of the program did not run")


def with_folder_of_nobody(then: Callable[[Machine], None]) -> dict[str, Any]:
    return {"before": functools.partial(folder_by_nobody, mode="0777"), "during": then}


PREPARED: dict[str, dict[str, Any]] = {
    "lock_folder_0777_by_nobody": {"before": functools.partial(folder_by_nobody, mode="0777")},
    "lock_folder_0755_by_nobody": {"before": functools.partial(folder_by_nobody, mode="0755")},
    "lock_folder_1777_by_nobody_and_removal": {"before": functools.partial(folder_by_nobody, mode="1777"),
                                               "during": removal},
    "lock_folder_0777_by_nobody_and_removal": with_folder_of_nobody(removal),
    "lock_folder_0777_by_nobody_and_thieves": with_folder_of_nobody(start_lock_thieves),
    "lock_folder_as_link": {"before": folder_as_link, "during": removal},
    "lock_files_0600_by_nobody": {"before": functools.partial(files_by_nobody, mode="0600")},
    "lock_files_0666_by_nobody": {"before": functools.partial(files_by_nobody, mode="0666"), "during": lies},
    "lock_files_as_links": {"before": files_as_links},
    "lock_files_as_fifos": {"before": files_as_fifos},
    "lock_files_as_folders": {"before": files_as_folders},
    "locks_held_by_nobody": {"before": files_held_by_nobody},
    "lock_names_by_nobody": {"before": names_by_nobody},
    "lock_thieves": {"during": start_lock_thieves},
    "lock_removal": {"during": removal},
    "lock_lies": {"during": lies},
    "lock_name_thieves": {"during": start_reserved_name_thieves},
    "lock_name_thieves_called_gyrotherm": {"during": start_name_thieves},
}

for _name, _what in PREPARED.items():
    enter("locks", _name, functools.partial(attacked, **_what), private_mounts=True)


def lock_thieves_and_make_safe(scene: Scene) -> None:
    """Program and guard are killed while user nobody waits for the locks. make-safe --kill, as systemd calls it, acts,
    and so does a resume."""
    machine = Machine(scene)
    run = machine.first()
    need_begun(machine, run)
    start_lock_thieves(machine)
    guards = until(run.guards) or []
    for pid in guards:
        kill(pid, signal.SIGSTOP)
    died = time.monotonic()
    run.signal(signal.SIGKILL)
    run.wait()
    for pid in guards:
        kill(pid)
    time.sleep(0.5)
    made = scene.programs.finish([scene.programs.make_safe, "--kill", run.record], 30)
    scene.expect(made.code == 0, f"make-safe --kill ended with {made.code}: {made.text}")
    scene.expect_safe(machine.laboratory, died, 40, "make-safe --kill")
    again = scene.resume(run)
    acknowledged = run.acknowledged()
    scene.expect(again.wait_acknowledged(acknowledged + 3, 30), f"no progress after resume: {again.errors()[-400:]}")


def second_in_another_mount_namespace(scene: Scene) -> None:
    """The second program has a /run and a /tmp of its own. It is refused."""
    machine = Machine(scene)
    run = machine.first()
    need_begun(machine, run)
    elsewhere = ("unshare", "--mount", "--propagation", "private", "sh", "-c", FRESH, "sh", str(scene.folder))
    expect_refused(machine, machine.second(before=elsewhere), run)
    expect_safe_death(machine, run)


def second_in_another_runtime_folder(scene: Scene) -> None:
    """/run/lock does not exist, and the two programs have different XDG_RUNTIME_DIR. The second is refused."""
    machine = Machine(scene)
    os.rmdir("/run/lock")
    for name in ("one", "two"):
        os.makedirs(f"/run/user/{name}", 0o700)
    run = machine.first(XDG_RUNTIME_DIR="/run/user/one")
    need_begun(machine, run)
    expect_refused(machine, machine.second(XDG_RUNTIME_DIR="/run/user/two"), run)
    expect_safe_death(machine, run)


def second_by_nobody(scene: Scene) -> None:
    """Another user's program wants the chamber. It is refused and names the owner."""
    machine = Machine(scene)
    run = machine.first()
    need_begun(machine, run)
    own = scene.folder / "of-nobody"
    own.mkdir()
    shutil.chown(own, "nobody")
    expect_refused(machine, machine.second(before=NOBODY, record=own / "second.db"), run)
    expect_safe_death(machine, run)


def first_by_nobody(scene: Scene) -> None:
    """Another authorised user's program owns the chamber. Root's is refused and names the owner."""
    machine = Machine(scene)
    groups = scene.folder / "group"
    groups.write_text(pathlib.Path("/etc/group").read_text(encoding="utf-8") + "\ndialout:x:20:nobody\n",
                      encoding="utf-8")
    subprocess.run(["mount", "--bind", groups, "/etc/group"], check=True, timeout=20)
    shutil.chown(scene.folder, "nobody")
    run = machine.first(before=NOBODY)
    scene.need(run.wait_acknowledged(2, 30), f"the run of user nobody did not begin: {run.errors()[-400:]}")
    expect_refused(machine, machine.second(), run, user="nobody")
    expect_safe_death(machine, run)


def host_address() -> str:
    """Returns the machine's own address. No packet is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
            return str(probe.getsockname()[0])
        except OSError as error:
            raise Failed(f"this machine has no address: {error}") from error


def second_by_another_address(scene: Scene, *, first: str, second: str) -> None:
    """One chamber under two addresses of this machine. The second program is refused."""
    machine = Machine(scene)
    first, second = (host_address() if host == "own" else host for host in (first, second))
    run = machine.first(first)
    need_begun(machine, run)
    ran = machine.second(second)
    if second == "localhost" and ran.code == 4:
        scene.fact("a host name is refused")
    else:
        expect_refused(machine, ran, run)
    expect_safe_death(machine, run)


def foreign_safe_state_file(scene: Scene, *, option: str) -> None:
    """A safe-state file of another user names a process of root's and a hot set point. Root's make-safe kills no
    process and sends nothing."""
    machine = Machine(scene)
    run = machine.first()
    need_begun(machine, run)
    text = pathlib.Path(f"{run.record}.safe-state").read_text()
    scene.need(run.tell("abort")[0], "an abort was refused")
    scene.need(run.wait() == 6, "it did not end")
    victim = subprocess.Popen(["sleep", "300"], env=scene.programs.environment())
    started = pathlib.Path(f"/proc/{victim.pid}/stat").read_text().rpartition(")")[2].split()[19]
    evil = scene.folder / "evil.db"
    for key, value in (("record", f'"{evil}"'), ("safe_set_point_c", "179"), ("pid", str(victim.pid)),
                       ("started", started)):
        text = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text, count=1)
    orders = pathlib.Path(f"{evil}.safe-state")
    orders.write_text(text)
    shutil.chown(orders, "nobody")
    since = time.monotonic()
    made = scene.programs.finish([scene.programs.make_safe, *([option] if option else []), evil], 30)
    codes = (2, 4) if option == "--guard" else (4,)  # a guard first waits for orders
    scene.expect(made.code in codes, f"make-safe ended with {made.code}, expected 4: {made.text}")
    scene.expect(process_state(victim.pid) not in ("", "Z"), "make-safe has killed a process that another user named")
    victim.kill()
    victim.wait()
    sent = [write.value for write in machine.laboratory.chamber.writes(since)]
    scene.expect(not sent, f"make-safe has sent {sent} °C to the chamber")


for _carry_out in (lock_thieves_and_make_safe, second_in_another_mount_namespace, second_in_another_runtime_folder,
                   second_by_nobody, first_by_nobody):
    enter("locks", _carry_out.__name__, _carry_out, private_mounts=True)
for _first, _second in (("127.0.0.1", "0.0.0.0"), ("0.0.0.0", "127.0.0.1"), ("127.0.0.1", "localhost"),
                        ("127.0.0.1", "127.0.0.2"), ("127.0.0.1", "own"), ("own", "0.0.0.0")):
    enter("locks", f"address_{_first}_and_{_second}",
          functools.partial(second_by_another_address, first=_first, second=_second), private_mounts=True)
for _option in ("", "--kill", "--guard"):
    enter("locks", f"foreign_safe_state_file{_option.replace('--', '_')}",
          functools.partial(foreign_safe_state_file, option=_option), private_mounts=True)
