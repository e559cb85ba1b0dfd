# SPDX-License-Identifier: Apache-2.0
"""What the store holds is what the records hold, and nobody gets anything else in."""
from __future__ import annotations

import concurrent.futures
import contextlib
import datetime
import hashlib
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import time
import unittest
import uuid

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "monitor"))
from cluster import (
    BIN,
    GYROTHERM,
    PUBLISH,
    SITE,
    SOURCE,
    Cluster,
    Rig,
    cluster,
    events_of,
    finished,
    record,
    rows_of,
    run_of,
    stored_events,
    stored_rows,
    until,
)
from programs import Monitor  # noqa: E402

CALIBRATION = {
    "schema": "gyrotherm-calibration/1",
    "number": "C-1",
    "state": "authorised",
    "simulated": False,
    "item": {"serial_number": "0042", "model": "RLG-1"},
    "ended": "2026-01-05",
    "issued": "2026-01-09",
    "files": [{"role": "record", "id": "r", "profile": "qualification"}],
    "results": [
        {
            "group": "bias",
            "key": "stabilised_bias",
            "axis": "x",
            "stage": "as_left",
            "run": "r",
            "in_sample": False,
            "detail": "",
            "columns": [
                {"quantity": "set_point", "unit": "°C", "values": [{"value": -20}, {"value": 50}]},
                {
                    "quantity": "bias",
                    "unit": "°/h",
                    "values": [
                        {"value": 0.01, "u": 0.001, "k": 2, "U": 0.002},
                        {"value": 0.03, "u": 0.001, "k": 2, "U": 0.002},
                    ],
                },
            ],
        }
    ],
}


