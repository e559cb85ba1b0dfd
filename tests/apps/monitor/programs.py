# SPDX-License-Identifier: Apache-2.0
"""A monitor, a run on a virtual laboratory in real time, and their clients, for the tests of the page."""
from __future__ import annotations

import http.client
import json
import os
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import tempfile
import time
import unittest
from typing import Any, Callable

MONITOR = os.environ["GYROTHERM_MONITOR"]
GYROTHERM = os.environ["GYROTHERM_PROGRAM"]
SOURCE = pathlib.Path(os.environ["GYROTHERM_SOURCE"])
PASSWORD = "correct horse"
MOST_MEMORY_MB = float(os.environ.get("GYROTHERM_MEMORY_MB", "64"))


EVENT_LIMIT = 60.0  # s, after which an event that only a busy machine delays is taken for missing


def until(condition: Callable[[], Any], seconds: float = EVENT_LIMIT, every: float = 0.05) -> Any:
    """Waits until the condition holds. Returns its result, or its last result after `seconds`."""
    end = time.monotonic() + seconds
    while not (answer := condition()) and time.monotonic() < end:
        time.sleep(every)
    return answer


class Folder:
    def __enter__(self) -> pathlib.Path:
        self.path = pathlib.Path(tempfile.mkdtemp(prefix="gyrotherm-monitor-"))
        return self.path

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.path, ignore_errors=True)


def monitor_command(folder: pathlib.Path, *words: str, password: str | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [MONITOR, *words, "--state", str(folder / "state")],
        input=password,
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )


class Answer:
    def __init__(self, status: int, headers: dict[str, str], body: bytes) -> None:
        self.status, self.headers, self.body = status, headers, body

    @property
    def json(self) -> Any:
        return json.loads(self.body)


