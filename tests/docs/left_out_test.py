#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares docs/reference/keys.md and the schema of rigs with the program: left_out_test.py PROGRAMS.

Omits each key of each shipped rig once, sets each number outside the range of its key once, and checks the rig."""

import json
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

try:
    import jsonschema
except ImportError:
    jsonschema = None  # python3-jsonschema; the comparison with the program does not need it

sys.dont_write_bytecode = True
SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "docs/site"))
import key_schemas  # noqa: E402
import keys  # noqa: E402

PROGRAM = Path(sys.argv.pop(1)).resolve() / "gyrotherm"
RIGS = SOURCE / "profiles/rigs"
# Optional keys that every shipped rig requires.
REQUIRED_BY_SHIPPED_RIGS = {
    ("thermometer", "line"),  # optional for a process
    ("gyro", "line"),  # optional if the line is shared
    ("gyro.axis", "direction"),  # optional without a fixture
    ("analysis", "gradients"),  # optional if units name their own
    ("analogue_input.channel", "gyro"),  # optional with one unit
    ("virtual", "body"),  # optional for the default body
    ("virtual.network", "conduction"),  # optional if all nodes are connected
}


def to_toml(value) -> str:
    """Returns a TOML value on one line. Paths that are relative to the rig become absolute."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {to_toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(to_toml, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value.replace("../", f"{RIGS.parent}/"), ensure_ascii=False)
    return repr(value)


def iterate_tables(node: dict, name: str = ""):
    """Yields each table with its name, the file itself first."""
    yield name, node
    for key, value in node.items():
        for inner in value if isinstance(value, list) else [value]:
            if isinstance(inner, dict):
                yield from iterate_tables(inner, f"{name}.{key}" if name else key)


def bare(table: str) -> str:
    return table.split(" ")[0].strip("[]")


def find_error(rig: dict, folder: str) -> str:
    """Returns the error that the program prints for a rig; "" for a valid one."""
    file = Path(folder) / "rig.toml"
    file.write_text("".join(f"{key} = {to_toml(value)}\n" for key, value in rig.items()), encoding="utf-8")
    command = [PROGRAM, "check", "--rig", str(file)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False).stderr.strip()


def wrong_values(key: keys.Key, value) -> list:
    """Returns values outside the range of a key, in the form of its value."""
    bounds = key_schemas.parse_bounds(key.range)
    wrong = [bounds[name] for name in ("exclusiveMinimum", "exclusiveMaximum") if name in bounds]
    wrong += [bounds["minimum"] - 1] if "minimum" in bounds else []
    wrong += [bounds["maximum"] + 1] if "maximum" in bounds else []
    wrong += [bounds["not"]["const"]] if "not" in bounds else []
    return [[one, *value[1:]] for one in wrong] if isinstance(value, list) else wrong


class Rigs(unittest.TestCase):
    def setUp(self):
        first = ["virtual.toml", "virtual-hard.toml"]
        paths = sorted(RIGS.glob("*.toml"), key=lambda path: (path.name not in first, path.name))
        self.rigs = {path.name: tomllib.loads(path.read_text(encoding="utf-8")) for path in paths}
        schema = json.loads((SOURCE / "docs/reference/schemas/rig.schema.json").read_text(encoding="utf-8"))
        self.validator = jsonschema.Draft7Validator(schema) if jsonschema else None

    def schema_accepts(self, rig: dict) -> bool | None:
        return self.validator.is_valid(rig) if self.validator else None

    def test_required_keys_match_page(self):
        required_flags = {}
        for key in keys.read_keys(keys.RIG | keys.VIRTUAL):
            required_flags.setdefault((bare(key.table), key.name), []).append(key.required)
        optional = {
            (name, key)
            for rig in self.rigs.values()
            for name, table in iterate_tables(rig)
            for key in {key for (of, key) in required_flags if of == name} - set(table)
        }
        seen = set()
        with tempfile.TemporaryDirectory(prefix="gyrotherm-keys-") as folder:
            for file, rig in self.rigs.items():
                self.assertEqual(find_error(rig, folder), "", file)
                for name, table in iterate_tables(rig):
                    for key in [key for key in table if (name, key) in required_flags.keys() - seen]:
                        seen.add((name, key))
                        value, order = table.pop(key), list(table.items())
                        fault, accepts = find_error(rig, folder), self.schema_accepts(rig)
                        table.clear()
                        table.update({key: value} | dict(order))
                        at = f"{file}: [{name}] {key}"
                        if all(required_flags[name, key]):
                            self.assertNotEqual(fault, "", f"{at} is optional")
                            self.assertIsNot(accepts, True, f"{at} is required, but not by the schema")
                        elif not any(required_flags[name, key]):
                            may_fail = (name, key) in optional or (name, key) in REQUIRED_BY_SHIPPED_RIGS
                            self.assertFalse(fault and not may_fail, f"{at} is required: {fault}")
                        if not fault:
                            self.assertIsNot(accepts, False, f"{at} is optional, but not by the schema")
        self.assertGreater(len(seen), 220)

    def test_unknown_keys_are_refused(self):
        seen = set()
        with tempfile.TemporaryDirectory(prefix="gyrotherm-keys-") as folder:
            for file, rig in self.rigs.items():
                for name, table in iterate_tables(rig):
                    if name in seen or name.startswith("gyro.frame"):
                        continue
                    seen.add(name)
                    table["colour"] = 1
                    self.assertNotEqual(find_error(rig, folder), "", f"{file}: [{name}] colour")
                    self.assertIsNot(self.schema_accepts(rig), True, f"{file}: [{name}] colour")
                    del table["colour"]
        self.assertGreater(len(seen), 40)

    def test_ranges_match_program(self):
        known = {}
        for key in keys.described_keys("rig") + keys.described_keys("virtual"):
            known.setdefault((bare(key.table), key.name), []).append(key)
        seen = 0
        with tempfile.TemporaryDirectory(prefix="gyrotherm-keys-") as folder:
            for file, rig in self.rigs.items():
                for name, table in iterate_tables(rig):
                    for key in [key for key in table if len(known.get((name, key), [])) == 1]:
                        value, described = table[key], known.pop((name, key))[0]
                        for wrong in wrong_values(described, value):
                            table[key] = wrong
                            at = f"{file}: [{name}] {key} = {wrong}"
                            self.assertNotEqual(find_error(rig, folder), "", f"{at} is accepted, not {described.range}")
                            self.assertIsNot(self.schema_accepts(rig), True, f"{at} is accepted by the schema")
                            seen += 1
                        table[key] = value
        self.assertGreater(seen, 100)


if __name__ == "__main__":
    unittest.main()