class Store(unittest.TestCase):
    store: Cluster

    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()
        cls.rig = Rig(cls.store, cls.store.folder / "rig-1")
        cls.record = record(cls.rig.records / "day.db")
        cls.run_id = run_of(cls.record)
        (cls.rig.records / "report").mkdir()
        cls.calibration = cls.rig.records / "report/calibration.json"
        cls.calibration.write_text(json.dumps(CALIBRATION))
        (cls.rig.records / "other.json").write_text("{}")
        cls.archive = cls.rig.folder / "archive"
        cls.archive.mkdir()
        cls.rig.file.write_text(cls.rig.file.read_text() + '[archive]\nfolder = "archive"\n')
        cls.sent = cls.rig.once()

    def refused(self, text: str, user: str, why: str) -> None:
        done = self.store.try_sql(text, user)
        self.assertNotEqual(done.returncode, 0, text)
        self.assertIn(why, done.stderr)

    def checksum(self) -> list[list[str]]:
        return self.store.sql(
            "SELECT (SELECT md5(string_agg(s::text, '' ORDER BY run, slot)) FROM gyrotherm.sample s),"
            " (SELECT md5(string_agg(e::text, '' ORDER BY run, number)) FROM gyrotherm.event e),"
            " (SELECT md5(string_agg(r::text, '' ORDER BY id)) FROM gyrotherm.run r)"
        )

    def test_a_finished_run_is_there_to_the_bit(self) -> None:
        self.assertEqual(self.sent.returncode, 0, self.sent.stderr)
        rows = rows_of(self.record)
        self.assertGreater(len(rows), 10_000)
        self.assertEqual(stored_rows(self.store, self.run_id), rows)
        self.assertEqual(stored_events(self.store, self.run_id), events_of(self.record))
        self.assertTrue(finished(self.store, self.run_id))
        head = self.store.sql("SELECT state, rows, rows_in_record, files->0->>'sha256' FROM gyrotherm.run")[0]
        digest = hashlib.sha256(self.record.read_bytes()).hexdigest()
        self.assertEqual(head, ["complete", str(len(rows)), str(len(rows)), digest])
        self.assertEqual((self.archive / f"{digest}.db").read_bytes(), self.record.read_bytes())
        self.assertEqual([path.name for path in self.archive.iterdir()], [f"{digest}.db"])

    def test_sending_it_again_changes_nothing(self) -> None:
        before = self.checksum()
        self.assertEqual(self.rig.once().returncode, 0)
        self.assertEqual(self.checksum(), before)

    def test_words_and_units_are_there_for_people(self) -> None:
        row = dict(
            (name, (value, unit, word))
            for name, value, unit, word in self.store.sql(
                f"SELECT name, value, unit, word FROM gyrotherm.v1_sample WHERE run = '{self.run_id}' AND slot = 9",
                "ada",
            )
        )
        self.assertEqual(row["state"], ("0", "", "execute"))
        self.assertEqual(row["monotonic_ns"][:2], ("10000000000", "ns"))
        self.assertEqual(row["A"][1], "°C")

    def test_what_a_calibration_says_is_taken_from_its_bytes(self) -> None:
        rows = self.store.sql(
            "SELECT quantity, condition, value, expanded_uncertainty, sha256 FROM gyrotherm.v1_calibration"
            " WHERE quantity LIKE '%.bias' ORDER BY value",
            "ada",
        )
        digest = hashlib.sha256(self.calibration.read_bytes()).hexdigest()
        self.assertEqual(
            rows,
            [
                ["stabilised_bias.bias", "qualification, set point -20 °C", "0.01", "0.002", digest],
                ["stabilised_bias.bias", "qualification, set point 50 °C", "0.03", "0.002", digest],
            ],
        )

    def test_a_hostile_rig_gets_nothing_in(self) -> None:
        before, run = self.checksum(), self.run_id
        for call in (
            f"add_rows('{run}', -1, '{{0}}', '{{0}}', '{{\"{{1}}\"}}')",
            f"add_rows('{run}', 16479, '{{16480}}', '{{0}}', '{{\"{{1}}\"}}')",
            f"add_events('{run}', 0, '[]')",
            f"add_gaps('{run}', -1, '[]')",
            f"say_state('{run}', 'aborted', '', '[]')",
            f"finish_run('{run}', '{{}}')",
            f"""add_run('{run}', 'rig-2', '{{"started_ns": 0, "profile": "p"}}')""",
        ):
            self.refused(f"SELECT gyrotherm.{call}", "rig_2", "is not one of rig_2")
        self.assertEqual(self.store.sql(f"SELECT * FROM gyrotherm.run_position('{run}')", "rig_2"), [])
        for statement in (
            "SELECT * FROM gyrotherm.sample",
            "DELETE FROM gyrotherm.run",
            "UPDATE gyrotherm.run SET rows = 0",
            "INSERT INTO gyrotherm.gap VALUES (gen_random_uuid(), 1, 2, '')",
            "SELECT * FROM gyrotherm.v1_run",
            "SELECT gyrotherm.drop_month('2026-01-01')",
            f"SELECT gyrotherm.give_up('{run}')",
            f"SELECT gyrotherm.own_run('{run}')",
            "SELECT gyrotherm.make_month('2026-01-01')",
            "TRUNCATE gyrotherm.sample",
            "DROP TABLE gyrotherm.sample",
        ):
            self.refused(statement, "rig_2", "permission denied" if "DROP" not in statement else "must be owner")
        self.refused("SELECT gyrotherm.version()", "nobody", "permission denied")
        self.refused("SET ROLE rig_1; SELECT 1", "rig_2", "permission denied")
        self.refused("DELETE FROM gyrotherm.sample", "ada", "permission denied")
        self.refused(
            "SELECT gyrotherm.add_document('rig-1', 'model', 'm', '{\"schema\": \"gyrotherm-model/1\"}')",
            "rig_2",
            "is not one of rig_2",
        )
        self.assertEqual(self.checksum(), before)

    def test_rows_that_contradict_are_refused(self) -> None:
        before, run = self.checksum(), self.run_id
        row = self.store.sql(f"SELECT numbers FROM gyrotherm.sample WHERE run = '{run}' AND slot = 5")[0][0]
        utc = self.store.sql(f"SELECT utc_ns FROM gyrotherm.sample WHERE run = '{run}' AND slot = 5")[0][0]
        other = row.replace(row.strip("{}").split(",")[3], "99", 1)
        call = "SELECT gyrotherm.add_rows('{}', {}, '{}', '{}', '{}')"
        self.assertEqual(self.store.sql(call.format(run, 4, "{5}", f"{{{utc}}}", f'{{"{row}"}}'), "rig_1"), [["16479"]])
        for after, slots, utcs, numbers, why in (
            (4, "{5}", f"{{{utc}}}", f'{{"{other}"}}', "is another one"),
            (4, "{5}", "{7}", f'{{"{row}"}}', "is another one"),
            (4, "{5}", "{7}", '{"{1,2}"}', "has not"),
            (16479, "{16480}", "{7}", f'{{"{row}"}}', "is finished"),
            (20000, "{20001}", "{7}", f'{{"{row}"}}', "would leave a hole"),
            (4, "{6,5}", "{7,7}", f'{{"{row}","{row}"}}', "not in order"),
            (4, "{5,5}", "{7,7}", f'{{"{row}","{row}"}}', "not in order"),
            (4, "{5}", "{7,8}", f'{{"{row}"}}', "not in order"),
            (4, "{NULL}", "{7}", f'{{"{row}"}}', "not in order"),
            (-5, "{-2}", "{7}", f'{{"{row}"}}', "not in order"),
        ):
            self.refused(call.format(run, after, slots, utcs, numbers), "rig_1", why)
        self.refused(
            f'SELECT gyrotherm.finish_run(\'{run}\', \'{{"chain_head": "0", "files": []}}\')',
            "rig_1",
            "with other files",
        )
        event = {"number": 1, "slot": 0, "utc_ns": 1, "kind": "note", "text": "other"}
        self.refused(f"SELECT gyrotherm.add_events('{run}', 0, '{json.dumps([event])}')", "rig_1", "is another one")
        self.assertEqual(self.checksum(), before)

    def test_a_record_that_was_changed_is_told_once_and_others_go_on(self) -> None:
        rig = Rig(self.store, self.store.folder / "liar")
        for name in ("day.db", "day.db.sha256"):
            shutil.copy(self.record.parent / name, rig.records / name)
        changed = subprocess.run(
            [
                "python3",
                "-c",
                "import sqlite3, sys; d = sqlite3.connect(sys.argv[1]);"
                "d.execute(\"DELETE FROM meta WHERE key = 'outcome'\");"
                "d.execute('UPDATE sample SET \"A\" = 1 WHERE slot = 7');"
                "d.commit()",
                rig.records / "day.db",
            ],
            check=False,
        )
        self.assertEqual(changed.returncode, 0)
        self.store.sql("UPDATE gyrotherm.run SET finished = false, last_slot = 6")
        try:
            sent = rig.once()
            self.assertEqual(sent.returncode, 4, sent.stderr)
            self.assertIn("a row that is there is another one", sent.stderr)
            self.assertEqual(stored_rows(self.store, self.run_id), rows_of(self.record))
        finally:
            self.store.sql("UPDATE gyrotherm.run SET finished = true, last_slot = 16479")

    def test_the_definers_functions_pin_their_search_path(self) -> None:
        loose = self.store.sql(
            "SELECT proname FROM pg_proc p JOIN pg_namespace n ON n.oid = pronamespace WHERE nspname = 'gyrotherm'"
            " AND prosecdef AND NOT coalesce(array_to_string(proconfig, ','), '') ~ 'search_path=pg_catalog, pg_temp'"
        )
        self.assertEqual(loose, [])
        open_to_all = self.store.sql(
            "SELECT proname FROM pg_proc p JOIN pg_namespace n ON n.oid = pronamespace WHERE nspname = 'gyrotherm'"
            " AND has_function_privilege('nobody', p.oid, 'execute')"
        )
        self.assertEqual(open_to_all, [])

    def test_no_clock_of_the_server_is_in_a_key(self) -> None:
        """Whatever the server's clock says: defaults and computed columns of the tables have it nowhere."""
        clocks = self.store.sql(
            "SELECT c.relname FROM pg_attrdef d JOIN pg_class c ON c.oid = adrelid"
            " WHERE relnamespace = 'gyrotherm'::regnamespace AND relname <> 'migration'"
            " AND pg_get_expr(adbin, adrelid) ~ 'now|current|clock'"
        )
        self.assertEqual(clocks, [])
        calls = self.store.sql(
            "SELECT proname FROM pg_proc p JOIN pg_namespace n ON n.oid = pronamespace WHERE nspname = 'gyrotherm'"
            " AND prosrc ~* 'now\\(|current_(date|time)|clock_timestamp|localtime'"
            " ORDER BY 1"
        )
        self.assertEqual(calls, [["add_rows"], ["add_run"], ["end_stale"], ["make_month"]],
                         "when a row came, the age of a session, and how many months in a day")

    def test_every_question_is_answered(self) -> None:
        for question in ("drift", "outliers", "units", "thermometers", "utilisation", "attention", "rigs", "live",
                         "alarms", "frequent-alarms", "standards", "charts", "yield", "capability",
                         "recalibration", "status"):
            asked = [SITE, question, "--store", self.store.address("ada"), "--json"]
            answer = subprocess.run(asked, capture_output=True, text=True, check=False)
            self.assertEqual(answer.returncode, 0, answer.stderr)
            self.assertIsInstance(json.loads(answer.stdout), list)
        table = subprocess.run(
            [GYROTHERM, "site", "rigs", "--site", self.rig.file], capture_output=True, text=True, check=False
        )
        self.assertEqual(table.returncode, 4, "a rig reads no view")
        table = subprocess.run(
            [GYROTHERM, "site", "rigs", "--all", "--store", self.store.address("ada")],
            capture_output=True,
            text=True,
            check=True,
        )
        self.assertRegex(table.stdout, r"rig +state +profile .* simulated\nrig-1 +idle +short-rate .* SIMULATED\n")
        table = subprocess.run(
            [SITE, "utilisation", "--all", "--store", self.store.address("ada")],
            capture_output=True,
            text=True,
            check=True,
        )
        self.assertRegex(table.stdout, r"rig +week .* simulated\n(.*\n)*rig-1 .* SIMULATED\n")

    def test_status_says_how_far_it_is(self) -> None:
        status = self.rig.status()
        self.assertEqual([(run["lag_s"], run["finished_in_store"]) for run in status], [(0, True)])

    def test_a_store_of_a_newer_program_is_left_alone(self) -> None:
        self.store.sql("INSERT INTO gyrotherm.migration VALUES (99, 'future', '')")
        try:
            words = [SITE, "migrate", "--store", self.store.address("gyrotherm_owner")]
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 4)
            self.assertIn("a newer version migrated it", done.stderr)
            self.assertEqual(self.rig.once().returncode, 0, "rigs of two versions share a store")
        finally:
            self.store.sql("DELETE FROM gyrotherm.migration WHERE number = 99")

    def test_a_store_of_other_migrations_is_left_alone(self) -> None:
        """A store that was made before the first release has eight, of which the first one differs."""
        self.store.sql("UPDATE gyrotherm.migration SET sha256 = 'other' || sha256")
        self.store.sql("INSERT INTO gyrotherm.migration VALUES (8, 'zeros', '')")
        try:
            words = [SITE, "migrate", "--store", self.store.address("gyrotherm_owner")]
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 4)
            self.assertIn("migration 1 that differs", done.stderr)
            self.assertIn("create a new store and publish the records again", done.stderr)
        finally:
            self.store.sql("DELETE FROM gyrotherm.migration WHERE number = 8")
            self.store.sql("UPDATE gyrotherm.migration SET sha256 = substr(sha256, 6)")
        self.assertEqual(self.store.migrate(), "nothing to do\n")


class Beginning(unittest.TestCase):
    def test_many_rigs_begin_a_month_at_once(self) -> None:
        info = '{"started_ns": 1900000000000000000, "profile": "p", "simulated": false, "imported": false,'
        info += ' "channels": [], "units": []}'
        with cluster() as store:
            store.migrate()
            store.add_people()
            calls = [
                f"SELECT pg_sleep_until('{{}}'); SELECT gyrotherm.add_run('{uuid.uuid4()}', 'rig-{i}', '{info}')"
                for i in range(12)
            ]
            at = store.sql("SELECT clock_timestamp() + interval '600 ms'")[0][0]
            with concurrent.futures.ThreadPoolExecutor(len(calls)) as pool:
                done = list(pool.map(lambda call: store.try_sql(call.replace("{}", at, 1), "rig_1"), calls))
            self.assertEqual([one.stderr for one in done], [""] * len(calls))
            self.assertEqual(store.sql("SELECT count(*) FROM gyrotherm.run"), [[str(len(calls))]])


