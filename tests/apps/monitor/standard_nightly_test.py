# SPDX-License-Identifier: Apache-2.0
"""The view of the check standard in a browser, on check runs of a virtual rig of which the last has a changed
thermometer. The view fits each width, its figure has a title and a description, its tables can be reached by keyboard,
and the browser logs no errors. If axe-core is available (GYROTHERM_AXE=…/axe.min.js), it finds no problems. Screenshots
are written to GYROTHERM_PICTURES, if set."""
import os
import pathlib
import sys
import time
import unittest

from programs import SOURCE, Folder, Monitor, gyrotherm, until

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

RUNS = 8
WIDTHS = (360, 1280)


def make_check_runs(folder: pathlib.Path) -> None:
    """Makes check runs of a virtual rig. In the last one, the correction of thermometer D differs by 0.5 K."""
    rig = (SOURCE / "profiles/rigs/virtual.toml").read_text()
    for part in ("chambers/", "gyros/"):
        rig = rig.replace(f'"../{part}', f'"{SOURCE}/profiles/{part}')
    rig = rig.replace("[gyro]\n", '[gyro]\nserial_number = "G-0001"\n')
    rig += '\n[check_standard]\nserial_numbers = ["G-0001"]\n'
    (folder / "rig.toml").write_text(rig)
    changed = rig.replace("offsets = [0, 0, 0, 0, 0, 0, 0, 0]", "offsets = [0, 0, 0, 0.5, 0, 0, 0, 0]")
    assert changed != rig
    (folder / "changed.toml").write_text(changed)
    records = []
    for day in range(RUNS):
        name = "changed.toml" if day == RUNS - 1 else "rig.toml"
        records.append(str(folder / f"check-{day}.db"))
        ran = gyrotherm(
            "run", "check-standard", "--rig", str(folder / name), "--days-later", str(day), "--out", records[-1]
        )
        assert ran.returncode == 0, ran.stderr
    added = gyrotherm("standard", str(folder / "rig.toml"), *records)
    assert added.returncode == 1, added.stdout + added.stderr


class StandardPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.opened = Folder()
        cls.folder = cls.opened.__enter__()
        make_check_runs(cls.folder)
        cls.monitor = Monitor(cls.folder)
        options = Options()
        for word in ("--headless=new", "--no-sandbox", "--hide-scrollbars"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)

        def find_runs() -> list[dict]:
            runs = cls.monitor.ask("/api/v1/runs").json["runs"]
            return runs if len(runs) == RUNS else []

        cls.key = until(find_runs)[0]["key"]

    @classmethod
    def tearDownClass(cls) -> None:
        cls.browser.quit()
        cls.monitor.stop()
        cls.opened.__exit__(None, None, None)

    def open_view(self, width: int, scheme: str) -> None:
        self.browser.execute_cdp_cmd(
            "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        )
        self.browser.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": False},
        )
        self.browser.get("about:blank")
        self.browser.get(f"http://127.0.0.1:{self.monitor.port}/#/run/{self.key}/standard")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".plot svg"), 20), self.text())
        time.sleep(0.5)

    def text(self) -> str:
        return self.browser.execute_script("return document.body.innerText")

    def test_1_view_shows_charts_cause_and_runs(self) -> None:
        self.open_view(1280, "light")
        text = self.text()
        for words in (
            "SIMULATED",
            "G-0001",
            f"Out of control and not explained: 1 of {RUNS} runs",
            "Probable cause: thermometer.",
            "thermometer D",
            f"check-{RUNS - 1}.db",
            "check-standard.jsonl",
        ):
            self.assertIn(words, text)
        figure = self.browser.find_element(By.CSS_SELECTOR, ".plot svg")
        self.assertEqual(figure.get_attribute("role"), "img")
        title = self.browser.execute_script("return document.querySelector('.plot svg > title').textContent")
        self.assertTrue(title.startswith("SIMULATED"), title)
        description = self.browser.execute_script("return document.querySelector('.plot svg > desc').textContent")
        self.assertIn("Out of control", description)
        labels = {
            region.get_attribute("aria-label")
            for region in self.browser.find_elements(By.CSS_SELECTOR, "main [role=region][tabindex='0']")
        }
        self.assertLessEqual({"Table of the results of the last check run", "Table of check runs"}, labels)
        rows = self.browser.find_elements(By.CSS_SELECTOR, "[aria-label='Table of check runs'] tbody tr")
        self.assertEqual(len(rows), RUNS)
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, "main button, main input"), [], "it is read-only")

    def test_2_view_fits_each_width_and_scheme(self) -> None:
        axe = os.environ.get("GYROTHERM_AXE")
        pictures = os.environ.get("GYROTHERM_PICTURES")
        grounds = set()
        for scheme in ("light", "dark"):
            for width in WIDTHS:
                with self.subTest(scheme=scheme, width=width):
                    self.open_view(width, scheme)
                    self.assertLessEqual(
                        self.browser.execute_script("return document.documentElement.scrollWidth - innerWidth"), 0
                    )
                    figure, box = self.browser.execute_script(
                        "const box = document.querySelector('.plot');"
                        "return [box.firstChild.getBoundingClientRect().width, box.clientWidth]"
                    )
                    self.assertAlmostEqual(figure, box, delta=1, msg="the figure is drawn for this width")
                    fill = "return getComputedStyle(document.querySelector('.plot svg > rect')).fill"
                    grounds.add(self.browser.execute_script(fill))
                    if axe:
                        self.browser.execute_cdp_cmd(
                            "Runtime.evaluate", {"expression": pathlib.Path(axe).read_text()}
                        )
                        found = self.browser.execute_async_script(
                            "axe.run().then(r => arguments[0](r.violations.map(v => [v.id, v.nodes[0].html])))"
                        )
                        self.assertEqual(found, [])
                    if pictures:
                        height = self.browser.execute_script("return document.documentElement.scrollHeight")
                        self.browser.execute_cdp_cmd(
                            "Emulation.setDeviceMetricsOverride",
                            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
                        )
                        self.browser.save_screenshot(f"{pictures}/standard-{width}-{scheme}.png")
        self.assertEqual(len(grounds), 2, "the figure has the ground of each colour scheme")
        logged = [entry["message"] for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]
        self.assertEqual(logged, [])

    def test_3_explanation_appears_and_removed_history_is_reported(self) -> None:
        self.open_view(1280, "light")
        explained = gyrotherm(
            "standard", "explain", str(self.folder / "rig.toml"),
            "--cause", "thermometer", "--part", "D", "--note", "<b>replaced</b>", "--by", "Ada",
        )  # fmt: skip
        self.assertEqual(explained.returncode, 0, explained.stderr)
        self.assertTrue(until(lambda: "<b>replaced</b>" in self.text(), 30), self.text())
        self.assertIn("In control", self.text())
        self.assertNotIn("Probable cause", self.text())
        (self.folder / "check-standard.jsonl").unlink()
        self.assertTrue(until(lambda: "there is no history of check runs yet" in self.text(), 30), self.text())


if __name__ == "__main__":
    unittest.main()
