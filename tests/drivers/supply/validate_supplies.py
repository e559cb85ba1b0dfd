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
schema = json.loads((folder / "supply.schema.json").read_text(encoding="utf-8"))
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)

failures = []
descriptions = {path.stem: tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.toml"))}
for name, content in descriptions.items():
    for error in validator.iter_errors(content):
        failures.append(f"{name}: {list(error.path)}: {error.message}")

wrong = {
    "an unknown key": lambda d: d.update(colour="red"),
    "a thermometer": lambda d: d.update(kind="thermometer"),
    "a supply without a number of outputs": lambda d: d.pop("outputs"),
    "an unknown item": lambda d: d["item"][0].update(name="volts"),
    "a question without an answer": lambda d: d["item"][0].pop("answer"),
    "an output without codes": lambda d: d["item"][4].pop("codes"),
    "a trip with codes and flags": lambda d: d["item"][7].update(flags={"over_voltage": 2}),
    "a measurement that is written": lambda d: d["item"][5].update(tell="X {value:f}"),
    "no item for the voltage": lambda d: d["item"].pop(2),
    "a unit without a line": lambda d: [d["link"].pop(key, None) for key in ("tcp", "serial")],
}
for what, change in wrong.items():
    changed = copy.deepcopy(descriptions["keysight_e36312a"])
    change(changed)
    if validator.is_valid(changed):
        failures.append(f"the schema accepts {what}")

print("\n".join(failures) or f"{len(descriptions)} descriptions are valid")
sys.exit(1 if failures or len(descriptions) < 6 else 0)
