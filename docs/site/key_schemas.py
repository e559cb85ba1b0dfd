# SPDX-License-Identifier: Apache-2.0
"""Makes JSON schemas (draft 07) of user-written files, from the same data as docs/reference/keys.md.

A schema is at most as strict as the program: it accepts each file that the program accepts. It does not compare values
of different keys and does not read other files."""

from __future__ import annotations

import json
import re
import tomllib
from copy import deepcopy
from dataclasses import dataclass, field

import keys
from keys import Key

_NUMBER = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"
_TIME = rf"^\s*({_NUMBER.replace('[+-]?', '[+]?', 1)}\s*(ms|s|min|h|d)\s*)+$"
_THERMOMETERS = 9  # A to H, shell


def _quantity(units: str) -> dict:
    return {"type": ["number", "string"], "pattern": rf"^\s*{_NUMBER}\s*({units})\s*$"}


_TEXT, _REAL, _WHOLE, _FLAG = {"type": "string"}, {"type": "number"}, {"type": "integer"}, {"type": "boolean"}
_DURATION = {"type": "string", "pattern": _TIME}
_CELSIUS, _KELVINS, _RATE = _quantity("°C|C"), _quantity("K|°C"), _quantity("°C/min|K/min")
_DAY = {"type": "string", "pattern": r"^(\d{4}-\d{2}-\d{2})?$"}
_LANGUAGES = {
    "anyOf": [_TEXT, {"type": "object", "properties": {"en": _TEXT, "de": _TEXT}, "additionalProperties": False}]
}


def _list_of(items: dict, **bounds: int) -> dict:
    return {"type": "array", "items": items} | bounds


_EACH = {"anyOf": [_REAL, _list_of(_REAL, minItems=_THERMOMETERS, maxItems=_THERMOMETERS)]}
# Kind of keys.py → its schema.
_FORMS = {
    "a text": _TEXT, "a list of texts": _list_of(_TEXT), "a number": _REAL, "a list of numbers": _list_of(_REAL),
    "rows of [lowest, highest]": _list_of(_list_of(_REAL, minItems=2, maxItems=2), minItems=1),
    "a whole number": _WHOLE, "true or false": _FLAG, "a temperature": _CELSIUS, "an amount in K": _KELVINS,
    "a time": _DURATION, "a rate": _RATE, "a list of rates": _list_of(_RATE),
    "[slowest, fastest]": _list_of(_RATE, minItems=2, maxItems=2),
    "[shortest, longest]": _list_of(_DURATION, minItems=2, maxItems=2), "a file, by name or path": _TEXT, "a day": _DAY,
    "names of channels": _list_of(_TEXT), "a number above 0": _REAL, "a number, not below 0": _REAL,
    "s, at least 1": _REAL, "a number, or one for each thermometer": _EACH,
    "a text, or one for each of `en` and `de`": _LANGUAGES,
}  # fmt: skip


@dataclass
class Case:
    """A value of the key that selects the kind of a table."""

    tables: tuple[str, ...] = ()  # of keys.py
    keys: tuple[str, ...] = ()  # keys of the table itself that only this case accepts
    required: tuple[str, ...] = ()
    rules: dict = field(default_factory=dict)


@dataclass
class Choice:
    """The key that selects the kind of a table, its default, and its values."""

    key: str
    default: str
    cases: dict[str, Case]


def _either(*names: str) -> dict:
    return {"oneOf": [{"required": [name]} for name in names]}


def _any(*names: str) -> dict:
    return {"anyOf": [{"required": [name]} for name in names]}


def _not_both(*names: str) -> dict:
    return {"not": {"required": list(names)}}


