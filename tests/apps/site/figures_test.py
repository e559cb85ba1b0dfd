# SPDX-License-Identifier: Apache-2.0
"""Figures of unit types and check standards in the store: yield, capability, the next calibration, control charts.
Every number is compared with one that this file computes in another way."""
from __future__ import annotations

import datetime
import json
import math
import pathlib
import random
import subprocess
import sys
import unittest
from typing import Any

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cluster import GYROTHERM, SITE, SOURCE, Cluster, Rig, cluster  # noqa: E402

LIMIT = 0.01


def report(
    serial: str,
    day: datetime.date,
    value: float,
    *,
    stage: str = "uncompensated",
    model: str = "RLG-1",
    limit: float | None = LIMIT,
    verdict: str | None = None,
    u: float = 0.0005,
    state: str = "authorised",
    simulated: bool = False,
    more: list[dict[str, Any]] | None = None,
) -> str:
    """Returns a calibration report with one result, the bias scatter, and its limit."""

    def table(at: str, number: float) -> dict[str, Any]:
        return {
            "group": "noise", "key": "bias", "axis": "x", "stage": at, "run": "r", "in_sample": False, "detail": "",
            "columns": [
                {"quantity": "std", "unit": "°/h", "values": [{"value": number, "u": u, "k": 2, "U": 2 * u}]}
            ],
        }  # fmt: skip

    conformity = []
    if limit is not None:
        conformity = [
            {"quantity": "bias.std", "axis": "x", "stage": stage, "run": "r", "unit": "°/h", "value": {"value": value},
             "limit": limit, "rule": "simple", "verdict": verdict or ("pass" if abs(value) <= limit else "fail")}
        ]  # fmt: skip
    return json.dumps(
        {
            "schema": "gyrotherm-calibration/1",
            "number": f"{serial}-{day}",
            "state": state,
            "simulated": simulated,
            "item": {"serial_number": serial, "model": model},
            "ended": str(day),
            "issued": str(day),
            "files": [{"role": "record", "id": "r", "profile": "qualification"}],
            "results": [table(stage, value), *(table(*one) for one in more or [])],
            "conformity": conformity,
        }
    )


def binomial_at_least(passed: int, units: int, p: float) -> float:
    return math.fsum(math.comb(units, k) * p**k * (1 - p) ** (units - k) for k in range(passed, units + 1))


def find_root(function, low: float, high: float) -> float:
    """Returns the root of an increasing function."""
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return (low + high) / 2


def student_quantile(freedom: int, probability: float) -> float:
    """Returns the quantile by Simpson's rule over the angle: T = sqrt(ν) tan(a) has the density cos(a)^(ν - 1)."""

    def area(to: float) -> float:
        steps = 2000
        height = to / steps
        inner = math.fsum((4 if i % 2 else 2) * math.cos(i * height) ** (freedom - 1) for i in range(1, steps))
        return height / 3 * (1 + inner + math.cos(to) ** (freedom - 1))

    whole = area(math.pi / 2)
    angle = find_root(lambda a: 0.5 + 0.5 * area(a) / whole - probability, 0, math.pi / 2)
    return math.sqrt(freedom) * math.tan(angle)


class FiguresCase(unittest.TestCase):
    store: Cluster

    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()

    def setUp(self) -> None:
        self.waiting: list[str] = []

    def add(self, text: str) -> None:
        """Adds a report before the next question. A report that the store refuses is left out."""
        quoted = text.replace("'", "''")
        self.waiting.append(
            f"DO $do$ BEGIN PERFORM gyrotherm.add_document('rig-1', 'calibration', 'c.json', '{quoted}');"
            " EXCEPTION WHEN check_violation OR invalid_text_representation OR numeric_value_out_of_range"
            " OR invalid_parameter_value THEN NULL; END $do$;"
        )

    def add_waiting(self) -> None:
        self.store.sql("\n".join(self.waiting), "rig_1")
        self.waiting.clear()

    def ask(self, question: str, *options: str) -> list[dict[str, Any]]:
        self.add_waiting()
        done = subprocess.run(
            [SITE, question, "--json", "--store", self.store.address("ada"), *options],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)


