# SPDX-License-Identifier: Apache-2.0
"""The real programs as processes: start them on files, pipes and terminals, send requests, kill and clean up."""
from __future__ import annotations

import contextlib
import fcntl
import json
import os
import pathlib
import signal
import socket
import struct
import subprocess
import tempfile
import termios
import threading
import time
from dataclasses import dataclass
from typing import Any, Callable, IO

MARK = "GYROTHERM_EDGES"  # environment mark of started processes: the attack's folder
TELL = "gyrotherm-tell/1"
FOREIGN_VARIABLES = ("NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID", "XDG_RUNTIME_DIR", "NO_COLOR")  # not passed on
EVENT_LIMIT = 60.0  # s; a later event counts as missing
TERMINAL = {"TERM": "xterm"}  # a chroot has no terminal type
NOBODY = ("setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups", "--")


def until(condition: Callable[[], Any], seconds: float = EVENT_LIMIT, every: float = 0.05) -> Any:
    """Waits until the condition holds. Returns its value, or its last value after `seconds`."""
    end = time.monotonic() + seconds
    while not (answer := condition()) and time.monotonic() < end:
        time.sleep(every)
    return answer


@dataclass(frozen=True)
class Ran:
    code: int  # −1000 if it did not end in time
    out: bytes
    err: bytes
    seconds: float

    @property
    def text(self) -> str:
        return (self.out + self.err).decode(errors="replace")


@dataclass
class Programs:
    """Paths of the programs, and their environment."""
    gyrotherm: pathlib.Path
    folder: pathlib.Path  # attack
    hanging_disk: str = ""  # library for LD_PRELOAD

    @property
    def make_safe(self) -> pathlib.Path:
        return self.gyrotherm.with_name("gyrotherm-make-safe")

    def environment(self, more: dict[str, str] | None = None) -> dict[str, str]:
        kept = {k: v for k, v in os.environ.items() if k not in FOREIGN_VARIABLES}
        return kept | TERMINAL | {MARK: str(self.folder)} | (more or {})

    def finish(self, command: list[Any], within: float = 60, before: tuple[str, ...] = (), **environment: str) -> Ran:
        """Runs a command to its end. Kills it after `within`."""
        began = time.monotonic()
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:  # a guard could keep a pipe open
            process = subprocess.Popen([*before, *map(str, command)], stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                       env=self.environment(environment), start_new_session=True)
            try:
                code = process.wait(within)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait(10)
                code = -1000
            out.seek(0)
            err.seek(0)
            return Ran(code, out.read(), err.read(), time.monotonic() - began)

    def status(self, record: pathlib.Path, within: float = 10) -> dict[str, Any]:
        """Returns the output of `status --json`, parsed; empty without output."""
        ran = self.finish([self.gyrotherm, "status", "--json", record], within)
        try:
            return json.loads(ran.out)
        except ValueError:
            return {}


@dataclass
class Run:
    """Program that executes a run."""
    programs: Programs
    process: subprocess.Popen[bytes]
    record: pathlib.Path
    out: pathlib.Path | None  # file of standard output, if any
    err: pathlib.Path | None
    terminal: "Terminal | None" = None
    unread: "Pipe | None" = None  # pipe of standard error, if any

    @property
    def pid(self) -> int:
        return self.process.pid

    def output(self) -> str:
        return self.out.read_text(errors="replace") if self.out else ""

    def errors(self) -> str:
        if self.terminal:
            return self.terminal.shown.decode(errors="replace")
        if self.unread:
            return self.unread.read_for(0.2).decode(errors="replace")
        return self.err.read_text(errors="replace") if self.err else ""

    def acknowledged(self) -> int:
        """Returns the last acknowledged second, or −1."""
        return max((line.get("acknowledged", -1) for line in json_lines(self.output())), default=-1)

    def wait_acknowledged(self, second: int, within: float = 60) -> bool:
        return bool(until(lambda: self.acknowledged() >= second or self.ended(), within)) and \
            self.acknowledged() >= second

    def ended(self) -> bool:
        return self.process.poll() is not None

    def wait(self, within: float = EVENT_LIMIT) -> int | None:
        """Returns its exit code, or −signal; None if it still lives after `within`."""
        try:
            return self.process.wait(within)
        except subprocess.TimeoutExpired:
            return None

    def signal(self, number: int) -> None:
        if not self.ended():
            self.process.send_signal(number)

    def tell(self, word: str, note: str = "") -> tuple[bool, str]:
        """Returns whether the request was done, and the answer."""
        return Speaker(self.record, word, note).answer()

    def status(self) -> dict[str, Any]:
        return self.programs.status(self.record)

    def guards(self) -> list[int]:
        return find_guards(self.record)