class Refused(unittest.TestCase):
    def test_once_fails_for_a_document_though_a_long_run_needs_more_rounds(self) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()
            rig = Rig(store, store.folder / "rig-1")
            profile = store.folder / "long.toml"
            profile.write_text(
                'schema = "gyrotherm-profile/1"\nname = "long"\n'
                '[[segment]]\nkind = "hold"\nat = "20 °C"\ntime = "8 h"\n'
            )
            run = run_of(record(rig.records / "long.db", str(profile)))
            (rig.records / "calibration.json").write_text(json.dumps(CALIBRATION | {"ended": "infinity"}))
            sent = rig.once()
            self.assertGreater(len(stored_rows(store, run)), 25_000, "more than one turn")
            self.assertTrue(finished(store, run), sent.stderr)
            self.assertEqual(sent.returncode, 4, sent.stderr)
            self.assertEqual(sent.stderr.count("refused by the store"), 1)


class Replacing(unittest.TestCase):
    def test_a_report_is_replaced_by_whoever_sent_it(self) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()

            def add(rig: int, **changes: object) -> None:
                text = json.dumps(CALIBRATION | changes)
                store.sql(f"SELECT gyrotherm.add_document('rig-{rig}', 'calibration', 'c', $c${text}$c$)",
                          f"rig_{rig}")

            def current() -> list[list[str]]:
                return store.sql("SELECT d.rig FROM gyrotherm.current_calibration JOIN gyrotherm.document d"
                                 " USING (sha256) ORDER BY 1")

            add(1)
            add(2, state="superseded")
            self.assertEqual(current(), [["rig-1"]], "another rig's word takes nothing away")
            self.assertNotEqual(store.sql("SELECT count(*) FROM gyrotherm.v1_drift"), [["0"]])
            add(2, issued="2026-01-10")
            self.assertEqual(current(), [["rig-1"]], "the number that it superseded itself")
            add(2, number="C-2")
            self.assertEqual(current(), [["rig-1"], ["rig-2"]])
            add(1, state="superseded", issued="2026-01-11")
            self.assertEqual(current(), [["rig-2"]])


class Renewed(unittest.TestCase):
    """Under the path of a record there is another one, in the file of the same number: what `cp` leaves."""

    def publish_one_after_another(self, end_it: bool) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()
            rig = Rig(store, store.folder / "rig-1")
            kept = store.folder / "kept"
            kept.mkdir()
            one, two = (record(kept / f"{seed}.db", "tests/profiles/ten-seconds.toml", seed) for seed in (1, 2))
            if not end_it:
                with contextlib.closing(sqlite3.connect(one)) as database, database:
                    database.execute("DELETE FROM meta WHERE key = 'outcome'")
                    database.execute("DELETE FROM sample WHERE slot > 3")
            path = rig.records / "run.db"
            shutil.copyfile(one, path)
            number = path.stat().st_ino
            rig.start()
            try:
                rows = len(rows_of(one))
                sent = lambda: store.sql(
                    f"SELECT rows, finished FROM gyrotherm.run WHERE id = '{run_of(one)}'"
                ) == [[str(rows), "t" if end_it else "f"]]  # noqa: E731
                self.assertTrue(until(sent), rig.log.read_text())
                shutil.copyfile(two, path)
                self.assertEqual(path.stat().st_ino, number)
                self.assertTrue(until(lambda: finished(store, run_of(two))), rig.log.read_text())
                for source in (one, two):
                    self.assertEqual(stored_rows(store, run_of(source)), rows_of(source))
                self.assertEqual([(run["lag_s"], run["finished_in_store"]) for run in rig.status()], [(0, True)])
            finally:
                self.assertEqual(rig.stop(), 0)

    def test_a_finished_run_is_replaced(self) -> None:
        self.publish_one_after_another(end_it=True)

    def test_an_unfinished_run_is_replaced(self) -> None:
        self.publish_one_after_another(end_it=False)


