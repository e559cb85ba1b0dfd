# SPDX-License-Identifier: Apache-2.0
"""A run is read by SECoP, by a client of our own that knows the protocol from its specification: it identifies the
node, has it describe itself, checks each value by its datainfo, follows updates, and is refused what it may not. Who
floods the node, or does not read, harms neither the page nor the run."""
from __future__ import annotations

import json
import re
import socket
import time
import unittest

from programs import MOST_MEMORY_MB, PASSWORD, Monitor, RealTimeRun, WatchedRun, monitor_command, until

NAME = re.compile(r"[a-zA-Z_][a-zA-Z0-9_]{0,62}")


class Client:
    """Requests and replies, and the updates that come between them."""

    def __init__(self, port: int) -> None:
        self.line = socket.create_connection(("127.0.0.1", port), timeout=10)
        self.file = self.line.makefile("r", encoding="ascii", newline="\n")
        self.updates: list[tuple[str, str, list]] = []

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()
        self.line.close()

    def next(self) -> tuple[str, str, str]:
        text = self.file.readline()
        if not text:
            raise ConnectionError("the node has closed the connection")
        action, specifier, data = (text.rstrip("\n").split(" ", 2) + ["", ""])[:3]
        if action in ("update", "error_update"):
            self.updates.append((action, specifier, json.loads(data)))
        return action, specifier, data

    def ask(self, request: str) -> tuple[str, str, str]:
        self.line.sendall(request.encode() + b"\n")
        while (reply := self.next())[0] in ("update", "error_update"):
            pass
        return reply

    def read(self, place: str) -> tuple[str, list]:
        action, specifier, data = self.ask(f"read {place}")
        assert specifier == place, specifier
        return action, json.loads(data)

    def describe(self) -> dict:
        action, _, data = self.ask("describe")
        assert action == "describing", action
        return json.loads(data)


def fits(value: object, info: dict) -> bool:
    """Whether a value is of the type that its datainfo says."""
    kind = info["type"]
    if kind == "double":
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind == "bool":
        return isinstance(value, bool)
    if kind == "string":
        return isinstance(value, str)
    if kind == "enum":
        return isinstance(value, int) and value in info["members"].values()
    if kind == "tuple":
        return len(value) == len(info["members"]) and all(fits(v, i) for v, i in zip(value, info["members"]))
    raise ValueError(kind)