class Types(FiguresCase):
    def test_yield_has_the_interval_of_clopper_and_pearson(self) -> None:
        day = datetime.date(2026, 3, 1)
        for serial in range(40):
            verdict = "conditional_pass" if serial == 5 else "not_known" if serial == 6 else None
            value = 0.02 if serial < 3 else 0.005
            self.add(report(f"Y{serial}", day, value, model="yield-1", verdict=verdict))
        # An older failure, a draft and a simulated report do not count; a newer report replaces the older one.
        self.add(report("Y7", datetime.date(2025, 1, 1), 0.05, model="yield-1"))
        self.add(report("Y8", datetime.date(2026, 4, 1), 0.05, model="yield-1", state="draft"))
        self.add(report("Y9", datetime.date(2026, 4, 1), 0.05, model="yield-1", simulated=True))
        rows = [row for row in self.ask("yield") if row["model"] == "yield-1"]
        self.assertEqual([row["quantity"] for row in rows], ["all limits", "bias.std"])
        for row in rows:
            self.assertEqual((row["units"], row["passed"], row["undecided"]), (39, 36, 1))
            self.assertAlmostEqual(row["yield"], 36 / 39, 12)
            low = find_root(lambda p: binomial_at_least(36, 39, p) - 0.025, 0, 1)
            high = find_root(lambda p: binomial_at_least(37, 39, p) - 0.975, 0, 1)
            self.assertAlmostEqual(row["low"], low, 9)
            self.assertAlmostEqual(row["high"], high, 9)
        simulated = [row for row in self.ask("yield", "--all") if row["model"] == "yield-1" and row["simulated"]]
        self.assertEqual([row["units"] for row in simulated], [1, 1])

    def test_yield_of_all_or_no_units_has_one_bound(self) -> None:
        for serial in range(7):
            self.add(report(f"G{serial}", datetime.date(2026, 3, 1), 0.001, model="yield-all"))
            self.add(report(f"B{serial}", datetime.date(2026, 3, 1), -0.02, model="yield-none"))
        rows = {row["model"]: row for row in self.ask("yield") if row["quantity"] == "all limits"}
        good, bad = rows["yield-all"], rows["yield-none"]
        self.assertEqual((good["yield"], good["high"]), (1, 1))
        self.assertAlmostEqual(good["low"], 0.025 ** (1 / 7), 10)
        self.assertEqual((bad["yield"], bad["low"]), (0, 0))
        self.assertAlmostEqual(bad["high"], 1 - 0.025 ** (1 / 7), 10)

    def test_capability_is_that_of_the_nearer_limit(self) -> None:
        generator = random.Random(1)
        for model, middle in (("cpk-up", 0.004), ("cpk-down", -0.004)):
            values = [generator.gauss(middle, 0.001) for _ in range(30)]
            for serial, value in enumerate(values):
                self.add(report(f"{model}{serial}", datetime.date(2026, 3, 1), value, model=model))
            [row] = [row for row in self.ask("capability") if row["model"] == model]
            mean = math.fsum(values) / 30
            s = math.sqrt(math.fsum((value - mean) ** 2 for value in values) / 29)
            cpk = min(LIMIT - mean, LIMIT + mean) / (3 * s)
            width = 1.959963985 * math.sqrt(1 / (9 * 30) + cpk**2 / (2 * 29))
            self.assertEqual((row["units"], row["limit"], row["unit"]), (30, LIMIT, "°/h"))
            self.assertAlmostEqual(row["cpk"], cpk, 9)
            self.assertAlmostEqual(row["low"], cpk - width, 8)
            self.assertAlmostEqual(row["high"], cpk + width, 8)

    def test_capability_needs_five_units_with_one_limit(self) -> None:
        for serial in range(8):
            limit = 0.01 if serial < 4 else 0.02
            self.add(report(f"F{serial}", datetime.date(2026, 3, 1), 0.001 * serial, model="few", limit=limit))
            self.add(report(f"E{serial}", datetime.date(2026, 3, 1), 0.003, model="equal"))
        rows = [row for row in self.ask("capability", "--all") if row["model"] in ("few", "equal")]
        self.assertEqual([(row["model"], row["units"], row["cpk"]) for row in rows], [("equal", 8, None)])

    def test_hostile_numbers_do_not_make_a_question_fail(self) -> None:
        for serial, value in enumerate((1e99, -1e99, 1e-149, 0, 5e-324, 1e120)):
            day = datetime.date(2026, 3, 1 + serial)
            for limit in (1e-99, 1e99, 1e-320, 1e300, -1, 0):
                self.add(report(f"H{serial}", day, value, model="hostile", limit=limit))
                self.add(report("H", day + datetime.timedelta(days=40), value, model="hostile", limit=limit))
        for broken in ("null", '"x"', "{}", "[1, null, {}]", '[{"limit": "x"}]', '[{"limit": 1}]'):
            text = report("H9", datetime.date(2026, 5, 1), 0.1, model="hostile", limit=None)
            self.add(text.replace('"conformity": []', f'"conformity": {broken}'))
        for question in ("yield", "capability", "recalibration"):
            self.ask(question, "--all", "--most", "0")


