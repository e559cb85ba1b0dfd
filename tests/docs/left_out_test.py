#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the page of keys for required and optional keys: left_out_test.py PROGRAMS.

Removes each key of each shipped rig once and checks the rig."""

import json
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "docs/site"))
import keys  # noqa: E402

PROGRAM = Path(sys.argv.pop(1)).resolve() / "gyrotherm"
RIGS = SOURCE / "profiles/rigs"
# Keys required by every shipped rig, but not by every rig.
OTHERS = {
    ("thermometer", "line"),  # a process has no line
    ("gyro", "line"),  # shared with another gyro
    ("gyro.axis", "direction"),  # without a fixture
    ("analysis", "gradients"),  # gradients per gyro
    ("analogue_input.channel", "gyro"),  # only one gyro
    ("virtual", "body"),  # default body
    ("virtual.network", "conduction"),  # each node is coupled to the chamber
}


def written(value) -> str:
    """Returns a value as TOML on one line. Paths relative to the rig become absolute."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {written(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(written, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value.replace("../", f"{RIGS.parent}/"), ensure_ascii=False)
    return repr(value)


def tables_of(node: dict, name: str = ""):
    """Yields each table with its name, first the file itself."""
    yield name, node
    for key, value in node.items():
        for inner in value if isinstance(value, list) else [value]:
            if isinstance(inner, dict):
                yield from tables_of(inner, f"{name}.{key}" if name else key)


def bare(table: str) -> str:
    return table.split(" ")[0].strip("[]")


def fault_of(rig: dict, folder: str) -> str:
    """Returns the messages of the program about a rig; empty if it is valid."""
    file = Path(folder) / "rig.toml"
    file.write_text("".join(f"{key} = {written(value)}\n" for key, value in rig.items()), encoding="utf-8")
    command = [PROGRAM, "check", "--rig", str(file)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False).stderr.strip()


class LeftOut(unittest.TestCase):
    def setUp(self):
        first = ["virtual.toml", "virtual-hard.toml"]
        paths = sorted(RIGS.glob("*.toml"), key=lambda path: (path.name not in first, path.name))
        self.rigs = {path.name: tomllib.loads(path.read_text(encoding="utf-8")) for path in paths}

    def test_required_keys_match_page(self):
        said = {}
        for key in keys.keys_of(keys.RIG | keys.VIRTUAL):
            said.setdefault((bare(key.table), key.name), []).append(key.required)
        optional = {
            (name, key)
            for rig in self.rigs.values()
            for name, table in tables_of(rig)
            for key in {key for (of, key) in said if of == name} - set(table)
        }
        seen = set()
        with tempfile.TemporaryDirectory(prefix="gyrotherm-keys-") as folder:
            for file, rig in self.rigs.items():
                self.assertEqual(fault_of(rig, folder), "", file)
                for name, table in tables_of(rig):
                    for key in [key for key in table if (name, key) in said.keys() - seen]:
                        seen.add((name, key))
                        value, order = table.pop(key), list(table.items())
                        fault = fault_of(rig, folder)
                        table.clear()
                        table.update({key: value} | dict(order))
                        if all(said[name, key]):
                            self.assertNotEqual(fault, "", f"{file}: [{name}] {key} may be left out")
                        elif not any(said[name, key]):
                            needed = fault and (name, key) not in optional and (name, key) not in OTHERS
                            self.assertFalse(needed, f"{file}: [{name}] {key} may not: {fault}")
        self.assertGreater(len(seen), 220)


if __name__ == "__main__":
    unittest.main()
