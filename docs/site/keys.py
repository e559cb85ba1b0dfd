#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of keys, out of the readers themselves: which keys a file may have, what each is read as, and whether it may
be left out, stand in the sources once, where they are read. What a key means is said by a comment of a shipped file,
or of one in a page.

Here stands only which table each reading function reads; a function that reads a key and is not listed is an error, so
that no key can be forgotten. Called as a program it writes docs/reference/keys.md, which tests/docs/keys_test.py holds
against it, and against the shipped files."""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]

# Source → function, or function:variable → the tables that it reads. "" is the file itself.
_SOAKS = ["defaults", "[segment] hold", "[segment] random"]
_CALIBRATED = ["[thermometer]", "[thermometer.calibration]"]
_AXIS = ["[gyro]", "[gyro.axis]"]
PROFILE = {
    "sequencer/profile/profile.cpp": {"parse_profile": [""], "read_accept": []},
    "sequencer/profile/written_profile.cpp": {
        "read_all": ["", "[segment] repeat"], "read": ["[segment]"], "read_hold": ["[segment] hold"],
        "read_prompt": ["[segment] hold"], "read_ramp": ["[segment] ramp"], "read_repeat": ["[segment] repeat"],
        "read_random": ["[segment] random"], "read_soak_conditions": _SOAKS, "read_defaults": ["defaults"],
    },
}  # fmt: skip
RIG = {
    "sequencer/rig/rig_file.cpp": {
        "parse_rig": [""], "parse_rig:chamber": ["chamber"], "read_chamber": ["chamber"], "read_map": ["chamber"],
        "read_link_keywords": ["chamber", "chamber.link"],
        "read_limiter:chamber": ["chamber"], "read_limiter": ["chamber.limiter"], "read_analysis": ["analysis"],
        "read_safe": ["safe"], "check_safe_air": [], "determine_simulated": [""],
    },
    "sequencer/rig/thermometer_settings.cpp": {
        "read_link": ["[thermometer]"], "read_link:link": ["thermometer.link"],
        "read_sensor": ["thermometer.sensor"], "read_dcon": ["[thermometer] dcon"],
        "read_command": ["[thermometer] process"], "read_certificate": _CALIBRATED,
        "read_uncertainty": _CALIBRATED, "read_calibration": ["[thermometer.calibration]"],
        "read_offsets": ["[thermometer]"], "read_channels": ["[thermometer]"], "read_thermometer": ["[thermometer]"],
    },
    "sequencer/rig/gyro_settings.cpp": {
        "read": [""], "read_axis_names": ["[gyro]"], "read_axis_names:axis": ["[gyro.axis]"],
        "read_direction": ["[gyro.axis]"], "read_single_direction": _AXIS, "arcsec_per_count": _AXIS, "read_axis": _AXIS,
        "read_unit": ["[gyro]"], "read_frames": ["[gyro]"], "begin_line": ["[gyro]"], "share_line": ["[gyro]"],
        "read_scales": _AXIS, "share_values": ["[gyro]"],
    },
    "sequencer/rig/fixture.cpp": {"read_fixture": ["fixture"], "read_latitude": ["fixture", *_AXIS]},
    "sequencer/rig/analogue_settings.cpp": {
        "framing_in": ["[analogue_input]", "analogue_input.link"],
        "word_order_in": ["[analogue_input]", "analogue_input.link"], "read_analogue_map": ["[analogue_input]"], "read_analogue_input": ["[analogue_input]"],
        "read_analogue_inputs": [""], "find_unit": ["[analogue_input.channel]"],
        "read_channel": ["[analogue_input.channel]"],
    },
    "drivers/line/link_settings.cpp": {"read_link_settings": ["chamber.link", "analogue_input.link"]},
    "sequencer/interlocks/limits.cpp": {
        "read_limits:root": [""], "read_limits": ["limits"], "read_times": ["limits"],
        "read_measurements": ["limits"],
        "read_own_limits": ["limits"], "read_own_limits:its": ["limits.channel.NAME"],
        "read_air_thermometers": ["limits"], "read_policy": ["policy"],
        "read_run_limits:root": [""], "read_run_limits": ["limits"], "read_run_limits:safe": ["safe"],
    },
}  # fmt: skip
_BIAS = "virtual.bias"
VIRTUAL = {
    "simulator/laboratory_file.cpp": {
        "read_plant": ["virtual.plant"], "read_readout": ["virtual.gyro"], "read_dead_band": ["virtual.gyro.dead_band"],
        "read_thermometers": ["virtual.thermometers"], "read_failing": ["[virtual.thermometers.failing]"],
        "read_spread": ["virtual.spread"], "read_hard_spread": ["virtual.spread.hard"], "has_reduced_gyro": ["virtual"],
        "find_gyro_model:root": [], "find_gyro_model:table": ["virtual"], "find_gyro_model:thermal": ["virtual.thermal"],
        "parse_laboratory:root": [], "parse_laboratory:table": ["virtual"], "parse_laboratory": ["virtual.power_on"],
    },
    "simulator/unit_file.cpp": {
        "part_of_a_name": ["[virtual.unit]", "[virtual.unit.axis]", "[virtual.value]"],
        "read_units": ["virtual"], "has_units": ["virtual"], "read_unit": ["[virtual.unit]"],
        "read_axis": ["[virtual.unit.axis]"], "read_hop": ["virtual.unit.axis.hop"],
        "read_bracket": ["[virtual.bracket]"], "read_own_temperature": ["virtual.own_temperature"],
        "read_value": ["[virtual.value]"],
    },
    "simulator/virtual_gyro.cpp": {
        "read_reduced_gyro:table": ["virtual"], "read_reduced_gyro:thermal": ["virtual.thermal"],
        "read_reduced_gyro:bias": [_BIAS], "read_reduced_gyro:spread": ["virtual.thermal.spread"],
        "read_reduced_gyro": ["virtual.power_on"], "read_thermal_spread": ["virtual.thermal.spread"],
        "read_side_wind": ["virtual.thermal.side_wind"], "read_power_growth": ["virtual.thermal.power_growth"],
        "read_physics": [_BIAS], "read_flow": [f"{_BIAS}.gas_flow"], "read_wave": [f"[{_BIAS}.wave]"],
        "read_play": [f"[{_BIAS}.play]"], "read_mode_hops": [f"{_BIAS}.mode_hops"],
        "read_growth": [f"{_BIAS}.growth"], "read_lag": [f"{_BIAS}.lag.gas_flow", f"{_BIAS}.lag.deformation"],
        "read_ageing": [f"{_BIAS}.ageing"], "read_storage": [f"{_BIAS}.storage"], "read_slow_bias": [_BIAS],
        "read_slow_bias:lag": [f"{_BIAS}.lag"], "read_slow_bias:term": [f"[{_BIAS}.relaxation]"],
        "read_slow_bias:phase": [f"[{_BIAS}.warm_up]"],
    },
    "simulator/lumped_gyro.cpp": {
        "read_lumped_gyro": ["virtual"], "read_network": ["virtual.network"], "read_links": ["virtual.network"],
        "read_links:conduction": ["[virtual.network.conduction]"], "read_bias": [f"{_BIAS} reference"],
    },
}  # fmt: skip
_ORDER = "report/order.cpp"  # a laboratory's file, and that of an order, in part by the same functions
LABORATORY = {
    _ORDER: {
        "texts": [], "country": [""], "party": [""], "people:table": [""], "people": ["[person]"],
        "equipment:table": [""], "equipment": ["[equipment]"], "logo": [""], "item": [], "units": [], "influences": [],
        "limits": [], "replaced": [], "deviations": [], "parse_laboratory:one": ["[statement]"],
        "parse_laboratory": [""], "parse_order": [],
    },
}  # fmt: skip
ORDER = {
    _ORDER: {
        "texts": [], "country": ["customer"], "party": ["customer"], "people:table": [""], "people": ["[person]"],
        "equipment": [], "logo": [], "item": ["[unit]"], "units:table": [""], "units": ["[unit]"],
        "influences:table": [""], "influences": ["[influence]"], "limits:table": [""], "limits": ["[limit]"],
        "replaced:table": [""], "replaced": ["replaces"], "deviations:table": [""], "deviations": ["[deviation]"],
        "parse_laboratory": [], "parse_order": [""],
    },
}  # fmt: skip
SITE = {
    "apps/site/site_file.cpp": {
        "passfile_at": ["store"], "read_store_address": ["store"], "read_archive": ["archive"], "parse_site:store": ["store"], "parse_site": [""],
    },
    "apps/monitor/site_file.cpp": {
        "address_of": ["[notify.address]"], "rule_of": ["[notify.rule]"], "mail_of": ["notify.mail"],
        "check_names": [], "parse_site:notify": ["notify"], "parse_site": [""],
    },
}  # fmt: skip
# Reading function → what the value is. None: it reads no value. "table NAME": a function that is given the table, and
# has the name of a method of tables.
_KINDS = {
    "text": "a text", "texts": "a list of texts", "number": "a number", "numbers": "a list of numbers",
    "number_rows": "rows of numbers", "integer": "a whole number", "whole": "a whole number",
    "boolean": "true or false", "celsius": "a temperature", "kelvins": "an amount in K", "duration": "a time",
    "rate": "a rate", "positive_rate": "a rate", "rates": "a list of rates", "durations": "a list of times",
    "choice": "one of", "one_of": "one of", "one_of_or_default": "one of", "one_of_link": "one of", "read_either": "one of",
    "table": "a table", "tables": "tables", "expect": "the schema", "read_named": "a file, by name or path",
    "read_time": "a time", "read_time_if_any": "a time", "read_lost": "a time", "read_temperature": "a temperature",
    "read_temperature_if_any": "a temperature", "read_side": "a temperature", "read_rate_if_any": "a rate",
    "read_rates": "a list of rates", "read_band": "an amount in K", "read_rate_range": "[slowest, fastest]",
    "read_time_range": "[shortest, longest]", "read_temperature_ranges": "rows of [lowest, highest]",
    "read_uncertainty": "a number", "read_axis_uncertainty": "a number", "above_zero": "a number", "read_day": "a day",
    "read_channel_names": "names of channels", "read_choice": "names of channels", "read_range": "a temperature",
    "ignore": "a table", "positive": "a number above 0", "not_negative": "a number, not below 0",
    "time_constant_s": "s, at least 1", "within": "a number", "each": "a number, or one for each thermometer",
    "each_or_none": "a number, or one for each thermometer", "day": "a day", "name_at": "a text", "line_at": "a text",
    "texts_at": "a list of texts", "table texts": "a text, or one for each of `en` and `de`",
    "table numbers": "a list of numbers",
    "has": None, "mistake": None, "place": None, "is_list": None, "is_table": None, "append": None, "bounded": None, "check": None,
    "check_safe_set_point": None, "expect_set_point": None, "format": None, "failure": None, "find_node": None,
    "has_role": None,
}  # fmt: skip
_LEFT_OUT = {
    "read_side", "read_time_if_any", "read_temperature_if_any", "read_rate_if_any", "read_uncertainty",
    "read_axis_uncertainty", "above_zero", "read_day", "day", "one_of_or_default", "one_of_link", "read_either", "texts", "numbers", "rates",
    "read_rates", "read_channel_names", "read_choice", "tables", "read_range", "ignore", "table texts",
}  # fmt: skip
_DEFAULTS = {"each_or_none": "0"}
# What the line that reads a key does not show: another key has the say, or a check that follows wants it.
_DEPENDS = {
    "[thermometer]": {"line"}, "thermometer.sensor": {"a", "b", "c", "offset", "scale"},
    "[gyro]": {"line", "latitude", "shares_line_with"}, "[gyro.axis]": {"latitude"},
    "virtual": {"thermal", "network"}, "virtual.spread": {"capacity", "film"}, "[virtual.unit.axis]": {"name"},
    "notify.mail": {"password_file"},
}  # fmt: skip
_NEEDED = {
    "": {"thermometer", "gyro", "segment", "folders"}, "[segment] repeat": {"segment"}, "[thermometer]": {"channels"},
    "[thermometer] process": {"command"}, "[analogue_input]": {"channel"}, "virtual.network": {"nodes"},
    "[virtual.unit]": {"axis"}, "[virtual.bracket]": {"units"}, "[influence]": {"name"},
}  # fmt: skip
_FUNCTION = re.compile(r"^(?:  )?(?:static |\[\[nodiscard\]\] |constexpr )*[\w:<>,&* ]+?[ &*](\w+)\([^;]*$")
# Reading function → how many of the arguments after the key are no default.
_BOUNDS = {
    "choice": 1, "expect": 1, "within": 1, "each": 1, "each_or_none": 1, "table numbers": 2, "whole": 2,
    "read_named": 3, "read_either": 2,
}  # fmt: skip
_STATEMENT = re.compile(r"\s*(if|for|while|return|switch|else|case)\b")
_CALL = re.compile(
    r'([\w:]+)(?:<[^()]*?>)?\((?:(?P<first>[\w:.]+), )?(?:(?P<table>[\w.\[\]*>-]+?), )?"(?P<key>[a-z_0-9]*)"'
)


@dataclass
class Key:
    table: str
    name: str
    kind: str
    required: bool
    default: str
    place: str


def _words_of(constant: str) -> list[str]:
    """The words of a Vocabulary, where it is defined."""
    constant = constant.split("::")[-1]
    if constant == "kThermometerDrivers":  # made of the table of kinds
        text = (SOURCE / "drivers/thermometer/thermometer_kinds.hpp").read_text(encoding="utf-8")
        return re.findall(r'\.name = "(\w+)"', text)
    for path in [*SOURCE.glob("drivers/**/*.hpp"), *SOURCE.glob("sequencer/rig/*.cpp"), *SOURCE.glob("simulator/*.cpp"),
                 SOURCE / _ORDER, SOURCE / "apps/monitor/site_file.cpp"]:  # fmt: skip
        text = path.read_text(encoding="utf-8")
        if found := re.search(rf"constexpr [^;=]*\b{constant}\b\s*[={{][^;]*;", text):
            return re.findall(r'"([^"]+)"', found[0])
    raise ValueError(f"{constant}: its definition is not found")


def _arguments(rest: str) -> list[str]:
    """Those that follow the key of a call, up to its closing bracket."""
    found, depth, text = [], 0, ""
    for mark in rest:
        depth += (mark in "([{") - (mark in ")]}")
        if depth < 0 or (mark == "," and depth == 0):
            found.append(text.strip())
            text = ""
        else:
            text += mark
        if depth < 0:
            break
    return [argument for argument in found if argument]


def _default_of(arguments: list[str]) -> str:
    """The value that is taken where the key is left out, if it stands there."""
    plain = arguments and re.fullmatch(r'"[^"]+"|-?[\d.]+|true|false', arguments[0])
    return arguments[0] if plain else ""


def _kind_of(function: str, constant: str, rest: str, place: str) -> str | None:
    if function not in _KINDS:
        raise ValueError(f"{place}: docs/site/keys.py does not know what {function} reads")
    kind = _KINDS[function]
    if kind != "one of":
        return kind
    if function.startswith("one_of"):
        words = _words_of(constant)
    else:
        braces = re.match(r", \{([^}]*)\}", rest)
        words = re.findall(r'"([^"]+)"', braces[1] if braces else rest.split(")")[0])
    if not words:
        return "a text"
    return "one of " + ", ".join(f"`{word}`" for word in words)


def _is_guarded(key: str, before: str, function: str) -> bool:
    """Whether the reading, of which `before` is the line so far, is one that may not come to pass: a condition stands
    before it, or the function has asked for the key."""
    return re.match(r"\s*(if|else|case)\b", before) is not None or _is_chosen(before) or f'has("{key}")' in function


def _is_chosen(before: str) -> bool:
    return "?" in re.split("[,;]", before)[-1]


def keys_of(sources: dict[str, dict[str, list[str]]]) -> list[Key]:
    keys: dict[tuple[str, str], Key] = {}
    for source, functions in sources.items():
        function, above = "", ""
        text = (SOURCE / source).read_text(encoding="utf-8")
        lines = text.splitlines()
        for number, line in enumerate(lines, 1):
            begins = _FUNCTION.match(line)
            if begins and re.match(r" {0,2}\S", line) and not _STATEMENT.match(line):
                function, above = begins[1], ""
            whole = line + " ".join(following.strip() for following in lines[number : number + 2])
            for call in _CALL.finditer(line):
                place = f"{source}:{number}"
                name = call[1].split("::")[-1].removeprefix("std::")
                if call[1].startswith(("std::", "fmt::", "drivers::")) or name in ("make_vocabulary", "parse_day"):
                    continue
                if not call["key"] and name != "read_range":
                    continue
                rest = whole[call.end("key") + 1 :]
                is_given = call["table"] or call["first"]
                name = f"table {name}" if is_given and f"table {name}" in _KINDS else name
                kind = _kind_of(name, call["first"] or "", rest, place)
                if kind is None:
                    continue
                before = line[: call.start()]
                owner = re.search(r"(\w+)(?:\.|->)$", before) if not call["table"] else None
                variable = owner[1] if owner else (call["table"] or call["first"] or "").split(".")[0]
                tables = functions.get(f"{function}:{variable}", functions.get(function))
                if tables is None:
                    raise ValueError(f"{place}: docs/site/keys.py does not know which table {function} reads")
                names = [call["key"]]
                if name == "read_range":
                    names = [call["key"] + end for end in ("lowest", "highest")]
                for one in names:
                    guarded = _is_guarded(one, before, above)
                    arguments = _arguments(rest)[_BOUNDS.get(name, 0) :]
                    default = _DEFAULTS.get(name, "" if _is_chosen(before) else _default_of(arguments))
                    required = not (arguments or guarded or default or name in _LEFT_OUT)
                    for table in tables:
                        known = keys.get((table, one))
                        if known is None or _KINDS["ignore"] == known.kind:
                            keys[table, one] = Key(table, one, kind, required, default, place)
            above += line + "\n"
    return _as_a_whole(list(keys.values()))


def _as_a_whole(keys: list[Key]) -> list[Key]:
    """What no line shows by itself; and a table that is read in any case may be left out if each of its keys may."""
    for key in keys:
        key.required = key.required or key.name in _NEEDED.get(key.table, ())
        key.required = key.required and key.name not in _DEPENDS.get(key.table, ())
    of_table = {table: [key for key in keys if key.table == table] for table in {key.table for key in keys}}
    for key in sorted(keys, key=lambda k: -k.table.count(".")):
        if key.kind == _KINDS["table"] and key.required:
            below = f"{key.table}.{key.name}" if key.table else key.name
            key.required = any(inner.required for inner in of_table.get(below, ()))
    return keys


def _comments_of(path: Path) -> dict[tuple[str, str], tuple[str, str]]:
    """(table, key) → the value and the comment of a shipped file."""
    found: dict[tuple[str, str], tuple[str, str]] = {}
    table = ""
    for line in path.read_text(encoding="utf-8").splitlines():
        stripped = line.strip()
        if stripped.startswith("```"):  # a block of a page
            table = ""
        if header := re.match(r"(\[\[?[\w.]+\]\]?)$", stripped.split("#")[0].strip()):
            table = header[1].replace("[[", "[").replace("]]", "]") if header[1].startswith("[[") else header[1][1:-1]
            table = re.sub(r"segment\.(segment\.)*segment", "segment", table)
        elif entry := re.match(r"(?:# )?([a-z_0-9]+) += ((?:\"[^\"]*\"|\[[^#]*\]|[^#\"])+?)\s*# (.*)$", stripped):
            found.setdefault((table, entry[1]), (entry[2], entry[3]))
    return found


def _meanings(patterns: list[str]) -> dict[tuple[str, str], tuple[str, str]]:
    found: dict[tuple[str, str], tuple[str, str]] = {}
    for pattern in patterns:
        for path in sorted(SOURCE.glob(pattern)):
            for place, meaning in _comments_of(path).items():
                found.setdefault(place, meaning)
    return found


def _title(table: str) -> str:
    if not table:
        return "The file itself"
    bare, _, of = table.partition(" ")
    return f"`[{bare}]`" + (f", {of}" if of else "")


def _chapter(title: str, sources: dict[str, dict[str, list[str]]], shipped: list[str], note: str) -> list[str]:
    keys = keys_of(sources)
    meanings = _meanings(shipped)
    lines = [f"## {title}", "", textwrap.fill(note, 120, break_on_hyphens=False), ""]
    for table in sorted({key.table for key in keys}, key=lambda t: (t != "", t.strip("[]"))):
        lines += [f"### {_title(table)}", "", "| key | is | if it is left out | an example says |", "|---|---|---|---|"]
        for key in sorted((k for k in keys if k.table == table), key=lambda k: not k.required):
            absent = "a mistake" if key.required else (f"`{key.default}`" if key.default else "")
            bare = table.split(" ")[0]
            value, words = meanings.get((bare, key.name), meanings.get((bare.strip("[]"), key.name), ("", "")))
            example = f"`{value}`: {words}" if value else ""
            row = [f"`{key.name}`", key.kind, absent, example]
            lines.append("| " + " | ".join(row).replace("|  |", "| |").rstrip() + " |")
        lines.append("")
    return lines


def page() -> str:
    opening = (
        "This page is made by `docs/site/keys.py` from the functions that read the files, so that it has every key of "
        "these files that is read and no other; what an example says is a comment of a shipped file, or of one in these "
        "pages. \"A mistake\": of the key, where its table is there. An empty third column: it depends on other keys, or "
        "nothing is meant. [Files](../files.md) says what the files are for, [Import](../importing.md) has the keys of a "
        "map. An unknown key is a mistake, and the program names the nearest one."
    )
    virtual = "profiles/rigs/virtual"
    lines = ["# Keys of the files that people write", "", textwrap.fill(opening, 120), ""]
    lines += _chapter("Profile", PROFILE, ["profiles/*.toml"], "`[metadata]` has keys of your own, `[accept]` figures of "
                      "the report and their limits.")  # fmt: skip
    lines += _chapter("Rig", RIG, ["profiles/rigs/example-f4t*.toml", "profiles/rigs/example*.toml", f"{virtual}.toml",
                      "profiles/rigs/*.toml"], "Keys of `[gyro.frame]` are those of a gyro's stream, in "
                      "`profiles/gyro-streams/README.md`. Defaults of `[limits]`, and what each interlock of `[policy]` "
                      "does, are in [Interlocks](../interlocks.md).")  # fmt: skip
    lines += _chapter("The virtual laboratory of a rig", VIRTUAL, [f"{virtual}.toml", f"{virtual}-hard.toml",
                      f"{virtual}-*.toml"], "Of a rig whose lines are `\"virtual\"`. What the terms mean is "
                      "explained in [The virtual gyro](../virtual-gyro.md).")  # fmt: skip
    report = ["docs/calibration-report.md"]
    lines += _chapter("Laboratory", LABORATORY, report, "Of a [calibration report](../calibration-report.md). Without "
                      "some of those that may be left out a report is a draft, and says which.")  # fmt: skip
    lines += _chapter("Order", ORDER, report, "Of a [calibration report](../calibration-report.md), likewise.")
    lines += _chapter("Site", SITE, ["docs/site.md", "docs/monitor.md"], "One file for `gyrotherm-publish`, which reads "
                      "all but `[notify]`, and for `gyrotherm-monitor`, which reads `name` and `[notify]` and "
                      "lets the rest be left out: [The site](../site.md), [The live page](../monitor.md).")  # fmt: skip
    return "\n".join(lines).rstrip() + "\n"


def written_keys(file: dict) -> set[tuple[str, str]]:
    """Every (table, key) of a TOML file that was read; a segment's table is that of its kind."""
    found: set[tuple[str, str]] = set()

    def walk(table: dict, name: str) -> None:
        for key, value in table.items():
            found.add((name, key))
            below = f"{name}.{key}" if name else key
            if isinstance(value, dict):
                walk(value, below)
            elif isinstance(value, list) and value and isinstance(value[0], dict):
                for one in value:
                    walk(one, "segment" if key == "segment" else below)

    walk(file, "")
    return found


if __name__ == "__main__":
    (SOURCE / "docs/reference/keys.md").write_text(page(), encoding="utf-8")
