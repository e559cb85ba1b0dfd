# SPDX-License-Identifier: Apache-2.0
"""Whatever breaks between a record and the store, in the end the store has each row once, as it was recorded. With
--long each fault comes as often as it takes to believe that."""
from __future__ import annotations

import os
import pathlib
import random
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "monitor"))
os.environ.setdefault("GYROTHERM_MONITOR", "")
from cluster import (
    GYROTHERM,
    SOURCE,
    Cluster,
    Rig,
    cluster,
    events_of,
    finished,
    free_port,
    must_have_postgresql,
    record,
    rows_of,
    run_of,
    stored_events,
    stored_rows,
    until,
)
from programs import RealTimeRun, gyrotherm  # noqa: E402

LONG = "--long" in sys.argv
SEED = int(os.environ.get("GYROTHERM_SEED", "1"))


class Proxy:
    """A line to the store that cuts, stalls and drops. `mode` is "cut" (after some bytes either way the connection is
    reset), "stall" (nothing moves any more, nobody is told), "none" (it refuses connections) or "open"."""

    def __init__(self, port: int, chance: random.Random) -> None:
        self.target, self.chance, self.mode, self.broken = port, chance, "open", 0
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self) -> None:
        while True:
            try:
                client, _ = self.server.accept()
            except OSError:
                return
            threading.Thread(target=self.carry, args=(client, self.mode), daemon=True).start()

    def carry(self, client: socket.socket, mode: str) -> None:
        with client:
            if mode == "none":
                self.broken += 1
                return
            left = self.chance.randrange(500, 1_500_000) if mode in ("cut", "stall") else None
            with socket.create_connection(("127.0.0.1", self.target)) as server:
                while True:
                    for end in select.select([client, server], [], [])[0]:
                        try:
                            piece = end.recv(65536)
                            other = server if end is client else client
                            if left is not None:
                                piece = piece[:left]
                                left -= len(piece)
                            other.sendall(piece)
                        except OSError:
                            return
                        if not piece and left != 0:
                            return
                        if left == 0:
                            self.broken += 1
                            if mode == "stall":
                                select.select([client], [], [], 5)  # until the publisher gives it up
                                time.sleep(0.2)
                            return


