# SPDX-License-Identifier: Apache-2.0
"""A PostgreSQL cluster of the test's own, in a folder of its own, and the programs of a site that use it."""
from __future__ import annotations

import contextlib
import json
import os
import pathlib
import pwd
import re
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
from typing import Any, Callable, Iterator

BIN = pathlib.Path("/usr/lib/postgresql/15/bin")
PUBLISH = os.environ["GYROTHERM_PUBLISH"]
SITE = os.environ["GYROTHERM_SITE"]
GYROTHERM = os.environ.get("GYROTHERM_PROGRAM", "")
SOURCE = pathlib.Path(os.environ["GYROTHERM_SOURCE"])
SKIPPED = 77


def skip(reason: str) -> None:
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)


def must_have_postgresql() -> None:
    if not (BIN / "initdb").exists():
        skip(f"{BIN} is not there: postgresql-15 is not installed")
    if os.geteuid() == 0:
        try:
            pwd.getpwnam("postgres")
        except KeyError:
            skip("PostgreSQL does not run as root, and there is no user postgres")


def until(condition: Callable[[], Any], seconds: float = 60, every: float = 0.1) -> Any:
    """Waits until the condition holds and returns what it returned; its last answer after `seconds`."""
    end = time.monotonic() + seconds
    while not (answer := condition()) and time.monotonic() < end:
        time.sleep(every)
    return answer


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as line:
        return line.getsockname()[1]


class Cluster:
    """Roles: `postgres`, `gyrotherm_owner` (migrates), `rig_1`, `rig_2` (in gyrotherm_rig), `ada` (an analyst). Over
    the socket whoever asks is let in; over TCP by SCRAM and TLS alone."""

    SETTINGS = """
listen_addresses = '127.0.0.1'
max_connections = 60
shared_buffers = 32MB
fsync = off
max_wal_size = 256MB
min_wal_size = 64MB
log_min_messages = warning
autovacuum = off
restart_after_crash = on
password_encryption = scram-sha-256
"""

    def __init__(self, folder: pathlib.Path, data: pathlib.Path | None = None, settings: str = "") -> None:
        self.folder, self.data, self.port = folder, data or folder / "data", free_port()
        self.as_postgres = (
            ["setpriv", "--reuid=postgres", "--regid=postgres", "--clear-groups"] if os.geteuid() == 0 else []
        )
        if self.as_postgres:
            shutil.chown(folder, "postgres")
        folder.chmod(0o755)
        self.call("initdb", "-D", self.data, "-U", "postgres", "-A", "trust", "-E", "UTF8", "--locale=C", "--no-sync")
        self.settings = f"{self.SETTINGS}port = {self.port}\nunix_socket_directories = '{folder}'\n{settings}"
        self.write("postgresql.auto.conf", self.settings)
        self.write("pg_hba.conf", "local all all trust\nhostssl all all 127.0.0.1/32 scram-sha-256\n")
        self.process: subprocess.Popen[bytes] | None = None
        self.start()
        self.sql("CREATE ROLE gyrotherm_owner LOGIN", database="postgres")
        self.sql("CREATE ROLE gyrotherm_rig NOLOGIN; CREATE ROLE gyrotherm_analyst NOLOGIN", database="postgres")
        self.sql("CREATE DATABASE gyrotherm OWNER gyrotherm_owner", database="postgres")

    def write(self, name: str, text: str, mode: int = 0o600) -> pathlib.Path:
        path = self.data / name
        path.write_text(text)
        path.chmod(mode)
        if self.as_postgres:
            shutil.chown(path, "postgres", "postgres")
        return path

    def call(self, program: str, *words: Any) -> str:
        done = subprocess.run(
            [*self.as_postgres, BIN / program, *map(str, words)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{program}: {done.stderr}"
        return done.stdout

    def start(self) -> None:
        with open(self.folder / "server.log", "ab") as log:
            self.process = subprocess.Popen(
                [*self.as_postgres, BIN / "postgres", "-D", self.data], stdout=log, stderr=log, start_new_session=True
            )
        assert until(self.answers, 60, 0.05), (self.folder / "server.log").read_text()

    def answers(self) -> bool:
        if self.process.poll() is not None:
            return False
        asked = [BIN / "pg_isready", "-q", "-h", str(self.folder), "-p", str(self.port)]
        return subprocess.run(asked, check=False).returncode == 0

    def kill(self) -> None:
        """The postmaster and all of its processes, as a power cut does it; nothing where it has ended itself."""
        if self.process.poll() is not None:
            return
        children = self.children()
        for process in (self.process.pid, *children):
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        self.process.wait()
        until(lambda: not any(pathlib.Path(f"/proc/{child}").exists() for child in children))

    def children(self) -> list[int]:
        found = pathlib.Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text()
        return [int(number) for number in found.split()]

    def stop(self) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.process.wait(timeout=60)

    def address(self, user: str, database: str = "gyrotherm") -> str:
        return f"host={self.folder} port={self.port} dbname={database} user={user}"

    def sql(self, text: str, user: str = "postgres", database: str = "gyrotherm") -> list[list[str]]:
        done = self.try_sql(text, user, database)
        assert done.returncode == 0, f"{text}: {done.stderr}"
        return [line.split("\x1f") for line in done.stdout.splitlines()]

    def try_sql(
        self, text: str, user: str = "postgres", database: str = "gyrotherm"
    ) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [BIN / "psql", "-X", "-q", "-A", "-t", "-F", "\x1f", "-v", "ON_ERROR_STOP=1", self.address(user, database)],
            input=text,
            capture_output=True,
            text=True,
            check=False,
        )

    def migrate(self) -> str:
        address = f"{self.address('postgres')} options='-c role=gyrotherm_owner'"  # as docs/site.md has it
        made = subprocess.run([SITE, "migrate", "--store", address], capture_output=True, text=True, check=False)
        assert made.returncode == 0, made.stderr
        return made.stdout

    def add_people(self) -> None:
        self.sql(
            "CREATE ROLE rig_1 LOGIN PASSWORD 'one' IN ROLE gyrotherm_rig;"
            "CREATE ROLE rig_2 LOGIN IN ROLE gyrotherm_rig;"
            "CREATE ROLE ada LOGIN IN ROLE gyrotherm_analyst; CREATE ROLE nobody LOGIN"
        )


@contextlib.contextmanager
def cluster(**options: Any) -> Iterator[Cluster]:
    must_have_postgresql()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="gyrotherm-site-"))
    made = None
    try:
        made = Cluster(folder, **options)
        yield made
    finally:
        if made is not None:
            made.stop()
        shutil.rmtree(folder, ignore_errors=True)