class Simulated(unittest.TestCase):
    """A virtual run's clock may be a year ahead, and its unit may have the number of a real one: what it sends is kept,
    and stands apart."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()
        cls.add_run("chamber-3", "2026-11-20", certificate="K-2026-0117", due="2027-01-17")
        cls.add_run("chamber-3", "2027-01-01", simulated=True)
        cls.add_calibration("0042", "2026-01-05", 0.05, simulated=True, state="draft")
        cls.add_calibration("0042", "2026-10-01", 0.001)

    @classmethod
    def add_run(cls, rig: str, day: str, certificate: str = "", due: str = "", simulated: bool = False,
                imported: bool = False) -> str:
        run = str(uuid.uuid4())
        began = int(datetime.datetime.fromisoformat(f"{day}T12:00:00+00:00").timestamp()) * 10**9
        calibration = {"instrument": "virtual" if simulated else "F200", "certificate": certificate,
                       "calibrated": "2026-01-17", "due": due}
        channel = {"name": "A", "unit": "°C", "measures": "temperature", "unit_under_test": "",
                   "calibration": calibration}
        info = {"started_ns": began, "profile": day, "simulated": simulated, "imported": imported, "units": [],
                "channels": [channel]}
        cls.store.sql(f"SELECT gyrotherm.add_run('{run}', '{rig}', '{json.dumps(info)}')", "rig_1")
        return run

    @classmethod
    def add_calibration(cls, unit: str, day: str, bias: float, model: str = "RLG-1", **more: object) -> None:
        column = {"quantity": "bias", "unit": "°/h", "values": [{"value": bias, "u": 0.001, "k": 2, "U": 0.002}]}
        result = CALIBRATION["results"][0] | {"columns": [column]}
        text = json.dumps(CALIBRATION | {"number": f"C-{unit}-{day}", "ended": day, "results": [result],
                                         "item": {"serial_number": unit, "model": model}} | more)
        cls.store.sql(f"SELECT gyrotherm.add_document('chamber-3', 'calibration', 'c', $c${text}$c$)", "rig_1")

    @classmethod
    def thermometer(cls) -> list[str]:
        return cls.store.sql("SELECT instrument, certificate, due FROM gyrotherm.v1_thermometer"
                             " WHERE rig = 'chamber-3'", "ada")[0]

    @classmethod
    def changes(cls, simulated: bool) -> list[float]:
        return [float(change) for change, in cls.store.sql(
            "SELECT change FROM gyrotherm.v1_drift WHERE serial_number = '0042' AND change IS NOT NULL"
            f" AND simulated = {simulated} ORDER BY calibrated", "ada")]

    def ask(self, question: str, *words: str) -> list[dict]:
        asked = [SITE, question, "--store", self.store.address("ada"), "--json", *words]
        return json.loads(subprocess.run(asked, capture_output=True, text=True, check=True).stdout)

    def test_a_thermometer_keeps_its_certificate(self) -> None:
        self.assertEqual(self.thermometer(), ["F200", "K-2026-0117", "2027-01-17"])
        self.add_run("chamber-3", "2027-02-01", simulated=True)
        self.assertEqual(self.thermometer(), ["F200", "K-2026-0117", "2027-01-17"])
        self.add_run("chamber-3", "2026-11-21", certificate="K-2026-0200", due="2027-11-20")
        self.assertEqual(self.thermometer(), ["F200", "K-2026-0200", "2027-11-20"])

    def test_an_imported_table_has_no_thermometer_of_the_rig(self) -> None:
        self.add_run("chamber-8", "2026-11-22", imported=True)
        of_rig = "SELECT name, certificate FROM gyrotherm.v1_thermometer WHERE rig = 'chamber-8'"
        self.assertEqual(self.store.sql(of_rig, "ada"), [])
        self.add_run("chamber-8", "2026-11-20", certificate="K-1")
        self.assertEqual(self.store.sql(of_rig, "ada"), [["A", "K-1"]])
        self.add_run("chamber-8", "2026-11-23", imported=True)
        self.assertEqual(self.store.sql(of_rig, "ada"), [["A", "K-1"]])

    def test_no_unit_drifts_from_what_was_simulated(self) -> None:
        self.assertEqual(self.changes(False), [])
        self.add_calibration("0042", "2026-11-01", 0.003)
        self.add_calibration("0042", "2026-11-01", 0.2, simulated=True, state="draft")
        self.assertEqual([round(change, 6) for change in self.changes(False)], [0.002])
        self.assertEqual([round(change, 6) for change in self.changes(True)], [0.15])
        self.assertEqual([row["simulated"] for row in self.ask("drift", "--unit", "0042")], [False])
        self.assertEqual(len(self.ask("drift", "--unit", "0042", "--all")), 4, "each of the four results")

    def test_only_results_of_one_zero_are_compared(self) -> None:
        """A bias is no drift of one that was counted from another zero, or from a record's own mean."""
        run, other = (f"{digit}" * 32 for digit in "ab")
        result = CALIBRATION["results"][0] | {"run": run}
        own = "mean of the first hold removed"
        for unit, zeros, comparable in (
                ("Z1", ("earth rate removed", "earth rate removed"), True),
                ("Z2", ("earth rate removed", "nothing removed"), False),
                ("Z3", (own, own), False),
                ("Z4", ("", ""), True)):
            for day, zero, value, of in (("2026-01-05", zeros[0], 0.01, run), ("2026-06-05", zeros[1], 0.03, other)):
                columns = [{"quantity": quantity, "unit": "°/h", "values": [{"value": value, "u": 1, "k": 2, "U": 2}]}
                           for quantity in ("mean", "std")]
                text = json.dumps(CALIBRATION | {
                    "number": f"C-{unit}-{day}", "ended": day, "results": [result | {"run": of, "columns": columns}],
                    "item": {"serial_number": unit, "model": "RLG-1"},
                    "bias_zero": "" if unit == "Z3" else zero,
                    "bias_zeros": [{"axis": result["axis"], "run": of, "zero": zero}] if unit == "Z3" else []})
                self.store.sql(f"SELECT gyrotherm.add_document('chamber-3', 'calibration', 'c', $c${text}$c$)", "rig_1")
            changed = {quantity.partition(".")[2] for quantity, in self.store.sql(
                f"SELECT quantity FROM gyrotherm.v1_drift WHERE serial_number = '{unit}' AND change IS NOT NULL", "ada")}
            self.assertEqual(changed, {"mean", "std"} if comparable else {"std"}, unit)
        conditions = [condition for condition, in self.store.sql(
            "SELECT condition FROM gyrotherm.v1_drift WHERE serial_number = 'Z3' AND quantity LIKE '%.mean'", "ada")]
        self.assertEqual(sorted(text.rpartition(", ")[2] for text in conditions), [f"run {run}", f"run {other}"])

    def test_a_model_is_judged_by_real_units(self) -> None:
        for i in range(5):
            self.add_calibration(f"R{i}", "2026-03-01", 5.0 if i == 4 else 0.01 + 0.001 * i, "lot")
            self.add_calibration(f"S{i}", "2026-03-01", 5.0 if i else 0.01, "lot", simulated=True)
        self.assertEqual([(row["serial_number"], row["units"]) for row in self.ask("outliers")], [("R4", 5)])

    def test_a_draft_of_a_dry_run_hides_no_draft_of_the_same_day(self) -> None:
        for simulated in (False, True):
            self.add_calibration("0043", "2026-04-01", 0.01, simulated=simulated, state="draft")
        self.assertEqual(self.store.sql("SELECT count(*) FROM gyrotherm.current_calibration"
                                        " WHERE serial_number = '0043'"), [["2"]])

    def test_on_a_rig_is_the_run_that_began_last(self) -> None:
        self.add_run("chamber-4", "2026-05-01")  # and nobody has heard of it since
        last = self.add_run("chamber-4", "2026-06-01")
        self.store.sql(f"UPDATE gyrotherm.run SET finished = true, state = 'complete' WHERE id = '{last}'")
        self.add_run("chamber-4", "2027-05-01", simulated=True)
        self.add_run("chamber-5", "2026-05-01", simulated=True)
        self.store.sql("SELECT gyrotherm.add_document('chamber-6', 'model', 'm',"
                       " '{\"schema\": \"gyrotherm-model/1\"}')", "rig_1")
        told = {row["rig"]: (row["state"], row["profile"], row["runs"]) for row in self.ask("rigs")}
        self.assertEqual(told["chamber-4"], ("idle", "2026-06-01", 2), "without the virtual run")
        self.assertEqual(told["chamber-6"], (None, None, 0), "a rig without a run")
        self.assertNotIn("chamber-5", told)
        self.assertEqual([row["runs"] for row in self.ask("rigs", "--all") if row["rig"] == "chamber-5"], [1])

    def test_a_warning_is_an_alarm_and_an_aborted_run_is_not_silent(self) -> None:
        run = self.add_run("chamber-7", "2026-07-01")
        alarm = {"slot": 5, "utc_ns": 1, "segment": 0, "channel": None, "interlock": None, "reaction": None}
        events = [
            alarm | {"number": 1, "kind": "fault", "interlock": "stuck", "reaction": "warn", "text": "A stands"},
            alarm | {"number": 2, "kind": "fault", "channel": "A", "text": "A does not answer"},
            alarm | {"number": 3, "kind": "interlock", "interlock": "air_limit", "reaction": "abort", "text": "too hot"},
            alarm | {"number": 4, "kind": "fault", "interlock": "storage", "reaction": "warn", "text": "disk"},
            alarm | {"number": 5, "kind": "acknowledged", "interlock": "storage", "reaction": "warn",
                     "text": "alarm 4 acknowledged by ada (uid 1000): seen"},
            *(alarm | {"number": n, "kind": "interlock", "interlock": i, "channel": c, "reaction": "suspend", "text": t}
              for n, i, c, t in ((6, "door", None, "open"), (7, "lost", "A", "lost A"), (8, "door", None, "open"),
                                 (9, "lost", "B", "lost B"), (10, "lost", "A", "lost A"), (11, "door", None, "open"))),
            alarm | {"number": 12, "kind": "acknowledged", "interlock": "door", "reaction": "suspend",
                     "text": "alarm 6 to 8 acknowledged by ada (uid 1000): the latch"},
        ]
        self.store.sql(f"SELECT gyrotherm.add_events('{run}', 0, '{json.dumps(events)}')", "rig_1")
        self.store.sql(f"SELECT gyrotherm.say_state('{run}', 'aborted', 'too hot', '[]')", "rig_1")
        told = [(row["what"], row["detail"]) for row in self.ask("attention") if row["rig"] == "chamber-7"]
        self.assertEqual(sorted(told), [("aborted", "too hot"), ("alarm", "A stands"), ("alarm", "lost A (2 times)"),
                                        ("alarm", "lost B"), ("alarm", "open"), ("alarm", "too hot")])


class Upgraded(unittest.TestCase):
    """A store of an earlier version, with data, that is migrated."""

    def test_thermometers_of_imported_tables_are_removed(self) -> None:
        with cluster() as store:
            owner = f"{store.address('postgres')} options='-c role=gyrotherm_owner'"
            words = [SITE, "migrate", "--to", "5", "--store", owner]
            subprocess.run(words, capture_output=True, text=True, check=True)
            store.add_people()
            for rig, started, imported, certificate in (("a", 1, False, "old"), ("a", 2, False, "real"),
                                                        ("a", 3, True, ""), ("b", 4, True, ""), ("c", 5, False, "c")):
                calibration = {"instrument": "i", "certificate": certificate, "calibrated": "", "due": "2027-01-17"}
                channel = {"name": "A", "unit": "°C", "measures": "temperature", "unit_under_test": "",
                           "calibration": calibration}
                info = {"started_ns": started * 10**18 // 10, "profile": "p", "simulated": False, "imported": imported,
                        "units": [], "channels": [channel]}
                store.sql(f"SELECT gyrotherm.add_run('{uuid.uuid4()}', '{rig}', '{json.dumps(info)}')", "rig_1")
            known = "SELECT rig, certificate, due FROM gyrotherm.v1_thermometer ORDER BY rig"
            self.assertEqual(store.sql(known, "ada"),
                             [["a", "", "2027-01-17"], ["b", "", "2027-01-17"], ["c", "c", "2027-01-17"]])
            self.assertIn("migration 6", store.migrate())
            self.assertEqual(store.sql(known, "ada"), [["a", "real", "2027-01-17"], ["c", "c", "2027-01-17"]])

    def test_no_other_role_blocks_a_migration(self) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()
            for user in ("rig_1", "ada"):
                self.assertIn("permission denied", store.try_sql(
                    "BEGIN; LOCK TABLE gyrotherm.migration IN SHARE MODE", user).stderr)
            held = "SELECT pg_advisory_lock(hashtext('gyrotherm.migrate')); SELECT pg_sleep(300)"
            holder = subprocess.Popen([BIN / "psql", "-X", "-q", "-c", held, store.address("rig_1")],
                                      stdout=subprocess.DEVNULL)
            try:
                waits = "SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND granted"
                self.assertTrue(until(lambda: store.sql(waits) == [["1"]]))
                self.assertIn("nothing to do", store.migrate())
                store.sql("DROP SCHEMA gyrotherm CASCADE")
                self.assertIn("migration 7", store.migrate())
            finally:
                holder.kill()
                holder.wait()

    def test_two_programs_create_one_store(self) -> None:
        with cluster() as store, concurrent.futures.ThreadPoolExecutor() as pool:
            made = [one.result() for one in [pool.submit(store.migrate) for _ in range(4)]]
            self.assertEqual(sum(text.count("migration 1:") for text in made), 1, made)
            last = store.sql("SELECT max(number) FROM gyrotherm.migration")
            self.assertEqual(store.sql("SELECT count(*) FROM gyrotherm.migration"), last)