class Faults(unittest.TestCase):
    digest: list[list[str]] | None = None

    @classmethod
    def setUpClass(cls) -> None:
        must_have_postgresql()
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()
        cls.kept = cls.store.folder / "kept"
        cls.kept.mkdir()
        cls.day = record(cls.kept / "day.db")
        cls.rows, cls.events, cls.run_id = rows_of(cls.day), events_of(cls.day), run_of(cls.day)

    def setUp(self) -> None:
        self.chance = random.Random(SEED)
        self.forget()

    def forget(self) -> None:
        """As the owner may: everything that was sent."""
        self.store.sql("TRUNCATE gyrotherm.run, gyrotherm.sample, gyrotherm.rig, gyrotherm.document CASCADE")

    def rig(self, name: str, **more: str) -> Rig:
        rig = Rig(
            self.store, pathlib.Path(tempfile.mkdtemp(prefix=f"{name}-", dir=self.store.folder)), name="rig-1", **more
        )
        shutil.copy(self.day, rig.records / "day.db")
        self.addCleanup(lambda: rig.process and rig.process.poll() is None and rig.kill())
        return rig

    def check_all_is_there(self, rig: Rig | None = None) -> None:
        there = until(lambda: finished(self.store, self.run_id), 60)
        self.assertTrue(there, f"seed {SEED}\n" + (rig.log.read_text() if rig else ""))
        digest = self.store.sql(
            "SELECT (SELECT md5(string_agg(s::text, '' ORDER BY run, slot)) FROM gyrotherm.sample s),"
            " (SELECT md5(string_agg(e::text, '' ORDER BY run, number)) FROM gyrotherm.event e)"
        )
        if self.digest is None:  # compared row by row once, and by their digest from then on
            self.assertEqual(stored_rows(self.store, self.run_id), self.rows, f"seed {SEED}")
            self.assertEqual(stored_events(self.store, self.run_id), self.events, f"seed {SEED}")
            type(self).digest = digest
        self.assertEqual(digest, self.digest, f"seed {SEED}")
        head = self.store.sql("SELECT count(*), min(rows), min(events) FROM gyrotherm.run")
        self.assertEqual(head, [["1", str(len(self.rows)), str(len(self.events))]])

    def again(self, rig: Rig) -> None:
        """The whole run is sent anew, from nothing."""
        self.assertEqual(rig.stop(), 0)
        self.forget()
        rig.start()

    def test_the_server_is_killed(self) -> None:
        rig = self.rig("server-killed")
        rig.start()
        kills, sent = 0, 0
        while kills < (100 if LONG else 2):
            time.sleep(self.chance.uniform(0, 0.3))
            if finished(self.store, self.run_id):
                self.check_all_is_there(rig)
                self.again(rig)
                sent += 1
                continue
            self.store.kill()
            kills += 1
            self.store.start()
        self.check_all_is_there(rig)
        self.assertEqual(rig.stop(), 0)
        lines = rig.log.read_text().splitlines()
        self.assertLess(len(lines), 4 * kills + 4 * sent + 10, "a line for a change of state, not for a try")

    def test_the_publisher_is_killed(self) -> None:
        rig = self.rig("publisher-killed")
        for _ in range(1000 if LONG else 8):
            rig.start()
            time.sleep(self.chance.uniform(0, 0.25))
            rig.kill()
            if finished(self.store, self.run_id):
                self.check_all_is_there(rig)
                self.forget()
        rig.start()
        self.check_all_is_there(rig)
        self.assertEqual(rig.stop(), 0)

    def test_the_network_is_cut(self) -> None:
        proxy = Proxy(self.store.port, self.chance)
        self.store.write("pg_hba.conf", "local all all trust\nhost all all 127.0.0.1/32 trust\n")
        self.store.sql("SELECT pg_reload_conf()")
        address = f"host=127.0.0.1 port={proxy.port} dbname=gyrotherm user=rig_1 sslmode=disable gssencmode=disable"
        rig = self.rig("network", address=address, store='longest_answer = "1 s"')
        proxy.mode = "none"
        rig.start()
        self.assertTrue(until(lambda: proxy.broken > 1))
        for mode, times in (("cut", 60 if LONG else 2), ("stall", 20 if LONG else 1)):
            proxy.mode, before = mode, proxy.broken
            while proxy.broken < before + times:
                time.sleep(0.05)
                if finished(self.store, self.run_id):
                    self.check_all_is_there(rig)
                    self.again(rig)
        proxy.mode = "open"
        self.check_all_is_there(rig)
        self.assertEqual(rig.stop(), 0)

    def test_two_publishers_send_the_same_run(self) -> None:
        for _ in range(20 if LONG else 1):
            rigs = [self.rig(f"twin-{i}") for i in range(2)]
            for rig in rigs:
                rig.start()
            self.check_all_is_there(rigs[0])
            for rig in rigs:
                self.assertEqual(rig.stop(), 0, rig.log.read_text())
                self.assertNotIn("refuses", rig.log.read_text())
            self.forget()

    def test_a_publisher_ends_when_it_is_asked_to(self) -> None:
        """Also while nobody answers it."""
        with socket.create_server(("127.0.0.1", 0)) as deaf:
            rig = self.rig("deaf", address=f"host=127.0.0.1 port={deaf.getsockname()[1]} dbname=g user=rig_1")
            rig.start()
            time.sleep(0.3)
            begun = time.monotonic()
            self.assertEqual(rig.stop(), 0)
            self.assertLess(time.monotonic() - begun, 1)

    def test_an_archive_that_is_full_keeps_the_run_open(self) -> None:
        rig = self.rig("archive", below='[archive]\ncommand = ["false", "{file}", "{sha256}"]')
        done = rig.once()
        self.assertEqual(done.returncode, 4)
        self.assertIn("false: ended with exit code 1", done.stderr)
        self.assertFalse(finished(self.store, self.run_id))
        rig.file.write_text(rig.file.read_text().replace('"false"', '"cp"').replace("{sha256}", "../kept.{sha256}"))
        rig.file.write_text(rig.file.read_text().replace("../kept.", f"{rig.folder}/"))
        self.assertEqual(rig.once().returncode, 0)
        self.check_all_is_there()


def killed_in_its_middle(path: pathlib.Path) -> None:
    """Kills a run after some rows were written and before its end. Repeats a run that ended sooner."""
    some = 1_000_000  # bytes; before the first there are 0.5 MB, after the last 3.5
    words = ["run", "tests/profiles/short-rate.toml", "--rig", "profiles/rigs/virtual.toml", "--out", path, "--quiet"]
    for _ in range(20):
        run = subprocess.Popen([GYROTHERM, *words], cwd=SOURCE)
        until(lambda: (path.exists() and path.stat().st_size > some) or run.poll() is not None, 20, 0.005)
        run.kill()
        run.wait()
        if path.with_name(path.name + "-wal").exists():
            return
        for left in path.parent.glob(path.name + "*"):
            left.unlink()
    raise AssertionError("no run could be killed before its end")