class Secop(WatchedRun):
    @classmethod
    def begin(cls) -> None:
        cls.run_ = RealTimeRun(cls.folder)
        cls.monitor = Monitor(cls.folder, "--secop", "127.0.0.1:0")
        place = cls.monitor.process.stdout.readline()
        cls.port = int(re.fullmatch(r"secop://127\.0\.0\.1:(\d+)\n", place)[1])

    def client(self) -> Client:
        return Client(self.port)

    def test_a_client_finds_out_what_there_is_and_reads_all_of_it(self) -> None:
        with self.client() as client:
            client.line.sendall(b"*IDN?\r\n")
            self.assertEqual(client.file.readline(), "ISSE&SINE2020,SECoP,V2019-09-16,v1.0\n")
            node = client.describe()
            self.assertTrue({"equipment_id", "description", "modules"} <= node.keys())
            self.assertTrue({"run", "chamber_air_c", "chamber_set_point_c", "A", "rate"} <= node["modules"].keys())
            for name, module in node["modules"].items():
                self.assertTrue(NAME.fullmatch(name), name)
                self.assertEqual(module["interface_classes"], ["Readable"])
                self.assertTrue({"value", "status"} <= module["accessibles"].keys())
                for word, parameter in module["accessibles"].items():
                    self.assertTrue(parameter["readonly"] and parameter["description"])
                    action, report = client.read(f"{name}:{word}")
                    if action == "reply":
                        self.assertTrue(fits(report[0], parameter["datainfo"]), (name, word, report))
                        self.assertIn("t", report[1])
                    else:
                        self.assertEqual((action, len(report)), ("error_read", 3))
            action, report = client.read("chamber_air_c:value")
            self.assertEqual(action, "reply")
            self.assertTrue(-60 < report[0] < 100)
            self.assertLess(abs(report[1]["t"] - time.time()), 10)
            self.assertEqual(node["modules"]["chamber_air_c"]["accessibles"]["value"]["datainfo"]["unit"], "°C")
            self.assertIn(client.read("run:status")[1][0][0], (200, 300))

    def test_updates_come_each_second_to_whom_asked_for_them(self) -> None:
        with self.client() as client, self.client() as other:
            wanted = sum(len(module["accessibles"]) for module in client.describe()["modules"].values())
            self.assertEqual(client.ask("activate")[:2], ("active", ""))
            self.assertEqual(len({place for _, place, _ in client.updates}), wanted, "all come before \"active\"")
            self.assertEqual(other.ask("activate A")[:2], ("active", "A"))
            client.updates.clear()
            end = time.monotonic() + 6
            while time.monotonic() < end:
                client.next()
            told = [report for action, place, report in client.updates if (action, place) == ("update", "A:value")]
            times = [report[1]["t"] for report in told]
            self.assertGreaterEqual(len(times), 4)
            self.assertEqual(times, sorted(set(times)), "each second once")
            self.assertEqual(client.ask("deactivate")[0], "inactive")
            client.updates.clear()
            time.sleep(1.5)
            self.assertEqual(client.ask("ping x")[:2], ("pong", "x"))
            self.assertEqual(client.updates, [])
            other.ask("ping")
            self.assertEqual({place.split(":")[0] for _, place, _ in other.updates}, {"A"})

    def test_what_it_may_not_is_refused_by_its_class(self) -> None:
        refusals = {
            "change chamber_set_point_c:value 85": "ReadOnly",
            "change run:value {": "BadJSON",
            "do run:stop": "NoSuchCommand",
            "read nothing:value": "NoSuchModule",
            "read run:nothing": "NoSuchParameter",
            "read run": "ProtocolError",
            "launch": "ProtocolError",
            "": "ProtocolError",
        }
        with self.client() as client:
            for request, kind in refusals.items():
                action, specifier, data = client.ask(request)
                words = request.split(" ")
                self.assertEqual(action, f"error_{words[0]}")
                self.assertEqual(specifier, words[1] if len(words) > 1 else "")
                self.assertEqual(json.loads(data)[0], kind, request)

    def test_whoever_only_listens_on_is_answered_to_the_last_line(self) -> None:
        with self.client() as client:
            client.line.sendall(b"".join(b"ping %d\n" % i for i in range(1000)))
            client.line.shutdown(socket.SHUT_WR)
            pongs = [client.next()[1] for _ in range(1000)]
            self.assertEqual(pongs, [str(i) for i in range(1000)])
            with self.assertRaises(ConnectionError):
                client.next()

    def test_a_line_without_an_end_ends_the_connection(self) -> None:
        with self.client() as client:
            client.line.sendall(b"read " + b"x" * 5000)
            self.assertEqual(json.loads(client.next()[2])[0], "ProtocolError")
            with self.assertRaises(ConnectionError):
                client.next()

    def test_a_flood_harms_neither_the_page_nor_the_run(self) -> None:
        begun = self.run_.acknowledged
        spent = self.cpu_s()
        start = time.monotonic()
        lines = [socket.create_connection(("127.0.0.1", self.port), timeout=5) for _ in range(14)]
        deaf = socket.create_connection(("127.0.0.1", self.port), timeout=5)
        try:
            for line in [*lines, deaf]:
                line.setblocking(False)
            end = start + 8
            while time.monotonic() < end:
                for line in lines:
                    self.push(line, b"describe\nactivate\nping 1\n" * 50)
                    self.pull(line)
                self.push(deaf, b"activate\ndescribe\n" * 50)
                time.sleep(0.02)
            self.assertEqual(self.monitor.ask("/api/v1/runs").status, 200)
        finally:
            for line in [*lines, deaf]:
                line.close()
        lasted = time.monotonic() - start
        share = 100 * (self.cpu_s() - spent) / lasted
        print(f"flood of SECoP: {share:.0f} % of a core, {self.monitor.memory_mb:.0f} MB")
        self.assertTrue(until(lambda: self.run_.acknowledged >= begun + int(lasted) - 3, 10))
        self.assertLess(self.monitor.memory_mb, MOST_MEMORY_MB)
        self.assertTrue(until(self.answers, 20), "the next client is served")

    def cpu_s(self) -> float:
        with open(f"/proc/{self.monitor.process.pid}/stat", encoding="ascii") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / 100

    @staticmethod
    def push(line: socket.socket, text: bytes) -> None:
        try:
            line.send(text)
        except OSError:
            pass

    @staticmethod
    def pull(line: socket.socket) -> None:
        try:
            while line.recv(1 << 20):
                pass
        except OSError:
            pass

    def answers(self) -> bool:
        try:
            with self.client() as client:
                return client.ask("ping 1")[0] == "pong"
        except OSError:
            return False

    def test_more_connections_than_there_are_places_are_sent_away(self) -> None:
        lines = [socket.create_connection(("127.0.0.1", self.port), timeout=5) for _ in range(40)]
        time.sleep(2.5)
        open_now = 0
        for line in lines:
            line.settimeout(2)
            try:
                line.sendall(b"ping 1\n")
                open_now += line.recv(100).startswith(b"pong")
            except OSError:
                pass
            line.close()
        self.assertLessEqual(open_now, 16)
        self.assertGreater(open_now, 0)
        self.assertTrue(until(self.answers, 10))

    def test_it_is_nobodys_by_accident(self) -> None:
        for options, said in (
            (("--secop", "0.0.0.0:0"), "--secop-for-everybody"),
            (("--secop", "here"), "ADDRESS:PORT"),
            (("--secop-rig", "virtual"), "--secop"),
            (("--secop-for-everybody",), "--secop"),
            (("--secop", f"127.0.0.1:{self.port}"), "cannot be listened at"),
        ):
            done = monitor_command(self.folder, "--folder", str(self.folder), "--listen", "127.0.0.1:0", *options)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(said, done.stderr)


