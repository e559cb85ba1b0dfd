# SPDX-License-Identifier: Apache-2.0
"""Validates every register map of a folder against its JSON Schema, and checks that the schema refuses errors.

Exit code 77: python3-jsonschema is not installed.
"""
import copy
import json
import pathlib
import sys
import tomllib

try:
    import jsonschema
except ImportError:
    sys.exit(77)

folder = pathlib.Path(sys.argv[1])
schema = json.loads((folder / "chamber.schema.json").read_text())
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)

failures = []
maps = sorted(folder.glob("*.toml"))
for path in maps:
    for error in validator.iter_errors(tomllib.loads(path.read_text())):
        failures.append(f"{path.name}: {list(error.path)}: {error.message}")

good = tomllib.loads((folder / "watlow_f4t.toml").read_text())
wrong = {
    "an unknown key": lambda m: m.update(colour="red"),
    "an unknown type": lambda m: m["register"][0].update(type="u8"),
    "a missing address": lambda m: m["register"][0].pop("address"),
    "an unknown activity": lambda m: m["state"][0].update(activity="sleeping"),
    "a step of no kind": lambda m: m["sequence"]["start"].append({"within": "1 s"}),
    "a duration without a unit": lambda m: m["link"].update(timeout="600"),
}
for what, change in wrong.items():
    changed = copy.deepcopy(good)
    change(changed)
    if validator.is_valid(changed):
        failures.append(f"the schema accepts {what}")

print("\n".join(failures) or f"{len(maps)} maps are valid")
sys.exit(1 if failures or len(maps) < 13 else 0)
