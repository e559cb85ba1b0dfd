# SPDX-License-Identifier: Apache-2.0
"""Validates every description of a folder against its JSON Schema, and checks that the schema refuses errors.

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
[schema_file] = folder.glob("*.schema.json")
kind = schema_file.name.split(".")[0]
schema = json.loads(schema_file.read_text(encoding="utf-8"))
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)

failures = []
descriptions = {path.stem: tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.toml"))}
for name, content in descriptions.items():
    for error in validator.iter_errors(content):
        failures.append(f"{name}: {list(error.path)}: {error.message}")

WRONG = {
    "an unknown key": lambda d: d.update(colour="red"),
    "a unit without a line": lambda d: [d["link"].pop(key, None) for key in ("tcp", "serial")],
}
# By the kind of the descriptions: the smallest number of files, the file that is changed, and the changes.
KINDS = {
    "supply": (6, "keysight_e36312a", {
        "a thermometer": lambda d: d.update(kind="thermometer"),
        "a supply without a number of outputs": lambda d: d.pop("outputs"),
        "an unknown item": lambda d: d["item"][0].update(name="volts"),
        "a question without an answer": lambda d: d["item"][0].pop("answer"),
        "an output without codes": lambda d: d["item"][4].pop("codes"),
        "a trip with codes and flags": lambda d: d["item"][7].update(flags={"over_voltage": 2}),
        "a measurement that is written": lambda d: d["item"][5].update(tell="X {value:f}"),
        "no item for the voltage": lambda d: d["item"].pop(2),
    }),
    "thermometer": (7, "keysight_34970a", {
        "a chamber": lambda d: d.update(kind="chamber"),
        "readings without a range": lambda d: d["item"][0].pop("range"),
        "count and inputs": lambda d: d["item"][0].update(inputs=["A"]),
        "a question without an answer": lambda d: d["sequence"]["prepare"].append({"ask": "A?"}),
        "a command with a required value": lambda d: d["sequence"]["prepare"].append({"tell": "A", "is": 0}),
        "a status without flags": lambda d: d["item"].append({"name": "status", "ask": "S?", "answer": "{value:d}"}),
        "a number format of another kind": lambda d: d["simulated"].update(number="%.8E"),
    }),
}
fewest, example, wrong = KINDS[kind]
for what, change in (WRONG | wrong).items():
    changed = copy.deepcopy(descriptions[example])
    change(changed)
    if validator.is_valid(changed):
        failures.append(f"the schema accepts {what}")

print("\n".join(failures) or f"{len(descriptions)} descriptions are valid")
sys.exit(1 if failures or len(descriptions) < fewest else 0)
