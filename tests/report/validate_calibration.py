# SPDX-License-Identifier: Apache-2.0
"""Validates a calibration.json against the JSON Schema, and checks that the schema refuses wrong files.

Exit code 77: python3-jsonschema is not installed.
"""
import copy
import json
import pathlib
import sys

try:
    import jsonschema
except ImportError:
    sys.exit(77)

schema = json.loads(pathlib.Path(sys.argv[1]).read_text())
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)

good = json.loads(pathlib.Path(sys.argv[2]).read_text())
failures = [f"{list(error.path)}: {error.message}" for error in validator.iter_errors(good)]

wrong = {
    "an unknown key": lambda r: r.update(colour="red"),
    "another schema": lambda r: r.update(schema="gyrotherm-calibration/9"),
    "a day that is none": lambda r: r.update(issued="20.11.2026"),
    "an unknown stage": lambda r: r["results"][0].update(stage="repaired"),
    "a result without a unit": lambda r: r["results"][0]["columns"][0].pop("unit"),
    "a value in words": lambda r: r["results"][0]["columns"][0]["values"][0].update(value="much"),
    "a negative uncertainty": lambda r: r["conformity"][0]["value"].update(u=-1),
    "an unknown verdict": lambda r: r["conformity"][0].update(verdict="good"),
    "a hash that is none": lambda r: r["files"][0].update(sha256="abc"),
    "an unknown role": lambda r: r["equipment"][0].update(role="broom"),
}
for what, change in wrong.items():
    changed = copy.deepcopy(good)
    change(changed)
    if validator.is_valid(changed):
        failures.append(f"the schema accepts {what}")

print("\n".join(failures) or "valid")
sys.exit(1 if failures else 0)
