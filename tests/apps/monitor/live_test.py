# SPDX-License-Identifier: Apache-2.0
"""Watches a run: each second arrives once and in order, also when the monitor is killed repeatedly. The answers conform
to openapi.json, and no files appear or disappear next to the record."""
import http.client
import json
import pathlib
import subprocess
import sys
import threading
import time
import unittest
from typing import Callable

from programs import MOST_MEMORY_MB, Monitor, RealTimeRun, WatchedRun, key_of, until

try:
    import jsonschema
except ImportError:
    jsonschema = None


class Watcher(threading.Thread):
    """Behaves like a browser's EventSource: resumes with Last-Event-ID after an interruption."""

    def __init__(
        self, monitor: Monitor, key: str, after: int, acknowledged: Callable[[], int] = lambda: 0
    ) -> None:
        super().__init__(daemon=True)
        self.monitor, self.key, self.last, self.done = monitor, key, after, False
        self.acknowledged = acknowledged
        self.slots: list[int] = []
        self.came: list[float] = []
        self.behind: list[int] = []  # seconds that the run had acknowledged since, when the sample came
        self.events: dict[int, dict] = {}
        self.statuses: list[dict] = []
        self.samples: list[dict] = []
        self.start()

    def run(self) -> None:
        while not self.done:
            try:
                self.read()
            except (OSError, http.client.HTTPException, ValueError):
                time.sleep(0.1)

    def read(self) -> None:
        line = http.client.HTTPConnection("127.0.0.1", self.monitor.port, timeout=20)
        try:
            self.read_from(line)
        finally:
            line.close()

    def read_from(self, line: http.client.HTTPConnection) -> None:
        line.request(
            "GET", f"/api/v1/runs/{self.key}/events-stream?after={self.last}", headers={"Last-Event-ID": str(self.last)}
        )
        reply = line.getresponse()
        if reply.status != 200:
            raise OSError(reply.status)
        kind = ""
        while not self.done:
            text = reply.readline().decode()
            if not text:
                raise OSError("the stream has ended")
            name, _, value = text.rstrip("\n").partition(": ")
            if name == "event":
                kind = value
            elif name == "data" and kind == "sample":
                sample = json.loads(value)
                self.last = sample["slot"]
                self.slots.append(self.last)
                self.samples.append(sample)
                self.came.append(time.time())
                self.behind.append(self.acknowledged() - self.last)
            elif name == "data" and kind == "event":
                self.events[json.loads(value)["number"]] = json.loads(value)
            elif name == "data" and kind == "status":
                self.statuses.append(json.loads(value))


def schemas() -> dict:
    """Returns the schemas of the interface as JSON Schema, which does not have the keyword "nullable" of OpenAPI."""

    def plain(value):
        if isinstance(value, list):
            return [plain(one) for one in value]
        if not isinstance(value, dict):
            return value
        value = {k: plain(v) for k, v in value.items()}
        if value.pop("nullable", False):
            value["type"] = [value["type"], "null"]
        return value

    text = (pathlib.Path(__file__).parents[3] / "apps/monitor/openapi.json").read_text()
    return plain(json.loads(text))


