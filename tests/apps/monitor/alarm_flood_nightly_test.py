# SPDX-License-Identifier: Apache-2.0
"""Half an hour of an overloaded machine and an intermittent cable, observed in a browser: at most one row per cause and
instrument; comment, selection and focus survive each update; two clicks acknowledge everything.

GYROTHERM_FLOOD_MINUTES changes the duration; GYROTHERM_PICTURES is a folder for screenshots."""
import os
import pathlib
import random
import select
import signal
import socket
import sys
import threading
import time
import unittest

from programs import PASSWORD, Browser, Monitor, RealTimeRun, WatchedRun, key_of, monitor_command, until

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
except ImportError:
    print("skipped: python3-selenium is not installed")
    sys.exit(77)
if not pathlib.Path("/usr/bin/chromedriver").exists():
    print("skipped: chromium-driver is not installed")
    sys.exit(77)

MINUTES = float(os.environ.get("GYROTHERM_FLOOD_MINUTES", "30"))
COMMENT = "the cable of scanner 1 was loose, the backup starved the machine"
PROFILE = """schema = "gyrotherm-profile/1"
name = "flood"

[[segment]]
kind = "hold"
at = "20 °C"
time = "2 h"
"""


class Cable:
    """Forwards the bytes of one TCP line. While it is cut, it forwards none and closes open connections."""

    def __init__(self, port: str) -> None:
        self.far, self.whole = int(port), True
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = str(self.listener.getsockname()[1])
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self) -> None:
        while True:
            near, _ = self.listener.accept()
            threading.Thread(target=self.carry, args=(near,), daemon=True).start()

    def carry(self, near: socket.socket) -> None:
        try:
            with near, socket.create_connection(("127.0.0.1", self.far)) as far:
                while True:
                    for end in select.select([near, far], [], [], 0.2)[0]:
                        data = end.recv(65536)
                        if not data:
                            return
                        if self.whole:
                            (far if end is near else near).sendall(data)
        except OSError:
            pass


