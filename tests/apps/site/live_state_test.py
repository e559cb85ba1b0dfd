#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How each rig is now: what the store answers, and the live page shows, of runs in progress, silent and ended."""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys
import time
import unittest
import uuid

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "monitor"))

from cluster import GYROTHERM, PUBLISH, SITE, SOURCE, Rig, cluster, finished, record, run_of, until
from programs import Monitor, RealTimeRun


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()

    def monitor(self) -> Monitor:
        own = self.store.folder / "monitor.toml"
        own.write_text('schema = "gyrotherm-site/1"\nname = "hall 4"\n\n'
                       f'[store]\naddress = "{self.store.address("ada")}"\n')
        (self.store.folder / "none").mkdir(exist_ok=True)
        monitor = Monitor(self.store.folder, "--site", str(own), runs=self.store.folder / "none")
        self.addCleanup(monitor.stop)
        return monitor

    def live(self, rig: str) -> dict:
        asked = [SITE, "live", "--store", self.store.address("ada"), "--json", "--most", "0"]
        rigs = json.loads(subprocess.run(asked, capture_output=True, text=True, check=True).stdout)
        return next((one for one in rigs if one["rig"] == rig), {})

    def add_run(self, rig: str, age_s: int, simulated: bool = False, numbers: str = "{20,19.5,1}") -> str:
        """A run whose only second is so old by the clock of its rig."""
        run, began = str(uuid.uuid4()), (int(time.time()) - age_s) * 10**9
        channels = [{"name": name, "unit": "", "measures": "program", "unit_under_test": ""}
                    for name in ("set_point_c", "chamber_air_c", "segment")]
        info = {"started_ns": began, "profile": "p", "simulated": simulated, "imported": False, "units": [],
                "channels": channels, "segments": [{"name": "warm"}, {"name": "cold"}]}
        self.store.sql(f"SELECT gyrotherm.add_run('{run}', '{rig}', '{json.dumps(info)}');"
                       f"SELECT gyrotherm.add_rows('{run}', -1, '{{0}}', '{{{began}}}', '{{\"{numbers}\"}}')", "rig_1")
        return run

    def finish(self, run: str, state: str, alarms: list[dict]) -> None:
        end = {"state": state, "cause": "", "alarms": alarms, "ended_ns": 0, "rows": 1, "events": 0, "gaps": 0,
               "chain_head": "", "files": []}
        self.store.sql(f"SELECT gyrotherm.finish_run('{run}', '{json.dumps(end)}')", "rig_1")

    def make_old(self, rig: str, seconds: int) -> None:
        """As if the last row had come so long ago."""
        self.store.sql(f"UPDATE gyrotherm.run SET heard = heard - interval '{seconds} s' WHERE rig = '{rig}'")

    def test_a_run_in_progress_is_followed_to_its_end(self) -> None:
        monitor = self.monitor()
        rigs = [Rig(self.store, self.store.folder / name, name) for name in ("rig-1", "rig-2")]
        runs = [RealTimeRun(rig.records) for rig in rigs]
        for rig, run in zip(rigs, runs):
            self.addCleanup(run.end)
            rig.start()
            self.addCleanup(lambda rig=rig: rig.process.poll() is None and rig.kill())
        on_page = lambda: {rig["rig"]: rig for rig in monitor.ask("/api/v1/site").json["rigs"]
                           if rig["rig"] in ("rig-1", "rig-2")}
        shown = until(lambda: len(now := on_page()) == 2
                      and all(rig["segment"] and rig["state"] == "execute" for rig in now.values()) and now, 60)
        self.assertTrue(shown, monitor.ask("/api/v1/site").body)
        for rig in shown.values():
            self.assertEqual((rig["state"], rig["alarms"]), ("execute", 0))
            self.assertLess(rig["age_s"], 30)
            self.assertLess(abs(rig["chamber_air_c"] - 20), 40)
            self.assertLess(abs(rig["set_point_c"] - 20), 60)

        subprocess.run([GYROTHERM, "tell", runs[0].record, "pause"], check=True, cwd=SOURCE)
        subprocess.run([GYROTHERM, "tell", runs[0].record, "note", "a person was here"], check=True, cwd=SOURCE)
        self.assertTrue(until(lambda: self.live("rig-1")["state"] == "held", 60), self.live("rig-1"))
        noted = "SELECT count(*) FROM gyrotherm.v1_event WHERE text LIKE '%a person was here%'"
        self.assertTrue(until(lambda: self.store.sql(noted, "ada") == [["1"]], 60), rigs[0].log.read_text())

        self.store.kill()
        lost = until(lambda: (site := monitor.ask("/api/v1/site").json)["store"]["error"] and site, 60)
        self.assertTrue(lost, "the page says that the store does not answer")
        self.assertLessEqual({"rig-1", "rig-2"}, {rig["rig"] for rig in lost["rigs"]}, "the last answer remains")
        later = until(lambda: (site := monitor.ask("/api/v1/site").json)["store"]["age_s"] > lost["store"]["age_s"] + 1
                      and site)
        self.assertGreater(later["rigs"][0]["age_s"], lost["rigs"][0]["age_s"])
        self.store.start()
        self.assertTrue(until(lambda: not monitor.ask("/api/v1/site").json["store"]["error"], 60))
        self.assertTrue(until(lambda: self.live("rig-1")["age_s"] <= 3, 60), rigs[0].log.read_text())
        self.assertEqual(self.live("rig-1")["state"], "held")

        runs[0].run.kill()  # and its guard makes the chamber safe
        runs[0].run.wait()
        self.assertTrue(until(lambda: self.live("rig-1")["age_s"] >= 5, 60), self.live("rig-1"))
        self.make_old("rig-1", 60)
        silent = self.live("rig-1")
        self.assertEqual((silent["state"], silent["segment"], silent["chamber_air_c"]), ("silent", None, None))
        self.assertGreaterEqual(silent["age_s"], 60)

        runs[1].end()
        self.assertTrue(until(lambda: finished(self.store, run_of(runs[1].record)), 60), rigs[1].log.read_text())
        ended = self.live("rig-2")
        self.assertEqual((ended["state"], ended["segment"], ended["set_point_c"]), ("idle", None, None))

    def test_a_publisher_that_stopped_is_silent_with_its_age(self) -> None:
        self.add_run("stopped", 0)
        self.assertEqual(self.live("stopped")["state"], "execute")
        self.make_old("stopped", 90)
        silent = self.live("stopped")
        self.assertEqual((silent["state"], silent["set_point_c"]), ("silent", None))
        self.assertTrue(90 <= silent["age_s"] < 150, silent)

    def attention(self, rig: str) -> list[str]:
        asked = [SITE, "attention", "--all", "--store", self.store.address("ada"), "--json", "--most", "0"]
        rows = json.loads(subprocess.run(asked, capture_output=True, text=True, check=True).stdout)
        return [row["what"] for row in rows if row["rig"] == rig]

    def test_a_running_virtual_run_needs_no_attention(self) -> None:
        """Its clock is virtual: it may begin in 1970 or in the next year."""
        for rig, age_s in (("past", 30_000_000), ("future", -30_000_000)):
            self.add_run(rig, age_s, simulated=True)
            self.assertEqual(self.attention(rig), [], rig)
            self.make_old(rig, 540)
            self.assertEqual(self.attention(rig), [], "the limit is ten minutes")
            self.make_old(rig, 120)
            self.assertEqual(self.attention(rig), ["silent"], rig)

    def test_a_real_run_is_silent_by_either_clock(self) -> None:
        self.add_run("fresh", 0)
        self.assertEqual(self.attention("fresh"), [])
        self.make_old("fresh", 660)
        self.assertEqual(self.attention("fresh"), ["silent"])
        self.add_run("delayed", 660)
        self.assertEqual(self.attention("delayed"), ["silent"])

    def test_a_backlog_is_as_old_as_its_rows(self) -> None:
        self.add_run("backlog", 3600)
        self.assertEqual(self.live("backlog")["state"], "silent")
        self.assertGreaterEqual(self.live("backlog")["age_s"], 3600)

    def test_alarms_of_a_run_that_ended_remain_until_the_next_run(self) -> None:
        row = {"number": 12, "interlock": "door", "subject": "", "text": "open; " * 100, "acknowledged": False,
               "suppressed_by": "", "active": True}
        alarms = [row | {"number": number} for number in range(256)]
        alarms += [row | {"acknowledged": True}, row | {"suppressed_by": "host_late"}]
        run = self.add_run("alarms", 10)
        said = f"SELECT gyrotherm.say_state('{run}', 'suspended', 'door', '{json.dumps(alarms)}')"
        self.store.sql(said, "rig_1")
        self.assertEqual((self.live("alarms")["state"], self.live("alarms")["alarms"]), ("suspended", 256))
        self.finish(run, "stopped", alarms)
        left = self.live("alarms")
        self.assertEqual((left["state"], left["alarms"], left["segment"], left["chamber_air_c"]),
                         ("stopped", 256, "cold", None))
        self.finish(self.add_run("alarms", 0), "complete", [row | {"acknowledged": True}])
        self.assertEqual(self.live("alarms")["state"], "idle")

    def test_an_aborted_run_remains(self) -> None:
        run = self.add_run("aborted", 7200)
        self.store.sql(f"SELECT gyrotherm.say_state('{run}', 'aborted', 'too hot', '[]')", "rig_1")
        self.assertEqual((self.live("aborted")["state"], self.live("aborted")["cause"]), ("aborted", "too hot"))

    def test_a_real_run_comes_before_a_virtual_one(self) -> None:
        self.add_run("both", -10_000_000, simulated=True)
        self.assertEqual((self.live("both")["state"], self.live("both")["simulated"]), ("execute", True))
        real = self.add_run("both", 0)
        self.assertEqual(self.live("both")["simulated"], False)
        self.finish(real, "complete", [])
        self.assertEqual((self.live("both")["state"], self.live("both")["simulated"]), ("execute", True))
        self.make_old("both", 90)
        self.assertEqual((self.live("both")["state"], self.live("both")["simulated"]), ("idle", False))

    def test_a_rig_speaks_for_itself_and_spoils_no_list(self) -> None:
        run = self.add_run("hostile", 0, numbers="{NaN,1e308,1e300}")
        self.assertEqual(self.live("hostile")["state"], "execute")
        shown = [self.live("hostile")[name] for name in ("segment", "set_point_c", "chamber_air_c")]
        self.assertEqual(shown, [None, None, None], "no number with which a page could calculate")
        for alarms in ("null", "{}", "5", json.dumps(["x" * 1_000_001])):
            said = self.store.try_sql(f"SELECT gyrotherm.say_state('{run}', 'held', '', '{alarms}')", "rig_1")
            self.assertIn("not a list of rows", said.stderr, alarms[:9])
        self.store.sql(f"SELECT gyrotherm.say_state('{run}', 'held', '', '[5, null, {{\"acknowledged\": 7}}]')", "rig_1")
        self.assertEqual((self.live("hostile")["state"], self.live("hostile")["alarms"]), ("held", 3))
        said = self.store.try_sql(f"SELECT gyrotherm.say_state('{run}', 'aborted', '', '[]')", "rig_2")
        self.assertIn("is not one of rig_2", said.stderr)
        self.assertEqual(self.live("hostile")["state"], "held")

    def test_a_store_of_the_version_before_is_named(self) -> None:
        rig = Rig(self.store, self.store.folder / "early", "early")
        record(rig.records / "run.db", "tests/profiles/ten-seconds.toml", seed=3)
        self.store.sql("ALTER FUNCTION gyrotherm.say_state RENAME TO say_state_before")
        try:
            done = subprocess.run([PUBLISH, "--site", rig.file, "--once"], capture_output=True, text=True, check=False)
        finally:
            self.store.sql("ALTER FUNCTION gyrotherm.say_state_before RENAME TO say_state")
        self.assertEqual(done.returncode, 4)
        self.assertIn("gyrotherm site migrate", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