_CERTIFICATE = {"dependencies": {"coverage_factor": ["uncertainty"], "distribution": ["uncertainty"]}}
_LINE = ("line",)
_SPREADS = {"properties": {"spread": {"properties": {"capacity": False, "film": False}}}}
# Table → its kinds.
_CHOICES = {
    "[segment]": Choice("kind", "", {
        "hold": Case(("[segment] hold",)), "ramp": Case(("[segment] ramp",), rules=_not_both("rate", "time")),
        "random": Case(("[segment] random",)), "repeat": Case(("[segment] repeat",), rules=_either("count", "rates")),
    }),
    "[thermometer]": Choice("driver", "", {
        "lakeshore_218": Case(required=_LINE), "pt12": Case(required=_LINE),
        "mcc_usb_temp": Case(keys=("sensor",), required=_LINE), "dcon": Case(("[thermometer] dcon",), required=_LINE),
        "process": Case(("[thermometer] process",)),
        "text": Case(("[thermometer] text",), required=_LINE),
    }),
    "thermometer.sensor": Choice("kind", "rtd", {
        "rtd": Case(keys=("wires", "r0_ohm", "a_per_k", "b_per_k2", "c_per_k4")),
        "thermocouple": Case(keys=("type",), required=("type",)),
        "thermistor": Case(keys=("wires", "a", "b", "c"), required=("a", "b", "c")),
        "semiconductor": Case(keys=("differential", "offset", "scale"), required=("offset", "scale")),
    }),
    "virtual": Choice("body", "reference", {
        "twin": Case(keys=("thermal",), required=("thermal",), rules=_SPREADS),
        "reference": Case(keys=("network",), required=("network",),
                          rules={"properties": {"spread": {"required": ["capacity", "film"]}}}),
    }),
    "[virtual.thermometers.failing]": Choice("how", "", {
        "stuck": Case(), "dead": Case(), "offset": Case(keys=("error_k",), required=("error_k",)),
        "spikes": Case(keys=("error_k", "spikes_per_h"), required=("error_k", "spikes_per_h")),
    }),
}  # fmt: skip
# Paths of keys whose schemas a function of _Maker makes.
_SPECIAL = ("metadata", "accept", "policy", "limits.channel", "gyro", "gyro.axis", "gyro.frame", "virtual.bias")
_BIASES = {"twin": "virtual.bias", "reference": "virtual.bias reference"}
# Table → conditions that concern several of its keys.
_RULES = {
    "chamber.limiter": _any("lowest", "highest"),
    "[thermometer]": _CERTIFICATE,
    "[thermometer.calibration]": _CERTIFICATE | _not_both("offset", "polynomial"),
    "[gyro]": _either("line", "shares_line_with") | {"if": {"required": ["line"]}, "then": _either("stream", "frame")},
    "archive": _either("folder", "command"),
    "store": _not_both("passfile", "credential"),
    "[notify.address]": _either("command", "mail", "apprise"),
}
# gyrotherm-monitor reads site files without these tables, gyrotherm site needs only [store], gyrotherm-publish needs all
# of them.
_PUBLISHED = {
    "dependencies": {
        "rig": ["folders", "store"], "folders": ["rig", "store"], "archive": ["rig", "folders", "store"],
    }
}  # fmt: skip


def parse_bounds(text: str) -> dict:
    """Returns the numeric bounds in the description of a range. Ignores words and parts that refer to another key."""
    bounds: dict = {}
    for part in re.split(r"[,;] ", text):
        number = r"(-?[\d.]+(?:e\d+)?)"
        for pattern, keyword in (
            (f"above {number}", "exclusiveMinimum"), (f"at least {number}", "minimum"),
            (f"below {number}", "exclusiveMaximum"), (f"at most {number}", "maximum"),
        ):  # fmt: skip
            if found := re.fullmatch(pattern, part):
                bounds[keyword] = _number(found[1])
        if found := re.fullmatch(f"{number} to {number}", part):
            bounds |= {"minimum": _number(found[1]), "maximum": _number(found[2])}
        elif found := re.match(f"{number} to ", part):
            bounds["minimum"] = _number(found[1])
        if found := re.fullmatch(f"not {number}", part):
            bounds["not"] = {"const": _number(found[1])}
    return bounds


def _number(text: str) -> int | float:
    value = float(text)
    return int(value) if value.is_integer() else value


def _parse_count(text: str) -> dict:
    """Returns the bounds on the length of a list from its description."""
    if found := re.fullmatch(r"0 or (\d+)", text):
        exact = int(found[1])
        return {"anyOf": [{"maxItems": 0}, {"minItems": exact, "maxItems": exact}]}
    if found := re.fullmatch(r"(\d+)(?: to (\d+))?", text):
        return {"minItems": int(found[1]), "maxItems": int(found[2] or found[1])}
    if found := re.fullmatch(r"at least (\d+)", text):
        return {"minItems": int(found[1])}
    return {}


def _add_bounds(form: dict, bounds: dict) -> None:
    """Adds bounds to all numbers of a schema, including those in lists and alternatives."""
    types = form.get("type", ())
    if {"number", "integer"} & ({types} if isinstance(types, str) else set(types)):
        form.update(bounds)
    for inner in [*([form["items"]] if "items" in form else []), *form.get("anyOf", ())]:
        _add_bounds(inner, bounds)


