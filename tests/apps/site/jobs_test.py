#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Work that is spread over machines ends as it does on one: byte by byte, whoever dies on the way.

    jobs_test.py CASE…"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).parent))

from slurm import SlurmCluster, missing

SITE, GYROTHERM = os.environ["GYROTHERM_SITE"], os.environ["GYROTHERM_PROGRAM"]
PROFILES = Path(os.environ["GYROTHERM_SOURCE"]) / "tests/profiles"
SMALL = ["--quick", "--rate-profile", str(PROFILES / "short-rate.toml"), "--random-profile",
         str(PROFILES / "short-random.toml")]
SKIPPED = 77
VARYING = {"timings.json", "digests.json"}


def contents(folder: Path) -> dict[str, str]:
    """Of all that is the result, a digest by name."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*"))
            if path.is_file() and path.name not in VARYING and "job" not in path.relative_to(folder).parts}


def tasks_at_work(folder: Path) -> list[int]:
    """Commands of tasks: programs that stand in the folder and train."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            if os.readlink(process / "cwd") == str(folder) and b"--only" in words:
                found.append(int(process.name))
        except OSError:
            continue
    return found


class Spread(unittest.TestCase):
    environment = dict(os.environ)

    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="gyrotherm-jobs-")).resolve()
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def run_in(self, where: str, *command: str, expect: int = 0) -> subprocess.CompletedProcess:
        (self.folder / where).mkdir(exist_ok=True)
        ran = subprocess.run(command, cwd=self.folder / where, env=self.environment, capture_output=True, text=True)
        self.assertEqual(ran.returncode, expect, ran.stderr)
        return ran

    def begin(self, where: str, *command: str) -> subprocess.Popen:
        return subprocess.Popen(command, cwd=self.folder / where, env=self.environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def records(self, rig: str, words: list[str]) -> None:
        """In alone/lot, and in spread/lot."""
        self.run_in("alone", GYROTHERM, "qualify", "--rig", rig, "--out", "lot", "--records-only", *words)
        shutil.copytree(self.folder / "alone", self.folder / "spread")

    def alone(self, rig: str, words: list[str]) -> float:
        """The lot as one machine leaves it, in alone/lot; another folder has its records. How long training took."""
        self.records(rig, words)
        began = time.monotonic()
        self.run_in("alone", GYROTHERM, "qualify", "--rig", rig, "--out", "lot", *words)
        return time.monotonic() - began

    def expect_the_same(self) -> None:
        alone, spread = contents(self.folder / "alone/lot"), contents(self.folder / "spread/lot")
        self.assertEqual(alone.keys(), spread.keys())
        self.assertEqual([name for name in alone if alone[name] != spread[name]], [])


@unittest.skipUnless(shutil.which("parallel"), "parallel is not installed")
class ByParallel(Spread):
    def test_a_command_that_there_is_not_is_named(self) -> None:
        for word, said in (("rigz", 'Did you mean "rigs"?'), ("calibrate-all", "is not one of the commands")):
            self.assertIn(said, self.run_in("here", SITE, word, expect=2).stderr)
        ran = self.run_in("here", SITE, "rigs", "--stoer", "host=none", expect=2)
        self.assertIn("--stoer is not an option of rigs. Did you mean --store?", ran.stderr)
        ran = self.run_in("here", SITE, "rigs", "--store", "host=none", "--most", "0x10", expect=2)
        self.assertIn('--most: "0x10" is not an accepted number', ran.stderr)

    def test_no_seed_and_too_many_are_refused(self) -> None:
        for first, last in (("5", "2"), ("0", "100000"), ("1", str(2**64 - 1))):
            ran = self.run_in("here", SITE, "seeds", "none.db", "--out", "seeds", "--first", first, "--last", last,
                              expect=2)
            self.assertIn(f"{first} to {last}, expected 1 to 100000 seeds", ran.stderr)
        self.assertFalse((self.folder / "here/seeds").exists())

    def test_a_record_that_cannot_be_read_is_refused_at_once(self) -> None:
        (self.folder / "model.json").write_text("{}")
        for command in (["seeds", "none.db"], ["seeds", "../model.json"], ["placement", "none.db"],
                        ["leave-one-out", "a.db", "b.db", "c.db", "d.db"]):
            self.run_in("here", SITE, *command, "--out", "results", "--by", "parallel", expect=4)
            self.assertFalse((self.folder / "here/results").exists(), command)

    def test_a_lot_is_the_same_whatever_died(self) -> None:
        self.alone("virtual-triad", SMALL)
        command = [SITE, "train", "--rig", "virtual-triad", "--lot", "lot", "--by", "parallel", "--", *SMALL]
        training = self.begin("spread", *command)
        while not (at_work := tasks_at_work(self.folder / "spread")):
            self.assertIsNone(training.poll())
            time.sleep(0.01)
        os.kill(at_work[0], signal.SIGKILL)
        out, said = training.communicate()
        self.assertEqual(training.returncode, 0, said)
        self.assertIn("3 of 3 tasks done", said)
        self.assertTrue(out.startswith("SIMULATED"), out)
        self.expect_the_same()
        again = self.run_in("spread", *command)
        self.assertNotIn("tasks done", again.stderr, "there is nothing to do")
        full = subprocess.run(f"'{SITE}' job lot/job > /dev/full", shell=True, cwd=self.folder / "spread",
                              capture_output=True, text=True)
        self.assertEqual((full.returncode, full.stderr), (4, "gyrotherm-site: stdout: cannot be written\n"))
        told = self.run_in("spread", SITE, "job", "lot/job").stdout.splitlines()
        self.assertEqual([line.split()[:2] for line in told], [[axis, "done"] for axis in "xyz"])

    def test_seeds_are_trained_and_verified_and_a_failure_is_named(self) -> None:
        self.records("virtual-triad", SMALL)
        words = ["--quick", "--inputs", "multi-point", "--unit", "x"]
        self.run_in("spread", SITE, "seeds", "lot/ramp.db", "--verify", "lot/random.db", "--last", "2", "--out",
                    "seeds", "--by", "parallel", "--", *words)
        for seed in (1, 2):
            folder = self.folder / f"spread/seeds/seed-{seed}"
            self.assertIn("compensated", json.loads((folder / "verify.json").read_text()))
            self.run_in("alone", GYROTHERM, "train", "lot/ramp.db", *words, "--seed", str(seed), "--out",
                        f"{seed}.json")
            self.assertEqual((folder / "model.json").read_bytes(), (self.folder / f"alone/{seed}.json").read_bytes())
        failed = self.run_in("spread", SITE, "placement", "lot/ramp.db", "--out", "placement", "--by", "parallel", "--",
                             "--folds", "nonsense", expect=2)
        self.assertIn("3 of 3 tasks failed: x (exit code 2)", failed.stderr)
        self.assertIn("nonsense", (self.folder / "spread/placement/job/tasks/x.log").read_text())
        other = self.run_in("spread", SITE, "placement", "lot/random.db", "--out", "placement", "--by", "parallel",
                            expect=2)
        self.assertIn("contains another job", other.stderr)


class WithoutSlurm(Spread):
    """What Slurm is told: an sbatch that notes it, and a squeue that has what the test says."""

    def setUp(self) -> None:
        super().setUp()
        self.told, self.queue = self.folder / "told", self.folder / "queue"
        programs = self.folder / "programs"
        programs.mkdir()
        for name, does in (("sbatch", f'echo "$*" >> {self.told}; echo "$((100 + $(wc -l < {self.told})));lab"'),
                           ("squeue", f'echo "$*" > {self.queue}.asked; cat {self.queue}')):
            (programs / name).write_text(f"#!/bin/sh\necho '{name}: warning: a word to people' >&2\n{does}\n")
            (programs / name).chmod(0o755)
        self.environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
        self.queue.write_text("")

    def arrays(self) -> list[str]:
        return self.told.read_text().splitlines()

    def test_an_array_that_is_at_it_is_waited_for(self) -> None:
        self.run_in("spread", GYROTHERM, "run", str(PROFILES / "short-rate.toml"), "--rig", "virtual", "--out",
                    "ramp.db", "--quiet")
        self.run_in("spread", SITE, "seeds", "ramp.db", "--last", "3", "--out", "100 % of seeds", "--by", "slurm",
                    "--detach")
        self.assertEqual(len(self.arrays()), 1)
        job = self.folder / "spread/100 % of seeds/job"
        self.assertIn(f"--array=0-2 --output={job.parent.parent}/100 %% of seeds/job/slurm.log", self.arrays()[0])
        self.queue.write_text("7\n101\n101\n")
        waiting = self.begin("spread", SITE, "job", str(job), "--wait", "--by", "slurm")
        time.sleep(4)
        self.assertEqual(len(self.arrays()), 1, "some of them are still queued")
        self.assertIn("%F", (self.folder / "queue.asked").read_text(), "elements have numbers of their own")
        self.queue.write_text("1012\n")  # another one, whose number begins like this one's
        self.assertIn("tasks died 3 times", waiting.communicate(timeout=60)[1])
        self.assertEqual(len(self.arrays()), 3, "what has ended nowhere is handed out again")

    def test_an_sbatch_that_says_no_number_is_an_error_at_once(self) -> None:
        self.run_in("spread", GYROTHERM, "run", str(PROFILES / "short-rate.toml"), "--rig", "virtual", "--out",
                    "ramp.db", "--quiet")
        sbatch = self.folder / "programs/sbatch"
        sbatch.write_text(sbatch.read_text().replace("echo \"$((", "echo \"Submitted $(("))
        failed = self.run_in("spread", SITE, "seeds", "ramp.db", "--last", "2", "--out", "seeds", "--by", "slurm",
                             expect=4)
        self.assertIn('sbatch: expected a job number, found "Submitted 101;lab"', failed.stderr)
        self.assertEqual(len(self.arrays()), 1)


@unittest.skipIf(missing(), f"not installed: {', '.join(missing())}")
class BySlurm(Spread):
    def test_a_lot_of_24_axes_is_the_same_though_a_node_dies(self) -> None:
        words = ["--quick"]
        alone_s = self.alone("virtual-lot", words)
        with SlurmCluster(self.folder / "slurm", nodes=2) as cluster:
            self.environment = cluster.environment
            began = time.monotonic()
            training = self.begin("spread", SITE, "train", "--rig", "virtual-lot", "--lot", "lot", "--by", "slurm",
                                  "--", *words)
            ends = self.folder / "spread/lot/job/tasks"
            while len(list(ends.glob("*.json"))) < 8:
                self.assertIsNone(training.poll())
                time.sleep(0.1)
            cluster.kill("node2")
            time.sleep(2)
            cluster.start_node("node2")
            _, said = training.communicate()
            spread_s = time.monotonic() - began
        self.assertEqual(training.returncode, 0, said)
        self.expect_the_same()
        walls = [json.loads(path.read_text())["wall_s"] for path in ends.glob("*.json")]
        print(f"24 axes: one process {alone_s:.1f} s, two nodes of one core, one of which died, {spread_s:.1f} s; "
              f"a task {min(walls):.1f} to {max(walls):.1f} s")

    def test_what_a_task_costs_beside_its_work(self) -> None:
        self.run_in("spread", GYROTHERM, "--version")
        with SlurmCluster(self.folder / "slurm", nodes=2) as cluster:
            self.environment = cluster.environment
            script = self.folder / "nothing.sh"
            script.write_text("#!/bin/sh\n")
            began = time.monotonic()
            self.run_in("spread", "sbatch", "--wait", "--array=0-49", "--output=/dev/null", str(script))
            print(f"50 empty tasks of Slurm: {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    program = unittest.main(exit=False, verbosity=2)
    ran, skipped = program.result.testsRun, len(program.result.skipped)
    sys.exit(1 if not program.result.wasSuccessful() else SKIPPED if ran == skipped else 0)
