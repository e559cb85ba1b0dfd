# SPDX-License-Identifier: Apache-2.0
"""A store that was lost is restored to a point in time from its backup, as docs/site.md has it, and the rig sends the
rest of it again."""
from __future__ import annotations

import pathlib
import shutil
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cluster import Rig, cluster, record, rows_of, run_of, stored_rows, until


class Backup(unittest.TestCase):
    def test_a_store_is_restored_to_a_point_in_time(self) -> None:
        with cluster() as store:
            wal, base = store.folder / "wal", store.folder / "base"
            wal.mkdir()
            if store.as_postgres:
                shutil.chown(wal, "postgres")
            archiving = f"archive_mode = on\narchive_command = 'test ! -f {wal}/%f && cp %p {wal}/%f'\n"
            store.write("postgresql.auto.conf", store.settings + archiving)
            store.write("pg_hba.conf", "local all all trust\nlocal replication all trust\n")
            store.stop()
            store.start()
            store.migrate()
            store.add_people()
            rig = Rig(store, store.folder / "rig-1")
            one = record(rig.records / "one.db", "tests/profiles/ten-seconds.toml", seed=1)
            self.assertEqual(rig.once().returncode, 0)
            where = ["-h", store.folder, "-p", store.port, "-U", "postgres"]
            store.call("pg_basebackup", *where, f"--pgdata={base}", "--checkpoint=fast", "--wal-method=none")
            two = record(rig.records / "two.db", "tests/profiles/short-random.toml", seed=2)
            self.assertEqual(rig.once().returncode, 0)
            everything = store.sql("SELECT md5(string_agg(s::text, '' ORDER BY run, slot)) FROM gyrotherm.sample s")
            then = store.sql("SELECT clock_timestamp()")[0][0]
            three = record(rig.records / "three.db", "tests/profiles/ten-seconds.toml", seed=3)
            self.assertEqual(rig.once().returncode, 0)
            written = store.sql("SELECT pg_walfile_name(pg_switch_wal())")[0][0]
            self.assertTrue(until(lambda: (wal / written).exists()))
            store.kill()
            shutil.rmtree(store.data)
            shutil.move(base, store.data)
            restoring = f"restore_command = 'cp {wal}/%f %p'\nrecovery_target_time = '{then}'\n"
            store.write("postgresql.auto.conf", f"{store.settings}{restoring}recovery_target_action = 'promote'\n")
            store.write("recovery.signal", "")
            store.start()
            self.assertTrue(until(lambda: store.sql("SELECT pg_is_in_recovery()") == [["f"]]))
            restored = store.sql("SELECT md5(string_agg(s::text, '' ORDER BY run, slot)) FROM gyrotherm.sample s")
            self.assertEqual(restored, everything)
            self.assertEqual(store.sql("SELECT count(*) FROM gyrotherm.run"), [["2"]])
            self.assertEqual(rig.once().returncode, 0)
            for path in (one, two, three):
                self.assertEqual(stored_rows(store, run_of(path)), rows_of(path))


if __name__ == "__main__":
    unittest.main()