def _description(key: Key) -> str:
    """Returns the text that an editor displays at a key."""
    default = key.default_text()
    is_requirement = key.is_required or key.meaning.condition
    requirement = default[0].upper() + default[1:] if is_requirement else f"Default: {default}"
    return f"{key.meaning.text}.\n\nValue: {key.value_text()}. {requirement}."


def value_schema(key: Key) -> dict:
    """Returns the schema of a key whose value is not a table."""
    if key.kind.startswith("one of "):
        form: dict = {"enum": re.findall(r"`([^`]+)`", key.kind)}
    else:
        form = deepcopy(_FORMS[key.kind])
    if constant := re.fullmatch(r'`"(gyrotherm-[\w-]+/\d+)"`', key.meaning.range):
        form = {"const": constant[1]}
    _add_bounds(form, parse_bounds(key.range))
    form |= _parse_count(key.meaning.count)
    if key.meaning.pattern:
        form["pattern"] = key.meaning.pattern
    literal = re.fullmatch(r"`([\"\[\d][^`]*)`", key.meaning.default or f"`{key.default}`")
    if not key.meaning.default and key.default in ("true", "false"):
        form["default"] = key.default == "true"
    elif literal and not key.meaning.condition:
        form["default"] = tomllib.loads(f"value = {literal[1]}")["value"]
    return form