class Recalibration(FiguresCase):
    def reference(self, days: list[int], values: list[float], limit: float, u: float) -> float:
        """Returns the years from the last calibration to the first day on which the limit may be exceeded, found by
        trying each 1/1000 of a year."""
        years = [(b - a) / 365.25 for a, b in zip(days, days[1:])]
        changes = [b - a for a, b in zip(values, values[1:])]
        whole = sum(years)
        drift = sum(changes) / whole
        s2 = sum((d - drift * t) ** 2 / t for d, t in zip(changes, years)) / (len(changes) - 1)
        t95 = student_quantile(len(changes) - 1, 0.95)
        for step in range(20_000):
            t = step / 1000
            reach = t95 * math.sqrt(s2 * t * (1 + t / whole) + u**2)
            if max(abs(values[-1] + drift * t + reach), abs(values[-1] + drift * t - reach)) > limit:
                return t
        return math.inf

    def test_date_follows_from_drift_scatter_and_uncertainty(self) -> None:
        first = datetime.date(2020, 1, 1)
        cases = {
            "up": ([0, 365, 731, 1096], [0.001, 0.0021, 0.0029, 0.0041], 0.0002),
            "down": ([0, 400, 700, 1096], [0.001, -0.0006, -0.0021, -0.0039], 0.0002),
            "noisy": ([0, 365, 731, 1096], [0.0, 0.003, -0.002, 0.001], 0.0002),
            "three": ([0, 365, 731], [0.001, 0.0012, 0.0013], 0.0001),
            "still": ([0, 365, 731, 1096], [0.001, 0.001, 0.001, 0.001], 0.0001),
            "near": ([0, 365, 731, 1096], [0.0085, 0.0088, 0.0091, 0.0093], 0.0001),
        }
        for serial, (days, values, u) in cases.items():
            for day, value in zip(days, values):
                self.add(report(serial, first + datetime.timedelta(days=day), value, u=u))
        rows = {row["serial_number"]: row for row in self.ask("recalibration")}
        for serial, (days, values, u) in cases.items():
            with self.subTest(serial):
                row, years = rows[serial], self.reference(days, values, LIMIT, u)
                self.assertEqual(row["calibrations"], len(days))
                if math.isinf(years):
                    self.assertEqual((row["due"], row["note"]), (None, "later than 20 years"))
                    continue
                due = datetime.date.fromisoformat(row["due"])
                expected = first + datetime.timedelta(days=days[-1] + years * 365.25)
                self.assertLessEqual(abs((due - expected).days), 2, expected)
        self.assertIsNone(rows["still"]["due"])
        self.assertLess(rows["noisy"]["due"], rows["up"]["due"], "the scatter of the changes shortens the interval")
        self.assertEqual(rows["near"]["note"], "")

    def test_fewer_than_three_calibrations_have_no_date(self) -> None:
        for day in (1, 2):
            self.add(report("two", datetime.date(2020 + day, 1, 1), 0.001 * day))
        self.add(report("one", datetime.date(2021, 1, 1), 0.001))
        rows = {row["serial_number"]: row for row in self.ask("recalibration")}
        for serial, count in (("one", 1), ("two", 2)):
            self.assertEqual(rows[serial]["calibrations"], count)
            self.assertEqual((rows[serial]["due"], rows[serial]["note"]), (None, "fewer than three calibrations"))
        # The same calibration again and a draft do not count as a third one.
        self.add(report("two", datetime.date(2022, 1, 1), 0.0021, state="draft"))
        [row] = self.ask("recalibration", "--unit", "two")
        self.assertEqual(row["calibrations"], 2)

    def test_adjustments_are_not_drift(self) -> None:
        """Each year the unit is found 0.002 °/h higher than it was left, and is adjusted to 0."""
        for year in range(4):
            day = datetime.date(2020 + year, 1, 1)
            found = [("as_found", 0.002 + 0.0001 * (year % 2))] if year else []
            self.add(report("adjusted", day, 0.0001, stage="as_left", more=found))
        [row] = self.ask("recalibration", "--unit", "adjusted")
        self.assertEqual(row["calibrations"], 4)
        self.assertAlmostEqual(row["drift_per_year"], (0.0019 * 3 + 0.0002) / 3, delta=2e-5)
        self.assertIsNotNone(row["due"])

    def test_unit_outside_its_limit_is_due_now(self) -> None:
        for year in range(3):
            self.add(report("outside", datetime.date(2020 + year, 1, 1), 0.0099 + 0.0001 * year, u=0.001))
        [row] = self.ask("recalibration", "--unit", "outside")
        self.assertEqual((row["due"], row["note"]), ("2022-01-01", "not within the limit with 95 % now"))


