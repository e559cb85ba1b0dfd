#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A whole site on one machine, of Debian's packages: PostgreSQL, Prometheus with Alertmanager, Slurm with two
nodes, three rigs whose chambers go sixty times as fast, their publishers, and the live page. One rig's program is
killed: somebody is told. All of it ends in order."""

from __future__ import annotations

import http.server
import json
import os
import pathlib
import shutil
import subprocess
import sys
import threading
import unittest
import urllib.request

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "monitor"))
os.environ["PATH"] += ":/usr/sbin"

import slurm
from cluster import SITE, SKIPPED, SOURCE, Rig, cluster, finished, free_port, rows_of, run_of, stored_rows, until
from programs import Monitor, RealTimeRun

RULES = SOURCE / "apps/monitor/prometheus/gyrotherm.rules.yml"
RIGS = ("rig-1", "rig-2", "rig-3")


class Pager(http.server.BaseHTTPRequestHandler):
    """Whoever Alertmanager tells."""

    told: list[dict] = []

    def do_POST(self) -> None:
        self.told.extend(json.loads(self.rfile.read(int(self.headers["Content-Length"])))["alerts"])
        self.send_response(200)
        self.end_headers()

    def log_message(self, *_) -> None:
        pass


class WholeSite(unittest.TestCase):
    def begin(self, folder: pathlib.Path, *words: object) -> subprocess.Popen:
        with open(folder / f"{pathlib.Path(str(words[0])).name}.log", "ab") as log:
            process = subprocess.Popen(list(map(str, words)), stdout=log, stderr=log, cwd=folder)
        self.addCleanup(process.kill)
        return process

    def begin_alerts(self, folder: pathlib.Path, monitor: Monitor) -> list[subprocess.Popen]:
        pager = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Pager)
        threading.Thread(target=pager.serve_forever, daemon=True).start()
        self.addCleanup(pager.shutdown)
        alerts, metrics, peers = free_port(), free_port(), free_port()
        # The rule of the package, with less patience.
        (folder / "rules.yml").write_text(RULES.read_text().replace("for: 1m", "for: 2s"))
        (folder / "alertmanager.yml").write_text(
            "route: {receiver: pager, group_wait: 1s}\nreceivers:\n- name: pager\n  webhook_configs:\n"
            f"  - url: http://127.0.0.1:{pager.server_port}/\n")
        (folder / "prometheus.yml").write_text(
            "global: {scrape_interval: 1s, evaluation_interval: 1s}\nrule_files: [rules.yml]\n"
            f"alerting: {{alertmanagers: [{{static_configs: [{{targets: ['127.0.0.1:{alerts}']}}]}}]}}\n"
            f"scrape_configs: [{{job_name: gyrotherm, static_configs: [{{targets: ['127.0.0.1:{monitor.port}']}}]}}]\n")
        started = [
            self.begin(folder, "prometheus-alertmanager", "--config.file=alertmanager.yml", "--storage.path=alerts",
                       f"--web.listen-address=127.0.0.1:{alerts}", f"--cluster.listen-address=127.0.0.1:{peers}"),
            self.begin(folder, "prometheus", "--config.file=prometheus.yml", "--storage.tsdb.path=metrics",
                       f"--web.listen-address=127.0.0.1:{metrics}")]
        up = f"http://127.0.0.1:{metrics}/api/v1/query?query=gyrotherm_run_up"

        def sees_runs() -> bool:
            try:
                return len(json.load(urllib.request.urlopen(up))["data"]["result"]) == len(RIGS)
            except OSError:
                return False

        self.assertTrue(until(sees_runs, 60), (folder / "prometheus.log").read_text())
        return started

    def test_a_site(self) -> None:
        with cluster() as store:
            store.migrate()
            store.add_people()
            rigs = [Rig(store, store.folder / name, name, top='name = "hall 4"') for name in RIGS]
            runs = [RealTimeRun(rig.records, name=rig.name, pace="x60") for rig in rigs]
            for run in runs:
                self.addCleanup(run.end)
            for rig in rigs:
                rig.start()
                self.addCleanup(lambda rig=rig: rig.process.kill())
            own = store.folder / "monitor.toml"
            own.write_text(f'schema = "gyrotherm-site/1"\nname = "hall 4"\nrig = "none"\nfolders = ["."]\n\n[store]\n'
                           f'address = "{store.address("ada")}"\n')
            folders = [word for rig in rigs[1:] for word in ("--folder", str(rig.records))]
            monitor = Monitor(store.folder, "--site", str(own), *folders, runs=rigs[0].records)
            self.addCleanup(monitor.kill)
            alerts = self.begin_alerts(store.folder, monitor)

            on = lambda: {rig["rig"] for rig in monitor.ask("/api/v1/site").json["rigs"]
                          if rig["state"] == "execute" and rig["chamber_air_c"] is not None}
            self.assertTrue(until(lambda: on() == set(RIGS), 30), monitor.ask("/api/v1/site").body)
            in_store = monitor.ask("/api/v1/site/rigs")
            self.assertEqual(in_store.status, 200, in_store.body)
            self.assertEqual({row["rig"] for row in in_store.json}, set(RIGS))

            with slurm.SlurmCluster(store.folder / "slurm") as machines:
                small = ["--quick", "--rate-profile", SOURCE / "tests/profiles/short-rate.toml", "--random-profile",
                         SOURCE / "tests/profiles/short-random.toml"]
                lot = rigs[0].records / "lot"
                trained = subprocess.run([SITE, "train", "--rig", "virtual-triad", "--lot", lot, "--by", "slurm", "--",
                                          *small], env=machines.environment, capture_output=True, text=True)
                self.assertEqual(trained.returncode, 0, trained.stderr)
            models = lambda: int(store.sql("SELECT count(*) FROM gyrotherm.document WHERE kind = 'model'")[0][0])
            self.assertTrue(until(lambda: models() == 9, 30), "three of each axis are in the store")

            runs[2].run.kill()  # and its guard makes the chamber safe
            self.assertTrue(until(lambda: any(alert["labels"]["alertname"] == "GyrothermRunDoesNotAnswer"
                                              for alert in Pager.told), 60), Pager.told)

            for run in runs[:2]:
                run.end()
            for rig, run in list(zip(rigs, runs))[:2]:
                self.assertTrue(until(lambda: finished(store, run_of(run.record)), 30), rig.log.read_text())
                self.assertEqual(stored_rows(store, run_of(run.record)), rows_of(run.record))
            for rig in rigs:
                self.assertEqual(rig.stop(), 0, rig.log.read_text())
            states = lambda: {rig["rig"]: rig["state"] for rig in monitor.ask("/api/v1/site").json["rigs"]}
            self.assertTrue(until(lambda: states() == {"rig-1": "idle", "rig-2": "idle", "rig-3": "silent"}, 90), states())
            for process in alerts:
                process.terminate()
                self.assertEqual(process.wait(20), 0)
            self.assertEqual(monitor.stop(), 0)


if __name__ == "__main__":
    needed = ["prometheus", "prometheus-alertmanager", *slurm.PROGRAMS]
    if missing := [program for program in needed if not shutil.which(program)]:
        print(f"skipped: {', '.join(missing)} is not installed")
        sys.exit(SKIPPED)
    unittest.main(verbosity=2)
