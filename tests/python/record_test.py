# SPDX-License-Identifier: Apache-2.0
"""A record in pandas and xarray has the values that the program reports."""

import hashlib
import json
import os
import shutil
import sqlite3
import time
import unittest
from pathlib import Path

from program import SOURCE, FolderTest, gyrotherm, record, start

import numpy as np
import pandas as pd

import gyrotherm as module
from gyrotherm import chain


def exported(path, out):
    """Returns the result of `export` for a record."""
    gyrotherm("export", path, "--out", out, "--unverified")
    return pd.read_csv(out, comment="#", float_precision="round_trip")


class Record(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.path = record(cls.folder / "run.db")
        cls.run_ = module.open(cls.path)

    def test_has_the_values_of_export(self):
        frame, table = self.run_.to_pandas(calibrated=False), exported(self.path, self.folder / "run.csv")
        self.assertEqual(len(frame), len(table))
        for title, name in (("A [°C]", "A"), ("shell [°C]", "shell"), ("set point [°C]", "set_point_c"),
                            ("chamber air [°C]", "chamber_air_c"),
                            ("gyro [pulses of 0.1 arcsec]", "pulses"), ("gyro interval [s]", "interval_s"),
                            ("true bias [°/h]", "true_bias_deg_per_h"), ("phase", "phase")):
            np.testing.assert_array_equal(table[title].to_numpy(), frame[name].to_numpy(), err_msg=title)

    def test_states_units_axes_and_simulation(self):
        dataset = self.run_.to_xarray()
        self.assertIn("SIMULATED", dataset.attrs["source"])
        self.assertIn("SIMULATED", repr(self.run_))
        self.assertEqual(dataset["A"].attrs["units"], "degC")
        self.assertEqual(dataset["bias_deg_per_h"].attrs["bias_zero"], "earth rate removed")
        self.assertEqual(self.run_.to_pandas().attrs["columns"]["bias_deg_per_h"]["units"], "degree/hour")
        self.assertEqual([axis.label for axis in self.run_.axes], ["gyro"])
        self.assertEqual(str(dataset["utc"].values[0]), "2026-01-01T00:00:01.000000000")
        self.assertEqual(self.run_.segments["seconds"].sum(), len(dataset["time_s"]))
        self.assertEqual(self.run_.events["kind"].iloc[0], "started")

    def test_bias_is_rate_over_exact_interval_minus_earth_rate(self):
        axis, frame = self.run_.axes[0], self.run_.to_pandas()
        expected = axis.scale * frame["pulses"] / frame["interval_s"] - axis.earth_rate_deg_per_h
        np.testing.assert_array_equal(frame["bias_deg_per_h"], expected)
        self.assertLess(abs((frame["bias_deg_per_h"] - frame["true_bias_deg_per_h"]).mean()), 0.01)

    def test_reading_changes_nothing(self):
        before = self.files()
        module.open(self.path).to_pandas()
        self.assertEqual(self.files(), before)

    def test_refuses_files_that_are_not_records(self):
        (self.folder / "text.db").write_text("no record " * 100)
        sqlite3.connect(self.folder / "other.db").execute("CREATE TABLE a(b)").connection.close()
        for name, why in (("none.db", "No such file"), ("text.db", "not a database"), ("other.db", "not a gyrotherm"),
                          (".", "not a regular file")):
            with self.assertRaisesRegex(module.RecordError, why):
                module.open(self.folder / name)
        shutil.copy(self.path, self.folder / "journal.db")
        (self.folder / "journal.db-journal").write_bytes(b"")
        with self.assertRaisesRegex(module.RecordError, "journal"):
            module.open(self.folder / "journal.db")

    def test_calibration_is_applied(self):
        copy = self.folder / "calibrated.db"
        shutil.copy(self.path, copy)
        database = sqlite3.connect(copy)
        database.execute("UPDATE channel SET offset_k = 0.25 WHERE name = 'A'")
        database.execute("UPDATE channel SET polynomial = '0.5,1.01,-0.0001' WHERE name = 'B'")
        database.commit()
        database.close()
        run = module.open(copy)
        raw, frame = run.to_pandas(calibrated=False), run.to_pandas()
        np.testing.assert_array_equal(frame["A"], raw["A"] + 0.25)
        np.testing.assert_allclose(frame["B"], 0.5 + 1.01 * raw["B"] - 0.0001 * raw["B"] ** 2, rtol=1e-15)
        self.assertEqual(run.to_xarray()["A"].attrs["calibration"], "applied")

    def test_run_starts_at_first_second(self):
        copy = self.folder / "real.db"
        shutil.copy(self.path, copy)
        described = module.open(copy).info.started_utc_ns
        for simulated, late in ((1, 0), (0, 5_300_000_000)):
            database = sqlite3.connect(copy)
            database.execute("UPDATE meta SET value = ? WHERE key = 'simulated'", (simulated,))
            database.execute("UPDATE sample SET utc_ns = monotonic_ns + ?", (described + 5_300_000_000,))
            database.commit()
            database.close()
            run = module.open(copy)
            self.assertEqual(run.info.started_utc_ns, described + late)
            self.assertEqual(str(run.to_pandas()["utc"].iloc[0]), "2026-01-01 00:00:06.300000+00:00")

    def test_run_on_virtual_instruments_of_a_real_rig_is_marked(self):
        copy = self.folder / "served.db"
        shutil.copy(self.path, copy)
        database = sqlite3.connect(copy)
        database.execute("UPDATE meta SET value = 0 WHERE key = 'simulated'")
        database.commit()
        run = module.open(copy)
        self.assertFalse(run.info.simulated)
        self.assertEqual(run.to_xarray().attrs["source"], "measured")
        for position, name in enumerate(("chamber", "thermometer 2")):
            database.execute("INSERT INTO list(name, of, value, position) VALUES('virtual_instruments', '', ?, ?)",
                             (name, position))
        database.commit()
        database.close()
        run = module.open(copy)
        self.assertTrue(run.info.simulated)
        self.assertEqual(run.info.virtual_instruments, ("chamber", "thermometer 2"))
        self.assertIn("SIMULATED", repr(run))
        self.assertEqual(run.to_xarray().attrs["source"],
                         "SIMULATED: these instruments were virtual: chamber, thermometer 2")

    def test_faults_and_gaps_are_nan(self):
        copy = self.folder / "gaps.db"
        shutil.copy(self.path, copy)
        database = sqlite3.connect(copy)
        database.execute("DELETE FROM sample WHERE slot BETWEEN 1000 AND 1009")
        database.execute("INSERT INTO gap VALUES(1000, 1009, 'tested', 0)")
        database.execute("UPDATE sample SET C = NULL, pulses = NULL, interval_ns = NULL WHERE slot = 1500")
        database.commit()
        database.close()
        run = module.open(copy)
        frame, table = run.to_pandas(), exported(copy, self.folder / "gaps.csv")
        self.assertEqual(len(frame), len(table) + 10)
        self.assertTrue(frame.loc[1000:1009, ["A", "bias_deg_per_h"]].isna().all(axis=None))
        self.assertTrue((frame.loc[1000:1009, "segment"] == -1).all())
        self.assertTrue(frame.loc[1500, ["C", "bias_deg_per_h"]].isna().all())
        self.assertEqual(run.gaps.to_numpy().tolist(), [[1000, 1009, "tested"]])
        clusters = run.clusters()
        self.assertEqual(len(clusters), 94)
        self.assertFalse({1000.0, 1500.0} & set(clusters.start_s))
        rates = dict(zip(clusters.start_s, clusters.rate_c_per_min[:, 0]))
        self.assertTrue(np.isnan(rates[1100.0]) and np.isfinite(rates[1200.0]))


class Turned(FolderTest):
    def test_earth_rate_changes_sign_after_turn(self):
        text = (SOURCE / "profiles/two-position.toml").read_text(encoding="utf-8")
        profile = self.folder / "turned.toml"
        profile.write_text(text.replace('"6 h"', '"40 min"').replace('"2 h"', '"20 min"'), encoding="utf-8")
        path = record(self.folder / "two.db", profile=profile)
        frame = module.open(path).to_pandas()
        self.assertLess(frame["bias_deg_per_h"].abs().max(), 2)  # the Earth rate, 10.6 °/h, is removed on both sides
        model, out = self.folder / "two.json", self.folder / "two.csv"
        ramp = record(self.folder / "ramp.db")  # the temperature of the other record does not vary
        gyrotherm("train", ramp, "--method", "linear", "--inputs", "A", "--out", model)
        gyrotherm("export", path, "--compensated", "--model", model, "--out", out)
        table = pd.read_csv(out, comment="#", float_precision="round_trip")
        np.testing.assert_array_equal(table["bias [°/h]"], frame["bias_deg_per_h"].to_numpy())


class UnknownEarthRate(FolderTest):
    def test_removes_mean_of_first_hold(self):
        path = record(self.folder / "run.db")
        database = sqlite3.connect(path)
        database.execute("UPDATE axis SET earth_rate_deg_per_h = NULL")
        database.commit()
        database.close()
        axis = module.open(path).axis()
        self.assertEqual(axis.bias_zero, "mean of the first hold removed")
        self.assertLess(abs(axis.bias_deg_per_h[:1200].mean()), 1e-12)


class Lot(FolderTest):
    def test_requires_name_of_axis(self):
        run = module.open(record(self.folder / "run.db", rig="virtual-tetrad"))
        labels = [axis.label for axis in run.axes]
        self.assertEqual(len(labels), 4)
        with self.assertRaisesRegex(module.RecordError, "choose one with unit= and axis="):
            run.clusters()
        for label in labels:
            self.assertEqual(run.clusters(label).label, label)
            self.assertEqual(run.to_xarray()[f"{label}.bias_deg_per_h"].attrs["input_axis"], label)


def wait_until(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"condition not met within {seconds:g} s")
        time.sleep(0.01)


class Running(FolderTest):
    """A run that is read while it is written, and after it was killed."""

    def begin(self, name):
        path, printed = self.folder / name, self.folder / f"{name}.json"
        process = start("run", "profiles/qualification.toml", "--rig", "profiles/rigs/virtual.toml", "--out", path,
                        "--json", out=printed)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        wait_until(lambda: "acknowledged" in printed.read_text())
        return path, process

    def test_ignores_files_named_like_parts(self):
        path = record(self.folder / "alone.db")
        beside = self.folder / "alone.2.db"
        for content in (b"", b"no record", None):
            if content is None:
                beside.unlink()
                beside.mkdir()
            else:
                beside.write_bytes(content)
            self.assertEqual(len(module.open(path).to_pandas()), 9600, content)
        beside.rmdir()

    def test_accepts_any_file_name(self):
        path = Path(os.fsdecode(os.fsencode(self.folder) + b"/r\xe9 %?.db"))
        self.assertEqual(len(module.open(record(path)).to_pandas()), 9600)

    def test_refuses_active_run_and_reads_killed_run(self):
        path, process = self.begin("killed.db")
        with self.assertRaisesRegex(module.BeingWritten, "is being written by another program"):
            module.open(path)
        with self.assertRaises(module.BeingWritten):
            next(module.follow(path, sleep=lambda seconds: None))
        process.kill()
        process.wait()
        before = self.files()
        run = module.open(path)
        self.assertFalse(run.finished)
        self.assertGreater(len(run.to_pandas()), 10)
        self.assertEqual(self.files(), before)
        with self.assertRaisesRegex(module.RecordError, "has not finished"):
            run.clusters()
        np.testing.assert_array_equal(exported(path, self.folder / "killed.csv")["A [°C]"],
                                      run.to_pandas(calibrated=False)["A"].to_numpy())


class SelfEnding(FolderTest):
    """A record whose decisions have added segments."""

    def test_has_added_segments_and_detects_their_edits(self):
        path = self.folder / "until.db"
        gyrotherm("run", SOURCE / "tests/profiles/short-until.toml", "--rig", "virtual-supply", "--until-u", "1000",
                  "--out", path)
        run = module.open(path)
        self.assertEqual(list(run.segments["name"]), ["hold 20 °C", "ramp to 40 °C", "hold 40 °C", "ramp to 20 °C"])
        self.assertEqual(run.segments["seconds"].iloc[3], 600)
        edits = ("UPDATE segment SET target_c = 21 WHERE position = 3", "DELETE FROM segment WHERE position = 3",
                 "UPDATE segment SET position = 4 WHERE position = 3", "UPDATE event SET segment = 2 WHERE reaction = 'ends'")
        for number, edit in enumerate(edits):
            copy = self.folder / f"edited-{number}.db"
            shutil.copy(path, copy)
            database = sqlite3.connect(copy)
            self.assertTrue(chain.is_intact(database))
            database.execute(edit)
            self.assertFalse(chain.is_intact(database), edit)
            database.close()


class Parts(FolderTest):
    """A record in two files, as after a disk error. The tests split the record of an undisturbed run."""

    def split_record(self, whole, name, clock_step_ns=0):
        """Splits a record. `clock_step_ns` is a step of the wall clock at the beginning of the second file."""
        first, second = self.folder / f"{name}.db", self.folder / f"{name}.2.db"
        shutil.copy(whole, first)
        shutil.copy(whole, second)
        database = sqlite3.connect(first)
        database.execute("DELETE FROM sample WHERE slot >= 5000")
        database.execute("DELETE FROM event WHERE slot >= 5000")
        database.execute("DELETE FROM meta WHERE key IN ('outcome', 'chain_end')")
        head = chain.rows_head(database, chain.description_head(database))
        database.execute("UPDATE frames SET head = ?", (head.hex(),))
        database.commit()
        database.close()
        database = sqlite3.connect(second)
        database.execute("DELETE FROM sample WHERE slot < 4900")
        database.execute("DELETE FROM event WHERE slot < 4900")
        database.execute("UPDATE sample SET utc_ns = utc_ns + ?", (clock_step_ns,))
        database.executemany("INSERT INTO meta VALUES(?, ?)", [("part", 2), ("continues", first.name),
                                                               ("continues_from", 4900), ("continues_cause", "tested")])
        database.commit()
        database.close()
        return first

    def test_report_names_each_file(self):
        path = self.split_record(record(self.folder / "whole.db"), "reported")
        gyrotherm("report", path, "--unverified", "--out", self.folder / "report")
        files = json.loads((self.folder / "report" / "calibration.json").read_text())["files"]
        self.assertEqual([(file["role"], file["name"], file["sha256"]) for file in files[:2]],
                         [(role, name, hashlib.sha256((self.folder / name).read_bytes()).hexdigest())
                          for role, name in (("record", "reported.db"), ("record_part", "reported.2.db"))])

    @staticmethod
    def rebuild_chain(database):
        head = chain.description_head(database)
        database.execute("UPDATE meta SET value = ? WHERE key = 'chain_start'", (head.hex(),))
        for table, row in list(chain.rows_in_order(database)):
            head = chain.next_head(head, table, row[:-1])
            key = {"sample": "slot", "gap": "first"}.get(table, "id")
            database.execute(f"UPDATE {table} SET chain = ? WHERE {key} = ?",
                             (int.from_bytes(head[:8], "little", signed=True), row[0]))

    def test_gaps_of_import_are_those_that_it_counted(self):
        for every, expected in (("", [[5, 44], [61, 95.5]]), ('every = "2 s"\n', [[4, 44], [60, 94]])):
            name = "grouped" if every else "plain"
            map_file, table, path = (self.folder / f"{name}.{end}" for end in ("toml", "csv", "db"))
            map_file.write_text('schema = "gyrotherm-import/1"\nname = "m"\n[time]\ncolumn = "t"\nunit = "s"\n' + every
                                + '[[thermometer]]\nname = "die"\ncolumn = "T"\n[gyro]\ncolumn = "w"\nkind = "rate"\n'
                                + "scale = 1\n")
            times = [*range(6), *range(44, 62), 95.5, 96.5]
            table.write_text("t,T,w\n" + "".join(f"{t},{20 + t / 100},{t % 3}\n" for t in times))
            said = gyrotherm("import", table, "--map", map_file, "--out", path)
            run = module.open(path)
            self.assertEqual(len(run.gaps), len(expected), said)
            np.testing.assert_allclose(run.gaps[["first", "last"]], expected)
            self.assertTrue(run.gaps["cause"].str.startswith("no row for ").all())

    def test_each_second_has_own_wall_time(self):
        whole = record(self.folder / "virtual.db")
        database = sqlite3.connect(whole)
        database.execute("UPDATE meta SET value = 0 WHERE key = 'simulated'")
        self.rebuild_chain(database)
        database.commit()
        database.close()
        run = module.open(self.split_record(whole, "set", clock_step_ns=10_000_000_000))
        self.assertTrue(run.gaps.empty)
        expected = module.open(whole).to_pandas()["utc"] + pd.to_timedelta(10 * (np.arange(9600) >= 4900), unit="s")
        np.testing.assert_array_equal(run.to_pandas()["utc"], expected)

    def test_second_file_replaces_rows_from_its_first_slot(self):
        whole = record(self.folder / "whole.db")
        first = self.split_record(whole, "run")
        run = module.open(first)
        self.assertTrue(run.finished)
        self.assertTrue(run.gaps.empty)
        pd.testing.assert_frame_equal(run.to_pandas(), module.open(whole).to_pandas())
        pd.testing.assert_frame_equal(run.events, module.open(whole).events)
        self.assertEqual(len(exported(first, self.folder / "run.csv")), 9600)  # the program sees the same chain
        database = sqlite3.connect(first)
        database.execute("UPDATE sample SET A = A + 1 WHERE slot = 77")
        database.commit()
        database.close()
        self.assertEqual(len(exported(first, self.folder / "changed.csv")), 9600 - 4900)
        self.assertEqual(module.open(first).gaps.to_numpy().tolist(), [[0, 4899, "lost with run.db: tested"]])
        first.write_text("damaged")
        run = module.open(first)
        self.assertEqual(run.gaps.to_numpy().tolist(), [[0, 4899, "lost with run.db: tested"]])
        self.assertTrue(run.to_pandas()["A"].iloc[:4900].isna().all())
        self.assertEqual(len(run.to_pandas()), 9600)

    def test_missing_middle_file_is_gap(self):
        first = self.split_record(record(self.folder / "long.db"), "hole")
        third = (self.folder / "hole.2.db").rename(self.folder / "hole.3.db")
        database = sqlite3.connect(third)
        database.executemany("UPDATE meta SET value = ? WHERE key = ?",
                             [(3, "part"), ("hole.2.db", "continues"), (6000, "continues_from")])
        database.execute("DELETE FROM sample WHERE slot < 6000")
        database.execute("DELETE FROM event WHERE slot < 6000")
        database.commit()
        database.close()
        self.assertEqual(module.open(first).gaps.to_numpy().tolist(), [[5000, 5999, "lost with hole.2.db: tested"]])
        self.assertEqual(len(exported(first, self.folder / "hole.csv")), 9600 - 1000)

    def test_ignores_other_record_with_name_of_part(self):
        path = record(self.folder / "soak.db")
        other = record(self.folder / "soak.2.db")
        Path(f"{other}.status").write_text('{"id": "another"}', encoding="utf-8")
        writer = sqlite3.connect(other, isolation_level=None)
        writer.execute("BEGIN EXCLUSIVE")
        self.assertEqual(len(module.open(path).to_pandas()), 9600)
        writer.close()


if __name__ == "__main__":
    assert SOURCE.exists()
    unittest.main()
