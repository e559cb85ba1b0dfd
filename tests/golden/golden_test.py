#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads the golden files of earlier releases with the present programs: golden_test.py PROGRAMS.

`make` made each archive with the programs of its release. A test compares the results with those of the release."""

import csv
import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
PROGRAMS = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else Path()
SKIPPED = 77
FINISHED = ("one", "later", "lot", "triad", "imported", "parts")
MODELS = ("linear", "ridge-u", "svr", "gp")


def read_rows(text: str) -> list[list[str]]:
    """Returns the rows of a table without its comments."""
    return list(csv.reader(line for line in text.splitlines() if line and not line.startswith("#")))


class Golden(unittest.TestCase):
    """Has the files of one release, unpacked."""

    archive: Path

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="gyrotherm-golden-")
        with tarfile.open(cls.archive) as packed:
            packed.extractall(cls.temporary.name)
        cls.folder = next(Path(cls.temporary.name).iterdir())

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def run_program(self, *arguments: str, code: int = 0, stdin: str = "") -> str:
        with open(self.folder / stdin if stdin else "/dev/null", encoding="utf-8") as source:
            done = subprocess.run([PROGRAMS / "gyrotherm", *arguments], cwd=self.folder, stdin=source, text=True,
                                  capture_output=True, check=False)
        self.assertEqual(done.returncode, code, f"{' '.join(arguments)}\n{done.stdout}{done.stderr}")
        return done.stdout

    def assert_equal_tables(self, now: str, then: str):
        """Compares two tables column by column. A later version may add columns."""
        now_rows, then_rows = read_rows(now), read_rows(then)
        self.assertEqual(len(now_rows), len(then_rows))
        places = [now_rows[0].index(name) for name in then_rows[0]]
        for row, (after, before) in enumerate(zip(now_rows[1:], then_rows[1:])):
            for place, value in zip(places, before):
                if after[place] == value:
                    continue
                self.assertTrue(after[place] and value, f"row {row}: {after[place]!r}, before {value!r}")
                self.assertAlmostEqual(float(after[place]), float(value), places=9, msg=f"row {row}")

    def test_records_are_verified_and_exported(self):
        for name in FINISHED:
            with self.subTest(name):
                self.run_program("status", f"{name}.db", "--verify")
                self.run_program("export", f"{name}.db", "--out", f"now-{name}.csv")
                self.assert_equal_tables((self.folder / f"now-{name}.csv").read_text(encoding="utf-8"),
                                         (self.folder / f"expected/{name}.csv").read_text(encoding="utf-8"))

    def test_record_has_its_parts(self):
        self.assertEqual(len(list(self.folder.glob("parts*.db"))), 2)
        rows = read_rows((self.folder / "expected/parts.csv").read_text(encoding="utf-8"))
        self.assertGreaterEqual(len(rows), 60)

    def test_killed_run_is_resumed(self):
        for file in self.folder.glob("killed.db*"):
            shutil.copy(file, self.folder / file.name.replace("killed", "resumed"))
        self.run_program("resume", "resumed.db", "--quiet")
        self.run_program("status", "resumed.db", "--verify")
        state = json.loads(self.run_program("status", "resumed.db", "--json"))
        self.assertEqual(state["state"], "complete")

    def test_models_predict_as_before(self):
        for name in MODELS:
            with self.subTest(name):
                compensated = self.run_program("compensate", f"{name}.json", stdin="expected/later.csv")
                before = (self.folder / f"expected/compensated-{name}.txt").read_text(encoding="utf-8")
                self.assertEqual(len(compensated.split()), len(before.split()))
                self.run_program("verify", f"{name}.json", "later.db")
                self.run_program("export-model", f"{name}.json", "--as", "c", "--out", f"{name}.c")

    def test_type_prior_is_used(self):
        self.run_program("train", "one.db", "--prior", "prior.json", "--out", "with-prior.json")
        self.run_program("verify", "with-prior.json", "later.db")

    def make_report(self, folder: str, *records: str):
        self.run_program("report", *records, "--model", "ridge-u.json", "--laboratory", "laboratory.toml", "--order",
                         "order.toml", "--out", folder)

    def test_signed_report_is_verified_and_compared(self):
        self.run_program("report", "verify", "calibration", "--trusted", "authority.pem")
        self.make_report("compared", "later.db", "one.db")
        self.run_program("report", "compare", "calibration", "compared")

    def test_texts_of_a_laboratory_are_read(self):
        self.run_program("check", "./half-hour.toml", "--rig", "./rig.toml")
        self.run_program("import", "logger.csv", "--map", "./logger.toml", "--out", "again.db")
        self.make_report("calibration-now", "one.db", "later.db")

    def test_files_of_running_program_are_read(self):
        shutil.copy(self.folder / "parts.db", self.folder / "seen.db")
        shutil.copy(self.folder / "running-parts.db.status", self.folder / "seen.db.status")
        self.run_program("status", "seen.db")


def make_case(archive: Path) -> type:
    return type(f"Golden_{archive.name.removesuffix('.tar.xz')}", (Golden,), {"archive": archive})


def main() -> int:
    archives = sorted(FOLDER.glob("*.tar.xz"))
    if not archives:
        print("skipped: no release has stored its files; see tests/golden/make")
        return SKIPPED
    suite = unittest.TestSuite(unittest.defaultTestLoader.loadTestsFromTestCase(make_case(archive))
                               for archive in archives)
    return 0 if unittest.TextTestRunner(verbosity=2).run(suite).wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
