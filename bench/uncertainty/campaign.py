#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Evaluates models and their budgets on virtual gyros: outside the trained range, after short trainings, and as
streams. Each line of the output is a row of a table.

bench/uncertainty/campaign.py GYROTHERM FOLDER soak|short|stream [--rigs …] [--seeds 201-210] [--methods …]

Records are kept in FOLDER and used again.
"""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROFILES = ROOT / "profiles"
PLANES = ("linear:multi-point-t", "ridge:physics", "ridge-u:temperatures", "ridge-u:thermal-history",
          "gp:temperatures", "svr-linear:temperatures")
SHORT = ("ridge-u:thermal-history", "linear:three-point", "lsf:polynomial")
LENGTHS = (72, 108, 144, 180, 216, 288, 432)


class Campaign:
    def __init__(self, program: str, folder: Path) -> None:
        self.program, self.folder = program, folder
        folder.mkdir(parents=True, exist_ok=True)

    def call(self, *arguments: object) -> str:
        done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, arguments))}: {done.stderr}")
        return done.stdout

    def record(self, profile: str, rig: str, seed: int) -> Path:
        path = self.folder / f"{rig}-{seed}-{profile}.db"
        if not path.exists():
            making = path.with_suffix(".making.db")
            making.unlink(missing_ok=True)
            self.call("run", PROFILES / f"{profile}.toml", "--rig", PROFILES / "rigs" / f"{rig}.toml", "--seed", seed,
                      "--out", making, "--quiet")
            making.rename(path)
        return path

    def model(self, rate: Path, method: str, clusters: str = "") -> Path:
        name, inputs = method.split(":")
        path = self.folder / f"{rate.stem}-{name}-{inputs}{'-' + clusters.replace(':', '_') if clusters else ''}.json"
        if not path.exists():
            part = ["--clusters", clusters] if clusters else []
            self.call("train", rate, "--method", name, "--inputs", inputs, "--out", path, "--quick", "--threads", 1, *part,
                      "--unverified", "--force")
        return path

    def verify(self, model: Path, record: Path, *options: object) -> dict:
        return json.loads(self.call("verify", model, record, "--json", "--unverified", *options).splitlines()[0])


def soak(campaign: Campaign, rig: str, seed: int, methods: tuple[str, ...]) -> None:
    """Prints the true error of the policy relative to that of the extrapolated function, and the coverage."""
    rate = campaign.record("qualification", rig, seed)
    for method in methods:
        model = campaign.model(rate, method)
        for profile in ("hot-soak", "cold-soak"):
            record = campaign.record(profile, rig, seed)
            ours, whole = (campaign.verify(model, record, "--outside", policy) for policy in ("continue", "extrapolate"))
            error, beside = (v["to_truth"]["rmse_deg_per_h"] for v in (ours, whole))
            print(rig, seed, profile, method, f"{error:.5f}", f"{error / beside:.3f}", f"{ours['coverage']['seen']:.4f}",
                  ours["outside_trained_range"], sep="\t", flush=True)


def short(campaign: Campaign, rig: str, seed: int, methods: tuple[str, ...]) -> None:
    """Prints model form, U and coverage on the random run, for trainings on the first clusters of a ramp run."""
    rate, random = (campaign.record(profile, rig, seed) for profile in ("qualification", "random"))
    for method in methods:
        for length in LENGTHS:
            model = campaign.model(rate, method, f"0:{length}")
            budget = json.loads(model.read_text())["uncertainty"]
            form = next(row for row in budget["budget"] if row["source"] == "model form")
            seen = campaign.verify(model, random)
            print(rig, seed, method, length, f"{form['standard_uncertainty']:.5f}", f"{form['degrees_of_freedom']:.1f}",
                  f"{budget['combined']['U_deg_per_h']:.5f}", f"{seen['compensated']['rmse_deg_per_h']:.5f}",
                  f"{seen['coverage']['seen']:.4f}", sep="\t", flush=True)


def stream(campaign: Campaign, rig: str, seed: int, methods: tuple[str, ...]) -> None:
    """Prints the STD of the true error of the stream relative to that of means without a lag."""
    rate = campaign.record("qualification", rig, seed)
    for method in methods:
        model = campaign.model(rate, method)
        led = json.loads(model.read_text())["latency"]["is_led"]
        for profile in ("random",):
            judged = campaign.verify(model, campaign.record(profile, rig, seed), "--as-streamed")["as_streamed"]
            ours, aligned = (judged[key]["std_deg_per_h"] for key in ("to_truth", "aligned_to_truth"))
            print(rig, seed, profile, method, led, f"{ours:.6f}", f"{aligned:.6f}", f"{ours / aligned:.3f}", sep="\t",
                  flush=True)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("program")
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("campaign", choices=("soak", "short", "stream"))
    arguments.add_argument("--rigs", nargs="+", default=["virtual", "virtual-hard"])
    arguments.add_argument("--seeds", default="201-210")
    arguments.add_argument("--methods", nargs="+")
    asked = arguments.parse_args()
    campaign = Campaign(asked.program, asked.folder)
    first, last = (int(seed) for seed in asked.seeds.split("-"))
    run, methods = {"soak": (soak, PLANES), "short": (short, SHORT),
                    "stream": (stream, ("ridge-u:temperatures", "ridge-u:thermal-history"))}[asked.campaign]
    for seed in range(first, last + 1):
        for rig in asked.rigs:
            run(campaign, rig, seed, tuple(asked.methods or methods))


if __name__ == "__main__":
    main()