def json_lines(text: str) -> list[dict[str, Any]]:
    """Returns the complete lines that are JSON objects."""
    found = []
    for line in text.split("\n")[:-1]:
        try:
            value = json.loads(line)
        except ValueError:
            continue
        if isinstance(value, dict):
            found.append(value)
    return found


class Speaker:
    """Sends one request to a run through its socket. The answer may be read later."""

    def __init__(self, record: pathlib.Path, word: str, note: str = "", within: float = 10) -> None:
        self.trouble: OSError | None = None
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.socket.settimeout(within)
        folder = os.open(record.parent, os.O_PATH | os.O_DIRECTORY)
        try:
            self.socket.connect(f"/proc/self/fd/{folder}/{record.name}.socket")
            self.socket.send(f"{TELL} {word} {note}".encode())
        except OSError as error:
            self.trouble = error
        finally:
            os.close(folder)

    def answer(self) -> tuple[bool, str]:
        """Returns whether it was done, and the answer or the reason for its absence."""
        try:
            if self.trouble:
                raise self.trouble
            _, verdict, text = self.socket.recv(4096).decode().split(" ", 2)
        except (OSError, ValueError) as error:
            return False, f"no answer: {error}"
        finally:
            self.socket.close()
        return verdict == "done", text


ERASE = b"\r\x1b[J"  # begins each picture but the first