class Withheld(unittest.TestCase):
    """Faults of one run: the store says that it is not finished, the log has one line, and others go on."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()

    def rig(self, name: str, seed: int, archive: str = "") -> tuple[Rig, pathlib.Path]:
        rig = Rig(self.store, self.store.folder / name, name=name, below=archive)
        (rig.folder / "archive").mkdir()
        self.addCleanup(lambda: rig.process and rig.process.poll() is None and rig.kill())
        return rig, record(rig.records / "day.db", "tests/profiles/ten-seconds.toml", seed=seed)

    def put(self, path: pathlib.Path, at: int, byte: bytes) -> bytes:
        with open(path, "r+b") as file:
            file.seek(at)
            before = file.read(1)
            file.seek(at)
            file.write(byte)
        return before

    def test_an_edited_row_is_not_complete(self) -> None:
        rig, day = self.rig("edited", 21, '[archive]\nfolder = "archive"')
        with contextlib.closing(sqlite3.connect(day)) as database:
            database.execute('UPDATE sample SET "A" = 1 WHERE slot = 3')
            database.commit()
        done = rig.once()
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("does not match the hash chain", done.stderr)
        self.assertFalse(finished(self.store, run_of(day)))
        self.assertEqual(list((rig.folder / "archive").iterdir()), [])

    def test_a_record_that_differs_from_its_manifest_waits_for_its_bytes(self) -> None:
        rig, day = self.rig("manifest", 22, '[archive]\nfolder = "archive"')
        run, before = run_of(day), self.put(day, 96, b"\1")
        rig.start()
        self.assertTrue(until(lambda: "has changed since the run was closed" in rig.log.read_text()))
        time.sleep(3)
        self.assertEqual(rig.log.read_text().count("has changed since"), 1)
        self.assertFalse(finished(self.store, run))
        self.put(day, 96, before)
        self.assertTrue(until(lambda: finished(self.store, run), 20), rig.log.read_text())
        self.assertEqual(rig.stop(), 0)

    def test_an_archive_that_fails_is_not_tried_each_second(self) -> None:
        command = '[archive]\ncommand = ["sh", "-c", "echo $0 >> tries; exit 1", "{file}", "{sha256}"]'
        rig, _ = self.rig("archive", 23, command.replace("tries", str(self.store.folder / "tries")))
        rig.start()
        tries = self.store.folder / "tries"
        self.assertTrue(until(tries.exists), rig.log.read_text())
        time.sleep(3.5)
        self.assertEqual(len(tries.read_text().splitlines()), 1)
        other = record(rig.records / "next.db", "tests/profiles/ten-seconds.toml", seed=24)
        rows = lambda: len(stored_rows(self.store, run_of(other)))  # noqa: E731
        self.assertTrue(until(rows, 20), "other runs go on")
        missing, kept = self.rig("nowhere", 25, '[archive]\nfolder = "none"')
        missing.start()
        self.assertTrue(until(lambda: "No such file" in missing.log.read_text()))
        time.sleep(2.5)
        self.assertEqual(missing.log.read_text().count("No such file"), 1)
        self.assertFalse(finished(self.store, run_of(kept)))

    def test_a_missing_folder_is_told(self) -> None:
        rig, day = self.rig("folders", 26)
        rig.file.write_text(rig.file.read_text().replace('["runs"]', '["runs", "gone"]'))
        gone = rig.folder / "gone"
        for words in (["--once"], ["--status"], ["--status", "--json"]):
            done = subprocess.run([PUBLISH, "--site", rig.file, *words], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 4, words)
            self.assertIn(f"{gone}: No such file or directory", done.stderr)
        self.assertIn(str(gone), done.stdout)
        self.assertTrue(finished(self.store, run_of(day)), "the other folder was sent")
        rig.start()
        told = lambda: rig.log.read_text().count(f"{gone}: No such file")  # noqa: E731
        self.assertTrue(until(lambda: told() == 1), rig.log.read_text())
        time.sleep(2.5)
        self.assertEqual(told(), 1)
        gone.mkdir()
        time.sleep(2.5)
        gone.rmdir()
        self.assertTrue(until(lambda: told() == 2), rig.log.read_text())
        gone.write_text("not a folder")
        self.assertTrue(until(lambda: "Not a directory" in rig.log.read_text()), rig.log.read_text())
        self.assertEqual(rig.stop(), 0)

    def test_one_bad_id_hides_no_other_status(self) -> None:
        rig, day = self.rig("ids", 27)
        self.assertEqual(rig.once().returncode, 0)
        bad = record(rig.records / "bad.db", "tests/profiles/ten-seconds.toml", seed=28)
        with contextlib.closing(sqlite3.connect(bad)) as database:
            database.execute("UPDATE meta SET value = 'no uuid' WHERE key = 'id'")
            database.commit()
        shown = {row["record"]: row for row in rig.status()}
        self.assertTrue(shown[str(day)]["finished_in_store"])
        self.assertIn("uuid", shown[str(bad)]["trouble"])

    def test_a_run_that_ends_by_itself_gets_its_further_segments(self) -> None:
        rig = Rig(self.store, self.store.folder / "until", name="until")
        path = rig.records / "until.db"
        done = subprocess.run(
            [GYROTHERM, "run", "tests/profiles/short-until.toml", "--rig", "virtual-supply", "--out", path, "--quiet"],
            cwd=SOURCE, capture_output=True, text=True, check=False,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(rig.once().returncode, 0)
        run = run_of(path)
        segments = f"SELECT jsonb_array_length(info->'segments') FROM gyrotherm.run WHERE id = '{run}'"
        whole = self.store.sql(segments)
        self.assertGreater(int(whole[0][0]), 2)
        self.store.sql("UPDATE gyrotherm.run SET finished = false, info = jsonb_set(info, '{segments}',"
                       f" jsonb_path_query_array(info->'segments', '$[0 to 1]')) WHERE id = '{run}'")
        self.assertEqual(self.store.sql(segments), [["2"]])
        sent = rig.once()
        self.assertEqual(sent.returncode, 0, sent.stderr)
        self.assertEqual(self.store.sql(segments), whole)

    def test_segments_are_only_added_at_the_end(self) -> None:
        run = str(uuid.uuid4())
        info = {"started_ns": 10**18, "profile": "p", "simulated": False, "imported": False, "units": [],
                "channels": [], "segments": [{"name": "a"}, {"name": "b"}]}
        self.store.sql(f"SELECT gyrotherm.add_run('{run}', 'growing', '{json.dumps(info)}')", "rig_1")
        add = lambda *names, user="rig_1": self.store.try_sql(  # noqa: E731
            f"SELECT gyrotherm.add_segments('{run}', '{json.dumps([{'name': name} for name in names])}')", user)
        for names, length in ((("a",), 2), ((), 2), (("a", "b"), 2), (("a", "b", "c"), 3), (("a", "b"), 3)):
            self.assertEqual(add(*names).stdout.strip(), str(length), names)
        for names in (("b",), ("a", "c", "c", "d"), ("a", "b", "d", "e")):
            self.assertIn("a segment that is there is another one", add(*names).stderr)
        self.assertIn("is not one of rig_2", add("a", "b", "c", "d", user="rig_2").stderr)
        self.assertIn("permission denied", add("a", "b", "c", "d", user="ada").stderr)
        self.assertIn("not a list", self.store.try_sql(
            f"SELECT gyrotherm.add_segments('{run}', '{{}}')", "rig_1").stderr)
        self.store.sql(f"SELECT gyrotherm.add_run('{run}', 'growing', '{json.dumps(info)}')", "rig_1")
        other = json.dumps(info | {"profile": "q"})
        self.assertIn("is another one", self.store.try_sql(
            f"SELECT gyrotherm.add_run('{run}', 'growing', '{other}')", "rig_1").stderr)
        self.store.sql(f"SELECT gyrotherm.give_up('{run}')")
        self.assertIn("the run is finished", add("a", "b", "c", "d").stderr)

    def test_an_imported_table_has_no_clock(self) -> None:
        run = str(uuid.uuid4())
        info = {"started_ns": 0, "profile": "p", "simulated": False, "imported": True, "units": [],
                "channels": [{"name": "A", "unit": "", "measures": "program", "unit_under_test": ""}]}
        event = {"number": 1, "slot": 0, "utc_ns": 0, "kind": "started", "interlock": None, "reaction": None,
                 "segment": None, "channel": None, "text": "imported"}
        timed = event | {"number": 2, "utc_ns": 10**18}
        self.store.sql(f"SELECT gyrotherm.add_run('{run}', 'table', '{json.dumps(info)}');"
                       f"SELECT gyrotherm.add_rows('{run}', -1, '{{0}}', '{{NULL}}', '{{\"{{1}}\"}}');"
                       f"SELECT gyrotherm.add_events('{run}', 0, '{json.dumps([event, timed])}')", "rig_1")
        times = f"SELECT utc IS NULL FROM gyrotherm.v1_event WHERE run = '{run}' ORDER BY number"
        self.assertEqual(self.store.sql(times, "ada"), [["t"], ["f"]])
        age = self.store.sql("SELECT age_s FROM gyrotherm.v1_live WHERE rig = 'table'", "ada")
        self.assertLess(float(age[0][0]), 3600)

    def test_arguments_without_effect_are_refused(self) -> None:
        address, site = self.store.address("ada"), self.store.folder / "query.toml"
        site.write_text(f'schema = "gyrotherm-site/1"\n[store]\naddress = "{address}"\n')
        for words, why in (
            (["rigs", "--site", site, "--passfile", "none"], "--passfile requires --store"),
            (["status", "--site", site, "--passfile", "none"], "--passfile requires --store"),
            (["rigs", "--site", site, "--", "--all"], "after --"),
            (["status", "--site", site, "--", "x"], "after --"),
            (["migrate", "--site", site, "--", "x"], "after --"),
            (["job", "none", "--", "--quick"], "after --"),
        ):
            done = subprocess.run([SITE, *words], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(why, done.stderr)
        done = subprocess.run([SITE, "rigs", "--site", site], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)


class Entrance(unittest.TestCase):
    """Who is let in, and how: TLS, SCRAM, secrets."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        folder = cls.store.folder
        run = lambda *words: subprocess.run(
            [*map(str, words)], check=True, capture_output=True, cwd=folder
        )  # noqa: E731
        run(
            "openssl",
            "req",
            "-x509",
            "-newkey",
            "rsa:2048",
            "-nodes",
            "-days",
            "2",
            "-subj",
            "/CN=site root",
            "-keyout",
            "root.key",
            "-out",
            "root.crt",
        )
        run(
            "openssl",
            "req",
            "-newkey",
            "rsa:2048",
            "-nodes",
            "-subj",
            "/CN=localhost",
            "-keyout",
            "server.key",
            "-out",
            "server.csr",
        )
        run(
            "openssl",
            "x509",
            "-req",
            "-days",
            "2",
            "-in",
            "server.csr",
            "-CA",
            "root.crt",
            "-CAkey",
            "root.key",
            "-CAcreateserial",
            "-out",
            "server.crt",
        )
        run(
            "openssl",
            "req",
            "-x509",
            "-newkey",
            "rsa:2048",
            "-nodes",
            "-days",
            "2",
            "-subj",
            "/CN=other root",
            "-keyout",
            "o.key",
            "-out",
            "other.crt",
        )
        for name in ("server.key", "server.crt"):
            cls.store.write(name, (folder / name).read_text())
        cls.store.write("postgresql.auto.conf", cls.store.settings + "ssl = on\n")
        cls.store.stop()
        cls.store.start()
        cls.store.migrate()
        cls.store.add_people()

    def rig(self, name: str, host: str = "localhost", root: str = "root.crt", **more: str) -> Rig:
        folder = self.store.folder
        address = (
            f"host={host} hostaddr=127.0.0.1 port={self.store.port} dbname=gyrotherm user=rig_1 sslmode=verify-full"
            f" sslrootcert={folder / root}"
        )
        return Rig(self.store, folder / name, name="rig-1", address=more.pop("address", address), **more)

    def pgpass(self, rig: Rig, password: str = "one", mode: int = 0o600) -> None:
        path = rig.folder / "pgpass"
        path.write_text(f"*:*:gyrotherm:rig_1:{password}\n")
        path.chmod(mode)

    def test_tls_and_scram_with_a_passfile(self) -> None:
        rig = self.rig("good", store='passfile = "pgpass"')
        self.pgpass(rig)
        done = rig.once()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("TLSv1.3", done.stderr)

    def test_a_credential_of_systemd(self) -> None:
        rig = self.rig("credential", store='credential = "store"')
        for mode in (0o400, 0o440):  # systemd before 254, and later with an access control list
            self.pgpass(rig, mode=mode)
            (rig.folder / "pgpass").rename(rig.folder / "store")
            done = subprocess.run(
                [PUBLISH, "--site", rig.file, "--once"],
                capture_output=True,
                text=True,
                check=False,
                env={"CREDENTIALS_DIRECTORY": str(rig.folder)},
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("TLSv1.3", done.stderr)
        (rig.folder / "store").write_text("*:*:gyrotherm:rig_1:two\n")
        done = subprocess.run(
            [PUBLISH, "--site", rig.file, "--once"],
            capture_output=True,
            text=True,
            check=False,
            env={"CREDENTIALS_DIRECTORY": str(rig.folder)},
        )
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn(str(rig.folder / "store"), done.stderr)
        done = rig.once()
        self.assertEqual(done.returncode, 4)
        self.assertIn("LoadCredential", done.stderr)

    def test_who_is_not_let_in(self) -> None:
        for name, more, password, mode, code, why in (
            ("wrong-password", {"store": 'passfile = "pgpass"'}, "two", 0o600, 3, "password authentication failed"),
            ("no-password", {}, None, 0o600, 3, "no password supplied"),
            ("open-passfile", {"store": 'passfile = "pgpass"'}, "one", 0o644, 4, "expected mode 0600"),
            ("other-host", {"host": "elsewhere", "store": 'passfile = "pgpass"'}, "one", 0o600, 3, "does not match"),
            (
                "other-root",
                {"root": "other.crt", "store": 'passfile = "pgpass"'},
                "one",
                0o600,
                3,
                "certificate verify failed",
            ),
            (
                "without-tls",
                {
                    "address": f"host=127.0.0.1 port={self.store.port} dbname=gyrotherm user=rig_1 sslmode=disable",
                    "store": 'passfile = "pgpass"',
                },
                "one",
                0o600,
                3,
                "no pg_hba.conf entry",
            ),
            ("told", {"address": "host=127.0.0.1 password=one"}, None, 0o600, 4, "use a passfile"),
        ):
            rig = self.rig(name, **more)
            if password:
                self.pgpass(rig, password, mode)
            done = rig.once()
            self.assertIn(why, done.stderr, name)
            self.assertEqual(done.returncode, code, f"{name}: {done.stderr}")
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)

    def test_the_store_is_taken_on_while_a_rig_sends(self) -> None:
        """Further migrations, under a publisher of the version before."""
        rig = Rig(self.store, self.store.folder / "old", name="rig-old", user="rig_2")
        one = record(rig.records / "one.db", "tests/profiles/ten-seconds.toml", seed=8)
        rig.start()
        try:
            self.assertTrue(until(lambda: finished(self.store, run_of(one))), rig.log.read_text())
            words = [os.environ["GYROTHERM_SITE_TEST"], "--gtest_filter=MigratedStore.*"]
            taken = subprocess.run(words, env=os.environ | {"GYROTHERM_STORE": self.store.address("gyrotherm_owner")},
                                   capture_output=True, text=True, check=False)
            self.assertEqual(taken.returncode, 0, taken.stdout)
            self.assertIn("[  PASSED  ] 1 test", taken.stdout)
            two = record(rig.records / "two.db", "tests/profiles/ten-seconds.toml", seed=9)
            self.assertTrue(until(lambda: finished(self.store, run_of(two))), rig.log.read_text())
        finally:
            self.assertEqual(rig.stop(), 0)


