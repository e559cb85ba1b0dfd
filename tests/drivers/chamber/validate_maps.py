# SPDX-License-Identifier: Apache-2.0
"""Validates every map of a folder against the JSON Schema of its kind, and checks that the schemas refuse errors.

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
validators = {}
for kind, file in (("gyrotherm-chamber/1", "chamber.schema.json"), ("gyrotherm-text/1", "text.schema.json")):
    schema = json.loads((folder / file).read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    validators[kind] = jsonschema.Draft202012Validator(schema)

failures = []
maps = sorted(folder.glob("*.toml"))
for path in maps:
    content = tomllib.loads(path.read_text())
    for error in validators[content["schema"]].iter_errors(content):
        failures.append(f"{path.name}: {list(error.path)}: {error.message}")

wrong = {
    "an unknown key": lambda m: m.update(colour="red"),
    "an unknown activity": lambda m: m["state"][0].update(activity="sleeping"),
    "a step of no kind": lambda m: m["sequence"]["start"].append({"within": "1 s"}),
    "a duration without a unit": lambda m: m["link"].update(timeout="600"),
}
wrong_registers = {
    "an unknown type": lambda m: m["register"][0].update(type="u8"),
    "a missing address": lambda m: m["register"][0].pop("address"),
}
wrong_texts = {
    "an item without question and command": lambda m: [m["item"][0].pop(key, None) for key in ("ask", "tell")],
    "a unit without a line": lambda m: [m["link"].pop(key, None) for key in ("tcp", "serial")],
    "an unknown key of an item": lambda m: m["item"][0].update(address=3),
    "an unknown checksum": lambda m: m["link"].update(frame={"checksum": "crc"}),
    "a register in a condition": lambda m: m["state"][0].update(register="mode"),
}
for name, changes in (("watlow_f4t.toml", wrong | wrong_registers), ("espec_p300.toml", wrong | wrong_texts)):
    good = tomllib.loads((folder / name).read_text())
    for what, change in changes.items():
        changed = copy.deepcopy(good)
        change(changed)
        if validators[good["schema"]].is_valid(changed):
            failures.append(f"the schema of {name} accepts {what}")

print("\n".join(failures) or f"{len(maps)} maps are valid")
sys.exit(1 if failures or len(maps) < 27 else 0)
