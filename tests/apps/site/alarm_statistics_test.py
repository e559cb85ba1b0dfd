#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Alarm statistics by month and rig, computed by the store from the events of runs."""

from __future__ import annotations

import datetime
import json
import pathlib
import subprocess
import sys
import unittest
import uuid

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))

from cluster import SITE, cluster

HOUR, DAY = 3600, 86400


def occurs(slot: int, alarm: str, reaction: str = "warn", text: str = "something") -> dict:
    """`alarm` is an interlock, with its subject after a blank."""
    kind = "fault" if reaction == "warn" else "interlock"
    return event(slot, kind, alarm, reaction, f"{alarm} ({reaction}): {text}")


def event(slot: int, kind: str, alarm: str, reaction: str | None, text: str) -> dict:
    interlock, _, channel = alarm.partition(" ")
    return {"slot": slot, "utc_ns": slot * 10**9, "kind": kind, "interlock": interlock or None, "reaction": reaction,
            "segment": 0, "channel": channel or None, "text": text}


def returns(slot: int, alarm: str) -> dict:
    return event(slot, "recovered", alarm, "go_on", f"{alarm} is over")


def acknowledged(slot: int, alarm: str, numbers: str) -> dict:
    return event(slot, "acknowledged", alarm, "warn", f"alarm {numbers} acknowledged by ada (uid 1000): seen")


def shelved(slot: int, alarm: str) -> dict:
    return event(slot, "command", alarm, "warn", "alarm 1 shelved for 2 h 00 min 00 s by ada (uid 1000): a new fan")


def unshelved(slot: int, alarm: str) -> dict:
    return event(slot, "command", alarm, "warn", "alarm 1 unshelved: the time is over")


def consequence(slot: int, alarm: str, reaction: str = "warn") -> dict:
    return occurs(slot, alarm, reaction, "silent [consequence of line_lost tcp://10.0.0.5:502]")