class AlarmFlood(WatchedRun):
    @classmethod
    def begin(cls) -> None:
        monitor_command(cls.folder, "user", "add", "ada", "--role", "operator", password=PASSWORD)
        (cls.folder / "flood.toml").write_text(PROFILE)
        cls.cables: list[Cable] = []

        def cables(ports: list[str]) -> list[str]:
            cls.cables.append(Cable(ports[1]))
            return [ports[0], cls.cables[0].port, *ports[2:]]

        cls.run_ = RealTimeRun(cls.folder, str(cls.folder / "flood.toml"), "flood", cables=cables)
        cls.monitor = Monitor(cls.folder, "--control")
        options = Options()
        for word in ("--headless=new", "--no-sandbox", "--hide-scrollbars"):
            options.add_argument(word)
        cls.browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        cls.ada = Browser(cls.monitor, "ada")
        cls.key = key_of(cls.monitor, cls.ada.headers, "flood")
        cls.pictures = os.environ.get("GYROTHERM_PICTURES")

    @classmethod
    def tearDownClass(cls) -> None:
        cls.browser.quit()
        super().tearDownClass()

    def script(self, words: str):
        return self.browser.execute_script("return " + words)

    def log_in(self) -> None:
        self.browser.get(f"http://127.0.0.1:{self.monitor.port}/#/run/{self.key}/alarms")
        self.assertTrue(until(lambda: self.browser.find_elements(By.ID, "login-name"), 20))
        self.browser.find_element(By.ID, "login-name").send_keys("ada")
        self.browser.find_element(By.ID, "login-password").send_keys(PASSWORD)
        self.browser.find_element(By.XPATH, "//form//button").click()
        self.assertTrue(until(lambda: self.browser.find_elements(By.ID, "alarm-comment"), 20))

    def flood(self, over: threading.Event) -> None:
        """Stops the run for 1 to 4 s, as on an overloaded machine, and cuts the cable for 1 to 9 s."""
        chance = random.Random(49)
        while not over.is_set():
            self.run_.run.send_signal(signal.SIGSTOP)
            over.wait(chance.uniform(1, 4))
            self.run_.run.send_signal(signal.SIGCONT)
            over.wait(chance.uniform(3, 9))
            self.cables[0].whole = False
            over.wait(chance.uniform(1, 9))
            self.cables[0].whole = True
            over.wait(chance.uniform(3, 15))

    def alarms(self) -> list[dict]:
        return self.ada.ask(f"/api/v1/runs/{self.key}").json["alarms"]

    def pick(self, name: str) -> None:
        if not self.pictures:
            return
        for scheme in ("light", "dark"):
            for width in (360, 1200):
                self.browser.execute_cdp_cmd(
                    "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
                )
                self.browser.execute_cdp_cmd(
                    "Emulation.setDeviceMetricsOverride",
                    {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": False},
                )
                time.sleep(0.5)
                self.browser.save_screenshot(f"{self.pictures}/{name}-{width}-{scheme}.png")
        self.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

    def test_a_flood_has_one_row_per_cause_and_loses_nothing_that_is_typed(self) -> None:
        self.log_in()
        over = threading.Event()
        flood = threading.Thread(target=self.flood, args=(over,), daemon=True)
        flood.start()
        end = time.monotonic() + 60 * MINUTES
        try:
            self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".alarms > li"), 120))
            row = self.browser.find_element(By.CSS_SELECTOR, ".alarms > li")
            box = row.find_element(By.CSS_SELECTOR, "input[type=checkbox]")
            box.click()
            field = self.browser.find_element(By.ID, "alarm-comment")
            field.click()
            typed, most = "", 0
            while time.monotonic() < end:
                alarms = self.alarms()
                tags = [(alarm["interlock"], alarm["subject"]) for alarm in alarms]
                self.assertEqual(len(tags), len(set(tags)), "one row per cause and instrument")
                most = max(most, len([alarm for alarm in alarms if not alarm["suppressed_by"]]))
                shown = self.script("[...document.querySelectorAll('.alarms > li')].length")
                self.assertLessEqual(shown, 6, tags)
                if len(typed) < len(COMMENT):
                    typed += COMMENT[len(typed)]
                    self.browser.switch_to.active_element.send_keys(typed[-1])
                self.assertEqual(self.script("document.activeElement.id"), "alarm-comment", "the focus stays")
                self.assertEqual(self.script("document.getElementById('alarm-comment').value"), typed)
                self.assertTrue(box.is_selected(), "the selection stays")
                time.sleep(min(1.0, max(0.05, 60 * MINUTES / len(COMMENT) / 2)))
        finally:
            over.set()
            flood.join(timeout=30)
        self.browser.switch_to.active_element.send_keys(COMMENT[len(typed):])
        self.assertTrue(until(lambda: self.run_.run.poll() is None and self.alarms(), 20))
        self.pick("flood")
        self.browser.find_element(By.XPATH, "//button[starts-with(., 'Acknowledge all shown')]").click()
        done = lambda: [alarm for alarm in self.alarms() if not alarm["acknowledged"] and not alarm["suppressed_by"]]
        if not until(lambda: not done(), 10):  # what came while the button was pressed
            self.browser.find_element(By.ID, "alarm-comment").send_keys(COMMENT)
            self.browser.find_element(By.XPATH, "//button[starts-with(., 'Acknowledge all shown')]").click()
        self.assertTrue(until(lambda: not done(), 10), "two clicks")
        self.pick("acknowledged")
        self.assertTrue(until(lambda: "None." in self.browser.find_element(By.TAG_NAME, "main").text, 120), "returned")
        events = self.ada.ask(f"/api/v1/runs/{self.key}/events").json["events"]
        occurrences = [event for event in events if event["interlock"] and event["kind"] in ("fault", "interlock")]
        print(f"{len(occurrences)} occurrences, at most {most} rows")
        self.assertGreater(len(occurrences), most, "each occurrence is an event")
        comments = [event["text"] for event in events if event["kind"] == "acknowledged"]
        self.assertTrue(comments and all(COMMENT in text and "ada (through" in text for text in comments), comments)


if __name__ == "__main__":
    unittest.main(verbosity=1)