class Monitor:
    """The program on a free port. `again()` restarts it on the same port."""

    def __init__(
        self, folder: pathlib.Path, *options: str, runs: pathlib.Path | None = None, program: str = MONITOR
    ) -> None:
        self.folder, self.options, self.runs, self.program = folder, options, runs or folder, program
        self.port = 0
        self.process: subprocess.Popen[str] | None = None
        self.log = open(folder / "monitor.log", "a", encoding="utf-8")
        self.again()

    def again(self) -> None:
        self.process = subprocess.Popen(
            [
                self.program,
                "--folder",
                str(self.runs),
                "--listen",
                f"127.0.0.1:{self.port}",
                "--state",
                str(self.folder / "state"),
                *self.options,
            ],
            stdout=subprocess.PIPE,
            stderr=self.log,
            text=True,
        )
        line = self.process.stdout.readline()
        assert line, (self.folder / "monitor.log").read_text()
        self.port = int(re.search(r":(\d+)/", line)[1])

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def stop(self) -> int:
        self.process.terminate()
        code = self.process.wait(timeout=20)
        self.process.stdout.close()
        self.log.close()
        return code

    def ask(self, path: str, body: dict[str, str] | None = None, headers: dict[str, str] | None = None) -> Answer:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        try:
            sent = dict(headers or {})
            if body is not None:
                sent.setdefault("Content-Type", "application/json")
            connection.request(
                "GET" if body is None else "POST", path, None if body is None else json.dumps(body), sent
            )
            reply = connection.getresponse()
            return Answer(reply.status, {k.lower(): v for k, v in reply.getheaders()}, reply.read())
        finally:
            connection.close()

    def raw(self, text: bytes, seconds: float = 3) -> bytes:
        """Returns the answer to these bytes until the connection ends, or until nothing has arrived for `seconds`."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=EVENT_LIMIT) as line:
            reply = b""
            try:
                line.sendall(text)
                while piece := line.recv(65536):
                    reply += piece
                    line.settimeout(seconds)
            except (TimeoutError, ConnectionError):
                pass
            return reply

    @property
    def memory_mb(self) -> float:
        text = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+)", text)[1]) / 1024


class Browser:
    """A logged-in user with its cookie, its second secret, and the headers of a browser."""

    def __init__(self, monitor: Monitor, name: str, password: str = PASSWORD) -> None:
        self.monitor = monitor
        self.headers = {"Origin": f"http://127.0.0.1:{monitor.port}", "Sec-Fetch-Site": "same-origin"}
        answer = monitor.ask("/api/v1/login", {"name": name, "password": password}, self.headers)
        assert answer.status == 200, answer.body
        self.headers["Cookie"] = answer.headers["set-cookie"].split(";")[0]
        self.headers["X-CSRF-Token"] = monitor.ask("/api/v1/session", None, self.headers).json["csrf"]

    def ask(self, path: str, body: dict[str, str] | None = None, without: str = "", **others: str) -> Answer:
        headers = {k: v for k, v in self.headers.items() if k != without} | {
            k.replace("_", "-"): v for k, v in others.items()
        }
        return self.monitor.ask(path, body, headers)


def gyrotherm(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([GYROTHERM, *words], capture_output=True, text=True, timeout=120, check=False, cwd=SOURCE)


class RealTimeRun:
    """A run on instruments served by `simulate`, in real time."""

    def __init__(
        self,
        folder: pathlib.Path,
        profile: str = "tests/profiles/ten-minutes-warm.toml",
        name: str = "run",
        pace: str = "real",
        cables: Callable[[list[str]], list[str]] = lambda ports: ports,
        rig_end: str = "",
    ) -> None:
        """Starts the run. `cables` may insert proxies: it receives the ports of the chamber, two thermometers and the
        gyro, and returns the ports for the run. `rig_end` is appended to the rig file."""
        self.record = folder / f"{name}.db"
        self.log = folder / "laboratory.log"
        with open(self.log, "w", encoding="utf-8") as log:
            self.laboratory = subprocess.Popen(
                [GYROTHERM, "simulate", "--rig", "profiles/rigs/virtual.toml", "--pace", pace],
                stdout=log,
                stderr=subprocess.STDOUT,
                cwd=SOURCE,
            )
        assert until(lambda: "gyro  " in self.log.read_text(), 60), self.log.read_text()
        text = self.log.read_text()
        ports = [
            re.search(rf"{who} +tcp://127\.0\.0\.1:(\d+)", text)[1]
            for who in ("chamber", "thermometer 1", "thermometer 2", "gyro")
        ]
        self.chamber = int(ports[0])
        ports = cables(ports)
        made = subprocess.run(
            ["python3", SOURCE / "tests/apps/gyrotherm/real_rig.py", SOURCE / "profiles/rigs/virtual.toml", *ports],
            capture_output=True,
            text=True,
            check=True,
        )
        (folder / "rig.toml").write_text(made.stdout + rig_end)
        with open(folder / "run.log", "w", encoding="utf-8") as log:
            self.run = subprocess.Popen(
                [GYROTHERM, "run", profile, "--rig", str(folder / "rig.toml"), "--out", str(self.record), "--json"],
                stdout=log,
                stderr=log,
                cwd=SOURCE,
            )
        self.folder = folder
        assert until(lambda: self.acknowledged >= 1, 60), (folder / "run.log").read_text()

    @property
    def acknowledged(self) -> int:
        found = re.findall(
            r'"acknowledged": (\d+)',
            (self.folder / "run.log").read_text() if (self.folder / "run.log").exists() else "",
        )
        return int(found[-1]) if found else -1

    def wait_for_profile(self) -> None:
        """Waits until the air is at the first set point, so that the run carries out its profile."""
        status = self.record.with_name(self.record.name + ".status")
        assert until(lambda: '"state":"execute"' in status.read_text().replace(" ", ""), 60), status.read_text()

    def end(self) -> None:
        if self.run.poll() is None:
            gyrotherm("tell", str(self.record), "stop")
            try:
                self.run.wait(timeout=120)
            except subprocess.TimeoutExpired:
                self.run.kill()
                self.run.wait()
        self.laboratory.terminate()
        self.laboratory.wait(timeout=20)

    def move_set_point(self, celsius: float) -> None:
        """Writes a set point like a second client of the chamber: Modbus function 16, register 103."""
        request = struct.pack(">HHHBBHHBf", 1, 0, 11, 1, 16, 103, 2, 4, celsius)
        with socket.create_connection(("127.0.0.1", self.chamber), timeout=5) as line:
            line.sendall(request)
            assert line.recv(64)[7] == 16

    def events(self) -> list[tuple[str, str]]:
        """Returns kind and text of the events of the closed record."""
        import sqlite3

        with sqlite3.connect(f"file:{self.record}?immutable=1", uri=True) as database:
            return database.execute("SELECT kind, text FROM event ORDER BY id").fetchall()


def key_of(monitor: Monitor, headers: dict[str, str] | None = None, name: str = "run") -> str:
    return until(
        lambda: next(
            (run["key"] for run in monitor.ask("/api/v1/runs", None, headers).json["runs"] if run["name"] == name), None
        )
    )


class WatchedRun(unittest.TestCase):
    """A folder with a run and its monitor for all tests of a class. begin() creates run_ and monitor."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.holder = Folder()
        cls.folder = cls.holder.__enter__()
        cls.begin()

    @classmethod
    def begin(cls) -> None:
        raise NotImplementedError

    @classmethod
    def tearDownClass(cls) -> None:
        cls.monitor.stop()
        cls.run_.end()
        cls.holder.__exit__()