def record(path: pathlib.Path, profile: str = "tests/profiles/short-rate.toml", seed: int = 1) -> pathlib.Path:
    """A finished run on the virtual rig, some thousand seconds of it."""
    words = ["run", profile, "--rig", "profiles/rigs/virtual.toml", "--seed", str(seed), "--out", str(path), "--quiet"]
    done = subprocess.run([GYROTHERM, *words], cwd=SOURCE, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return path


class Rig:
    """A rig of the site: folder of records, site file, publisher."""

    def __init__(
        self, server: Cluster, folder: pathlib.Path, name: str = "rig-1", user: str = "rig_1", **more: str
    ) -> None:
        self.folder, self.name, self.user = folder, name, user
        self.records = folder / "runs"
        self.records.mkdir(parents=True, exist_ok=True)
        self.file = folder / "site.toml"
        address = more.get("address", server.address(user))
        self.file.write_text(
            f'schema = "gyrotherm-site/1"\nrig = "{name}"\nfolders = ["runs"]\n{more.get("top", "")}\n'
            f'[store]\naddress = "{address}"\nlongest_wait = "500 ms"\n{more.get("store", "")}\n'
            f'{more.get("below", "")}\n'
        )
        self.log = folder / "publisher.log"
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen([PUBLISH, "--site", self.file], stdout=log, stderr=log)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def stop(self) -> int:
        self.process.terminate()
        return self.process.wait(timeout=20)

    def once(self) -> subprocess.CompletedProcess[str]:
        return subprocess.run([PUBLISH, "--site", self.file, "--once"], capture_output=True, text=True, check=False)

    def status(self) -> list[dict[str, Any]]:
        words = [PUBLISH, "--site", self.file, "--status", "--json"]
        return json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)


def rows_of(path: pathlib.Path) -> list[tuple[Any, ...]]:
    """Of a closed record: slot, UTC, and the numbers that the store is to have."""
    with contextlib.closing(sqlite3.connect(f"file:{path}?immutable=1", uri=True)) as database:
        columns = [name for _, name, *_ in database.execute("PRAGMA table_info(sample)")]
        columns = [name for name in columns if name not in ("slot", "utc_ns", "chain")]
        simulated = database.execute("SELECT value FROM meta WHERE key = 'simulated'").fetchone()
        if not simulated or not int(simulated[0]):
            columns = [name for name in columns if not name.endswith("true_bias_deg_per_h")]
        names = ", ".join(f'"{name}"' for name in columns)
        words = {
            "phase": ["ramping", "holding", "waiting for soak", "overdue", "complete"],
            "state": ["execute", "suspended", "held", "aborting", "aborted", "stopped", "complete"],
        }
        place = {columns.index(name): {word: i for i, word in enumerate(list_)} for name, list_ in words.items()}
        rows = []
        for slot, utc, *numbers in database.execute(f"SELECT slot, utc_ns, {names} FROM sample ORDER BY slot"):
            for at, numbers_of in place.items():
                numbers[at] = numbers_of.get(numbers[at]) if numbers[at] is not None else None
            rows.append((slot, utc, *(None if number is None else float(number) for number in numbers)))
        return rows


def run_of(path: pathlib.Path) -> str:
    with contextlib.closing(sqlite3.connect(f"file:{path}?immutable=1", uri=True)) as database:
        return database.execute("SELECT value FROM meta WHERE key = 'id'").fetchone()[0]


def stored_rows(store: Cluster, run: str) -> list[tuple[Any, ...]]:
    rows = []
    for slot, utc, numbers in store.sql(
        f"SELECT slot, utc_ns, numbers FROM gyrotherm.sample WHERE run = '{run}' ORDER BY slot"
    ):
        values = [None if number == "NULL" else float(number) for number in numbers.strip("{}").split(",")]
        rows.append((int(slot), int(utc) if utc else None, *values))
    return rows


def events_of(path: pathlib.Path) -> list[list[str]]:
    with contextlib.closing(sqlite3.connect(f"file:{path}?immutable=1", uri=True)) as database:
        found = database.execute("SELECT id, slot, utc_ns, kind, text FROM event ORDER BY id").fetchall()
    return [[str(value) for value in row] for row in found]


def stored_events(store: Cluster, run: str) -> list[list[str]]:
    return store.sql(
        f"SELECT number, slot, utc_ns, kind, text FROM gyrotherm.event WHERE run = '{run}' ORDER BY number"
    )


def finished(store: Cluster, run: str) -> bool:
    asked = store.try_sql(f"SELECT finished FROM gyrotherm.run WHERE id = '{run}'")
    return asked.returncode == 0 and asked.stdout.strip() == "t"


def number_in(text: str, pattern: str) -> int:
    return int(re.search(pattern, text)[1])
