#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Attacks the real program, and checks the commands that the chamber received and the content of the record.

    run.py GYROTHERM [NAME…] [--jobs N] [--long] [--hanging-disk LIBRARY] [--keep] [--list]

NAME is an attack, a group of attacks, or a pattern like "rm_*"; without NAME, all attacks run. Each attack runs in its
own process. An attack that fails while the machine itself stalls is repeated, up to three attempts. Prints one line for
each attack, then the details of the failures. Exits with 1 if an attack failed.
"""
from __future__ import annotations

import argparse
import dataclasses
import fnmatch
import functools
import importlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

import program
from attack import ATTACKS, Attack, Failed, Scene, Skipped

GROUPS = ("terminal", "lines", "requests", "guard", "locks", "files", "disk", "start", "slow", "presence", "status",
          "channels", "limits")
ATTEMPTS = 3  # for an attack on a machine that stalls
CROWDED = 3 * (os.cpu_count() or 1)  # busy programs that delay the next attack
LONGEST_CROWD = 1.0  # s, longest delay


@dataclasses.dataclass(frozen=True)
class Outcome:
    attack: Attack
    verdict: str  # ok, FAILED, skipped
    why: list[str]
    facts: list[str]
    stall_s: float  # duration of stalls of the machine during the attack
    seconds: float

    def line(self) -> str:
        more = "; ".join(self.why[:1] if self.verdict == "skipped" else self.facts)
        return f"{self.attack.name:<40} {self.verdict:<8} {self.seconds:6.1f} s  {more}".rstrip()


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", help="path of gyrotherm; gyrotherm-make-safe is in the same folder")
    parser.add_argument("names", nargs="*", help="attacks, groups or patterns")
    parser.add_argument("--jobs", type=int, default=8, help="slots; three attacks share one (default: 8)")
    parser.add_argument("--long", action="store_true", help="run the long forms and all repetitions")
    parser.add_argument("--hanging-disk", default="", help="the library of tests/apps/gyrotherm/hanging_disk.cpp")
    parser.add_argument("--keep", action="store_true", help="keep the folders of failed attacks")
    parser.add_argument("--list", action="store_true", help="print the attacks and exit")
    parser.add_argument("--alone", metavar="FOLDER", help=argparse.SUPPRESS)  # one attack in this process
    return parser.parse_args()


def chosen(names: list[str], long: bool) -> list[Attack]:
    """Returns the attacks with these names, in the order of their groups."""
    matches = {n: [a for a in ATTACKS.values() if a.group == n or fnmatch.fnmatchcase(a.name, n)] for n in names}
    for name, attacks in matches.items():
        if not attacks:
            sys.exit(f"unknown attack or group: {name}; --list prints all names")
    found = [a for a in ATTACKS.values() if not names or any(a in attacks for attacks in matches.values())]
    exact = set(names)
    return [a for a in found if long or not a.long_only or a.name in exact]


def clean_up_after_runner(runner: int, folder: pathlib.Path) -> None:
    """Cleans up after an attack when its runner has been killed. Does not return."""
    while os.getppid() == runner:
        time.sleep(1)
    program.sweep(folder)
    shutil.rmtree(folder.parent, ignore_errors=True)
    os._exit(1)


def carry_out_in_process(attack: Attack, options: argparse.Namespace) -> int:
    """Runs one attack in this process and prints its outcome for the runner."""
    folder = pathlib.Path(options.alone)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # started programs would inherit nohup's setting
    threading.Thread(target=clean_up_after_runner, args=(os.getppid(), folder), daemon=True).start()
    scene = Scene(pathlib.Path(options.program), folder, options.long, options.hanging_disk)
    verdict, why = "ok", scene.failures
    try:
        attack.carry_out(scene)
    except Failed as failed:
        scene.failures.append(str(failed))
    except Skipped as skipped:
        verdict, why = "skipped", [str(skipped)]
    except Exception:  # reports a defect of the attack itself
        scene.failures.append(traceback.format_exc())
    finally:
        scene.close()
    if scene.failures:
        verdict, why = "FAILED", scene.failures
    outcome = {"verdict": verdict, "why": why, "facts": scene.facts, "stall_s": scene.standstill.total()}
    print("outcome " + json.dumps(outcome), flush=True)
    return 0


@functools.cache
def private_mounts_are_possible() -> bool:
    return shutil.which("unshare") is not None and \
        subprocess.run(["unshare", "--mount", "true"], stderr=subprocess.DEVNULL, check=False).returncode == 0


def run_in_a_process(attack: Attack, options: argparse.Namespace, folder: pathlib.Path) -> Outcome:
    folder.mkdir()
    command = [sys.executable, __file__, options.program, attack.name, "--alone", str(folder)]
    command += ["--long"] * options.long + ["--hanging-disk", options.hanging_disk] * bool(options.hanging_disk)
    if attack.private_mounts and private_mounts_are_possible():
        command = ["unshare", "--mount", "--propagation", "private", *command]
    began = time.monotonic()
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               start_new_session=True)
    try:
        output, _ = process.communicate(timeout=attack.limit + 30)
        text = output.decode(errors="replace")
    except subprocess.TimeoutExpired:
        process.kill()
        text = f"the attack itself hung for {attack.limit + 30:g} s"
    program.sweep(folder)
    process.wait()
    seconds = time.monotonic() - began
    result = next((json.loads(line[8:]) for line in text.splitlines() if line.startswith("outcome ")), None)
    if result is None:
        result = {"verdict": "FAILED", "why": ["no outcome: " + text[-2000:]], "facts": [], "stall_s": 0.0}
    if result["verdict"] != "FAILED" or not options.keep:
        shutil.rmtree(folder, ignore_errors=True)
    return Outcome(attack, result["verdict"], result["why"], result["facts"], result["stall_s"], seconds)


def carry_out(attack: Attack, options: argparse.Namespace, base: pathlib.Path) -> Outcome:
    """Runs an attack, and repeats it if it fails while the machine stalls."""
    discarded = []
    while True:
        outcome = run_in_a_process(attack, options, base / (attack.name + "-again" * len(discarded)))
        if not (outcome.verdict == "FAILED" and outcome.stall_s and len(discarded) < ATTEMPTS - 1):
            return dataclasses.replace(outcome, facts=discarded + outcome.facts)
        discarded.append(f"repeated: the machine stalled for {outcome.stall_s:.1f} s and {outcome.why[0]}")


class Slots:
    """Limits the number of attacks that run at once to three per slot, because attacks mostly wait."""

    def __init__(self, slots: int) -> None:
        self.free = 3 * max(1, slots)
        self.change = threading.Condition()

    def take(self, attack: Attack) -> None:
        with self.change:
            self.change.wait_for(lambda: self.free >= self.size(attack))
            self.free -= self.size(attack)

    def give_back(self, attack: Attack) -> None:
        with self.change:
            self.free += self.size(attack)
            self.change.notify_all()

    @staticmethod
    def size(attack: Attack) -> int:
        return 3 if attack.alone else 1


def running_process_count() -> int:
    """Returns the number of processes of this machine that run or wait for a processor."""
    stat = pathlib.Path("/proc/stat").read_text()
    return next((int(line.split()[1]) for line in stat.splitlines() if line.startswith("procs_running ")), 0)


def run_all(attacks: list[Attack], options: argparse.Namespace) -> list[Outcome]:
    """Runs all attacks, the longest first so that no long one runs last."""
    outcomes: list[Outcome] = []
    slots, printing = Slots(options.jobs), threading.Lock()
    base = pathlib.Path(tempfile.mkdtemp(prefix="gyrotherm-edges-"))
    base.chmod(0o755)

    def work(attack: Attack) -> None:
        try:
            outcome = carry_out(attack, options, base)
        finally:
            slots.give_back(attack)
        with printing:
            outcomes.append(outcome)
            print(outcome.line(), flush=True)

    workers = []
    for attack in sorted(attacks, key=lambda a: -a.limit):
        slots.take(attack)
        program.until(lambda: running_process_count() <= CROWDED, LONGEST_CROWD)
        workers.append(threading.Thread(target=work, args=(attack,)))
        workers[-1].start()
    for worker in workers:
        worker.join()
    if options.keep and any(o.verdict == "FAILED" for o in outcomes):
        print(f"kept: {base}")
    else:
        shutil.rmtree(base, ignore_errors=True)
    return outcomes


def report(outcomes: list[Outcome], seconds: float) -> int:
    failed = [o for o in outcomes if o.verdict == "FAILED"]
    for outcome in failed:
        print(f"\n{outcome.attack.name}: {outcome.attack.doc}")
        for why in outcome.why:
            print("  - " + why.replace("\n", "\n    "))
    skipped = sum(o.verdict == "skipped" for o in outcomes)
    print(f"\n{len(outcomes)} attacks: {len(outcomes) - len(failed) - skipped} ok, {len(failed)} failed, "
          f"{skipped} skipped, in {seconds:.0f} s")
    return 1 if failed or not outcomes else 0


def main() -> int:
    options = arguments()
    for group in GROUPS:
        importlib.import_module(group)
    attacks = chosen(options.names, options.long)
    if options.list:
        for attack in attacks:
            print(f"{attack.group:<10} {attack.name:<40} {attack.doc.splitlines()[0] if attack.doc else ''}")
        return 0
    if not options.program or not pathlib.Path(options.program).is_file():
        print("expected the path of gyrotherm; see --help", file=sys.stderr)
        return 2
    os.umask(0o022)
    options.program = str(pathlib.Path(options.program).resolve())
    if options.alone:
        return carry_out_in_process(attacks[0], options)
    began = time.monotonic()
    return report(run_all(attacks, options), time.monotonic() - began)


if __name__ == "__main__":
    sys.exit(main())