class SecopWithUsers(WatchedRun):
    @classmethod
    def begin(cls) -> None:
        cls.run_ = RealTimeRun(cls.folder)
        cls.monitor = Monitor(cls.folder, "--secop", "127.0.0.1:0")
        cls.port = int(cls.monitor.process.stdout.readline().rsplit(":", 1)[1])

    def test_it_closes_once_the_page_has_users_and_goes_when_the_run_ends(self) -> None:
        with Client(self.port) as client:
            self.assertEqual(client.ask("activate A")[0], "active")
            self.run_.end()
            until(lambda: client.next()[0] == "error_update", 20)
            self.assertEqual(client.updates[-1][2][0], "Disabled")
            self.assertEqual(client.read("run:status")[1][0][0], 0)
            for place in ("run:value", "run:_left"):
                self.assertEqual(client.read(place)[1][0], "Disabled", place)
            self.assertEqual(client.read("run:_record")[1][0], "run")
            monitor_command(self.folder, "user", "add", "ada", "--role", "viewer", password=PASSWORD)
            with self.assertRaises(OSError):
                for _ in range(100):
                    client.ask("ping 1")
                    time.sleep(0.1)
        done = monitor_command(
            self.folder, "--folder", str(self.folder), "--listen", "127.0.0.1:0", "--secop", "127.0.0.1:0"
        )
        self.assertEqual(done.returncode, 2)
        self.assertIn("users alone", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=1)