class Terminal:
    """A pseudo-terminal whose master is read only on request."""

    def __init__(self) -> None:
        self.master, self.slave = os.openpty()
        self.name = os.ttyname(self.slave)
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
        self.shown = bytearray()
        self._reader: threading.Thread | None = None

    def press(self, keys: bytes) -> None:
        os.write(self.master, keys)

    def fill(self) -> None:
        """Fills the buffer completely, as after minutes of an unread panel."""
        own = os.open(self.name, os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
        idle = 0
        while idle < 5:  # the kernel drains it with a delay
            try:
                os.write(own, b"." * 64)
                idle = 0
            except BlockingIOError:
                idle += 1
                time.sleep(0.02)
        os.close(own)

    def start_reading(self) -> None:
        """Reads and stores the output from now on."""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        try:
            while data := os.read(self.master, 4096):
                self.shown += data
        except OSError:
            pass

    def pictures(self, since: int = 0) -> list[bytes]:
        """Returns each different picture that was drawn completely in the bytes after `since`, in order."""
        drawn = bytes(self.shown[since:]).split(ERASE)[1:-1]  # the last one may be incomplete
        return list(dict.fromkeys(drawn))

    def let_go(self) -> None:
        """Closes this process's copy of the terminal's end."""
        if self.slave >= 0:
            os.close(self.slave)
            self.slave = -1

    def hang_up(self) -> None:
        """Closes the terminal of its program, like a lost ssh session. Not while it is read."""
        self.let_go()
        if self.master >= 0:
            os.close(self.master)
            self.master = -1

    close = hang_up


class Pipe:
    """A pipe that is read only on request."""

    SIZE = 4096

    def __init__(self) -> None:
        self.reads, self.writes = os.pipe()
        fcntl.fcntl(self.writes, fcntl.F_SETPIPE_SZ, self.SIZE)

    def fill(self, but: int = 0) -> int:
        """Fills it up to `but` bytes. Returns the number of bytes written."""
        own = os.open(f"/proc/self/fd/{self.writes}", os.O_WRONLY | os.O_NONBLOCK)
        written = 0
        try:
            while written < self.SIZE - but:
                written += os.write(own, b"\n" * min(64, self.SIZE - but - written))
        except BlockingIOError:
            pass
        finally:
            os.close(own)
        return written

    def let_go(self) -> None:
        if self.writes >= 0:
            os.close(self.writes)
            self.writes = -1

    def read_for(self, seconds: float) -> bytes:
        """Returns all content, including content that arrives within that time."""
        os.set_blocking(self.reads, False)
        end, data = time.monotonic() + seconds, bytearray()
        while time.monotonic() < end:
            try:
                piece = os.read(self.reads, 65536)
            except BlockingIOError:
                time.sleep(0.05)
                continue
            if not piece:
                break
            data += piece
        return bytes(data)

    def close(self) -> None:
        self.let_go()
        if self.reads >= 0:
            os.close(self.reads)
            self.reads = -1


def start(programs: Programs, command: list[Any], record: pathlib.Path, *, name: str = "run",
          terminal: Terminal | None = None, stdout: int | IO[bytes] | None = None,
          stderr: "int | IO[bytes] | Pipe | None" = None, before: tuple[str, ...] = (),
          program: pathlib.Path | None = None,
          **environment: str) -> Run:
    """Starts gyrotherm. By default its output goes into files of the attack's folder. A terminal becomes its
    controlling one, its standard input and its standard error."""
    out = programs.folder / f"{name}.out" if stdout is None else None
    err = programs.folder / f"{name}.err" if stderr is None and terminal is None else None
    opened = [open(path, "wb") for path in (out, err) if path]
    files = iter(opened)
    unread = stderr if isinstance(stderr, Pipe) else None
    arguments = [*before, str(program or programs.gyrotherm), *map(str, command)]
    if terminal:
        arguments = ["setsid", "-c", *arguments]
    process = subprocess.Popen(arguments, stdin=terminal.slave if terminal else subprocess.DEVNULL,
                               stdout=next(files) if out else stdout,
                               stderr=next(files) if err else terminal.slave if terminal and stderr is None else
                               unread.writes if unread else stderr,
                               env=programs.environment(environment), start_new_session=not terminal)
    for file in opened:
        file.close()
    if terminal:
        terminal.let_go()
    return Run(programs, process, record, out, err, terminal, unread)


def processes() -> dict[int, list[str]]:
    """Returns every visible process with its command line."""
    found = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                line = pathlib.Path(f"/proc/{entry}/cmdline").read_bytes()
            except OSError:
                continue
            found[int(entry)] = line.decode(errors="replace").split("\0")[:-1]
    return found


def find_guards(record: pathlib.Path) -> list[int]:
    """Returns the living guards of a run."""
    return [pid for pid, words in processes().items()
            if "--guard" in words and str(record) in words and process_state(pid) not in ("Z", "X", "")]


def process_state(pid: int) -> str:
    """Returns the state letter of proc(5); empty if the process does not exist."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (OSError, IndexError):
        return ""


def open_descriptors(pid: int) -> list[str]:
    """Returns the target of each descriptor of a process. Descriptors that it closes meanwhile are omitted."""
    found = []
    try:
        for number in os.listdir(f"/proc/{pid}/fd"):
            with contextlib.suppress(FileNotFoundError):
                found.append(os.readlink(f"/proc/{pid}/fd/{number}"))
    except OSError:
        pass  # it has ended
    return found


def kill(pid: int, number: int = signal.SIGKILL) -> None:
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


def find_started_processes(folder: pathlib.Path) -> list[int]:
    """Returns all processes that were started for the attack of this folder, and their descendants."""
    wanted, found = f"{MARK}={folder}".encode(), []
    for entry in os.listdir("/proc"):
        if entry.isdigit() and int(entry) != os.getpid():
            try:
                if wanted in pathlib.Path(f"/proc/{entry}/environ").read_bytes().split(b"\0"):
                    found.append(int(entry))
            except OSError:
                continue
    return found


def sweep(folder: pathlib.Path) -> None:
    """Ends the remains of an attack: thaws and unmounts its disks, kills its processes."""
    mounts = [line.split()[1] for line in pathlib.Path("/proc/mounts").read_text().splitlines()
              if line.split()[1].startswith(f"{folder}/")]
    for mount in mounts:
        subprocess.run(["fsfreeze", "-u", mount], stderr=subprocess.DEVNULL, check=False, timeout=30)
    end = time.monotonic() + 10
    while (left := find_started_processes(folder)) and time.monotonic() < end:
        for pid in left:
            kill(pid)
        time.sleep(0.05)
    for mount in reversed(mounts):
        subprocess.run(["umount", "-l", mount], check=False, timeout=30)
