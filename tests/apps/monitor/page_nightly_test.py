# SPDX-License-Identifier: Apache-2.0
"""The page in a browser, on a run in real time: a ramp is shown, the run is held and resumed, a note is added, an alarm
acknowledged, a chart zoomed. The page fits each width and the browser logs no errors. If axe-core is available
(GYROTHERM_AXE=…/axe.min.js), it finds no problems. Screenshots are written to GYROTHERM_PICTURES, if set."""
import os
import pathlib
import re
import subprocess
import sys
import time
import unittest

from programs import (
    GYROTHERM,
    PASSWORD,
    SOURCE,
    Browser,
    Monitor,
    RealTimeRun,
    WatchedRun,
    gyrotherm,
    key_of,
    monitor_command,
    until,
)

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

PROFILE = """schema = "gyrotherm-profile/1"
name = "up"
title = "A ramp, for the page"

[[segment]]
kind = "hold"
at = "20 °C"
time = "8 s"

[[segment]]
kind = "ramp"
to = "30 °C"
rate = "5 °C/min"

[[segment]]
kind = "hold"
time = "10 min"
"""
VIEWS = ("now", "trend", "profile", "events", "alarms", "files", "runs", "rigs")
WIDTHS = (360, 800, 1600)


class Page(WatchedRun):
    @classmethod
    def begin(cls) -> None:
        monitor_command(cls.folder, "user", "add", "ada", "--role", "operator", password=PASSWORD)
        (cls.folder / "up.toml").write_text(PROFILE)
        os.environ["GYROTHERM_TEST_OBSERVE"] = "60 s"
        cls.run_ = RealTimeRun(cls.folder, str(cls.folder / "up.toml"), "soak")
        cls.monitor = Monitor(cls.folder, "--control")
        options = Options()
        for word in ("--headless=new", "--no-sandbox", "--hide-scrollbars"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        cls.key = key_of(cls.monitor, Browser(cls.monitor, "ada").headers, "soak")
        cls.pictures = os.environ.get("GYROTHERM_PICTURES")

    @classmethod
    def tearDownClass(cls) -> None:
        cls.browser.quit()
        super().tearDownClass()

    def open_view(self, view: str) -> None:
        site = view in ("runs", "rigs")
        self.browser.get(f"http://127.0.0.1:{self.monitor.port}/#/" + (view if site else f"run/{self.key}/{view}"))

    def text(self) -> str:
        return self.browser.execute_script("return document.body.innerText")

    def expect_text(self, words: str, seconds: float = 15) -> None:
        self.assertTrue(until(lambda: words in self.text(), seconds), f"{words!r} in {self.text()}")

    def press(self, element: str) -> None:
        until(lambda: self.browser.find_elements(By.XPATH, element), 10)
        self.browser.find_element(By.XPATH, element).click()

    def enter(self, element: str, words: str) -> None:
        until(lambda: self.browser.find_elements(By.ID, element), 10)
        self.browser.find_element(By.ID, element).send_keys(words)

    def test_1_operator_controls_run(self) -> None:
        self.open_view("now")
        self.expect_text("Log in")
        self.enter("login-name", "ada")
        self.enter("login-password", PASSWORD)
        self.press("//form//button")
        self.expect_text("Running")
        self.expect_text("Segment 2 of 3", 30)
        air = self.browser.find_element(By.XPATH, "//dt[.='Set point']/following-sibling::dd").text
        self.assertTrue(
            until(
                lambda: self.browser.find_element(By.XPATH, "//dt[.='Set point']/following-sibling::dd").text != air, 5
            ),
            "the ramp is seen",
        )
        self.press("//button[.='Pause']")
        self.expect_text("Held")
        self.expect_text("ada")
        self.press("//button[.='Resume']")
        self.enter("dialog-text", "looked at it")
        self.press("//dialog//button[.='Resume']")
        self.expect_text("Running")
        self.open_view("events")
        self.enter("note-text", "<img src=x onerror=alert(1)> the door was open")
        self.press("//button[.='Add']")
        self.expect_text("<img src=x onerror=alert(1)> the door was open")
        self.run_.move_set_point(26.0)
        self.open_view("alarms")
        self.expect_text("foreign_set_point", 20)
        if self.pictures:
            self.take_pictures("alarm", ("now", "alarms"))
            self.open_view("alarms")
        self.enter("alarm-comment", "put back by hand")
        self.press("//button[starts-with(., 'Acknowledge all shown')]")
        self.expect_text("ada (through")
        self.expect_text("put back by hand")
        self.expect_text("Acknowledge all shown (0)")
        self.open_view("now")
        self.press("//button[starts-with(., 'Stop')]")
        self.expect_text("A stop is final: the run cannot be resumed.")
        self.expect_text("pause it, or press Ctrl-C")
        self.expect_text("left")
        self.expect_text("safe set point, ")
        self.expect_text("Reason")
        self.press("//dialog//button[.='Cancel']")
        self.open_view("trend")
        self.press("//button[.='All']")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".chart canvas"), 10))
        self.expect_no_empty_rows()
        self.press("//button[.='Zoom in']")
        self.expect_text("every second")
        self.expect_different_labels()
        self.assertIn("chart", self.browser.find_element(By.CSS_SELECTOR, ".chart").get_attribute("class"))
        kinds = [kind for kind, _ in self.events()]
        self.assertGreaterEqual(kinds.count("command"), 2)
        self.assertIn("acknowledged", kinds)

    def expect_no_empty_rows(self) -> None:
        """Samples that arrive during the request of a chart are in it. Reads the rows from the library."""
        for _ in range(3):
            self.browser.refresh()
            self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".chart canvas"), 10))
            time.sleep(2.5)
            empty_rows = self.browser.execute_script("return chart.count_empty_rows()")
            self.assertEqual(empty_rows, 0)

    def expect_different_labels(self) -> None:
        """The ticks of a narrow scale have different labels."""
        labels = self.browser.execute_script("""
            const put = (id, value) => {
              document.getElementById(id).value = value;
              document.getElementById(id).dispatchEvent(new Event('input'));
            };
            put('scale-low', '19.97');
            put('scale-high', '20.05');
            document.getElementById('scale-fixed').click();
            return [...document.querySelectorAll('.dygraph-axis-label-y:not(.dygraph-axis-label-y2)')].map(label => label.textContent);
            """)
        self.assertGreaterEqual(len(labels), 3)
        self.assertEqual(len(set(labels)), len(labels), labels)

    def test_2_labels_of_axes_do_not_touch(self) -> None:
        options = "name => ({pixelsPerLabel: 30, axisLabelFormatter: String})[name]"
        ticks = self.evaluate(f"chart.make_ticks(19, 31, 240, {options}, null).map(tick => [tick.v, tick.label])")
        self.assertGreaterEqual(len(ticks), 4)
        for value, label in ticks:
            self.assertEqual(label == "", value < 19.5, (value, label))
        for width in (360, 1200):
            self.set_width(width)
            self.browser.get("about:blank")
            self.open_view("trend")
            self.press("//button[.='All']")
            self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".dygraph-annotation"), 20))
            self.assertEqual(self.touching_labels(), [], width)

    def touching_labels(self) -> list[str]:
        """Returns the labels of the trend that cover each other."""
        return self.evaluate("""(() => {
            const find = name => [...document.querySelectorAll(name)].filter(one => one.textContent !== '');
            const names = ['.dygraph-axis-label', '.dygraph-ylabel', '.dygraph-y2label', '.dygraph-annotation'];
            const boxes = names.flatMap(find).map(one => {
              const range = document.createRange();
              range.selectNodeContents(one);
              const text = one.className.includes('annotation') ? one : range;
              return [one, text.getBoundingClientRect()];
            });
            const touch = (a, b) =>
              a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
            return boxes.flatMap(([one, box], i) => boxes.slice(i + 1)
              .filter(([other, its]) => touch(box, its)
                && !(one.className.includes('annotation') && other.className.includes('annotation')))
              .map(([other]) => one.textContent + ' and ' + other.textContent));
          })()""")

    def test_2_trend_of_long_run_has_labels_on_a_narrow_page(self) -> None:
        for width in (360, 800, 1200):
            for hours in (3, 15, 20, 50):
                for started_ms in ("1764495000000", "null"):
                    self.set_width(width)
                    self.browser.get("about:blank")
                    self.open_view("now")
                    self.expect_text("Last sample")
                    last = 3600 * hours - 1
                    air_c = -100 if hours == 50 else 20
                    self.replace_answers("/series?", f"""Response.json({{from: 0, step: 60, count: {60 * hours},
                        last: {last}, channels: [['chamber_air_c', '°C', {air_c}], ['rate', '°/h', 10.7]].map(
                        ([name, unit, mean]) => {{
                          const values = Array.from({{length: {60 * hours}}}, (_, i) => mean + 0.04 * Math.sin(i));
                          return {{name, unit, low: values, mean: values, high: values}};
                        }})}})""")
                    self.browser.execute_script(f"""
                        close_stream();
                        page.run.sample = null;
                        Object.assign(page.run.status, {{slot: {last}, started_ms: {started_ms}}});
                        location.hash = `#/run/${{page.run.key}}/trend`;
                        """)
                    for span in ("24 h", "All"):
                        self.press(f"//button[.='{span}']")
                        time.sleep(0.5)
                        shown = (width, hours, started_ms, span)
                        labels = self.evaluate("document.querySelectorAll('.dygraph-axis-label-x').length")
                        self.assertGreaterEqual(labels, 2, shown)
                        self.assertEqual(self.touching_labels(), [], shown)
                        self.assertIn("10.70", self.evaluate(
                            "[...document.querySelectorAll('.dygraph-axis-label-y2')].map(one => one.textContent)"))

    def test_2_trend_shows_no_gap_that_is_not_in_the_record(self) -> None:
        """A sample that does not follow the last one is not added: the samples before it are requested."""
        self.browser.get("about:blank")
        self.open_view("trend")
        self.press("//button[.='All']")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".chart canvas"), 10))
        time.sleep(2.5)
        self.browser.execute_script("close_stream(); window.requests = 0;")
        self.replace_answers("/series?", "(++requests, got)")
        time.sleep(0.3)  # longer than the shortest time between two redraws
        for count, skipped in enumerate((1, 30, 300), 1):
            self.browser.execute_script(f"""
                const sample = page.run.sample;
                handle_sample(Object.assign({{}}, sample, {{slot: sample.slot + 1 + {skipped}}}));
                """)
            self.assertEqual(self.evaluate("chart.count_empty_rows()"), 0, skipped)
            self.assertTrue(until(lambda: self.evaluate("requests") == count, 5), skipped)
            time.sleep(1.5)
            self.assertEqual(self.evaluate("chart.count_empty_rows()"), 0, skipped)

    def test_2_late_confirmation_is_requested_again(self) -> None:
        for verb, action in (("stop", "Stop run"), ("abort", "Abort run")):
            self.browser.get("about:blank")
            self.open_view("now")
            self.expect_text("Last sample")
            self.browser.execute_script("window.sent = [];")
            self.replace_answers("/" + verb, """(() => {
                const body = JSON.parse(options.body), tokens = [undefined, 'a', 'b', 'c'];
                sent.push([body.confirm, body.text]);
                if (body.confirm === 'c') return Response.json({done: 'the run ends'});
                const error = body.confirm && 'not sent: too late';
                const confirm = tokens[tokens.indexOf(body.confirm) + 1];
                return Response.json({confirm, question: '1 min done.', error}, {status: 409});
              })()""", asks=False)
            self.press(f"//button[@id='command-{verb}']")
            self.expect_text("1 min done.")
            self.assertNotIn("too late", self.text())
            self.enter("dialog-text", "smoke")
            for more in (" and fire", "", ""):
                self.assertTrue(self.evaluate("document.getElementById('dialog').open"))
                self.enter("dialog-text", more)
                self.browser.execute_script("window.form = document.querySelector('dialog form');")
                self.press(f"//dialog//button[.='{action}']")
                is_answered = "document.querySelector('dialog form') !== form || sent.at(-1)[0] === 'c'"
                self.assertTrue(until(lambda: self.evaluate(is_answered), 5))
                if more:
                    self.expect_text("Not sent: too late. 1 min done.")
            result = "document.getElementById('command-result').textContent"
            self.assertTrue(until(lambda: self.evaluate(result) == "the run ends", 5), self.evaluate(result))
            reason = "smoke and fire"
            self.assertEqual(self.evaluate("sent"), [[None, None], ["a", reason], ["b", reason], ["c", reason]])
            self.replace_answers("/" + verb, "Response.json({}, {status: 500})", asks=False)
            self.press(f"//button[@id='command-{verb}']")
            self.assertTrue(until(lambda: self.evaluate(result) == "the command was not carried out", 5))

    def events(self) -> list[tuple[str, str]]:
        found = Browser(self.monitor, "ada").ask(f"/api/v1/runs/{self.key}/events").json["events"]
        return [(event["kind"], event["text"]) for event in found]

    def take_pictures(self, name: str, views: tuple[str, ...]) -> None:
        for dark in (False, True):
            self.set_colour_scheme("dark" if dark else "light")
            for width in WIDTHS:
                self.set_width(width)
                for view in views:
                    self.browser.get("about:blank")
                    self.open_view(view)
                    time.sleep(1.5)
                    self.browser.save_screenshot(
                        f"{self.pictures}/{name}-{view}-{width}-{'dark' if dark else 'light'}.png"
                    )
        self.set_width(1200)

    def set_colour_scheme(self, scheme: str) -> None:
        self.browser.execute_cdp_cmd(
            "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        )

    def set_width(self, width: int) -> None:
        self.browser.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": False},
        )

    def test_2_page_fits_each_width_without_errors(self) -> None:
        axe = os.environ.get("GYROTHERM_AXE")
        for scheme in ("light", "dark"):
            self.set_colour_scheme(scheme)
            for width in WIDTHS:
                self.set_width(width)
                for view in VIEWS:
                    with self.subTest(scheme=scheme, width=width, view=view):
                        self.browser.get("about:blank")
                        self.open_view(view)
                        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "main > *"), 10))
                        time.sleep(0.7)
                        self.assertEqual(self.browser.find_element(By.ID, "connection").text, "")
                        self.assertLessEqual(
                            self.browser.execute_script("return document.documentElement.scrollWidth - innerWidth"), 0
                        )
                        if axe and width != 800:
                            self.browser.execute_cdp_cmd(
                                "Runtime.evaluate", {"expression": pathlib.Path(axe).read_text()}
                            )
                            found = self.browser.execute_async_script(
                                "axe.run().then(r => arguments[0](r.violations.map(v => [v.id, v.nodes.length, v.nodes[0].html])))"
                            )
                            self.assertEqual(found, [])
        said = [
            entry["message"]
            for entry in self.browser.get_log("browser")
            if entry["level"] == "SEVERE" and not any(code in entry["message"] for code in ("401", "409"))
        ]  # what was refused
        self.assertEqual(said, [])
        if self.pictures:
            self.take_pictures("run", VIEWS)

    def test_2_narrow_page_hides_no_text_beside_its_edge(self) -> None:
        self.set_width(360)
        for view in VIEWS:
            with self.subTest(view=view):
                self.browser.get("about:blank")
                self.open_view(view)
                self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "main > *"), 10))
                time.sleep(1.5)
                beyond = self.browser.execute_script("""
                    return [...document.querySelectorAll('.tabs a, td, .channels li, .pick label')]
                      .filter(element => element.getBoundingClientRect().right > innerWidth + 1)
                      .map(element => element.textContent);
                    """)
                self.assertEqual(beyond, [])

    def test_2_trend_has_an_axis_for_the_rate(self) -> None:
        self.set_width(1200)
        self.open_view("trend")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".dygraph-y2label"), 20))
        label = self.browser.find_element(By.CSS_SELECTOR, ".dygraph-y2label").get_attribute("textContent")
        self.assertEqual(label, "°/h")
        left = self.browser.find_element(By.CSS_SELECTOR, ".dygraph-ylabel").get_attribute("textContent")
        self.assertEqual(left, "°C")

    def test_2_trend_follows_new_events_and_samples(self) -> None:
        self.set_width(1200)
        self.browser.get("about:blank")
        self.open_view("trend")
        self.press("//button[.='10 min']")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".chart canvas"), 10))
        caption = "document.getElementById('trend-caption').textContent"
        loaded = until(lambda: self.evaluate(caption), 10)
        self.assertIn(", live", loaded)
        self.assertTrue(until(lambda: self.evaluate(caption) != loaded, 10), "it contains the present second")
        self.assertIsNone(self.browser.find_element(By.ID, "trend-caption").get_attribute("role"))
        told = gyrotherm("tell", str(self.run_.record), "note", "seen in the trend")
        self.assertEqual(told.returncode, 0, told.stderr)
        marks = "[...document.querySelectorAll('.dygraph-annotation')].filter(m => m.title.includes('seen in the trend'))"
        self.assertTrue(until(lambda: self.evaluate(f"{marks}.length") == 1, 15), "without a reload")
        series = "{from: 100, step: 2, count: 5}"
        events = "[99, 100, 109, 110, 500].map(slot => ({kind: 'note', slot, text: 'a'}))"
        for is_growing, times_s in (("false", [100, 108]), ("true", [100, 108, 110, 500])):
            marks = f"chart.make_marks({events}, {series}, 'air', 0, {is_growing})"
            self.assertEqual(self.evaluate(f"{marks}.map(mark => mark.x / 1000)"), times_s)
        joined = f"chart.make_marks({events}, {series}, 'air', 0, true, 6)"
        self.assertEqual(self.evaluate(f"{joined}.map(mark => [mark.x / 1000, mark.text.length])"), [[100, 5], [500, 1]])

    def test_2_trend_is_requested_again_after_a_failure(self) -> None:
        self.set_width(1200)
        self.browser.get("about:blank")
        self.open_view("now")
        self.assertTrue(until(lambda: self.evaluate("typeof page === 'object' && page.run !== null"), 15))
        self.browser.execute_script("""
            window.usual_fetch = window.fetch;
            window.fetch = (path, ...more) =>
              String(path).includes('/series?') ? Promise.reject(new Error('no line')) : usual_fetch(path, ...more);
            location.hash = location.hash.replace('now', 'trend');
            """)
        self.expect_text("the monitor does not respond")
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, ".chart canvas"), [])
        self.browser.execute_script("window.fetch = window.usual_fetch")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".chart canvas"), 15))
        self.assertNotIn("the monitor does not respond", self.text())

    def test_2_values_are_written_as_people_write_them(self) -> None:
        self.open_view("now")
        written = {
            "format_with_unit(null, '°C')": "–",
            "format_with_unit(1, '1')": "1",
            "format_with_unit(0, '1')": "0",
            "format_with_unit(-3, '1')": "\u22123",
            "format_with_unit(0.12, '1')": "0.120",
            "format_with_unit(0.00034567, '1')": "0.000346",
            "format_with_unit(1234.5, '1')": "1235",
            "format_with_unit(null, '1')": "–",
            "format_signed(0.001, 2)": "0.00",
            "format_signed(-0.001, 2)": "0.00",
            "format_signed(0.5, 2)": "+0.50",
            "format_signed(10, 0)": "+10",
            "format_round_duration(0)": "0 s",
            "format_round_duration(1800)": "30 min",
            "format_round_duration(3600)": "1 h",
            "format_round_duration(90)": "1 min 30 s",
            "format_round_duration(86400)": "1 d",
            "format_text('ramp to -40 °C')": "ramp to \u221240\u00a0°C",
            "format_text('check-standard 2-3')": "check-standard 2-3",
            "channel_label({name: 'u1.discharge_current_a', unit: 'A'})": "u1.discharge current",
            "channel_label({name: 'x.discharge_current_ma', unit: 'mA'})": "x.discharge current",
            "channel_label({name: 'x.pickoff_mv', unit: 'mV'})": "x.pickoff",
            "channel_label({name: 'heater_v', unit: '°C'})": "heater v",
            "channel_label({name: 'true_bias_deg_per_h', unit: '°/h'})": "true bias",
            "channel_label({name: 'chamber_air_c', unit: '°C'})": "air",
            "channel_label({name: 'frames', unit: '1'})": "frames",
            "format_u(0.285)": "0.285\u00a0°/h",
            "format_u(0.1)": "0.100\u00a0°/h",
            "format_u(0.09996)": "0.100\u00a0°/h",
            "format_u(12.34)": "12.3\u00a0°/h",
            "format_u(1234)": "1234\u00a0°/h",
            "format_u(null)": "unknown",
            "format_probability(1)": ">\u00a099.9\u00a0%",
            "format_probability(0.9994)": "99.9\u00a0%",
            "format_probability(0)": "<\u00a00.1\u00a0%",
            "format_with_uncertainty(0.48831, 0.0463, 'K')": "0.488 ± 0.046 K",
            "format_with_uncertainty(-12.34, 3.2, 'K')": "\u221212.3 ± 3.2 K",
            "format_text('set point -40.5 °C, was (-2 °C)')": "set point \u221240.5\u00a0°C, was (\u22122\u00a0°C)",
            "text_nodes('resume with --accept, and --json').length": 5,
            "text_nodes('by 5--6 or a-b').length": 1,
            "format_time(Date.UTC(2001, 5, 1, 12), true).includes('2001')": True,
            "format_tick(Date.now(), true).length < 18": True,
            "format_time(Date.now(), true).startsWith(format_tick(Date.now(), true) + ' ')": True,
            "/^.*2001, \\d\\d:00 [A-Z]\\S+$/.test(format_time(Date.UTC(2001, 0, 1, 12), true))": True,
            "/^\\d\\d:00:00 [A-Z]\\S+$/.test(format_time(Date.UTC(2001, 6, 1, 12)))": True,
            "/^\\d\\d:00:00$/.test(format_tick(Date.UTC(2001, 6, 1, 12)))": True,
            "format_time(null, true)": "–",
            "format_with_unit(0.0010001, 'A')": "0.0010001\u00a0A",
            "format_with_unit(0.00100012, 'A')": "0.0010001\u00a0A",
            "format_with_unit(45.1234567, '%')": "45.123\u00a0%",
            "format_with_unit(0, 'V')": "0.0000\u00a0V",
            "format_with_unit(-12.5, 'mV')": "\u221212.500\u00a0mV",
            "format_with_unit(123456.7, 'Hz')": "123457\u00a0Hz",
            "format_with_unit(null, 'A')": "–",
            "format_with_unit(20.1234, '°C')": "20.12\u00a0°C",
            "format_with_unit(9.87654321, '°/h')": "9.8765\u00a0°/h",
            "cell_text(0.00671567)": "0.006716",
            "cell_text(0.888889)": "0.8889",
            "cell_text(-0.5)": "\u22120.5",
            "cell_text(0.05)": "0.05",
            "cell_text(43.9)": "43.9",
            "cell_text(57.1)": "57.1",
            "cell_text(57.0001)": "57",
            "cell_text(0.050049)": "0.05005",
            "cell_text(100.5)": "100.5",
            "cell_text(1200.4)": "1200",
            "cell_text(123456.7)": "123457",
            "cell_text(5000)": "5000",
            "cell_text(-3)": "\u22123",
            "cell_text(null)": "–",
            "cell_text(true)": "yes",
            "cell_text('2023-12-27 10:00:00.5+00')": "2023-12-27 10:00:00 UTC",
            "cell_content('2023-12-27').className": "no-break",
            "cell_content('chamber-3')": "chamber-3",
            "column_title('drift', 'e_n')": "E_n",
            "column_title('yield', 'low')": "95\u00a0% low",
            "column_title('alarms', 'low')": "low",
            "column_title('rigs', 'last_row')": "last row",
            "event_time_s({slot: 35999})": 36000,
            "event_time_s({slot: -1})": 0,
            "event_time_s({slot: 0, kind: 'started'})": 0,
            "event_time_s({slot: 0, kind: 'segment'})": 1,
            "event_time_s({slot: 7, time_s: 3.5})": 3.5,
            "make_sentence('the query failed: permission denied')": "The query failed: permission denied.",
            "found_text(1, 1)": "1 of 1 event",
            "found_text(0, 1)": "0 of 1 event",
            "found_text(1, 2)": "1 of 2 events",
            "found_text(0, 0)": "0 of 0 events",
            "time_left_s({running: true, state: 'aborting', time_left_s: 5})": None,
            "time_left_s({running: true, state: 'held', time_left_s: 5})": 5,
        }
        for call, text in written.items():
            self.assertEqual(self.browser.execute_script("return " + call), text, call)

    def test_2_phase_is_shown_only_while_the_profile_commands(self) -> None:
        self.open_view("now")
        status = "segment: 'hold -20 °C', segment_index: 2, segment_count: 12, phase: 'holding'"
        sample = "{in_segment_s: 1590}"
        place = "segment 3 of 12: hold \u221220\u00a0°C"
        for state, shown in (
            ("running: true, state: 'execute'", f"S{place[1:]} (holding, 26 min 30 s elapsed)"),
            ("running: true, state: 'held'", f"S{place[1:]} (holding, 26 min 30 s elapsed)"),
            ("running: true, state: 'aborting', cause: 'stopped by ada'", f"Ended in {place}, after 26 min 30 s"),
            ("running: false, state: 'stopped', finished: true", f"Ended in {place}, after 26 min 30 s"),
            ("running: false, state: 'aborted'", f"Ended in {place}, after 26 min 30 s"),
            ("running: false, state: 'aborting'", f"Ended in {place}, after 26 min 30 s"),
            ("running: false, state: 'execute'", f"Interrupted in {place}, after 26 min 30 s"),
            ("running: false, state: 'complete', finished: true", "All 12 segments are done"),
        ):
            self.assertEqual(self.evaluate(f"position_text({{{status}, {state}}}, {sample})"), shown)
        self.assertEqual(self.evaluate(f"position_text({{{status}, running: false, state: 'held'}}, null)"),
                         f"Interrupted in {place}")
        self.assertEqual(self.evaluate("position_text({segment_count: 0, running: true, state: 'held'}, null)"), "")

    def test_2_interrupted_run_has_last_values(self) -> None:
        self.open_view("now")
        interrupted = "name: 'quick', running: false, state: 'execute', age_s: 100"
        self.assertEqual(self.evaluate(f"set_point_label({{{interrupted}}})"), "Last set point of the run")
        self.assertEqual(self.evaluate("set_point_label({running: true, state: 'execute'})"), "Set point")
        self.assertEqual(self.evaluate("set_point_label({running: true, state: 'aborting'})"), "Chamber set point")
        self.assertEqual(
            self.evaluate("set_point_label({running: false, state: 'aborting'})"), "Last set point of the chamber"
        )
        run = f"{{status: {{{interrupted}}}, status_received_ms: 1000, sample: {{}}, sample_received_ms: 2000}}"
        self.assertEqual(self.evaluate(f"sample_age_s({run}, 3000)"), 102)
        self.assertIsNone(self.evaluate(f"sample_age_s({run.replace('age_s: 100', 'age_s: null')}, 3000)"))
        self.assertIsNone(self.evaluate(f"sample_age_s({run.replace('execute', 'aborted')}, 3000)"))
        trace = "made_safe: {utc_ms: Date.now(), set_point_c: 20, confirmed: true, given_up: false}"
        for more, shown in (
            ("", "gyrotherm status quick.db"),
            (", " + trace, "sent the chamber to its safe set point of 20.0\u00a0°C at"),
            (", " + trace.replace("true", "false"), "has NOT brought the chamber"),
            (", " + trace.replace("true, given_up: false", "false, given_up: true"), "an operator has ended"),
            (", simulated: true, virtual_instruments: ['gyro']", "gyrotherm-make-safe"),
        ):
            self.assertIn(shown, self.evaluate(f"safe_chamber_text({{{interrupted}{more}}})"))
        for more in ("simulated: true", "running: true", "finished: true", "state: 'aborted'"):
            self.assertEqual(self.evaluate(f"safe_chamber_text({{{interrupted}, {more}}})"), "", more)

    def test_2_missing_value_has_its_reason(self) -> None:
        self.open_view("now")
        fault, recovered = "{kind: 'fault', channel: '%s'}", "{kind: 'recovered', channel: '%s'}"
        y = "{name: 'y.rate_deg_per_h', unit_under_test: 'y'}"
        voltage = "{name: 'y.supply_v', unit_under_test: 'y'}"
        thermometer, air = "{name: 'A', unit_under_test: 'y'}", "{name: 'chamber_air_c', unit_under_test: ''}"
        dropped, returned = "{kind: 'dropped', channel: 'y'}", "{kind: 'returned', channel: 'y'}"
        raised = "{kind: 'fault', channel: 'y', interlock: 'no_counts'}"
        for channel, events, reason in (
            (y, (), ""),
            (y, (dropped,), "dropped"),
            (voltage, (dropped,), "dropped"),
            (y, (fault % "y", dropped), "dropped"),
            (y, (dropped, returned), ""),
            (y, (fault % "y", dropped, returned), "fault"),
            (y, (fault % "x",), ""),
            (y, (fault % "y", recovered % "y"), ""),
            (y, (fault % "y", "{kind: 'resumed'}"), ""),
            (y, (raised,), ""),
            (voltage, (fault % "y.supply_v",), "fault"),
            (thermometer, (fault % "A",), "fault"),
            (thermometer, (fault % "B",), ""),
            (air, (fault % "chamber",), "fault"),
        ):
            run = f"{{status: {{imported: false}}, events: [{', '.join(events)}]}}"
            self.assertEqual(self.evaluate(f"missing_reason({run}, {channel})"), reason, (channel, events))
        imported = f"{{status: {{imported: true}}, events: [{fault % 'y'}]}}"
        self.assertEqual(self.evaluate(f"missing_reason({imported}, {y})"), "")
        run = f"{{events: [{dropped}], units: [{{name: 'x', in_use: true}}, {{name: 'y', in_use: true}}]}}"
        positions = f"unit_rows({run}).map(row => row.firstChild.textContent)"
        self.assertEqual(self.evaluate(positions), ["x", "y (dropped)"])

    def test_2_expected_end_follows_the_status(self) -> None:
        """The views Now and Rigs show the same end, also if the last sample is of another second."""
        self.open_view("now")
        self.expect_text("Time left")
        status = "{running: true, state: 'execute', utc_ms: 24111000, slot: 24109, time_left_s: 3790}"
        self.assertEqual(self.evaluate(f"expected_end_ms({status})"), 1000 + 27900000)
        self.assertIsNone(self.evaluate(f"expected_end_ms({status.replace('24111000', 'null')})"))
        self.assertIsNone(self.evaluate(f"expected_end_ms({status.replace('true', 'false')})"))
        shown = self.evaluate("""[-90, 0, 90].map(seconds => {
            const {sample, status} = page.run, end = [...document.querySelectorAll('dt')].find(dt => dt.textContent === 'Ends');
            page.run.sample = Object.assign({}, sample, {utc_ms: sample.utc_ms + 1000 * seconds});
            page.view.refresh();
            page.run.sample = sample;
            return end.nextElementSibling.textContent === format_time(expected_end_ms(status), true);
          })""")
        self.assertEqual(shown, [True, True, True])

    def test_2_rate_of_last_second_is_that_of_the_sample(self) -> None:
        self.open_view("now")
        rate = "rate_deg_per_h: 10.6, mean_100s_deg_per_h: 10.5, earth_rate_deg_per_h: 10"
        for axis, channel, unit, sample, running, shown in (
            ("gyro", "rate", "°/h", "{slot: 9, values: [20, 10.7]}", "true", "10.7000"),
            ("x.z", "x.z.rate", "°/h", "{slot: 9, values: [20, 10.7]}", "true", "10.7000"),
            ("x.z", "x.z.rate", "°/h", "{slot: 9, values: [20, null]}", "true", "–"),
            ("x.z", "x.z.rate", "°/h", "null", "true", "10.6000"),
            ("x.z", "x.z.rate", "°/h", "{slot: 8, values: [20, 10.7]}", "false", "10.6000"),
            ("x.z", "x.y.rate", "°/h", "{slot: 9, values: [20, 10.7]}", "true", "10.6000"),
            ("gyro", "rate", "V", "{slot: 9, values: [20, 10.7]}", "true", "10.6000"),
        ):
            run = (f"{{channels: [{{name: 'set_point_c', unit: '°C'}}, {{name: '{channel}', unit: '{unit}'}}],"
                   f" sample: {sample}, status: {{running: {running}, slot: 9}}}}")
            row = self.evaluate(f"[...rate_row({run}, {{axis: '{axis}', {rate}}}).cells].map(cell => cell.textContent)")
            self.assertEqual(row, [axis, shown, "10.5000", "10.0000"], (axis, channel, sample))

    def test_2_site_uses_the_width_of_the_page(self) -> None:
        rows = "[{rig: 'chamber-3', runs: 57, hours: 57.1, last_run: '2026-11-30 07:45:00+00', days_since: 0.05}]"
        for width in (360, 800, 1280):
            self.set_width(width)
            self.browser.get("about:blank")
            self.open_view("rigs")
            self.expect_text("soak")
            self.replace_answers("/api/v1/site", f"""Response.json(path === '/api/v1/site' ? {{name: 'hall 2',
                store: {{age_s: 1, error: ''}}, rigs: [], questions: ['standards', 'utilisation']}} : {rows})""",
                asks=False)
            self.browser.execute_script("location.hash = '#/site'")
            self.expect_text("Runs on virtual rigs are not listed below.")
            note = "[...document.querySelectorAll('.wide > .note')].map(one => [one.clientWidth, one.clientHeight])[0]"
            note_width, note_height = self.evaluate(note)
            self.assertGreater(note_width, 0.8 * width - 40)
            self.assertLess(note_height, 60, "two lines at most")
            sections = self.evaluate("[...document.querySelectorAll('.wide > .sheet')].map(one => one.clientWidth)")
            self.assertEqual(len(sections), 2)
            for section in sections:
                self.assertGreaterEqual(section, note_width - 4)
            for summary in self.browser.find_elements(By.CSS_SELECTOR, "summary"):
                summary.click()
            self.assertTrue(until(lambda: self.evaluate("document.querySelectorAll('.wide td').length") == 10, 5))
            cut = self.evaluate("""[...document.querySelectorAll('.wide td')].filter(cell => {
                const range = document.createRange();
                range.selectNodeContents(cell);
                return range.getBoundingClientRect().right > cell.closest('.scroll').getBoundingClientRect().right;
              }).map(cell => cell.textContent)""")
            self.assertEqual(cut, [], width)
            self.assertIn("0.05", self.text())
            self.assertIn("57.1", self.text())

    def test_2_label_is_beside_its_field(self) -> None:
        seen = set()
        for width in (360, 420, 1200):
            self.set_width(width)
            for view in ("events", "trend", "alarms", "now"):
                self.browser.get("about:blank")
                self.open_view(view)
                self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "main > *"), 10))
                time.sleep(0.7)
                pairs = self.evaluate("""[...document.querySelectorAll('main label[for], main .field')].flatMap(label => {
                    const field = label.htmlFor ? document.getElementById(label.htmlFor) : label.lastChild;
                    const [a, b] = [label.htmlFor ? label : label.firstChild, field].map(one => one.getBoundingClientRect());
                    const is_unseen = label.classList.contains('unseen') || field.offsetParent === null;
                    return is_unseen ? [] : [[field.id, a.top < b.bottom && b.top < a.bottom, b.right <= innerWidth]];
                  })""")
                for name, is_beside, is_inside in pairs:
                    self.assertTrue(is_beside and is_inside, (width, view, name))
                    seen.add(name)
        for name in ("event-kind", "event-text", "note-text", "scale-low", "scale-high", "scale-fixed"):
            self.assertIn(name, seen)

    def test_2_ended_run_has_its_end(self) -> None:
        self.open_view("now")
        self.expect_text("Time left")
        fields = "started_ms: 1000, slot: 99, length_s: 100, imported: false"
        for state, end_ms in (
            ("running: false, state: 'complete', finished: true", 101000),
            ("running: false, state: 'aborted'", 101000),
            ("running: true, state: 'execute'", None),
            ("running: false, state: 'execute'", None),
            ("running: false, state: 'complete', trouble: 'unreadable'", None),
        ):
            self.assertEqual(self.evaluate(f"ended_ms({{{fields}, {state}}})"), end_ms, state)
        labels = self.evaluate("""(() => {
            const status = page.run.status, view = page.view;
            page.run.status = Object.assign({}, status, {running: false, state: 'execute', finished: true});
            view.refresh();
            const boxes = [...document.querySelectorAll('[aria-labelledby=now-times] dl > div')];
            const labels = boxes.filter(box => !box.hidden).map(box => box.firstChild.textContent);
            page.run.status = status;
            view.refresh();
            return labels;
          })()""")
        self.assertEqual(labels, ["Elapsed", "Ended", "UTC"])
        imported = "{name: 'german.csv', profile: 'imported', rig: 'german', imported: true}"
        self.assertEqual(self.evaluate(f"run_title({imported})"), "german.csv · imported")
        self.assertEqual(self.evaluate(f"run_title({imported.replace('true', 'false')})"),
                         "german.csv · imported on german")

    def test_4_rigs_have_no_imported_records(self) -> None:
        self.browser.get("about:blank")
        self.open_view("rigs")
        self.expect_text("soak")
        self.replace_runs_answer(
            "new Response(JSON.stringify({runs: json.runs.concat(json.runs.map(run => Object.assign({}, run,"
            " {key: 'table', name: 'german.csv', rig: 'german', imported: true, running: false})))}))"
        )
        time.sleep(4.5)
        self.assertIn("soak", self.text())
        self.assertNotIn("german", self.text())
        self.replace_runs_answer(
            "new Response(JSON.stringify({runs: json.runs.map(run => Object.assign({}, run,"
            " {key: 'table', name: 'german.csv', rig: 'german', imported: true, running: false}))}))"
        )
        self.expect_text("have only imported records")

    def test_2_segment_keeps_its_first_beginning(self) -> None:
        self.open_view("profile")
        begun = "[{segment: 0, utc_ms: 1000}, {segment: 1, utc_ms: 5000}, {segment: 0, utc_ms: 9000}]"
        events = ("[{kind: 'segment', segment: 1, utc_ms: 5000}, {kind: 'note', segment: 2, utc_ms: 6000},"
                  " {kind: 'segment', segment: 2, utc_ms: 7000}]")
        run = f"{{plan: {{begun: {begun}}}, events: {events}}}"
        self.assertEqual(self.evaluate(f"[...segment_beginnings({run})]"), [[0, 1000], [1, 5000], [2, 7000]])

    def test_2_alarms_of_ended_run_cannot_be_selected(self) -> None:
        self.open_view("alarms")
        alarm = "{number: 1, interlock: 'a', text: 'a', utc_ns: 1, acknowledged: false}"
        for running, acknowledged in ((True, False), (True, True), (False, False), (False, True)):
            disabled = self.evaluate(
                f"(row => (row.update(Object.assign({alarm}, {{acknowledged: {str(acknowledged).lower()}}}), []),"
                f" row.box.disabled))(make_alarm_row({{status: {{running: {str(running).lower()}}}}}, () => {{}}))"
            )
            self.assertEqual(disabled, acknowledged or not running)

    def test_2_alarms_of_ended_run_are_not_active_now(self) -> None:
        self.open_view("alarms")
        alarms = [f"{{number: {i}, interlock: 'i{i}', text: 't', utc_ns: 1, active: {active}}}"
                  for i, active in enumerate(("true", "true", "false"))]
        for status, state, badge, red in (
            ("running: true, state: 'held'", "active", "3 alarms", True),
            ("running: false, state: 'execute', finished: true", "active at the end of the run",
             "3 unacknowledged alarms", False),
            ("running: false, state: 'aborted'", "active at the end of the run", "3 unacknowledged alarms", False),
            ("running: false, state: 'execute'", "active at the interruption", "3 unacknowledged alarms", False),
        ):
            status = f"{{{status}, alarms: [{', '.join(alarms)}]}}"
            self.assertEqual(self.evaluate(f"alarm_summary({status})"),
                             f"3 unacknowledged alarms: 2 {state}, 1 returned")
            row = (f"(row => (row.update({alarms[0]}, [{alarms[1]}, {alarms[2]}]), row.element))"
                   f"(make_alarm_row({{status: {status}}}, () => {{}}))")
            self.assertEqual(self.evaluate(f"{row}.querySelector('.badge').textContent"), state.capitalize())
            self.assertEqual(self.evaluate(f"{row}.querySelector('.badge').classList.contains('alarm')"), red)
            self.assertEqual(self.evaluate(f"{row}.classList.contains('active')"), red)
            lines = self.evaluate(f"[...{row}.querySelectorAll('details li')].map(line => line.textContent)")
            self.assertEqual([line.split(":")[0] for line in lines], [state.capitalize(), "Returned"])
            self.assertEqual(self.evaluate(f"alarms_badge({status}).textContent"), badge)
            self.assertEqual(self.evaluate(f"alarms_badge({status}).classList.contains('alarm')"), red)

    def test_2_controls_follow_the_state_of_the_run(self) -> None:
        """A view that was opened while no program executed the run shows its controls after a resume."""
        for view, section in (("now", "control"), ("events", "note")):
            self.browser.get("about:blank")
            self.open_view(view)
            self.assertTrue(until(lambda: self.browser.find_elements(By.ID, section), 10))
            seen = self.evaluate(f"""(() => {{
                const status = page.run.status, hidden = () => document.getElementById('{section}').hidden, seen = [];
                page.run.status = Object.assign({{}}, status, {{running: false}});
                page.view.close?.();
                page.view = views.{view}(document.getElementById('content'));
                page.view.refresh();
                seen.push(hidden());
                for (const running of [true, false, true]) {{
                  handle_status(Object.assign({{}}, status, {{running}}));
                  seen.push(hidden());
                }}
                return seen;
              }})()""")
            self.assertEqual(seen, [True, False, True, False], view)

    def test_2_profile_is_drawn_again_at_the_end(self) -> None:
        self.browser.get("about:blank")
        self.open_view("profile")
        self.expect_text("red: deviation of the air from the set point, from 0.5\u00a0K on")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".profile-svg .now"), 15))
        for change in ("finished: true, state: 'execute'", "finished: true, state: 'stopped'", "state: 'execute'"):
            shown = self.evaluate(f"""(() => {{
                const status = page.run.status, find = name => document.querySelector('.profile-svg .' + name);
                const shown = () => [find('now') !== null, find('remaining').getAttribute('d') !== ''];
                handle_status(Object.assign({{}}, status, {{running: true, state: 'execute', time_left_s: 600}}));
                const before = shown();
                handle_status(Object.assign({{}}, status, {{running: false, {change}}}));
                const after = shown();
                handle_status(Object.assign({{}}, status));
                return [before, after];
              }})()""")
            self.assertEqual(shown, [[True, True], [False, False]], change)
        inside = self.evaluate("""(() => {
            const status = page.run.status, sample = page.run.sample;
            page.run.sample = Object.assign({}, sample, {slot: sample.slot + 900});
            handle_status(Object.assign({}, status, {state: 'aborting'}));
            const now = document.querySelector('.profile-svg .now'), box = now.ownerSVGElement.viewBox.baseVal;
            const inside = now.x1.baseVal.value < box.width;
            page.run.sample = sample;
            handle_status(status);
            return inside;
          })()""")
        self.assertTrue(inside)

    def test_2_last_refresh_of_profile_is_drawn(self) -> None:
        """A refresh within the shortest interval between two pictures is drawn after it."""
        self.browser.get("about:blank")
        self.open_view("profile")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".profile-svg .now"), 15))
        self.browser.execute_script("""
            close_stream();
            page.view.refresh();
            window.drawn = document.querySelector('.profile-svg');
            page.view.refresh();
            """)
        self.assertTrue(until(lambda: self.evaluate("document.querySelector('.profile-svg') !== drawn"), 10))

    def test_2_last_step_of_uncertainty_is_visible(self) -> None:
        """The decision to end a run is drawn with a step, even if the run ends in the same second."""
        self.open_view("profile")
        for length_s, running in ((7200, False), (7200, True), (7100, False), (9000, False)):
            decisions = ", ".join(
                f"{{u_now_deg_per_h: {u}, hours_used: {hours}, hours_left: 1, block: '{block}'}}"
                for u, hours, block in ((0.3, 1, "cold"), (0.1, 2, ""))
            )
            status = f"{{running: {str(running).lower()}, state: 'execute', length_s: {length_s}, time_left_s: 0}}"
            self.browser.execute_script(f"""
                const box = document.createElement('div');
                box.id = 'steps';
                document.getElementById('steps')?.remove();
                document.getElementById('content').append(box);
                drawing.draw_uncertainty(box, {{sample: null, status: {status},
                  plan: {{goal: {{u_deg_per_h: 0.1, decisions: [{decisions}]}}}}}});
                """)
            path = until(lambda: self.evaluate("document.querySelector('#steps .done')?.getAttribute('d')"), 10)
            begin, end = [float(x) for x in re.findall(r"[ML]([\d.]+) [\d.]+H([\d.]+)", path)[-1]]
            self.assertGreater(end - begin, 5, f"{length_s}: {path}")

    def test_2_failed_query_to_the_store_is_one_sentence(self) -> None:
        self.open_view("rigs")
        for age_s, shown in (("null", ""), ("90", " The list is 1 min 30 s old.")):
            note = self.evaluate(f"site_note({{store: {{error: 'permission denied', age_s: {age_s}}}, rigs: []}})")
            self.assertEqual(note, "The query to the store failed: permission denied." + shown)

    def test_2_list_of_rigs_names_a_stop(self) -> None:
        """The store of a site has the cause of the state only as a text."""
        self.open_view("rigs")
        rig = "rig: 'r', segment: null, chamber_air_c: null, set_point_c: null, alarms: null, age_s: null"
        for state, cause, shown in (
            ("aborting", "'stopped by ada (uid 0): smoke'", "Stopping"),
            ("aborting", "'aborted by ada (uid 0)'", "Aborting"),
            ("aborting", "'the air is too hot'", "Aborting"),
            ("aborting", "null", "Aborting"),
            ("stopped", "'stopped by ada (uid 0)'", "Stopped"),
            ("idle", "null", "Idle"),
        ):
            row = self.evaluate(
                f"rig_row({{{rig}, state: '{state}', cause: {cause}}}).querySelector('[data-title=State]').textContent"
            )
            self.assertEqual(row.strip(), shown, cause)

    def test_2_summary_of_alarms_has_its_numbers(self) -> None:
        self.open_view("now")
        root, consequence = "{number: 1, active: true}", "{number: 2, suppressed_by: 'a'}"
        for alarms, text in (
            ([root], "1 unacknowledged alarm: 1 active"),
            ([root, consequence], "with 1 consequence that is acknowledged together with it"),
            ([root, consequence, consequence], "with 2 consequences that are acknowledged together with it"),
            ([root, root, consequence], "with 1 consequence that is acknowledged together with them"),
        ):
            self.assertIn(text, self.evaluate(f"alarm_summary({{running: true, alarms: [{', '.join(alarms)}]}})"))

    def test_2_time_left_ends_with_the_decision_to_end(self) -> None:
        self.open_view("now")
        decision = "{block: 'cold', hours_used: 1, hours_left: 2}"
        status = f"{{running: true, state: 'execute', slot: 3599, length_s: 3600, time_left_s: 90, decision: {decision}}}"
        self.assertEqual(self.evaluate(f"goal_left_s({status}, null)"), 7200)
        self.assertEqual(self.evaluate(f"goal_left_s({status.replace('cold', '')}, null)"), 90)
        self.assertIsNone(self.evaluate(f"goal_left_s({status.replace('cold', '').replace('true', 'false')}, null)"))

    def test_chamber_that_refuses_safe_state_is_not_called_watched(self) -> None:
        began = "{kind: 'state', utc_ms: 1000}"
        for faults, expected in (("[]", 301000), ("['the chamber could NOT be sent to 20 °C (exception 4)']", None)):
            status = f"{{running: true, state: 'aborting', observe_s: 300, faults_now: {faults}}}"
            self.assertEqual(self.evaluate(f"watched_until_ms({{status: {status}, events: [{began}]}})"), expected)

    def test_card_of_rig_shows_chamber_that_returns(self) -> None:
        for chamber, state, expected in ((24, "suspended", True), (28, "execute", False), (20, "aborting", False)):
            status = f"{{running: true, state: '{state}', set_point_c: 28.3, chamber_set_point_c: {chamber}}}"
            self.assertEqual(self.evaluate(f"is_chamber_elsewhere({status})"), expected)

    def test_2_imported_record_has_its_own_times(self) -> None:
        rows = "".join(f"{10 * row},{20 + row / 100:.2f},{9 + row / 1000:.3f}\n" for row in range(360))
        (self.folder / "log.csv").write_text("t_s,T1,rate_dph\n" + rows)
        record, column_map = self.folder / "log.db", self.folder / "map.toml"
        for words in (("--guess", "--out", str(column_map)), ("--map", str(column_map), "--out", str(record))):
            made = gyrotherm("import", str(self.folder / "log.csv"), *words)
            self.assertEqual(made.returncode, 0, made.stderr)
        headers = Browser(self.monitor, "ada").headers
        key = until(lambda: key_of(self.monitor, headers, "log"))
        address = f"http://127.0.0.1:{self.monitor.port}/#/run/{key}/"
        self.browser.get("about:blank")
        self.browser.get(address + "now")
        self.expect_text("59 min 50 s")
        self.expect_text("Imported")
        self.expect_text("23.59")
        for absent in ("fault", "1970", "Set point", "Time left", "\nProfile\n\n"):
            self.assertNotIn(absent, self.text().split("Rigs", 1)[1])
        self.browser.get(address + "trend")
        self.expect_text("0 s to 59 min 50 s, every row")
        last = self.evaluate("chart.shown_times_s().at(-1)")
        self.assertEqual(last, 3590)
        self.assertNotIn("1970", self.text())
        self.browser.get(address + "events")
        self.expect_text("59 min 50 s")
        self.browser.get(f"http://127.0.0.1:{self.monitor.port}/#/runs")
        self.expect_text("59 min 50 s")
        for path in (record, record.with_name("log.db.sha256")):
            path.unlink()

    def test_2_profile_is_drawn_for_each_width(self) -> None:
        for view in ("now", "profile"):
            self.set_width(1200)
            self.open_view(view)
            width = "document.querySelector('.profile-svg')?.viewBox.baseVal.width - " \
                "document.querySelector('.profile-svg')?.parentElement.clientWidth"
            for pixels in (1200, 700, 1500):
                self.set_width(pixels)
                self.assertTrue(until(lambda: self.evaluate(width) == 0, 10), f"{view} {pixels}: {self.evaluate(width)}")

    def test_2_mark_of_an_alarm_has_its_colour(self) -> None:
        colours = self.evaluate('''(() => {
            const mark = document.createElement('div');
            mark.className = 'dygraph-annotation alarm-mark';
            mark.style.color = mark.style.borderColor = 'rgb(1, 2, 3)';
            document.body.append(mark);
            const style = getComputedStyle(mark), colours = [style.color, style.borderTopColor];
            mark.remove();
            return colours;
          })()''')
        self.assertNotIn("rgb(1, 2, 3)", colours)

    def test_3_page_is_usable_by_keyboard(self) -> None:
        self.set_width(1200)
        self.open_view("now")
        self.expect_text("Suspended", 20)
        reached = set()
        for _ in range(40):
            self.browser.switch_to.active_element.send_keys("\ue004")
            focused = self.browser.switch_to.active_element
            reached.add(focused.text or focused.get_attribute("id"))
            outline = self.browser.execute_script("return getComputedStyle(document.activeElement).outlineStyle")
            self.assertTrue(outline != "none" or focused.tag_name == "body", focused.get_attribute("outerHTML")[:80])
        for words in ("Skip to the content", "Trend", "Rigs", "Pause", "Stop …"):
            self.assertIn(words, reached)

    def evaluate(self, script: str):
        """Returns the result of the page's own functions."""
        return self.browser.execute_script(f"return {script}")

    def connection(self) -> str:
        return self.browser.find_element(By.ID, "connection").text

    def replace_answers(self, part: str, answer: str, asks: bool = True) -> None:
        """Replaces later answers to requests whose path contains `part`. `answer` is computed from the monitor's answer,
        `got`, unless `asks` is false, and from the `options` of the request."""
        self.browser.execute_script(f"""
            window.own_fetch ??= window.fetch;
            window.fetch = async (path, options) => {{
              if (!path.includes('{part}')) return own_fetch(path, options);
              const got = {"await own_fetch(path, options)" if asks else "null"};
              return {answer};
            }};
            """)

    def replace_runs_answer(self, answer: str) -> None:
        """Replaces later answers to requests for all runs. `answer` is computed from the monitor's answer, `json`."""
        self.browser.execute_script(f"""
            window.own_fetch ??= window.fetch;
            window.fetch = async (path, options) => {{
              const got = await own_fetch(path, options);
              if (path !== '/api/v1/runs') return got;
              const json = await got.json();
              return {answer};
            }};
            """)

    def test_4_new_data_keeps_focus_on_link(self) -> None:
        for view, box in (("rigs", ".cards"), ("runs", "tbody")):
            with self.subTest(view):
                self.browser.get("about:blank")
                self.open_view(view)
                self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, box + " a"), 10))
                self.browser.execute_script(f"document.querySelector('{box} a').focus()")
                self.replace_runs_answer(
                    "new Response(JSON.stringify({runs: json.runs.concat(json.runs.map(run => Object.assign({}, run,"
                    " {key: 'another', name: 'another', rig: 'another', profile: 'quite another'}))).reverse()}))"
                )
                self.expect_text("quite another")
                self.assertIn(f"/{self.key}/", self.evaluate("document.activeElement.getAttribute('href')"))

    def test_5_old_data_is_reported(self) -> None:
        for view in ("rigs", "runs"):
            with self.subTest(view):
                self.browser.get("about:blank")
                self.open_view(view)
                self.expect_text("soak")
                self.replace_runs_answer("new Response('{\"error\": \"too many requests\"}', {status: 429})")
                self.assertTrue(until(lambda: "too many requests" in self.connection(), 10))
                self.assertNotIn("There is no record", self.text())
                self.browser.execute_script("window.fetch = own_fetch")
                self.assertTrue(until(lambda: not self.connection(), 10))
                self.monitor.kill()
                self.assertTrue(until(lambda: "the monitor does not respond" in self.connection(), 10))
                self.assertIn("since", self.connection())
                self.monitor.again()
                self.assertTrue(until(lambda: not self.connection(), 10))

    def test_6_display_state_follows_status(self) -> None:
        self.open_view("now")
        self.expect_text("Last sample")
        for state, finished, said in (
            ("execute", False, "interrupted"),
            ("suspended", False, "interrupted"),
            ("held", False, "interrupted"),
            ("aborting", False, "interrupted"),
            ("aborted", False, "aborted"),
            ("stopped", True, "stopped"),
            ("execute", True, "complete"),
        ):
            status = f"{{state: '{state}', finished: {str(finished).lower()}, running: false}}"
            self.assertEqual(self.evaluate(f"display_state({status})"), said, status)
        cause = self.evaluate("display_cause({state: 'held', ended_by: 'held'})")
        self.assertIn("no program is executing this run", cause)
        silent = "status: {running: true, age_s: 7200}, status_received_ms: 1000, sample: {}, sample_received_ms: 2000"
        self.assertEqual(self.evaluate(f"sample_age_s({{{silent}}}, 3000)"), 7202)
        self.assertEqual(self.evaluate(f"sample_age_s({{{silent.replace('7200', '0')}}}, 9000)"), 8)
        stop = "{state: 'aborting', running: true, cause: 'stopped by ada (uid 0): smoke'}"
        self.assertEqual(self.evaluate(f"kStates[display_state({stop})]"), "Stopping")
        for known, shown in (("false", "aborting"), ("true", "stopping"), ("null", "stopping")):
            status = stop.replace("state:", f"stopped_by_operator: {known}, state:")
            self.assertEqual(self.evaluate(f"display_state({status})"), shown)
        status = stop.replace("stopped by ada", "ada ended it").replace("state:", "stopped_by_operator: true, state:")
        self.assertEqual(self.evaluate(f"display_state({status})"), "stopping")
        self.assertEqual(self.evaluate(f"display_state({stop.replace('stopped by', 'aborted by')})"), "aborting")
        self.assertEqual(self.evaluate(f"display_state({stop.replace('true', 'false')})"), "interrupted")
        self.assertEqual(self.evaluate("format_signed(20.23 - 20.0333, 2)"), "+0.20")
        self.assertEqual(self.evaluate("format_signed(-0.001, 2)"), "0.00")
        self.assertEqual(self.evaluate("[1, 0.5, 0.02, 0.3 - 0.2, 0.001].map(digits_for_distance)"), [0, 1, 2, 1, 3])
        text = self.evaluate(
            "(handle_status(Object.assign({}, page.run.status, {record_damage: 'it was cut', live_copy_trouble:"
            " 'its disk is full'})), document.body.innerText)"
        )
        self.assertIn("it was cut", text)
        self.assertIn("its disk is full", text)

    def test_6_values_of_left_profile_are_not_shown(self) -> None:
        """After a stop, and after an old sample, the page shows no value that no longer applies."""
        channels = "[{name: 'set_point_c'}, {name: 'chamber_air_c'}, {name: 'chamber_set_point_c'}]"
        run = (
            f"{{channels: {channels}, sample: {{slot: 9, values: [70, 60, 20]}}, events: [{{kind: 'state', slot: 5,"
            " utc_ms: 5000}], status: {state: 'aborting', running: true, slot: 9, observe_s: 300, set_point_c: 70}}"
        )
        self.assertEqual(self.evaluate(f"present_set_point({run})"), 20)
        self.assertEqual(self.evaluate(f"present_set_point({run.replace('aborting', 'held')})"), 70)
        self.assertIsNone(self.evaluate(f"present_set_point({run.replace(', 20]', ']')})"), "it is unknown")
        self.assertEqual(self.evaluate(f"watched_until_ms({run})"), 305000)
        self.assertIsNone(self.evaluate(f"watched_until_ms({run.replace('aborting', 'stopped')})"))
        self.assertIsNone(self.evaluate(f"watched_until_ms({run.replace('events: [', 'events: [], past: [')})"))
        self.assertEqual(self.evaluate(f"present_sample({run})")["slot"], 9)
        ended = run.replace("running: true, slot: 9", "running: false, slot: 99")
        self.assertIsNone(self.evaluate(f"present_sample({ended})"), "its last samples have not arrived")
        events = [("aborting: stopped by ada", 4), ("stopped by ada", 9), ("execute", 20), ("aborted", 30)]
        listed = ", ".join(f"{{kind: 'state', text: '{text}', slot: {slot}}}" for text, slot in events)
        self.assertEqual(self.evaluate(f"JSON.stringify(intervals_after_profile([{listed}]))"), "[[4,19],[30,null]]")
        self.assertEqual(self.evaluate("intervals_after_profile([])"), [])

    def test_6_times_of_events_have_seconds(self) -> None:
        self.open_view("events")
        self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "[data-title=Time]"), 10))
        times = self.evaluate("[...document.querySelectorAll('td[data-title=Time]')].map(cell => cell.innerText)")
        for shown in times:
            self.assertRegex(shown, r"\d\d:\d\d:\d\d [A-Z]\S+$")
        self.assertIn("1970", self.evaluate("format_time(86400000, true, true)"))
        self.set_width(1280)
        lines = "Math.max(...[...document.querySelectorAll('td[data-title=Time] > div')].map(cell => cell.offsetHeight))"
        self.assertLess(self.evaluate(lines), 30, "one line")
        texts = self.evaluate("[...document.querySelectorAll('td[data-title=Text]')].map(cell => cell.innerText)")
        self.assertFalse([text for text in texts if text.startswith("foreign_set_point: foreign_set_point")])
        self.open_view("alarms")
        self.expect_text("foreign_set_point: alarm")

    def test_6_killed_run_is_interrupted_and_resumed(self) -> None:
        record, log = self.folder / "killed.db", open(self.folder / "killed.log", "w", encoding="utf-8")
        virtual = ("--rig", "virtual", "--pace", "x10", "--out", str(record))
        output = {"cwd": SOURCE, "stdout": log, "stderr": log}
        program = subprocess.Popen([GYROTHERM, "run", str(self.folder / "up.toml"), *virtual], **output)
        key = until(lambda: key_of(self.monitor, Browser(self.monitor, "ada").headers, "killed"), 30)
        address = f"http://127.0.0.1:{self.monitor.port}/#/run/{key}/"
        self.browser.get("about:blank")
        self.browser.get(address + "now")
        self.expect_text("Segment 2 of 3", 60)
        program.kill()
        program.wait()
        self.expect_text("Interrupted in segment", 30)
        for view in ("profile", "now"):
            self.browser.get(address + view)
            self.expect_text("Interrupted" if view == "now" else "Solid: past set point")
            self.assertTrue(until(lambda: self.evaluate("document.querySelector('.profile-svg') !== null"), 10))
            self.assertFalse(self.evaluate("document.querySelector('.profile-svg .now') !== null"))
        self.expect_text("Last set point of the run")
        age = "//dt[.='Last sample']/following-sibling::dd"
        self.assertRegex(self.browser.find_element(By.XPATH, age).text, r"\d+ s ago")
        self.assertNotIn("Control", self.text())
        self.assertNotIn("gyrotherm-make-safe", self.text(), "no real chamber")
        program = subprocess.Popen([GYROTHERM, "resume", str(record), "--pace", "x10"], **output)
        try:
            self.expect_text("Running", 60)
            self.assertTrue(until(lambda: self.browser.find_element(By.ID, "command-pause").is_displayed(), 10))
            self.browser.get(address + "profile")
            self.expect_text("Solid: past set point")
            cell = "document.querySelector('[data-title=Began] > div')?.textContent"
            self.assertTrue(until(lambda: self.evaluate(cell), 10))
            self.assertRegex(self.evaluate(cell), r"\d\d:00:0\d [A-Z]\S+$", "not the time of the resume")
        finally:
            program.kill()
            program.wait()
            log.close()

    def test_6_fast_run_is_followed(self) -> None:
        """The stream omits samples of a fast run. Trend, profile and expected end follow it nevertheless."""
        record = self.folder / "fast.db"
        with open(self.folder / "fast.log", "w", encoding="utf-8") as log:
            program = subprocess.Popen(
                [GYROTHERM, "run", "two-position", "--rig", "virtual", "--pace", "x60", "--out", str(record)],
                cwd=SOURCE, stdout=log, stderr=log
            )
        try:
            key = until(lambda: key_of(self.monitor, Browser(self.monitor, "ada").headers, "fast"), 30)
            address = f"http://127.0.0.1:{self.monitor.port}/#/run/{key}/"
            self.browser.get("about:blank")
            self.browser.get(address + "trend")
            self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".chart canvas"), 30))
            seen = set()
            for _ in range(20):
                time.sleep(0.4)
                self.assertEqual(self.evaluate("chart.count_empty_rows()"), 0)
                seen.add(self.evaluate("chart.shown_times_s().at(-1)"))
            self.assertGreater(len(seen), 3, "the chart grows")
            self.browser.get(address + "now")
            self.assertTrue(until(lambda: self.browser.find_elements(By.CSS_SELECTOR, ".profile-svg .now"), 15))
            self.browser.execute_script("window.requests = 0;")
            self.replace_answers("/series?", "(++requests, got)")
            ends, apart = set(), []
            for _ in range(20):
                time.sleep(0.4)
                ends.add(self.evaluate("expected_end_ms(page.run.status)"))
                apart.append(self.evaluate("""(() => {
                    const done = document.querySelector('.profile-svg .done').getAttribute('d');
                    return Number(document.querySelector('.profile-svg .now').getAttribute('x1'))
                      - Number(done.match(/.*[ML]([\\d.]+) /)[1]);
                  })()"""))
            self.assertGreater(self.evaluate("requests"), 3, "of the series of the profile")
            self.assertLess(max(apart), 2, "the solid line ends at the present second")
            if not self.evaluate("page.run.status.behind_plan_s"):
                self.assertEqual(len(ends), 1, ends)
        finally:
            program.kill()
            program.wait()

    def test_7_replaced_record_is_loaded_again(self) -> None:
        self.open_view("now")
        self.expect_text("Last sample")
        self.browser.execute_script(
            "window.before = page.run; handle_status(Object.assign({}, page.run.status, {id: 'of another run'}))"
        )
        self.assertTrue(until(lambda: self.evaluate("page.run !== null && page.run !== before"), 10))
        self.expect_text("Last sample")

    def test_7_stop_shows_set_point_of_chamber(self) -> None:
        self.set_width(1280)
        self.open_view("now")
        self.press("//button[starts-with(., 'Stop')]")
        self.expect_text("A stop is final")
        self.enter("dialog-text", "smoke")
        self.press("//dialog//button[.='Stop run']")
        self.expect_text("Stopping")
        self.expect_text("Chamber set point")
        self.expect_text("The air is watched until")
        value = self.browser.find_element(By.XPATH, "//dt[.='Chamber set point']/following-sibling::dd")
        self.assertTrue(until(lambda: value.text.startswith("20.00"), 10), value.text)
        enabled = "[...document.querySelectorAll('#control button')].filter(b => !b.disabled).map(b => b.id)"
        self.assertTrue(until(lambda: self.evaluate(enabled) == ["command-abort"], 10), self.evaluate(enabled))
        text = self.text()
        for label in ("Time left", "Ends", "Behind plan", "Aborting"):
            self.assertNotIn(f"\n{label}\n", text)
        self.assertTrue(until(lambda: self.evaluate("intervals_after_profile(page.run.events).length") == 1, 10))
        if self.pictures:
            self.take_pictures("stopping", ("now", "trend", "profile", "rigs"))

    def test_8_removed_user_sees_login(self) -> None:
        self.open_view("now")
        self.expect_text("Last sample")
        monitor_command(self.folder, "user", "add", "eve", "--role", "viewer", password=PASSWORD)
        monitor_command(self.folder, "user", "remove", "ada")
        self.expect_text("Log in", 20)
        self.assertNotIn("ada", self.browser.find_element(By.ID, "who").text)


if __name__ == "__main__":
    unittest.main(verbosity=1)
