#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the page of keys says of one that is left out is what happens: left_out_test.py PROGRAMS. Each key of each shipped
rig is left out once, and the rig checked."""

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
# What no shipped rig can do without, but another can.
OTHERS = {
    ("thermometer", "line"),  # of a process
    ("gyro", "line"),  # of a gyro that shares another's
    ("gyro.axis", "direction"),  # where there is no fixture
    ("analysis", "gradients"),  # where each gyro names its own
    ("analogue_input.channel", "gyro"),  # where there is one gyro
    ("virtual", "body"),  # where it is the usual one
    ("virtual.network", "conduction"),  # where each node has a way of its own to the chamber
}


def written(value) -> str:
    """A value of a TOML file on one line; paths, which are relative to the rig, from the root."""
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
    """Each table with its name, the file itself first."""
    yield name, node
    for key, value in node.items():
        for inner in value if isinstance(value, list) else [value]:
            if isinstance(inner, dict):
                yield from tables_of(inner, f"{name}.{key}" if name else key)


def bare(table: str) -> str:
    return table.split(" ")[0].strip("[]")


def fault_of(rig: dict, folder: str) -> str:
    """What the program says of the rig; nothing where it is a good one."""
    file = Path(folder) / "rig.toml"
    file.write_text("".join(f"{key} = {written(value)}\n" for key, value in rig.items()), encoding="utf-8")
    command = [PROGRAM, "check", "--rig", str(file)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False).stderr.strip()


class LeftOut(unittest.TestCase):
    def setUp(self):
        first = ["virtual.toml", "virtual-hard.toml"]
        paths = sorted(RIGS.glob("*.toml"), key=lambda path: (path.name not in first, path.name))
        self.rigs = {path.name: tomllib.loads(path.read_text(encoding="utf-8")) for path in paths}

    def test_each_is_as_the_page_says(self):
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
