# SPDX-License-Identifier: Apache-2.0
"""Follows a run through its live copy: a link to an SQLite file in write-ahead mode that another connection writes."""

import shutil
import sqlite3
import unittest
from unittest import mock

from program import FolderTest, record

import pandas as pd

import gyrotherm as module
from gyrotherm import live
from gyrotherm.database import live_path, open_database
from gyrotherm.errors import RecordError


OTHER_RUN_ID = "f" * 32


def assign_other_run(path, connection=None):
    """Changes the run ID in a file, through the given connection or a new one."""
    writer = connection or sqlite3.connect(path, isolation_level=None)
    writer.execute("UPDATE meta SET value = ? WHERE key = 'id'", (OTHER_RUN_ID,))
    if connection is None:
        writer.close()


class Follow(FolderTest):
    def setUp(self):
        whole = self.folder / "whole.db"
        if not whole.exists():
            record(whole)
        self.whole = module.open(whole)
        self.path, self.live = self.folder / "run.db", self.folder / "run.live.db"
        shutil.copy(whole, self.folder / "run.live.db.1")
        self.live.symlink_to("run.live.db.1")
        self.writer = sqlite3.connect(self.live, isolation_level=None)
        self.writer.execute("PRAGMA journal_mode = WAL")
        self.writer.execute("ATTACH ? AS whole", (str(whole),))
        for table in ("sample", "event"):
            self.writer.execute(f"DELETE FROM main.{table} WHERE slot >= 3000")
        self.writer.execute("DELETE FROM main.meta WHERE key = 'outcome'")

    def tearDown(self):
        self.writer.close()
        for path in self.folder.glob("run*"):
            path.unlink()

    def advance(self, first, last):
        for table in ("sample", "event"):
            self.writer.execute(f"INSERT INTO main.{table} SELECT * FROM whole.{table} WHERE slot BETWEEN ? AND ?",
                                (first, last))

    def close(self):
        """Closes the record and removes its live copy, as at the end of a run."""
        shutil.copy(self.folder / "whole.db", self.path)
        self.writer.close()
        for path in self.folder.glob("run.live*"):
            path.unlink()

    def test_yields_each_second_once(self):
        steps = [lambda: self.advance(3000, 3099), lambda: None, lambda: self.advance(3100, 3100), self.close]
        pieces = list(module.follow(self.path, sleep=lambda seconds: steps.pop(0)()))
        self.assertEqual([len(piece) for piece in pieces], [3000, 100, 1, 6499])
        pd.testing.assert_frame_equal(pd.concat(pieces), self.whole.to_pandas(), check_categorical=False)

    def test_ends_when_writer_died(self):
        steps = [lambda: shutil.copy(self.folder / "whole.db", self.path)]
        pieces = list(module.follow(self.path, sleep=lambda seconds: steps.pop(0)()))
        self.assertEqual([len(piece) for piece in pieces], [3000, 6600])

    def test_opens_live_copy_without_change(self):
        before = {p.name for p in self.folder.iterdir()}
        self.assertEqual(len(module.open(self.live).to_pandas()), 3000)
        self.assertEqual({p.name for p in self.folder.iterdir()}, before)

    def test_follows_link_to_record(self):
        link = self.folder / "run_of_today.db"
        link.symlink_to("run.db")
        steps = [lambda: self.advance(3000, 3099), self.close]
        pieces = list(module.follow(link, sleep=lambda seconds: steps.pop(0)()))
        self.assertEqual([len(piece) for piece in pieces], [3000, 100, 6500])
        self.assertEqual(module.open(link).path, self.path.resolve())

    def test_continues_in_next_file(self):
        part = self.folder / "run.2.db"
        shutil.copy(self.folder / "whole.db", self.path)
        shutil.copy(self.folder / "whole.db", part)
        writer = sqlite3.connect(part, isolation_level=None)
        writer.execute("BEGIN EXCLUSIVE")
        steps = [lambda: None, lambda: self.advance(3000, 3099), writer.close]
        pieces = list(module.follow(self.path, sleep=lambda seconds: steps.pop(0)()))
        self.assertEqual([len(piece) for piece in pieces], [3000, 100, 6500])

    def test_reopens_restarted_live_copy(self):
        steps = [lambda: None, self.close]
        looks = [RecordError("run.live.db: No such file or directory"), None]
        with mock.patch.object(live, "open_database", side_effect=lambda path: self.look(looks, path)):
            pieces = list(module.follow(self.path, sleep=lambda seconds: steps.pop(0)()))
        self.assertEqual([len(piece) for piece in pieces], [3000, 6600])

    def look(self, looks, path):
        if looks and (trouble := looks.pop(0)) is not None:
            raise trouble
        return open_database(path)

    def test_follows_path_of_live_copy(self):
        steps = [lambda: self.advance(3000, 3099), self.close]
        pieces = list(module.follow(self.live, sleep=lambda seconds: steps.pop(0)()))
        self.assertEqual([len(piece) for piece in pieces], [3000, 100, 6500])

    def test_ignores_live_copy_of_another_run(self):
        shutil.copy(self.folder / "whole.db", self.path)
        assign_other_run(self.path)
        pieces = list(module.follow(self.path))
        self.assertEqual([len(piece) for piece in pieces], [9600])

    def test_ignores_live_copy_of_another_run_while_writing(self):
        shutil.copy(self.folder / "whole.db", self.path)
        (self.folder / "run.db.status").write_text('{"id": "%s"}' % OTHER_RUN_ID, encoding="utf-8")
        writer = sqlite3.connect(self.path, isolation_level=None)
        writer.execute("BEGIN EXCLUSIVE")
        with self.assertRaises(module.BeingWritten):
            list(module.follow(self.path, sleep=lambda seconds: None))
        writer.close()

    def test_ends_when_another_run_replaces_copy(self):
        seconds = module.follow(self.path, sleep=lambda seconds: assign_other_run(self.live, self.writer))
        self.assertEqual(len(next(seconds)), 3000)
        with self.assertRaises(RecordError):
            next(seconds)

    def test_ends_when_another_run_replaces_record(self):
        def replace(seconds):
            shutil.copy(self.folder / "whole.db", self.path)
            assign_other_run(self.path)

        seconds = module.follow(self.path, sleep=replace)
        self.assertEqual(len(next(seconds)), 3000)
        with self.assertRaises(RecordError):
            next(seconds)

    def test_uses_name_of_program(self):
        for record_name, copy in (("a.db", "a.live.db"), ("a.sqlite", "a.sqlite.live.db"), ("a", "a.live.db")):
            self.assertEqual(live_path(record_name).name, copy)

    def test_yields_closed_record_completely(self):
        self.close()
        pieces = list(module.follow(self.path))
        self.assertEqual([len(piece) for piece in pieces], [9600])


if __name__ == "__main__":
    unittest.main()