class CheckStandards(unittest.TestCase):
    """Check runs of a virtual rig, of which the last has a changed thermometer, as the publisher sends them."""

    store: Cluster

    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()
        cls.rig = Rig(cls.store, cls.store.folder / "rig-1")
        text = (SOURCE / "profiles/rigs/virtual.toml").read_text()
        for part in ("chambers/", "gyros/"):
            text = text.replace(f'"../{part}', f'"{SOURCE}/profiles/{part}')
        text = text.replace("[gyro]\n", '[gyro]\nserial_number = "G-0001"\n')
        text += '\n[check_standard]\nserial_numbers = ["G-0001"]\n'
        cls.rig_file = cls.rig.records / "rig.toml"
        cls.rig_file.write_text(text)
        changed = text.replace("offsets = [0, 0, 0, 0, 0, 0, 0, 0]", "offsets = [0, 0, 0, 0.5, 0, 0, 0, 0]")
        assert changed != text
        (cls.rig.records / "changed.toml").write_text(changed)
        cls.records = [cls.check_run(day, "changed.toml" if day == 6 else "rig.toml") for day in range(7)]

    @classmethod
    def gyrotherm(cls, *words: Any) -> subprocess.CompletedProcess[str]:
        return subprocess.run([GYROTHERM, *map(str, words)], cwd=SOURCE, capture_output=True, text=True, check=False)

    @classmethod
    def check_run(cls, day: int, rig: str) -> pathlib.Path:
        record = cls.rig.records / f"check-{day}.db"
        ran = cls.gyrotherm(
            "run", "check-standard", "--rig", cls.rig.records / rig, "--days-later", day, "--out", record, "--quiet"
        )
        assert ran.returncode == 0, ran.stderr
        return record

    def ask(self, question: str, *options: str) -> list[dict[str, Any]]:
        done = subprocess.run(
            [SITE, question, "--json", "--all", "--most", "0", "--store", self.store.address("ada"), *options],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def publish(self) -> None:
        sent = self.rig.once()
        self.assertEqual(sent.returncode, 0, sent.stderr)

    def test_charts_follow_the_history(self) -> None:
        self.publish()
        self.assertEqual(self.ask("standards"), [], "there is no history yet")
        made = self.gyrotherm("standard", self.rig_file, *self.records[:6])
        self.assertEqual(made.returncode, 0, made.stderr)
        self.publish()
        [standard] = self.ask("standards")
        self.assertEqual((standard["runs"], standard["open_runs"], standard["cause"]), (6, 0, None))
        self.assertEqual((standard["last_verdict"], standard["simulated"]), ("in control", True))
        self.assertEqual(standard["serial_numbers"], "G-0001")

        made = self.gyrotherm("standard", self.rig_file, self.records[6], "--json")
        self.assertEqual(made.returncode, 1, made.stderr)
        self.publish()
        [standard] = self.ask("standards")
        self.assertEqual((standard["runs"], standard["open_runs"], standard["cause"]), (7, 1, "thermometer"))
        self.assertGreater(standard["cause_probability"], 0.9)
        charts = json.loads(made.stdout)["charts"]
        rows = self.ask("charts")
        self.assertEqual(len(rows), 7 * len(charts))
        stored = {(row["result"], row["started"][:10]): row for row in rows}
        for chart in charts:
            for day, point in enumerate(chart["points"]):
                row = stored[chart["result"], f"2026-01-{day + 1:02}"]
                self.assertEqual(row["unit"], chart["unit"])
                for name in ("value", "centre", "low", "high", "q", "ewma"):
                    self.assertEqual(row[name], point[name], (chart["result"], day, name))
        self.assertTrue(any(row["verdict"] == "out of control" for row in rows))

        explained = self.gyrotherm("standard", "explain", self.rig_file, "--cause", "thermometer", "--by", "Ada")
        self.assertEqual(explained.returncode, 0, explained.stderr)
        self.publish()
        [standard] = self.ask("standards")
        self.assertEqual((standard["last_verdict"], standard["open_runs"], standard["cause"]), ("explained", 0, None))
        self.assertFalse(any(row["verdict"] == "out of control" for row in self.ask("charts")))
        self.refuse_others()

    def refuse_others(self) -> None:
        """Another rig cannot replace the charts, and the own rig cannot remove or change a run."""
        [[history]] = self.store.sql("SELECT history FROM gyrotherm.check_standard")
        charts = json.loads(self.gyrotherm("standard", self.rig_file, "--json").stdout)

        def send(changed: Any, user: str, rig: str) -> str:
            text = json.dumps(changed).replace("'", "''")
            done = self.store.try_sql(f"SELECT gyrotherm.add_check_standard('{rig}', '{history}', '{text}')", user)
            return done.stderr

        self.assertEqual(send(charts, "rig_1", "rig-1"), "")
        self.assertIn("is not one of rig_2", send(charts, "rig_2", "rig-2"))
        self.assertIn("is not one of rig_2", send(charts, "rig_2", "rig-1"))
        before = self.store.sql("SELECT md5(string_agg(c::text, '' ORDER BY number, chart)) FROM gyrotherm.check_result c")
        fewer = charts | {"runs": charts["runs"][:-1]}
        other = json.loads(json.dumps(charts))
        other["runs"][2]["sha256"] = "0" * 64
        infinite = json.loads(json.dumps(charts))
        infinite["charts"][0]["points"][0]["value"] = 1e200
        for changed, why in (
            (fewer, "lacks check runs"),
            (other, "lacks check runs"),
            (infinite, "check_result_is_a_number"),
            ({}, "no document"),
            ({"schema": "gyrotherm-control-charts/1"}, ""),
            (charts | {"runs": []}, "1 to 5000"),
        ):
            refused = send(changed, "rig_1", "rig-1")
            self.assertIn("ERROR", refused)
            self.assertIn(why, refused)
        after = self.store.sql("SELECT md5(string_agg(c::text, '' ORDER BY number, chart)) FROM gyrotherm.check_result c")
        self.assertEqual(after, before)
        denied = self.store.try_sql("SELECT * FROM gyrotherm.v1_check_chart", "rig_1").stderr
        self.assertIn("permission denied", denied)


if __name__ == "__main__":
    unittest.main(verbosity=2)
