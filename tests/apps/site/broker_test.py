#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a rig says of itself over MQTT while it is, with a broker of the test's own that wants TLS and a password."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "monitor"))

from cluster import GYROTHERM, PUBLISH, SKIPPED, SOURCE, free_port, record, until
from programs import Monitor, RealTimeRun

PASSWORD = "it is so"


class Broker:
    def __init__(self, folder: pathlib.Path):
        self.folder, self.port = folder, free_port()
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj",
                        "/CN=localhost", "-addext", "subjectAltName=DNS:localhost", "-keyout", folder / "key.pem",
                        "-out", folder / "cert.pem"], check=True, capture_output=True)
        (folder / "users").touch(0o600)
        subprocess.run(["mosquitto_passwd", "-b", folder / "users", "rig", PASSWORD], check=True, capture_output=True)
        (folder / "broker.conf").write_text(
            f"listener {self.port} localhost\ncertfile {folder}/cert.pem\nkeyfile {folder}/key.pem\n"
            f"allow_anonymous false\npassword_file {folder}/users\nuser root\n")
        self.start()

    def start(self) -> None:
        self.process = subprocess.Popen(["mosquitto", "-c", self.folder / "broker.conf"], stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        assert until(self.answers)

    def answers(self) -> bool:
        with socket.socket() as line:
            return line.connect_ex(("127.0.0.1", self.port)) == 0

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def client(self, program: str, topic: str) -> list:
        return [program, "-h", "localhost", "-p", str(self.port), "--cafile", self.folder / "cert.pem", "-u", "rig",
                "-P", PASSWORD, "-t", topic]

    def listener(self, topic: str) -> list:
        return self.client("mosquitto_sub", topic)

    def speaker(self, topic: str) -> list:
        return [*self.client("mosquitto_pub", topic), "-q", "1", "-r", "-s"]

    def heard(self, topic: str, count: int = 1, seconds: int = 20) -> list[dict]:
        lines = subprocess.run([*self.listener(topic), "-C", str(count), "-W", str(seconds)], capture_output=True,
                               text=True).stdout.splitlines()
        return [json.loads(line) for line in lines]


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="gyrotherm-live-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.broker = Broker(cls.folder)
        cls.addClassCleanup(lambda: cls.broker.kill())
        (cls.folder / "password").write_text(PASSWORD + "\n")
        (cls.folder / "records").mkdir()
        cls.site = cls.folder / "site.toml"
        cls.site.write_text(
            f'schema = "gyrotherm-site/1"\nname = "lab/1"\nrig = "rig 1"\nfolders = ["records"]\n\n[store]\n'
            f'address = "host=127.0.0.1 port={free_port()} dbname=gyrotherm"\n\n[live]\n'
            f'broker = "mqtts://localhost:{cls.broker.port}"\nauthority = "cert.pem"\nuser = "rig"\n'
            f'passfile = "password"\n')
        cls.log = open(cls.folder / "log", "w", encoding="utf-8")
        cls.addClassCleanup(cls.log.close)

    def publish(self) -> subprocess.Popen:
        process = subprocess.Popen([PUBLISH, "--site", self.site], stderr=self.log)
        self.addCleanup(process.kill)
        return process

    def status(self) -> dict:
        return self.broker.heard("gyrotherm/v1/lab_1/rig 1/status")[0]

    def test_it_says_how_it_is_whatever_becomes_of_others(self) -> None:
        publisher = self.publish()
        first = self.status()
        self.assertEqual((first["schema"], first["site"], first["rig"]), ("gyrotherm-live/1", "lab/1", "rig 1"))
        self.assertEqual((first["run"], first["left"]), (None, None))
        run = RealTimeRun(self.folder / "records")
        self.addCleanup(run.end)
        self.assertTrue(until(lambda: self.status()["run"] is not None))
        samples = self.broker.heard("gyrotherm/v1/lab_1/+/sample", 3)
        slots = [sample["values"]["slot"] for sample in samples]
        self.assertEqual(slots, list(range(slots[0], slots[0] + 3)))
        self.assertEqual({sample["run"] for sample in samples}, {self.status()["run"]["id"]})
        self.assertLess(abs(samples[0]["values"]["A"] - 20), 40)

        self.broker.kill()
        self.broker.start()  # it has kept nothing
        self.assertTrue(until(lambda: self.status()["run"]["state"] == "execute"))
        listening = subprocess.Popen([*self.broker.listener("gyrotherm/v1/#"), "-v", "-W", "15"],
                                     stdout=subprocess.PIPE, text=True)
        self.assertIn("/status", listening.stdout.readline())
        subprocess.run([GYROTHERM, "tell", run.record, "note", "somebody was here"], check=True, cwd=SOURCE)
        self.assertTrue(any("/event" in line and "somebody was here" in line for line in listening.stdout))
        listening.kill()
        listening.communicate()

        going_on = self.status()
        self.assertIsNone(going_on["left"])
        run.run.kill()  # and its guard makes the chamber safe
        self.assertTrue(until(lambda: self.status()["run"] is None))
        left = self.status()["left"]
        self.assertEqual((left["id"], left["finished"], left["being_written"]), (going_on["run"]["id"], False, False))

        publisher.send_signal(signal.SIGKILL)
        publisher.wait()
        self.assertTrue(until(lambda: self.status()["online"] is False), "the broker says so")
        publisher = self.publish()
        self.assertTrue(until(lambda: self.status()["online"] is True))
        publisher.send_signal(signal.SIGTERM)
        self.assertEqual(publisher.wait(10), 0)
        self.assertFalse(self.status()["online"])

    def test_a_rig_with_as_many_alarms_as_may_stand_is_heard(self) -> None:
        status = json.loads(pathlib.Path(f"{record(self.folder / 'ten.db', 'tests/profiles/ten-seconds.toml')}.status")
                            .read_text())
        alarm = {"slot": 345678, "utc": "2026-11-27T12:40:02Z", "utc_ns": 1795783202000000000,
                 "interlock": "not_taken", "reaction": "suspend",
                 "text": "not_taken (suspend): " + "a long story; " * 8}
        monitor = Monitor(self.folder, "--site", str(self.site), runs=self.folder / "records")
        self.addCleanup(monitor.stop)
        for count in (1, 256):
            status["alarms"] = [alarm | {"number": 12000 + i} for i in range(count)]
            told = {"schema": "gyrotherm-live/1", "site": "lab/1", "rig": "rig 2", "number": count, "online": True,
                    "utc": "2026-11-27T12:40:03Z", "run": None, "left": status}
            subprocess.run(self.broker.speaker("gyrotherm/v1/lab_1/rig 2/status"), input=json.dumps(told), check=True,
                           text=True)
            heard = lambda: [len(rig["left"]["alarms"]) for rig in monitor.ask("/api/v1/site").json["rigs"]
                             if rig["rig"] == "rig 2"]
            self.assertTrue(until(lambda: heard() == [count]), heard())

    def test_a_rig_speaks_for_its_own_topic_only(self) -> None:
        monitor = Monitor(self.folder, "--site", str(self.site), runs=self.folder / "records")
        self.addCleanup(monitor.stop)

        def say(topic: str, rig: str, utc: str) -> None:
            told = {"schema": "gyrotherm-live/1", "site": "lab/1", "rig": rig, "number": 1, "online": True, "utc": utc,
                    "run": None, "left": None}
            subprocess.run(self.broker.speaker(f"gyrotherm/v1/lab_1/{topic}/status"), input=json.dumps(told),
                           check=True, text=True)

        def heard() -> dict[str, float]:
            return {rig["rig"]: rig["age_s"] for rig in monitor.ask("/api/v1/site").json["rigs"]}

        now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        for topic, rig in (("rig 3", "rig 1"), ("rig 3", "rig 31"), ("rig_3", "rig 3/"), ("rig 4", "Rig 4")):
            say(topic, rig, now)
        say("rig_5", "rig/5", now)
        say("rig 6", "rig 6", now)
        self.assertTrue(until(lambda: {"rig/5", "rig 6"} <= heard().keys()), heard())
        self.assertFalse({"rig 31", "rig 3/", "Rig 4"} & heard().keys(), heard())

    def test_a_kept_status_is_as_old_as_its_utc(self) -> None:
        old = {"schema": "gyrotherm-live/1", "site": "lab/1", "number": 1, "online": True, "run": None, "left": None}
        ages = {"kept 1": 3600.0, "kept 2": 30 * 86400.0, "kept 3": 0.0, "kept 4": -3600.0}
        for rig, age in ages.items():
            utc = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(time.time() - age))
            subprocess.run(self.broker.speaker(f"gyrotherm/v1/lab_1/{rig}/status"), check=True, text=True,
                           input=json.dumps(old | {"rig": rig, "utc": utc}))
        monitor = Monitor(self.folder, "--site", str(self.site), runs=self.folder / "records")  # subscribes after that
        self.addCleanup(monitor.stop)
        heard = lambda: {rig["rig"]: rig["age_s"] for rig in monitor.ask("/api/v1/site").json["rigs"]}
        self.assertTrue(until(lambda: ages.keys() <= heard().keys()), heard())
        for rig, age in heard().items():
            if rig in ages:
                self.assertLess(abs(age - max(ages[rig], 0)), 60, rig)

    def test_without_a_broker_it_ends_as_soon_as_it_is_told(self) -> None:
        text = self.site.read_text().replace(str(self.broker.port), str(free_port()))
        elsewhere = self.folder / "elsewhere.toml"
        elsewhere.write_text(text)
        process = subprocess.Popen([PUBLISH, "--site", elsewhere], stderr=self.log)
        self.addCleanup(process.kill)
        with self.assertRaises(subprocess.TimeoutExpired):
            process.wait(3)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(3), 0)


if __name__ == "__main__":
    if missing := [program for program in ("mosquitto", "mosquitto_pub", "mosquitto_sub", "openssl")
                   if not shutil.which(program, path=os.environ.get("PATH", "") + ":/usr/sbin")]:
        print(f"skipped: {', '.join(missing)} is not installed")
        sys.exit(SKIPPED)
    os.environ["PATH"] = os.environ.get("PATH", "") + ":/usr/sbin"
    unittest.main(verbosity=2)