class _Maker:
    """Makes the schema of one kind of file from its keys."""

    def __init__(self, name: str, all_keys: list[Key]):
        self._tables: dict[str, list[Key]] = {}
        for key in all_keys:
            self._tables.setdefault(key.table, []).append(key)
        self._definitions: dict[str, dict] = {}
        self._name = name

    def schema(self) -> dict:
        file = keys.FILES[self._name]
        root = self._object("")
        if self._name == "site":
            root |= _PUBLISHED
        head = {
            "$schema": "http://json-schema.org/draft-07/schema#",
            "title": f"gyrotherm {file.title.lower()} ({file.schema})",
            "description": "Written by docs/site/keys.py. docs/reference/keys.md has the same text.",
        }
        return head | root | ({"definitions": self._definitions} if self._definitions else {})

    def _property(self, key: Key) -> dict:
        path = f"{key.table.split(' ')[0].strip('[]')}.{key.name}".lstrip(".")
        if path in _SPECIAL:
            form = getattr(self, f"_{path.replace('.', '_')}")()
        elif path in ("segment", "segment.segment", "until.block.segment", "until.closing.segment"):
            form = {"type": "array", "minItems": 1, "items": self._segment()}
        elif path.endswith(".parameter"):
            form = {"type": "object", "additionalProperties": {"type": ["string", "number"]}}
        elif key.kind == "a table":
            form = self._object(path)
        elif key.kind == "tables":
            form = _list_of(self._object(f"[{path}]"), **({"minItems": 1} if key.is_required else {}))
        else:
            form = value_schema(key)
        return {"description": _description(key)} | form

    def _object(self, table: str) -> dict:
        """Returns the schema of a table. Each kind of the table becomes a condition."""
        own = self._tables[table]
        form = {
            "type": "object",
            "properties": {key.name: self._property(key) for key in own},
            "required": [key.name for key in own if key.is_required],
            "additionalProperties": False,
        }
        if not form["required"]:
            del form["required"]
        form |= deepcopy(_RULES.get(table, {}))
        if choice := _CHOICES.get(table):
            self._add_cases(form, choice)
        return form

    def _add_cases(self, form: dict, choice: Choice) -> None:
        """Adds the keys of each kind, and the conditions under which each is accepted or required."""
        properties = form["properties"]
        common = set(properties) - {name for case in choice.cases.values() for name in case.keys}
        of_case: dict[str, dict[str, dict]] = {}
        for value, case in choice.cases.items():
            of_case[value] = {key.name: self._property(key) for table in case.tables for key in self._tables[table]}
            of_case[value] |= {name: properties[name] for name in case.keys}
        special = dict.fromkeys(name for named in of_case.values() for name in named)
        for name in special:
            forms = {value: named[name] for value, named in of_case.items() if name in named}
            different = [one for i, one in enumerate(forms.values()) if one not in list(forms.values())[:i]]
            if name not in common:
                texts = "\n\n".join(f"`{value}`: {one['description']}" for value, one in forms.items())
                properties[name] = different[0] if len(different) == 1 else {"description": texts}
        form["allOf"] = []
        for value, case in choice.cases.items():
            condition: dict = {"properties": {choice.key: {"const": value}}}
            if value != choice.default:
                condition["required"] = [choice.key]
            then: dict = {"properties": {}}
            for name in special:
                if name in of_case[value] and properties[name] != of_case[value][name]:
                    then["properties"][name] = of_case[value][name]
                elif name not in of_case[value] and name not in common:
                    then["properties"][name] = False
            needed = [key.name for table in case.tables for key in self._tables[table] if key.is_required]
            then["required"] = [*needed, *case.required]
            rules = deepcopy(case.rules)
            then["properties"] |= rules.pop("properties", {})
            if value in _BIASES:
                then["properties"]["bias"] = self._bias_conditions(_BIASES[value])
            form["allOf"].append({"if": condition, "then": {k: v for k, v in (then | rules).items() if v}})

    def _segment(self) -> dict:
        if "segment" not in self._definitions:
            self._definitions["segment"] = {}  # the kind "repeat" refers to it
            self._definitions["segment"].update(self._object("[segment]"))
        return {"$ref": "#/definitions/segment"}

    def _metadata(self) -> dict:
        return {"type": "object", "additionalProperties": _TEXT}

    def _accept(self) -> dict:
        self._definitions["accept"] = {
            "type": "object",
            "additionalProperties": {"anyOf": [_REAL, {"$ref": "#/definitions/accept"}]},
        }
        return {"allOf": [{"$ref": "#/definitions/accept"}]}

    def _policy(self) -> dict:
        """Returns the schema of [policy]. Reads the interlocks and their default reactions from the C++ source."""
        text = (keys.SOURCE / "sequencer/interlocks/interlocks.cpp").read_text(encoding="utf-8")
        rows = re.findall(r'\.name = "(\w+)", \.usual = Reaction::(\w+)(, \.choosable = false)?', text)
        reactions = ["warn", "suspend", "hold", "abort"]
        proof = {
            "description": "Reaction to proof tests that are due or failed at the start of a run: a warning, or the run is refused",
            "enum": ["warn", "refuse"],
            "default": "warn",
        }
        return {
            "type": "object",
            "properties": {"proof": proof}
            | {
                name: {
                    "description": f"Reaction to the interlock {name}, see docs/interlocks.md. Default: {usual}.",
                    "enum": ["abort"] if fixed else reactions,
                    "default": usual,
                }
                for name, usual, fixed in rows
            },
            "additionalProperties": False,
        }

    def _limits_channel(self) -> dict:
        return {"type": "object", "additionalProperties": self._object("limits.channel.NAME")}

    def _gyro(self) -> dict:
        one = self._object("[gyro]")
        several = deepcopy(one)
        del one["properties"]["name"]
        several["required"] = ["name", *several.get("required", [])]
        return {"anyOf": [one, _list_of(several, minItems=1)]}

    def _gyro_axis(self) -> dict:
        return {"anyOf": [_TEXT, _list_of(self._object("[gyro.axis]"))]}

    def _gyro_frame(self) -> dict:
        return {"type": "object"}

    def _virtual_bias(self) -> dict:
        """Returns the keys of both bodies. _bias_conditions has the conditions of each."""
        properties: dict[str, dict] = {}
        for body, table in _BIASES.items():
            for name, form in self._object(table)["properties"].items():
                text = f"`{body}`: {form['description']}"
                before = properties.get(name, {}).get("description", "")
                properties[name] = form | {"description": f"{before}\n\n{text}".lstrip()}
        return {"type": "object", "properties": properties, "additionalProperties": False}

    def _bias_conditions(self, table: str) -> dict:
        """Returns the conditions of one body: its required keys. Keys of the other body are refused."""
        own = {key.name for key in self._tables[table]}
        others = [key.name for other in _BIASES.values() for key in self._tables[other] if key.name not in own]
        required = [key.name for key in self._tables[table] if key.is_required]
        return {"required": required, "properties": dict.fromkeys(others, False)}


def schemas() -> dict[str, dict]:
    """Returns kind of file → schema. The schema of a rig includes [virtual]."""
    made = {}
    for name in keys.FILES:
        if name == "virtual":
            continue
        all_keys = keys.described_keys(name) + (keys.described_keys("virtual") if name == "rig" else [])
        made[name] = _Maker(name, all_keys).schema()
    return made


def schema_texts() -> dict[str, str]:
    """Returns file name in docs/reference/schemas → content."""
    return {
        f"{name}.schema.json": json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
        for name, schema in schemas().items()
    }