class ManyRigs(unittest.TestCase):
    def test_the_live_page_has_every_one(self) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()
            info = {"started_ns": 1900000000000000000, "profile": "p", "simulated": False, "imported": False,
                    "channels": [], "units": []}
            store.sql(f"SELECT gyrotherm.add_run(gen_random_uuid(), 'rig-' || i, '{json.dumps(info)}')"
                      " FROM generate_series(1, 122) i", "rig_1")
            lot = info | {"order_number": "2026-17", "units": [
                {"label": "u1", "serial_number": "0042", "model": "RLG-1"},
                {"label": "u2", "serial_number": "", "model": ""}]}
            store.sql(f"SELECT gyrotherm.add_run(gen_random_uuid(), 'rig-1', '{json.dumps(lot)}')", "rig_1")
            asked = [SITE, "units", "--unit", "0042", "--store", store.address("ada"), "--json"]
            units = json.loads(subprocess.run(asked, capture_output=True, text=True, check=True).stdout)
            self.assertEqual([(unit["serial_number"], unit["order_number"], unit["rig"], unit["position"])
                              for unit in units], [("0042", "2026-17", "rig-1", "u1")])
            orders = store.sql("SELECT order_number, count(*) FROM gyrotherm.v1_run GROUP BY 1 ORDER BY 1", "ada")
            self.assertEqual(orders, [["2026-17", "1"], ["", "122"]])
            (store.folder / "runs").mkdir()
            site = store.folder / "monitor.toml"
            site.write_text('schema = "gyrotherm-site/1"\nname = "hall 4"\nrig = "none"\nfolders = ["runs"]\n\n'
                            f'[store]\naddress = "{store.address("ada")}"\n')
            monitor = Monitor(store.folder, "--site", str(site), runs=store.folder / "runs")
            try:
                answer = monitor.ask("/api/v1/site/rigs")
                self.assertEqual(answer.status, 200, answer.body)
                self.assertEqual(len(answer.json), 122)
            finally:
                self.assertEqual(monitor.stop(), 0)
            asked = [SITE, "rigs", "--store", store.address("ada"), "--json"]
            some = subprocess.run(asked, capture_output=True, text=True, check=True)
            self.assertEqual(len(json.loads(some.stdout)), 100)
            self.assertIn("more rows may exist", some.stderr)