class Following(unittest.TestCase):
    def test_a_run_is_followed_while_it_goes_on(self) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()
            rig = Rig(store, store.folder / "rig-1")
            run = RealTimeRun(rig.records)
            try:
                rig.start()
                lag = lambda: run.acknowledged - int(
                    store.sql("SELECT coalesce(max(last_slot), -1) FROM gyrotherm.run")[0][0]
                )  # noqa: E731
                self.assertTrue(until(lambda: run.acknowledged >= 4, 120))
                self.assertTrue(until(lambda: lag() <= 3, 60), rig.log.read_text())
                state = lambda: store.sql("SELECT state, finished FROM gyrotherm.run")  # noqa: E731
                until(lambda: state() == [["execute", "f"]], 60)  # the run first ramps from the present air
                self.assertEqual(state(), [["execute", "f"]])
                gyrotherm("tell", str(run.record), "pause")
                self.assertTrue(until(lambda: store.sql("SELECT state FROM gyrotherm.run") == [["held"]], 60))
            finally:
                run.end()
            self.assertTrue(until(lambda: finished(store, run_of(run.record)), 60), rig.log.read_text())
            self.assertEqual(stored_rows(store, run_of(run.record)), rows_of(run.record))
            self.assertEqual(stored_events(store, run_of(run.record)), events_of(run.record))
            self.assertEqual(store.sql("SELECT state FROM gyrotherm.run"), [["stopped"]])
            self.assertEqual(rig.stop(), 0)

    def test_a_run_that_was_killed_and_resumed_is_one_run(self) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()
            rig = Rig(store, store.folder / "rig-1")
            path = rig.records / "run.db"
            killed_in_its_middle(path)
            rig.start()
            self.assertTrue(
                until(lambda: store.sql("SELECT rows > 0 FROM gyrotherm.run") == [["t"]], 60), rig.log.read_text()
            )
            resumed = gyrotherm("resume", str(path), "--gap", "90 s", "--accept")
            self.assertEqual(resumed.returncode, 0, resumed.stderr)
            self.assertTrue(until(lambda: finished(store, run_of(path)), 60), rig.log.read_text())
            self.assertEqual(stored_rows(store, run_of(path)), rows_of(path))
            self.assertEqual(stored_events(store, run_of(path)), events_of(path))
            self.assertGreaterEqual(int(store.sql("SELECT sum(seconds) FROM gyrotherm.v1_gap")[0][0]), 89)
            self.assertEqual(rig.stop(), 0)


@unittest.skipUnless(os.geteuid() == 0, "only root mounts a small disk")
class FullDisk(unittest.TestCase):
    def test_the_servers_disk_is_full(self) -> None:
        folder = pathlib.Path(tempfile.mkdtemp(prefix="gyrotherm-disk-"))
        if subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=120M", "none", folder], check=False, capture_output=True
        ).returncode:
            self.skipTest("no file system may be mounted here")
        ballast = folder / "ballast"
        try:
            with cluster(data=folder / "data", settings="max_wal_size = 32MB\nmin_wal_size = 32MB\n") as store:
                store.migrate()
                store.add_people()
                rig = Rig(store, store.folder / "rig-1")
                day = record(store.folder / "day.db")
                for round_ in range(10 if LONG else 1):
                    with open(ballast, "wb") as file:
                        left = shutil.disk_usage(folder).free - random.Random(SEED + round_).randrange(
                            400_000, 4_000_000
                        )
                        file.write(b"\0" * left)
                    shutil.copy(day, rig.records / "day.db")
                    rig.start()
                    refused = until(lambda: "gyrotherm-publish: store: " in rig.log.read_text())
                    self.assertTrue(refused, rig.log.read_text())
                    ballast.unlink()
                    if not until(store.answers, 10):
                        store.kill()
                        store.start()
                    self.assertTrue(until(lambda: finished(store, run_of(day)), 60), rig.log.read_text())
                    self.assertEqual(stored_rows(store, run_of(day)), rows_of(day))
                    self.assertEqual(rig.stop(), 0)
                    store.sql("TRUNCATE gyrotherm.run, gyrotherm.sample CASCADE")
                    rig.log.unlink()
        finally:
            subprocess.run(["umount", folder], check=False)
            folder.rmdir()


if __name__ == "__main__":
    unittest.main(argv=[word for word in sys.argv if word != "--long"])
