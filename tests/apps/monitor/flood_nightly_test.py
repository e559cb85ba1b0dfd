# SPDX-License-Identifier: Apache-2.0
"""Floods the page during a run: ten thousand connections, endless senders, bodies of a gigabyte, watchers that never
read. The run loses no second, the page stays within its memory, and it answers again at once."""
import socket
import threading
import time
import unittest

from programs import MOST_MEMORY_MB, Folder, Monitor, RealTimeRun, key_of, until

CONNECTIONS = 10_000


class Flood(unittest.TestCase):
    def test_the_run_does_not_notice(self) -> None:
        with Folder() as folder:
            run = RealTimeRun(folder)
            monitor = Monitor(folder)
            try:
                key = key_of(monitor)
                before, began = run.acknowledged, time.monotonic()
                self.attack(monitor, key)
                passed = time.monotonic() - began
                self.assertTrue(
                    until(lambda: run.acknowledged - before >= passed - 3, 5),
                    f"{run.acknowledged - before} s in {passed:.0f} s",
                )
                self.assertIsNone(monitor.process.poll(), "the page lives")
                self.assertTrue(until(lambda: self.answers(monitor), 5))
                print(
                    f"{CONNECTIONS} connections in {passed:.0f} s, {monitor.memory_mb:.0f} MB, {run.acknowledged - before} s acknowledged"
                )
                self.assertLess(monitor.memory_mb, MOST_MEMORY_MB)
                slots = [
                    row
                    for row in monitor.ask(
                        f"/api/v1/runs/{key}/series?channels=A&from={before}&to={before + int(passed) - 4}"
                    ).json["channels"][0]["low"]
                ]
                self.assertNotIn(None, slots, "no second is missing")
            finally:
                monitor.stop()
                run.end()

    def answers(self, monitor: Monitor) -> bool:
        try:
            return monitor.ask("/api/v1/runs").status in (200, 429)
        except OSError:
            return False

    def attack(self, monitor: Monitor, key: str) -> None:
        over = threading.Event()
        kinds = [
            b"",
            b"GET / HTTP/1.1\r\nHost: ",
            b"GET / HTTP/1.1\r\nX: " + b"y" * 20_000,
            b"POST /api/v1/login HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nContent-Length: 1000000000\r\n\r\n" % monitor.port,
            b"GET /api/v1/runs/%s/events-stream?after=-1 HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n"
            % (key.encode(), monitor.port),
        ]

        def slow() -> None:
            while not over.is_set():
                try:
                    with socket.create_connection(("127.0.0.1", monitor.port), timeout=2) as line:
                        for _ in range(20):
                            line.sendall(b"X")
                            time.sleep(0.2)
                except OSError:
                    pass

        def large() -> None:
            while not over.is_set():
                try:
                    with socket.create_connection(("127.0.0.1", monitor.port), timeout=2) as line:
                        line.sendall(kinds[3])
                        for _ in range(1000):
                            line.sendall(b"z" * 65536)
                except OSError:
                    pass

        threads = [threading.Thread(target=what, daemon=True) for what in [slow] * 40 + [large] * 2]
        for thread in threads:
            thread.start()
        lines: list[socket.socket] = []
        for i in range(CONNECTIONS):
            try:
                line = socket.create_connection(("127.0.0.1", monitor.port), timeout=2)
                line.sendall(kinds[i % len(kinds)])
                lines.append(line)
            except OSError:
                pass
            if len(lines) >= 800:
                lines.pop(0).close()
        over.set()
        for line in lines:
            line.close()
        for thread in threads:
            thread.join(timeout=10)


if __name__ == "__main__":
    unittest.main(verbosity=1)