class Bounded(unittest.TestCase):
    """Whatever a rig says, everybody else is answered."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()
        cls.views = [view for view, in cls.store.sql("SELECT viewname FROM pg_views WHERE viewname LIKE 'v1%'")]
        for unit, bias in enumerate((0.010, 0.011, 0.012, 0.013, 0.014)):
            cls.store.sql(cls.calibration(f"R{unit}", bias), "rig_1")

    @staticmethod
    def calibration(unit: str, bias: object, rig: str = "rig-1", **more: object) -> str:
        column = {"quantity": "bias", "unit": "°/h", "values": [{"value": bias, "u": 0.001, "k": 2, "U": 0.002}]}
        text = json.dumps(CALIBRATION | {"number": f"C-{unit}-{rig}", "item": {"serial_number": unit, "model": "lot"},
                                         "results": [CALIBRATION["results"][0] | {"columns": [column]}]} | more)
        return f"SELECT gyrotherm.add_document('{rig}', 'calibration', 'c', $c${text}$c$);"

    def say(self, *more: str, began_s: int = 1_900_000_000, **calibration: str) -> str:
        """A run of rig-2's, and what it says of it."""
        self.run_id = str(uuid.uuid4())
        info = {"started_ns": began_s * 10**9, "profile": "p", "simulated": "due" not in calibration,
                "imported": False, "units": [], "channels": [
                    {"name": "state", "unit": "", "measures": "program", "unit_under_test": "",
                     "words": ["execute"]},
                    {"name": "A", "unit": "°C", "measures": "temperature", "unit_under_test": "",
                     "calibration": {"instrument": "i", "certificate": "c", "calibrated": "", **calibration}}]}
        said = [f"add_run('{self.run_id}', 'rig-2', '{json.dumps(info)}')", *more]
        text = "".join(f"SELECT gyrotherm.{call.replace('RUN', self.run_id)};" for call in said)
        return self.store.try_sql(f"BEGIN; {text} COMMIT;", "rig_2").stderr

    def everybody_is_answered(self) -> None:
        for view in self.views:
            asked = self.store.try_sql(f"SELECT * FROM gyrotherm.{view}", "ada")
            self.assertEqual(asked.returncode, 0, f"{view}: {asked.stderr}")

    def test_by_numbers_beyond_their_place(self) -> None:
        rows = """add_rows('RUN', -1, '{0,1,2}', '{0,1,2}', '{"{1e300,1e308}","{NaN,1e308}","{0,NaN}"}')"""
        end = '{"state": "complete", "cause": "", "alarms": [], "rows": 3, "events": 0, "gaps": 0, "files": []}'
        self.assertEqual(self.say(rows, f"finish_run('RUN', '{end}')", began_s=1_800_000_000), "")
        self.everybody_is_answered()
        words = self.store.sql(f"SELECT word FROM gyrotherm.v1_sample WHERE run = '{self.run_id}' AND name = 'state'"
                               " ORDER BY slot", "ada")
        self.assertEqual(words, [[""], [""], ["execute"]])
        self.assertEqual(self.store.sql("SELECT gyrotherm.drop_month('2027-01-01')", "gyrotherm_owner"), [["1"]])

    def test_by_days_that_are_none(self) -> None:
        for due in ("soon", "2026-99-99", "infinity"):
            self.assertIn("ERROR", self.say(due=due), due)
            self.everybody_is_answered()
        self.assertEqual(self.say(due="2027-01-17"), "")

    def test_by_gaps_and_files_of_no_size(self) -> None:
        gaps = """add_gaps('RUN', -1, '[{"first": 0, "last": 2147483647, "cause": ""}]')"""
        self.assertIn("gap_lies_in_a_run", self.say(gaps))
        for size in ('"much"', "1e30", "-1"):
            end = ('{"state": "complete", "cause": "", "alarms": [], "rows": 0, "events": 0, "gaps": 0,'
                   f' "files": [{{"bytes": {size}}}]}}')
            self.assertIn("ERROR", self.say(f"finish_run('RUN', '{end}')"), size)
        self.everybody_is_answered()

    def test_by_results_that_are_no_number(self) -> None:
        for bias in (1e308, -1e308, 1e-300, "NaN", "Infinity"):
            said = self.store.try_sql(self.calibration("R0", bias, "rig-2", ended="2026-03-01"), "rig_2")
            self.assertIn("result_is_a_number", said.stderr, bias)
        said = self.store.try_sql(self.calibration("R0", 0.0, "rig-2", ended="infinity"), "rig_2")
        self.assertIn("calibration_is_of_a_day", said.stderr)
        self.everybody_is_answered()
        self.store.sql(self.calibration("R0", 0.01, ended="2026-04-01"), "rig_1")