class Live(WatchedRun):
    @classmethod
    def begin(cls) -> None:
        (cls.folder / "runs").mkdir()
        cls.run_ = RealTimeRun(cls.folder / "runs")
        cls.monitor = Monitor(cls.folder, runs=cls.folder / "runs")
        cls.key = key_of(cls.monitor)

    def test_every_second_comes_once_although_the_monitor_is_killed(self) -> None:
        self.assertTrue(until(lambda: self.monitor.ask(f"/api/v1/runs/{self.key}").json["channels"]))
        watchers = [Watcher(self.monitor, self.key, -1) for _ in range(3)]
        for _ in range(int(sys.argv[1]) if len(sys.argv) > 1 else 4):
            time.sleep(0.8)
            self.monitor.kill()
            self.monitor.again()
        wanted = self.run_.acknowledged + 1
        for watcher in watchers:
            self.assertTrue(until(lambda: watcher.last >= wanted), f"{watcher.last} of {wanted}")
            watcher.done = True
            self.assertEqual(watcher.slots, list(range(watcher.slots[-1] + 1)))
            self.assertIn("started", {event["kind"] for event in watcher.events.values()})
            self.assertTrue(watcher.statuses)
        values = watchers[0].samples[-1]["values"]
        self.assertEqual(len(values), len(self.monitor.ask(f"/api/v1/runs/{self.key}").json["channels"]))

    def test_a_sample_is_there_within_a_second_of_its_own(self) -> None:
        watchers = [
            Watcher(self.monitor, self.key, self.run_.acknowledged, lambda: self.run_.acknowledged) for _ in range(20)
        ]
        self.assertTrue(until(lambda: all(len(watcher.slots) >= 6 for watcher in watchers)))
        ages = sorted(
            came - sample["utc_ms"] / 1000
            for watcher in watchers
            for came, sample in zip(watcher.came[2:], watcher.samples[2:])
        )
        print(
            f"sample to watcher, of {len(ages)}: median {ages[len(ages) // 2]:.2f} s, 99 % {ages[int(0.99 * (len(ages) - 1))]:.2f} s; "
            f"{self.monitor.memory_mb:.0f} MB"
        )
        self.assertEqual(self.monitor.ask(f"/api/v1/runs/{self.key}/events-stream").status, 503, "the 21st")
        behind = sorted(seconds for watcher in watchers for seconds in watcher.behind[2:])
        self.assertLessEqual(behind[len(behind) // 2], 1)
        self.assertLess(self.monitor.memory_mb, MOST_MEMORY_MB)
        for watcher in watchers:
            watcher.done = True

    def test_the_answers_are_what_the_interface_says(self) -> None:
        if jsonschema is None:
            self.skipTest("python3-jsonschema is not installed")
        interface = self.monitor.ask("/api/v1/openapi.json").json
        resolver = schemas()
        run = f"/api/v1/runs/{self.key}"
        slot = self.monitor.ask(run).json["slot"]
        answers = {
            "runs": "/api/v1/runs",
            "run": run,
            "events": run + "/events",
            "alarms": run + "/alarms",
            "files": run + "/files",
            "profile": run + "/profile",
            "session": "/api/v1/session",
            "series": f"{run}/series?channels=A,chamber_air_c&from=0&to={slot}&buckets=3",
            "refusal": run + "/nothing",
        }
        for name, path in answers.items():
            with self.subTest(name):
                schema = {"$ref": f"#/components/schemas/{name}"} | {"components": resolver["components"]}
                jsonschema.validate(self.monitor.ask(path).json, schema)
        self.assertEqual(interface["info"]["title"], "gyrotherm-monitor")
        watcher = Watcher(self.monitor, self.key, slot - 1)
        self.assertTrue(until(lambda: watcher.samples and watcher.events and watcher.statuses))
        watcher.done = True
        for name, told in (
            ("sample", watcher.samples),
            ("event", list(watcher.events.values())),
            ("status", watcher.statuses),
        ):
            schema = {"$ref": f"#/components/schemas/{name}"} | {"components": resolver["components"]}
            jsonschema.validate(told[-1], schema)
        for bad in (
            "series?channels=nothing",
            "series?channels=A&buckets=0",
            "series?channels=A&buckets=99999",
            "series?channels=A&from=x",
            "events?after=x",
        ):
            self.assertEqual(self.monitor.ask(f"{run}/{bad}").status, 400, bad)

    def test_every_refusal_is_in_the_interface(self) -> None:
        paths = self.monitor.ask("/api/v1/openapi.json").json["paths"]
        for path, operations in paths.items():
            for method in operations.keys() & {"get", "post"}:
                wanted = {"403", "429"} | (set() if path in ("/session", "/login", "/logout") else {"401"})
                self.assertLessEqual(wanted, operations[method]["responses"].keys(), path)
        run = f"/runs/{self.key}"
        tries = {
            "/runs/{key}/series": (f"{run}/series", f"{run}/series?channels=A&from=x", "/runs/0/series"),
            "/runs/{key}/profile": ("/runs/0/profile",),
            "/runs/{key}/events": (f"{run}/events?after=x", "/runs/0/events"),
            "/runs/{key}/events-stream": (f"{run}/events-stream?after=x", "/runs/0/events-stream"),
            "/runs/{key}/alarms": ("/runs/0/alarms",),
            "/runs/{key}/standard": (f"{run}/standard", "/runs/0/standard"),
            "/runs/{key}/standard.svg": (f"{run}/standard.svg", "/runs/0/standard.svg"),
            "/runs/{key}/files": ("/runs/0/files",),
            "/runs/{key}/files/{name}": (f"{run}/files/nothing", "/runs/0/files/nothing"),
            "/site/{question}": ("/site/nothing",),
        }
        for path, addresses in tries.items():
            for address in addresses:
                status = self.monitor.ask("/api/v1" + address).status
                self.assertGreaterEqual(status, 400)
                self.assertIn(str(status), paths[path]["get"]["responses"], address)
        for path, address, body in (
            ("/login", "/login", {}),
            ("/login", "/login", {"name": "a"}),
            ("/sessions", "/sessions", {"user": "a"}),
            ("/runs/{key}/{verb}", run + "/note", {}),
        ):
            status = self.monitor.ask("/api/v1" + address, body).status
            self.assertIn(str(status), paths[path]["post"]["responses"], address)
        self.assertEqual(self.monitor.ask("/api/v1/site").json, None, "this monitor has no site")
        for path in ("/runsX", f"/runsX/{self.key}", f"/runs{self.key}"):
            self.assertEqual(self.monitor.ask("/api/v1" + path).status, 404, path)

    def test_a_chart_has_the_seconds_of_now(self) -> None:
        self.assertTrue(until(lambda: self.run_.acknowledged >= 6))
        slot = self.run_.acknowledged
        path = f"/api/v1/runs/{self.key}/series?channels=A,rate&from={max(0, slot - 5)}&to={slot}"
        made = until(
            lambda: (lambda answer: answer if answer.get("count", 0) >= 5 else None)(self.monitor.ask(path).json), 5
        )
        self.assertTrue(made)
        self.assertTrue(all(value is None or -60 < value < 100 for value in made["channels"][0]["low"]))

    def test_what_prometheus_reads_is_well_formed(self) -> None:
        text = self.monitor.ask("/metrics").body.decode()
        self.assertIn('gyrotherm_run_up{run="run",rig="virtual"', text)
        try:
            checked = subprocess.run(
                ["promtool", "check", "metrics"], input=text, capture_output=True, text=True, check=False
            )
        except FileNotFoundError:
            self.skipTest("promtool (prometheus) is not installed")
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)

    def test_nothing_is_made_beside_the_record(self) -> None:
        self.assertTrue(until(lambda: self.monitor.ask(f"/api/v1/runs/{self.key}").json["running"]))
        names = {path.name for path in (self.folder / "runs").iterdir()}
        ours = {name for name in names if not name.startswith("run.") and name not in ("rig.toml", "laboratory.log")}
        self.assertEqual(ours, set())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)
