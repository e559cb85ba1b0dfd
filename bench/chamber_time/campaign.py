#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares programs by the hours that they take and the models that they give, on virtual gyros.

bench/chamber_time/campaign.py GYROTHERM FOLDER programs|until [--rigs …] [--seeds 1-20] [--targets …] [--axis x]
                               [--prior RIG]

`programs` trains on the profiles short and qualification and verifies on five unseen programs. `until` lets the profile
until end by itself at each target and verifies on its mission; with --prior, the run and the training use a type prior
of eleven other gyros of a rig, which may be of another type. Each line of the output is one training as JSON;
FOLDER/results.jsonl keeps all of them. The records of a seed are removed when it is done.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
UNSEEN = (("random", 0), ("shipboard", 0), ("flight", 0), ("hot-soak", 0), ("random", 365))
METHOD = ("--method", "ridge-u", "--inputs", "thermal-history")
PRIOR_SEEDS = range(101, 112)


class Campaign:
    def __init__(self, program: str, folder: Path, axis: str) -> None:
        self.program, self.folder = program, folder
        self.axis = ("--axis", axis) if axis else ()
        folder.mkdir(parents=True, exist_ok=True)

    def call(self, *arguments: object) -> str:
        done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, arguments))}: {done.stderr}")
        return done.stdout + done.stderr

    def record(self, folder: Path, profile: str, rig: str, seed: int, *options: object) -> tuple[Path, str]:
        path = folder / f"{profile}-{len(list(folder.glob('*.db')))}.db"
        there = folder / f"{profile}.toml"
        text = self.call("run", there if there.exists() else ROOT / "profiles" / f"{profile}.toml",
                         "--rig", ROOT / "profiles/rigs" / f"{rig}.toml", "--seed", seed, "--out", path, *options)
        return path, text

    def train(self, record: Path, prior: Path | None = None) -> tuple[Path, dict]:
        """Trains on the record. With a prior, it also trains with it, and returns the model of the lower U."""
        models = []
        for i, how in enumerate([METHOD] + ([("--prior", prior)] if prior else [])):
            path = record.with_suffix(f".{i}.json")
            self.call("train", record, *self.axis, *how, "--out", path, "--quiet")
            models.append((path, json.loads(path.read_text())))
        return min(models, key=lambda model: model[1]["uncertainty"]["combined"]["U_deg_per_h"])

    def learn_prior(self, rig: str) -> Path:
        """Learns the type prior of eleven gyros of a rig, once."""
        prior = self.folder / f"prior-{rig}.json"
        if not prior.exists():
            folder = self.folder / f"prior-{rig}"
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            records = [self.record(folder, profile, rig, seed, "--quiet")[0]
                       for seed in PRIOR_SEEDS for profile in ("qualification", "random")]
            self.call("type-prior", *records, *self.axis, "--out", prior)
            shutil.rmtree(folder)
        return prior

    def verify(self, model: Path, record: Path) -> dict:
        result = json.loads(self.call("verify", model, record, *self.axis, "--json").splitlines()[0])
        return {"std": result["to_truth"]["std_deg_per_h"], "rmse": result["to_truth"]["rmse_deg_per_h"],
                "covered": result["coverage"]["seen"], "clusters": result["coverage"]["clusters"]}

    def keep(self, row: dict) -> None:
        print(json.dumps(row), flush=True)
        with (self.folder / "results.jsonl").open("a") as file:
            file.write(json.dumps(row) + "\n")


def programs(campaign: Campaign, folder: Path, rig: str, seed: int, _options: argparse.Namespace) -> None:
    unseen = []
    for profile, days in UNSEEN:
        later = ("--days-later", days) if days else ()
        unseen.append(campaign.record(folder, profile, rig, seed, "--quiet", *later)[0])
    for program in ("short", "qualification"):
        model, content = campaign.train(campaign.record(folder, program, rig, seed, "--quiet")[0])
        runs = [{"run": profile, "days": days, **campaign.verify(model, record)}
                for (profile, days), record in zip(UNSEEN, unseen)]
        campaign.keep({"rig": rig, "seed": seed, "program": program,
                       "U": content["uncertainty"]["combined"]["U_deg_per_h"], "runs": runs})


def until(campaign: Campaign, folder: Path, rig: str, seed: int, options: argparse.Namespace) -> None:
    mission = campaign.record(folder, "shipboard", rig, seed, "--quiet")[0]
    prior = campaign.learn_prior(options.prior) if options.prior else None
    if prior:
        text = (ROOT / "profiles/until.toml").read_text()
        (folder / "until.toml").write_text(text.replace("[until]\n", f'[until]\nprior = "{prior.resolve()}"\n', 1))
    for target in options.targets:
        record, text = campaign.record(folder, "until", rig, seed, "--until-u", target)
        decisions = [line for line in text.splitlines() if line.startswith("decision")]
        end = re.search(r"end, ([^;]*); U ([0-9.e-]+)", decisions[-1])
        seconds = re.search(r"recorded, (\d+) s", text)
        model, content = campaign.train(record, prior)
        campaign.keep({"rig": rig, "seed": seed, "prior": options.prior, "method": content["method"], "target": target, "end": end[1], "U": float(end[2]),
                       "hours": int(seconds[1]) / 3600, "decisions": len(decisions),
                       "U_model": content["uncertainty"]["combined"]["U_deg_per_h"],
                       **campaign.verify(model, mission)})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=Path)
    parser.add_argument("what", choices=("programs", "until"))
    parser.add_argument("--rigs", nargs="+", default=["virtual-hard"])
    parser.add_argument("--seeds", default="1-20")
    parser.add_argument("--targets", nargs="+", type=float, default=[0.02, 0.013, 0.0105])
    parser.add_argument("--axis", default="")
    parser.add_argument("--prior", default="", metavar="RIG")
    options = parser.parse_args()
    first, last = map(int, options.seeds.split("-"))
    campaign = Campaign(options.program, options.folder, options.axis)
    for rig in options.rigs:
        for seed in range(first, last + 1):
            folder = options.folder / f"{rig}-{seed}"
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            {"programs": programs, "until": until}[options.what](campaign, folder, rig, seed, options)
            shutil.rmtree(folder)


if __name__ == "__main__":
    main()