class Isolated(unittest.TestCase):
    """A rig that keeps a transaction open holds up no other rig for longer than a minute."""

    INFO = {"started_ns": 1_900_000_000 * 10**9, "profile": "p", "simulated": False, "imported": False, "channels": [],
            "units": [{"label": "u", "serial_number": "S1", "model": "m"}]}

    @classmethod
    def setUpClass(cls) -> None:
        cls.store = cls.enterClassContext(cluster())
        cls.store.migrate()
        cls.store.add_people()
        cls.store.sql("CREATE ROLE rig_3 LOGIN IN ROLE gyrotherm_rig")
        cls.store.sql("GRANT pg_signal_backend, pg_read_all_stats TO gyrotherm_owner")

    def add_run(self, rig: str, **changes: object) -> str:
        return f"SELECT gyrotherm.add_run('{uuid.uuid4()}', '{rig}', '{json.dumps(self.INFO | changes)}');"

    @staticmethod
    def calibration(rig: str, **changes: object) -> str:
        text = json.dumps(CALIBRATION | changes)
        return f"SELECT gyrotherm.add_document('{rig}', 'calibration', 'c', $c${text}$c$);"

    @contextlib.contextmanager
    def open_transaction(self, statements: str):
        """A session of rig_2 that has executed the statements and stays."""
        psql = subprocess.Popen([BIN / "psql", "-X", "-q", self.store.address("rig_2")], stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            psql.stdin.write(f"SET idle_in_transaction_session_timeout = 0;\nBEGIN;\n{statements}\n\\echo ready\n")
            psql.stdin.flush()
            lines = []
            while not lines or "ready" not in lines[-1]:
                lines.append(psql.stdout.readline())
                self.assertNotIn("ERROR", lines[-1])
            yield
        finally:
            psql.kill()
            psql.communicate()

    def test_no_rig_waits_for_an_open_transaction_of_another(self) -> None:
        self.store.sql(self.add_run("rig-1", units=[]) + self.add_run("rig-1"), "rig_1")  # the month is there
        for held in (self.add_run("rig-2", units=[{"label": "u", "serial_number": "S2", "model": "m"}]),
                     self.add_run("rig-2", simulated=True),
                     "SELECT pg_advisory_lock(hashtext('gyrotherm.make_month'));"
                     "SELECT pg_advisory_lock(hashtext('gyrotherm.make_drift'), hashtext('S1 m'));"):
            with self.open_transaction(held):
                # A statement that waits for the lock fails: the store's lock timeout is shorter than the transaction.
                self.store.sql(self.add_run("rig-1", units=[{"label": "u", "serial_number": "S2", "model": "m"}])
                               + self.add_run("rig-1", started_ns=(2_000_000_000 + 3_000_000 * len(held)) * 10**9)
                               + self.calibration("rig-1", number=f"C{len(held)}"), "rig_1")

    def test_an_old_transaction_ends_and_others_go_on(self) -> None:
        for number, held in enumerate((self.add_run("rig-2", started_ns=1_700_000_000 * 10**9),
                                       self.add_run("rig-new", started_ns=1_900_000_000 * 10**9),
                                       self.calibration("rig-2", number="held"))):
            wanted = held.replace("rig-2", "rig-1").replace("1700000000", "1701000000")
            with self.open_transaction(held):
                self.assertIn("lock timeout", self.store.try_sql(wanted, "rig_1").stderr, number)
                # As if the transaction were old already: the store's limit, which is one minute, made short.
                shown = self.store.sql("SELECT pg_get_functiondef('gyrotherm.end_stale'::regproc)")
                text = "\n".join(line[0] for line in shown)
                self.store.sql(text.replace("1 minute", "1 second"), "gyrotherm_owner")
                answer = self.store.try_sql(wanted, "rig_1")
                self.store.sql(text, "gyrotherm_owner")
                self.assertEqual(answer.returncode, 0, answer.stderr)

    def test_a_rig_opens_24_months_a_day(self) -> None:
        months = [1_300_000_000 + 2_679_000 * i for i in range(30)]
        said = [self.store.try_sql(self.add_run("rig-many", started_ns=s * 10**9), "rig_3").stderr for s in months]
        self.assertEqual([("24 months" in one) for one in said].count(False), 24)
        self.assertIn("24 months", said[-1])
        self.store.sql(self.add_run("rig-1", started_ns=1_299_000_000 * 10**9), "rig_1")

    def test_a_document_belongs_to_each_sender(self) -> None:
        text = json.dumps(CALIBRATION | {"number": "C-victim", "item": {"serial_number": "V", "model": "m"}})
        digest = hashlib.sha256(text.encode()).hexdigest()
        for rig, role in (("rig-evil", "rig_2"), ("rig-1", "rig_1")):
            self.assertEqual(self.store.sql(f"SELECT gyrotherm.has_document('{digest}')", role), [["f"]])
            self.store.sql(f"SELECT gyrotherm.add_document('{rig}', 'calibration', 'c', $c${text}$c$)", role)
        there = "SELECT count(*) > 0 FROM gyrotherm.v1_drift WHERE serial_number = 'V'"
        for changes in ({"state": "superseded"}, {"issued": "2020-01-01"}, {"state": "superseded", "issued": "x"[:0]}):
            evil = json.dumps(json.loads(text) | changes)
            self.store.try_sql(f"SELECT gyrotherm.add_document('rig-evil', 'calibration', 'c', $c${evil}$c$)", "rig_2")
            self.assertEqual(self.store.sql(there), [["t"]], changes)
        own = json.dumps(json.loads(text) | {"state": "superseded", "issued": "2026-03-03"})
        self.store.sql(f"SELECT gyrotherm.add_document('rig-1', 'calibration', 'c', $c${own}$c$)", "rig_1")
        self.assertEqual(self.store.sql(there), [["f"]], "its own sender may")


class Retention(unittest.TestCase):
    def test_a_month_goes_and_no_rig_brings_it_back(self) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()
            rig = Rig(store, store.folder / "rig-1")
            day = record(rig.records / "day.db", "tests/profiles/ten-seconds.toml")
            self.assertEqual(rig.once().returncode, 0)
            self.assertEqual(store.sql("SELECT gyrotherm.drop_month('2026-01-15', true)", "gyrotherm_owner"), [["1"]])
            self.assertEqual(store.sql("SELECT count(*) FROM gyrotherm.sample"), [["0"]])
            rows = len(rows_of(day))
            self.assertEqual(store.sql("SELECT count(*) FROM gyrotherm.dropped_2026_01"), [[str(rows)]])
            self.assertEqual(store.sql("SELECT rows, dropped, finished FROM gyrotherm.run"), [[str(rows), "t", "t"]])
            kept = store.sql("SELECT hour, numbers, mean, lowest <= mean, highest >= mean FROM gyrotherm.v1_hour"
                             " WHERE name = 'A'", "ada")
            mean = store.sql("SELECT avg(s.numbers[c.position]) FROM gyrotherm.dropped_2026_01 s"
                             " JOIN gyrotherm.channel c ON c.run = s.run AND c.name = 'A'")[0][0]
            self.assertEqual(kept, [["0", str(rows), mean, "t", "t"]])
            self.assertEqual(rig.once().returncode, 0)
            self.assertEqual(store.sql("SELECT count(*) FROM gyrotherm.sample"), [["0"]])
            record(rig.records / "next.db", "tests/profiles/ten-seconds.toml", seed=2)
            self.assertEqual(rig.once().returncode, 0, "the month has room again")
            self.assertEqual(store.sql("SELECT count(*) FROM gyrotherm.sample"), [[str(rows)]])
            for number in ("2", "3"):
                self.assertEqual(store.sql("SELECT gyrotherm.drop_month('2026-01-15', true) > 0", "gyrotherm_owner"),
                                 [["t"]])
                self.assertEqual(store.sql(f"SELECT count(*) FROM gyrotherm.dropped_2026_01_{number}"), [[str(rows)]])
                record(rig.records / f"next-{number}.db", "tests/profiles/ten-seconds.toml", seed=2 + int(number))
                self.assertEqual(rig.once().returncode, 0)
            self.assertEqual(store.sql("SELECT count(*) FROM gyrotherm.dropped_2026_01"), [[str(rows)]])
            store.sql("UPDATE gyrotherm.run SET finished = false WHERE NOT dropped")
            self.assertIn(
                "not finished", store.try_sql("SELECT gyrotherm.drop_month('2026-01-15')", "gyrotherm_owner").stderr
            )


if __name__ == "__main__":
    unittest.main()