class AlarmStatistics(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()

    def add_run(self, rig: str, started: str, seconds: int, events: list[dict], simulated: bool = False,
                imported: bool = False) -> str:
        run = str(uuid.uuid4())
        began = int(datetime.datetime.fromisoformat(started + "+00:00").timestamp()) * 10**9
        info = {"started_ns": began, "profile": "p", "simulated": simulated, "imported": imported, "units": [],
                "channels": []}
        self.store.sql(f"SELECT gyrotherm.add_run('{run}', '{rig}', '{json.dumps(info)}')", "rig_1")
        self.add_events(run, events)
        self.store.sql(f"UPDATE gyrotherm.run SET last_slot = {seconds - 1} WHERE id = '{run}'")
        return run

    def add_events(self, run: str, events: list[dict]) -> None:
        numbered = json.dumps([one | {"number": i + 1} for i, one in enumerate(events)])
        self.store.sql(f"SELECT gyrotherm.add_events('{run}', 0, $e${numbered}$e$)", "rig_1")

    def ask(self, rig: str, question: str = "alarms", *words: str) -> list[dict]:
        asked = [SITE, question, "--store", self.store.address("ada"), "--json", "--most", "0", *words]
        answer = json.loads(subprocess.run(asked, capture_output=True, text=True, check=True).stdout)
        return [row for row in answer if row["rig"] == rig]

    def month(self, rig: str, month: str = "2026-03-01") -> dict:
        return next(row for row in self.ask(rig) if row["month"] == month)

    def test_a_month_with_runs_and_without_alarms_has_zeros(self) -> None:
        self.add_run("quiet", "2026-01-10T00:00:00", 10 * HOUR, [])
        self.add_run("quiet", "2026-03-10T00:00:00", 5 * HOUR, [])
        rows = self.ask("quiet")
        self.assertEqual([row["month"] for row in rows], ["2026-03-01", "2026-01-01"], "no row without a run")
        row = rows[1]
        self.assertEqual((row["hours"], row["alarms"], row["per_10_min"], row["flood_percent"]), (10, 0, 0, 0))
        self.assertEqual((row["most_frequent"], row["acknowledged_after_s"], row["outside_isa_18_2"]), (None, None, ""))

    def test_a_run_over_the_end_of_a_month_counts_in_both(self) -> None:
        """24 h before the end of February and 12 h after it."""
        events = [occurs(HOUR, "door", "suspend"), occurs(DAY - 1, "stuck A"), occurs(DAY, "stuck A"),
                  occurs(DAY + HOUR, "air_limit", "abort")]
        self.add_run("border", "2026-02-28T00:00:00", 36 * HOUR, events)
        february, march = self.month("border", "2026-02-01"), self.month("border")
        self.assertEqual((february["hours"], march["hours"]), (24, 12))
        self.assertEqual([february[key] for key in ("alarms", "high", "medium", "low")], [2, 0, 1, 1])
        self.assertEqual([march[key] for key in ("alarms", "high", "medium", "low")], [2, 1, 0, 1])
        self.assertEqual(march["per_10_min"], round(2 / 72, 2))
        self.add_run("last second", "2026-02-28T23:59:59", 1, [])
        self.assertEqual([row["month"] for row in self.ask("last second")], ["2026-02-01"])

    def test_rigs_and_virtual_runs_are_apart(self) -> None:
        for rig, count in (("rig a", 2), ("rig b", 3)):
            self.add_run(rig, "2026-03-10T00:00:00", HOUR, [occurs(i, f"stuck {i}") for i in range(count)])
        self.add_run("rig a", "2026-03-12T00:00:00", HOUR, [occurs(1, "door", "suspend")] * 9, simulated=True)
        self.add_run("rig a", "2026-03-13T00:00:00", HOUR, [occurs(1, "door", "suspend")] * 7, imported=True)
        self.add_run("rig a", "2026-03-20T00:00:00", HOUR, [occurs(5, "stuck 1")])
        self.assertEqual((self.month("rig a")["alarms"], self.month("rig a")["hours"]), (3, 2), "two real runs")
        self.assertEqual(self.month("rig a")["most_frequent"], "stuck 1")
        self.assertEqual(self.month("rig b")["alarms"], 3)
        every = self.ask("rig a", "alarms", "--all")
        self.assertEqual([(row["simulated"], row["alarms"]) for row in every], [(False, 3), (True, 9)])

    def test_steps_of_the_clock_change_nothing(self) -> None:
        events = [occurs(600 * i, "wall_clock") for i in range(4)] + [acknowledged(2000, "wall_clock", "1 to 4")]
        for i, one in enumerate(events):
            one["utc_ns"] = (-1) ** i * 10**17 * i
        self.add_run("clock", "2026-03-31T23:00:00", 2 * HOUR, events)
        row = self.month("clock")
        self.assertEqual((row["alarms"], row["hours"], row["acknowledged_after_s"]), (4, 1, 1100))
        self.assertEqual(self.month("clock", "2026-04-01")["alarms"], 0)

    def test_more_than_ten_alarms_in_ten_minutes_are_a_flood(self) -> None:
        flood = [occurs(1200 + 50 * i, f"stuck {i}") for i in range(11)]
        none = [occurs(2400 + 50 * i, f"stuck {i}") for i in range(10)]
        self.add_run("flood", "2026-03-10T00:00:00", 100 * 600, [*flood, *none])
        row = self.month("flood")
        self.assertEqual((row["most_in_10_min"], row["flood_percent"], row["per_10_min"]), (11, 1.0, 0.21))
        self.assertEqual(row["outside_isa_18_2"], "peak, flood")
        self.add_run("burst", "2026-03-10T00:00:00", 60, [occurs(i, f"stuck {i}") for i in range(20)])
        row = self.month("burst")
        self.assertEqual((row["flood_percent"], row["per_10_min"]), (100, 200), "a run shorter than a period")
        self.assertEqual(row["outside_isa_18_2"], "rate, peak, flood")

    def test_an_alarm_chatters_if_it_comes_three_times_in_a_minute(self) -> None:
        quick = [occurs(slot, "stuck A") for slot in (0, 30, 60)]
        slow = [occurs(slot, "stuck B") for slot in (1000, 1030, 1061, 1092)]
        others = [occurs(2000 + i, f"stuck {i}") for i in range(3)]
        hidden = [shelved(2990, "stuck C"), *(occurs(3000 + i, "stuck C") for i in range(5)),
                  *(consequence(4000 + i, "channel_lost A") for i in range(5))]
        self.add_run("chatter", "2026-03-10T00:00:00", 24 * HOUR, [*quick, *slow, *others, *hidden])
        row = self.month("chatter")
        self.assertEqual((row["chattering"], row["outside_isa_18_2"]), (1, "chattering"))
        self.assertEqual((row["alarms"], row["shelved"], row["suppressed"], row["shelvings"]), (10, 5, 5, 1))
        self.assertEqual([one["alarm"] for one in self.ask("chatter", "frequent-alarms") if one["chatters"]], ["stuck A"])

    def test_an_alarm_is_active_until_it_returns_or_the_run_is_resumed(self) -> None:
        events = [occurs(0, "a"), occurs(0, "b"), occurs(0, "c"), occurs(0, "d u1"), occurs(0, "d u2"),
                  returns(DAY, "a"), returns(DAY + 1, "b"), returns(DAY + 1, "d u1")]
        self.add_run("stale", "2026-03-10T00:00:00", 3 * DAY, events)
        self.assertEqual(self.month("stale")["stale"], 4, "b, c and both units")
        longest = {row["alarm"]: row["longest_s"] for row in self.ask("stale", "frequent-alarms")}
        self.assertEqual(longest, {"a": DAY, "b": DAY + 1, "c": 3 * DAY - 1, "d u1": DAY + 1, "d u2": 3 * DAY - 1})
        resumed = [occurs(0, "a"), event(DAY, "resumed", "", None, "resumed after 3 s"), occurs(DAY + 5, "a")]
        self.add_run("resumed", "2026-03-10T00:00:00", 2 * DAY, resumed)
        self.assertEqual(self.month("resumed")["stale"], 0)

    def test_the_median_counts_real_acknowledgements(self) -> None:
        events = [occurs(100, "a"), occurs(110, "b"), acknowledged(120, "a", "1"), occurs(200, "b"),
                  acknowledged(310, "b", "2 to 4"), occurs(400, "c"),
                  event(401, "note", "c", "warn", "alarm 6 acknowledged by ada (uid 1000): forged"),
                  event(402, "acknowledged", "c", "warn", "alarm 6 is not acknowledged by ada"),
                  occurs(500, "d"), shelved(510, "d"), unshelved(600, "d"), occurs(700, "d"),
                  acknowledged(900, "d", "12")]
        self.add_run("median", "2026-03-10T00:00:00", HOUR, events)
        # 20 s, 200 s, 110 s and 200 s; the shelved occurrence and that without an acknowledgement have none
        self.assertEqual(self.month("median")["acknowledged_after_s"], 155)

    def test_what_is_not_announced_is_counted_apart(self) -> None:
        events = [occurs(0, "line_lost tcp://10.0.0.5:502"), consequence(1, "channel_lost A"),
                  consequence(2, "gyro_silent", "suspend"), consequence(3, "chamber_silent", "hold"),
                  consequence(4, "program", "abort"), occurs(10, "a"), shelved(20, "a"), occurs(30, "a"),
                  occurs(40, "a u1"), occurs(50, "a", "suspend"), occurs(60, "a"),
                  unshelved(61, "a"), occurs(70, "a")]
        self.add_run("apart", "2026-03-10T00:00:00", HOUR, events)
        row = self.month("apart")
        self.assertEqual((row["suppressed"], row["shelved"], row["shelvings"]), (2, 2, 1))
        self.assertEqual((row["alarms"], row["high"], row["medium"], row["low"]), (7, 1, 2, 4))

    def test_the_ten_most_frequent_alarms_are_ranked(self) -> None:
        events = [occurs(100 * i + n, f"stuck {i:02}") for i in range(12) for n in range(12 - i)]
        events += [occurs(5000, "stuck 00", "suspend")]
        self.add_run("ranked", "2026-03-10T00:00:00", 24 * HOUR, events)
        rows = self.ask("ranked", "frequent-alarms")
        self.assertEqual([row["alarm"] for row in rows], [f"stuck {i:02}" for i in range(10)])
        self.assertEqual([row["rank"] for row in rows], list(range(1, 11)))
        self.assertEqual((rows[0]["alarms"], rows[0]["percent"], rows[0]["priority"]), (13, 16.5, "medium"))
        self.assertEqual(len(self.ask("ranked", "frequent-alarms", "--all")), 12)
        row = self.month("ranked")
        self.assertEqual((row["most_frequent"], row["most_frequent_percent"]), ("stuck 00", 16))

    def test_numbers_of_one_rig_make_no_query_fail(self) -> None:
        """A rig may send any event: the queries of the others are answered."""
        wild = [occurs(-2147483648, "a"), occurs(2147483647, "a"), returns(-2147483648, "a"),
                event(0, "fault", "b", None, ""), event(0, "interlock", "b", "none", "%[consequence of"),
                event(5, "acknowledged", "b", None, "alarm 99999999999999999999 to 1 acknowledged by x"),
                shelved(0, "b"), shelved(0, "b"), unshelved(0, "c"), event(0, "command", "b", "warn", "alarm 1 shelved")]
        run = self.add_run("wild", "2116-12-31T23:59:59", 1, wild)
        self.store.sql(f"UPDATE gyrotherm.run SET last_slot = 2147483647 WHERE id = '{run}'")
        self.assertGreater(len(self.ask("wild")), 700, "68 years by month")
        self.assertTrue(self.ask("wild", "frequent-alarms"))
        self.add_run("no rows", "2026-03-10T00:00:00", 0, [occurs(-1, "a")])
        row = self.month("no rows")
        self.assertEqual((row["hours"], row["alarms"], row["per_10_min"]), (None, 1, None))


if __name__ == "__main__":
    unittest.main()
