#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/reference/keys.md, the list of all keys of user-written files.

The functions that read the files state which keys exist, the kind of each value, whether a key is required and most
defaults. This program reads them in the C++ sources. docs/site/key_meanings describes each key: its meaning, and the
unit, range or default that the reading function does not show. The program fails for a key without a meaning and for a
meaning without a key.

The tables below list the tables that each reading function reads. A function that reads a key and is not listed is an
error, so that no key is omitted. key_schemas.py makes JSON schemas from the same data."""

from __future__ import annotations

import re
import sys
import textwrap
import tomllib
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
MEANINGS = Path(__file__).resolve().parent / "key_meanings"

# Source → function or function:variable → tables that it reads. "" is the file itself.
_SOAKS = ["defaults", "[segment] hold", "[segment] random"]
_CALIBRATED = ["[thermometer]", "[thermometer.calibration]"]
_AXIS = ["[gyro]", "[gyro.axis]"]
PROFILE = {
    "sequencer/profile/profile.cpp": {"parse_profile": [""], "read_accept": [], "read_accepted": [], "read_condensation": ["condensation"]},
    "sequencer/profile/written_profile.cpp": {
        "read_all": ["", "[segment] repeat", "[until.block]", "until.closing"], "read": ["[segment]"], "read_hold": ["[segment] hold"],
        "read_prompt": ["[segment] hold"], "read_ramp": ["[segment] ramp"], "read_repeat": ["[segment] repeat"],
        "read_random": ["[segment] random"], "read_soak_conditions": _SOAKS, "read_defaults": ["defaults"],
        "check_block": [], "read_block": [],
    },
    "sequencer/profile/released_blocks.cpp": {
        "check_block_name": ["[until.block]"], "read_blocks": ["until"], "read_blocks:table": ["[until.block]"],
        "read_until": ["until"], "check_end": [], "check_longest": [], "expand_until": [],
    },
}  # fmt: skip
RIG = {
    "sequencer/rig/rig_file.cpp": {
        "parse_rig": [""], "read_name": [""], "parse_rig:chamber": ["chamber"], "read_chamber": ["chamber"], "read_map": ["chamber"],
        "read_word_order_and_framing": ["chamber", "chamber.link"],
        "read_limiter:chamber": ["chamber"], "read_limiter": ["chamber.limiter"], "read_analysis": ["analysis"],
        "read_safe_state": ["safe"], "read_room": ["room"], "check_safe_air": [], "check_safe_off": [], "check_relay_line": [], "list_line_tables": [""], "determine_simulated": [""],
        "read_trusted_certificates": ["certificates"],
    },
    "sequencer/rig/thermometer_certificate.cpp": {"read_named_certificate": _CALIBRATED},
    "sequencer/rig/thermometer_settings.cpp": {
        "read_common_certificate": ["[thermometer]"], "check_days": _CALIBRATED,
        "read_link": ["[thermometer]"], "read_link:link": ["thermometer.link"], "read_text_link": ["[thermometer]"],
        "read_sensor": ["thermometer.sensor"], "read_dcon": ["[thermometer] dcon"],
        "read_command": ["[thermometer] process"], "read_description": ["[thermometer] text"], "read_certificate": _CALIBRATED,
        "read_uncertainty": _CALIBRATED, "read_calibration": ["[thermometer.calibration]"],
        "read_offsets": ["[thermometer]"], "read_channels": ["[thermometer]"], "read_thermometer": ["[thermometer]"],
    },
    "sequencer/rig/gyro_settings.cpp": {
        "read": [""], "read_axis_names": ["[gyro]"], "read_axis_names:axis": ["[gyro.axis]"],
        "read_direction": _AXIS, "read_single_direction": _AXIS, "arcsec_per_count": _AXIS, "read_axis": _AXIS,
        "read_unit": ["[gyro]"], "read_frames": ["[gyro]"], "begin_line": ["[gyro]"], "share_line": ["[gyro]"],
        "read_scales": _AXIS, "share_values": ["[gyro]"],
    },
    "sequencer/rig/check_standard.cpp": {"read_check_standard": ["check_standard"]},
    "sequencer/rig/fixture.cpp": {"read_fixture": ["fixture"], "read_latitude": ["fixture", *_AXIS]},
    "sequencer/rig/analogue_settings.cpp": {
        "read_framing": ["[analogue_input]", "analogue_input.link"],
        "read_word_order": ["[analogue_input]", "analogue_input.link"], "read_analogue_map": ["[analogue_input]"], "read_analogue_input": ["[analogue_input]"],
        "read_analogue_inputs": [""], "find_unit": ["[analogue_input.channel]"],
        "read_channel": ["[analogue_input.channel]"],
    },
    "sequencer/rig/supply_settings.cpp": {
        "read_supply_description": ["[supply]"], "read_supply": ["[supply]"], "read_supplies": [""],
        "read_fed_units": ["[supply.output]"], "read_supply_output": ["[supply.output]"],
        "check_power_limits": [], "check_order": [], "read_supply:one": [], "add_measured_value": [],
        "read_number_if_any": [], "read_level_if_any": [], "read_required_level": [],
    },
    "sequencer/rig/proof_settings.cpp": {
        "read_proof_settings:root": [""], "read_proof_settings": ["prove"], "read_proof_settings:policy": ["policy"],
        "read_days": [], "read_span": [], "read_limit": [],
    },
    "drivers/supply/safety_relay.cpp": {
        "read_relay_settings": ["safe.also"], "read_modbus_relay": ["safe.also"], "read_text_relay": ["safe.also"],
    },
    "drivers/line/link_settings.cpp": {
        "read_link_settings": ["chamber.link", "analogue_input.link", "safe.also.link"],
        "read_line_settings": [
            "chamber.link", "analogue_input.link", "thermometer.link", "supply.link", "safe.also.link",
        ],
    },
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
        "read_name": ["[virtual.unit]", "[virtual.unit.axis]", "[virtual.value]"],
        "read_units": ["virtual"], "has_units": ["virtual"], "read_unit": ["[virtual.unit]"],
        "read_axis": ["[virtual.unit.axis]"], "read_hop": ["virtual.unit.axis.hop"],
        "read_bracket": ["[virtual.bracket]"], "read_own_temperature": ["virtual.own_temperature"],
        "read_value": ["[virtual.value]"], "read_load": ["[virtual.load]"],
    },
    "simulator/virtual_gyro.cpp": {
        "read_reduced_gyro:table": ["virtual"], "read_reduced_gyro:thermal": ["virtual.thermal"],
        "read_reduced_gyro:bias": [_BIAS], "read_reduced_gyro:spread": ["virtual.thermal.spread"],
        "read_reduced_gyro": ["virtual.power_on"], "read_thermal_spread": ["virtual.thermal.spread"],
        "read_side_wind": ["virtual.thermal.side_wind"], "read_power_growth": ["virtual.thermal.power_growth"],
        "read_physics": [_BIAS], "read_flow": [f"{_BIAS}.gas_flow"], "read_wave": [f"[{_BIAS}.wave]"],
        "read_play": [f"[{_BIAS}.play]"], "read_mode_hops": [f"{_BIAS}.mode_hops"],
        "read_growth": [f"{_BIAS}.growth"], "read_lag": [f"{_BIAS}.lag.gas_flow", f"{_BIAS}.lag.deformation"],
        "read_ageing": [f"{_BIAS}.ageing"], "read_storage_temperatures": [f"{_BIAS}.storage"], "read_slow_bias": [_BIAS],
        "read_slow_bias:lag": [f"{_BIAS}.lag"], "read_slow_bias:term": [f"[{_BIAS}.relaxation]"],
        "read_slow_bias:phase": [f"[{_BIAS}.warm_up]"],
    },
    "simulator/lumped_gyro.cpp": {
        "read_lumped_gyro": ["virtual"], "read_network": ["virtual.network"], "read_links": ["virtual.network"],
        "read_links:conduction": ["[virtual.network.conduction]"], "read_bias": [f"{_BIAS} reference"],
    },
}  # fmt: skip
# This source reads laboratory files and orders, partly with the same functions.
_ORDER = "report/order.cpp"
LABORATORY = {
    _ORDER: {
        "texts": [], "read_translated": [], "country": [""], "email": ["", "[person]"], "party": [""], "read_people:table": [""], "read_people": ["[person]"],
        "equipment:table": [""], "equipment": ["[equipment]"], "logo": [""], "item": [], "units": [], "influences": [],
        "limits": [], "read_replaced_report": [], "deviations": [], "parse_laboratory:one": ["[statement]"],
        "parse_laboratory": [""], "parse_order": [],
    },
}  # fmt: skip
ORDER = {
    _ORDER: {
        "texts": [], "read_translated": [], "country": ["customer"], "email": ["customer", "[person]"], "party": ["customer"], "read_people:table": [""],
        "read_people": ["[person]"],
        "equipment": [], "logo": [], "item": ["[unit]"], "units:table": [""], "units": ["[unit]"],
        "influences:table": [""], "influences": ["[influence]"], "limits:table": [""], "limits": ["[limit]"],
        "read_replaced_report:table": [""], "read_replaced_report": ["replaces"], "deviations:table": [""], "deviations": ["[deviation]"],
        "parse_laboratory": [], "parse_order": [""],
    },
}  # fmt: skip
SITE = {
    "apps/site/site_file.cpp": {
        "read_passfile": ["store"], "read_store_address": ["store"], "read_archive": ["archive"], "read_store_table:store": ["store"],
        "read_store_table": [""], "parse_site": [""], "parse_store": [""],
    },
    "apps/monitor/site_file.cpp": {
        "read_command": ["[notify.address]"], "read_mail_addresses": ["[notify.address]"],
        "read_address": ["[notify.address]"], "read_rule": ["[notify.rule]"], "read_mail_server": ["notify.mail"],
        "check_names": [], "parse_site:notify": ["notify"], "parse_site": [""],
    },
}  # fmt: skip
# Reading function → kind of the value; None: reads no value. "table NAME" is a free function that has the name of a
# method of TomlTable.
_KINDS = {
    "text": "a text", "texts": "a list of texts", "number": "a number", "numbers": "a list of numbers",
    "number_rows": "rows of numbers", "integer": "a whole number", "whole": "a whole number",
    "boolean": "true or false", "celsius": "a temperature", "kelvins": "an amount in K", "duration": "a time",
    "rate": "a rate", "positive_rate": "a rate", "rates": "a list of rates", "durations": "a list of times",
    "choice": "one of", "one_of": "one of", "one_of_or_default": "one of", "read_link_keyword": "one of", "read_either": "one of",
    "table": "a table", "tables": "tables", "expect": "the schema", "read_named": "a file, by name or path",
    "read_time": "a time", "read_time_if_any": "a time", "read_lost": "a time", "read_temperature": "a temperature",
    "read_temperature_if_any": "a temperature", "read_limit_if_any": "a temperature", "read_rate_if_any": "a rate",
    "read_rates": "a list of rates", "read_band": "an amount in K", "read_rate_range": "[slowest, fastest]",
    "read_time_range": "[shortest, longest]", "read_temperature_ranges": "rows of [lowest, highest]",
    "read_uncertainty": "a number", "read_axis_uncertainty": "a number", "read_positive_number": "a number", "read_day": "a day",
    "read_angle": "a number", "read_angle_uncertainty": "a number", "check_correction": None,
    "read_channel_names": "names of channels", "read_choice": "names of channels", "read_range": "a temperature",
    "ignore": "a table", "positive": "a number above 0", "not_negative": "a number, not below 0",
    "time_constant_s": "s, at least 1", "read_bounded": "a number",
    "read_each_thermometer": "a number, or one for each thermometer",
    "read_each_or_none": "a number, or one for each thermometer", "day": "a day", "read_rig_name": "a text",
    "read_text_line": "a text", "read_required_level": "a number above 0", "read_level_if_any": "a number above 0",
    "read_number_if_any": "a number", "read_days": "a time", "read_span": "an amount in K", "read_limit": "a time",
    "read_texts": "a list of texts", "table texts": "a text, or one for each of `en` and `de`",
    "read_translated": "a text, or one for each of `en` and `de`",
    "table numbers": "a list of numbers",
    "has": None, "note_error": None, "location": None, "is_list": None, "is_table": None, "is_text": None, "append": None, "bounded": None, "check": None,
    "check_safe_set_point": None, "expect_set_point": None, "format": None, "failure": None, "find_node": None,
    "has_role": None, "check_order": None,
}  # fmt: skip
# Reading functions for which the key is optional.
_OPTIONAL_READERS = {
    "read_limit_if_any", "read_time_if_any", "read_temperature_if_any", "read_rate_if_any", "read_uncertainty",
    "read_angle", "read_angle_uncertainty",
    "read_axis_uncertainty", "read_positive_number", "read_day", "day", "one_of_or_default", "read_link_keyword", "read_either", "texts", "numbers", "rates",
    "read_rates", "read_level_if_any", "read_number_if_any", "read_channel_names", "read_choice", "tables", "read_range", "ignore", "table texts",
}  # fmt: skip
_DEFAULTS = {"read_each_or_none": "0"}
# Table → keys that are required under a condition which is not visible in the line that reads them.
_CONDITIONALLY_REQUIRED = {
    "[thermometer]": {"line"}, "thermometer.sensor": {"a", "b", "c", "offset", "scale"},
    "[gyro]": {"line", "latitude", "shares_line_with"}, "[gyro.axis]": {"latitude"},
    "virtual": {"thermal", "network"}, "virtual.spread": {"capacity", "film"}, "[virtual.unit.axis]": {"name"},
    "notify.mail": {"password_file"},
    "safe.also": {"coil", "register", "tell_open", "tell_close", "ask", "is_open", "is_closed"},
}  # fmt: skip
# Table → keys that a later check requires.
_REQUIRED_LATER = {
    "": {"thermometer", "gyro", "segment", "folders"}, "[segment] repeat": {"segment"}, "until": {"block"}, "[until.block]": {"segment"},
    "until.closing": {"segment"}, "[thermometer]": {"channels"},
    "[thermometer] process": {"command"}, "[analogue_input]": {"channel"}, "[supply]": {"output"}, "virtual.network": {"nodes"},
    "[virtual.unit]": {"axis"}, "[virtual.bracket]": {"units"}, "[influence]": {"name"},
}  # fmt: skip
_FUNCTION = re.compile(
    r"^(?:  )?(?:static |\[\[nodiscard\]\] |constexpr )*[\w:<>,&* ]+?[ &*](\w+)\((?:[^;]*|[^;]*\) (?:const )?\{.*\})$"
)
# Reading function → number of arguments after the key that are not the default.
_ARGUMENTS_BEFORE_DEFAULT = {
    "choice": 1, "expect": 1, "read_bounded": 1, "read_each_thermometer": 1, "read_each_or_none": 1,
    "table numbers": 2, "whole": 2,
    "read_named": 3, "read_either": 2,
}  # fmt: skip
_STATEMENT = re.compile(r"\s*(if|for|while|return|switch|else|case)\b")
_CALL = re.compile(
    r'([\w:]+)(?:<[^()]*?>)?\((?:(?P<first>[\w:.]+), )?(?:(?P<table>[\w.\[\]*>-]+?), )?"(?P<key>[a-z_0-9]*)"'
)
# Suffix of a key's name → unit of its number, the longest first.
_UNITS = [
    ("deg_per_h_per_cm_per_s", "°/h per cm/s"), ("deg_per_h_per_sqrt_h", "°/h/√h"), ("deg_per_h_per_k2", "°/h per K²"),
    ("deg_per_h_per_k", "°/h per K"), ("deg_per_sqrt_h", "°/√h"), ("deg_per_h", "°/h"), ("k_per_sqrt_day", "K/√day"),
    ("k_per_year", "K/year"), ("k_per_min", "K/min"), ("j_per_k", "J/K"), ("w_per_k", "W/K"), ("_per_year", "1/year"),
    ("_per_k4", "1/K⁴"), ("_per_k2", "1/K²"), ("_per_k", "1/K"), ("_cm_per_s", "cm/s"), ("_per_h", "1/h"),
    ("arcsec_per_pulse", "arcsec"), ("_arcmin", "′"), ("_ohm", "Ω"), ("_ppm", "ppm"), ("_deg", "°"), ("_hz", "Hz"),
    ("_gb", "GB"), ("_k", "K"), ("_s", "s"), ("_w", "W"),
]  # fmt: skip
# Kind → its name on the page, the unit of its numbers, and the bounds that the reading function enforces.
_FORMS = {
    "a text": ("text", "", ""), "a list of texts": ("list of texts", "", ""), "a number": ("number", "", ""),
    "a list of numbers": ("list of numbers", "", ""), "a whole number": ("whole number", "", ""),
    "rows of [lowest, highest]": ("list of [lowest, highest]", "", ""), "true or false": ("`true` or `false`", "", ""),
    "a temperature": ("temperature", "°C", ""), "an amount in K": ("temperature difference", "K", ""),
    "a time": ("duration", "", ""), "a list of times": ("list of durations", "", ""), "a rate": ("rate", "°C/min", ""),
    "a list of rates": ("list of rates", "°C/min", ""), "[slowest, fastest]": ("[slowest, fastest]", "°C/min", ""),
    "[shortest, longest]": ("[shortest, longest]", "", ""), "a table": ("table", "", ""),
    "tables": ("array of tables", "", ""), "a file, by name or path": ("name or path", "", ""),
    "a day": ("day, `\"YYYY-MM-DD\"`", "", ""), "names of channels": ("list of channels", "", ""),
    "a number above 0": ("number", "", "above 0"), "a number, not below 0": ("number", "", "at least 0"),
    "s, at least 1": ("number", "s", "at least 1"),
    "a number, or one for each thermometer": ("number, or list of 9 for A to H and `shell`", "", ""),
    "a text, or one for each of `en` and `de`": ("text, or table of `en` and `de`", "", ""),
}  # fmt: skip
_CHRONO = {"milliseconds": "ms", "seconds": "s", "minutes": "min", "hours": "h"}
_MAX_MEANING_LENGTH = 120


@dataclass
class Meaning:
    """The fields of an entry. key_meanings/README.md describes them."""

    text: str = ""
    unit: str = ""
    range: str = ""
    count: str = ""
    pattern: str = ""
    example: str = ""
    default: str = ""
    condition: str = ""


@dataclass
class Key:
    table: str
    name: str
    kind: str
    required: bool
    default: str
    position: str
    meaning: Meaning = field(default_factory=Meaning)

    @property
    def unit(self) -> str:
        """Returns the unit of the number or numbers."""
        unit = self.meaning.unit or _form(self.kind)[1]
        if unit or "number" not in self.kind:
            return unit
        return next((unit for suffix, unit in _UNITS if f"_{self.name}".endswith(suffix)), "")

    @property
    def range(self) -> str:
        """Returns the permitted values in words."""
        return ", ".join(part for part in (_form(self.kind)[2], self.meaning.range) if part)

    @property
    def is_required(self) -> bool:
        """Returns whether the key is required without a condition."""
        return self.required and not self.meaning.condition

    def value_text(self) -> str:
        """Returns the cell of the column "value"."""
        parts = [_form(self.kind)[0], self.unit]
        count = self.meaning.count
        parts.append(re.sub(r"(\d)$", r"\1 elements", count).replace("least 1 elements", "least 1 element"))
        parts.append(self.range)
        text = ", ".join(part for part in parts if part)
        return text + (f"; example: `{self.meaning.example}`" if self.meaning.example else "")

    def default_text(self) -> str:
        """Returns the cell of the column "default"."""
        if self.is_required:
            return "required"
        if self.meaning.condition:
            return f"required {self.meaning.condition}"
        return self.meaning.default or f"`{self.default}`"


@dataclass
class FileKind:
    """A kind of file that people write."""

    title: str
    schema: str
    sources: dict[str, dict[str, list[str]]]
    note: str


FILES = {
    "profile": FileKind("Profile", "gyrotherm-profile/1", PROFILE, "The temperature program of a run."),
    "rig": FileKind(
        "Rig", "gyrotherm-rig/1", RIG,
        "The instruments, their connections and the limits of the interlocks. `profiles/gyro-streams/README.md` "
        "describes the keys of `[gyro.frame]`. [Interlocks](../interlocks.md) describes each interlock and its key in "
        "`[policy]`.",
    ),
    "virtual": FileKind(
        "The virtual laboratory of a rig", "gyrotherm-rig/1", VIRTUAL,
        "A rig whose lines are `\"virtual\"` has these tables. [The virtual gyro](../virtual-gyro.md) explains the "
        "terms.",
    ),
    "laboratory": FileKind(
        "Laboratory", "gyrotherm-laboratory/1", LABORATORY,
        "The data of the laboratory in [calibration reports](../calibration-report.md). Without some keys a report "
        "remains a draft, which lists them.",
    ),
    "order": FileKind(
        "Order", "gyrotherm-order/1", ORDER,
        "The data of one order in a [calibration report](../calibration-report.md). Without some keys the report "
        "remains a draft, which lists them.",
    ),
    "site": FileKind(
        "Site", "gyrotherm-site/1", SITE,
        "One file for three programs. `gyrotherm-publish` reads all tables but `[notify]` ([The site](../site.md)). "
        "`gyrotherm-monitor` reads `name` and `[notify]` ([The live page](../monitor.md)). `gyrotherm site` reads only "
        "`[store]`, also for the view Site of the live page.",
    ),
}  # fmt: skip


def _form(kind: str) -> tuple[str, str, str]:
    return _FORMS.get(kind, (kind, "", ""))


@cache
def _read_text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _find_terms(constant: str) -> list[str]:
    """Returns the terms of a Vocabulary from its definition."""
    constant = constant.split("::")[-1]
    if constant == "kThermometerDrivers":  # made from the table of kinds
        return re.findall(r'\.name = "(\w+)"', _read_text(SOURCE / "drivers/thermometer/thermometer_kinds.hpp"))
    for path in [*SOURCE.glob("drivers/**/*.hpp"), *SOURCE.glob("sequencer/rig/*.cpp"), *SOURCE.glob("simulator/*.cpp"),
                 SOURCE / _ORDER, SOURCE / "apps/monitor/site_file.cpp"]:  # fmt: skip
        if found := re.search(rf"constexpr [^;=]*\b{constant}\b\s*[={{][^;]*;", _read_text(path)):
            return re.findall(r'"([^"]+)"', found[0])
    raise ValueError(f"{constant}: definition not found")


def _arguments(rest: str) -> list[str]:
    """Returns the arguments after the key, up to the closing bracket of the call."""
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


@cache
def _read_initialisers(header: Path) -> dict[str, set[str]]:
    """Returns member → initialisers, for all structs of a header."""
    found: dict[str, set[str]] = {}
    for line in _read_text(header).splitlines():
        line = line.split("//")[0].rstrip()
        declared = re.match(r"  (?:const )?[\w:]+(?:<[\w:<>, ]*>)?\*? (\w.*);", line)
        if not declared or "(" in declared[1].split("=")[0]:
            continue
        for name, assigned, braced in re.findall(r"(\w+)(?: = ([^,{}]+)|(\{[^{}]*\}))(?:, |$)", declared[1]):
            found.setdefault(name, set()).add(assigned.strip() if assigned else braced)
    return found


def _find_included_headers(path: Path) -> list[Path]:
    names = re.findall(r'^#include "([^"]+)"', _read_text(path), re.M)
    return [SOURCE / name for name in names if (SOURCE / name).exists()]


@cache
def _find_initialiser(source: Path, member: str) -> str:
    """Returns the initialiser of a member from the nearest included header that has one, or "" if two differ."""
    own = source.with_suffix(".hpp")
    headers = [own] if own.exists() else _find_included_headers(source)
    seen: set[Path] = set()
    for _ in range(4):
        found = {one for header in headers for one in _read_initialisers(header).get(member, ())}
        if found:
            return found.pop() if len(found) == 1 else ""
        seen |= set(headers)
        headers = [one for header in [source, *headers] for one in _find_included_headers(header) if one not in seen]
    return ""


def _literal(kind: str, initialiser: str) -> str:
    """Returns a C++ initialiser as a TOML value, or "" if it is not a literal."""
    if time := re.fullmatch(r"std::chrono::(\w+)\((\d+)\)", initialiser):
        return f'"{time[2]} {_CHRONO[time[1]]}"'
    if kind == "true or false" and initialiser == "{}":
        return "false"
    if re.fullmatch(r'"[^"]*"|true|false', initialiser):
        return initialiser
    number = re.fullmatch(r"(?:[A-Z]\w*)?\{?(-?[\d.]+(?:e-?\d+)?)f?\}?", initialiser)
    if number is None and initialiser == "{}" and "number" in kind:
        return "0"
    if number is None:
        return ""
    unit = _form(kind)[1] if kind in ("a temperature", "an amount in K", "a rate") else ""
    return f'"{number[1]} {unit}"' if unit else number[1]


def _find_default(arguments: list[str], kind: str, source: Path) -> str:
    """Returns the default of a call as a TOML value: a literal argument, or the initialiser of a member."""
    if not arguments:
        return ""
    member = re.fullmatch(r"(?:\w+(?:\.|->))+(\w+)", arguments[0])
    if member and re.fullmatch(r"[\d.]+", arguments[0]) is None:
        return _literal(kind, _find_initialiser(source, member[1]))
    return _literal(kind, arguments[0])


def _find_kind(function: str, constant: str, rest: str, position: str) -> str | None:
    if function not in _KINDS:
        raise ValueError(f"{position}: unknown reading function {function}; add it to _KINDS in docs/site/keys.py")
    kind = _KINDS[function]
    if kind != "one of":
        return kind
    if function.startswith("one_of") or function == "read_link_keyword":
        terms = _find_terms(constant) + (["default"] if function in ("read_link_keyword", "one_of_or_default") else [])
    else:
        braces = re.match(r", \{([^}]*)\}", rest)
        terms = re.findall(r'"([^"]+)"', braces[1] if braces else rest.split(")")[0])
    if not terms:
        return "a text"
    return "one of " + ", ".join(f"`{term}`" for term in terms)


def _is_guarded(key: str, before: str, function: str) -> bool:
    """Returns whether a key is read under a condition. `before` is the part of the line before the key, `function` the
    part of the function above the line."""
    return re.match(r"\s*(if|else|case)\b", before) is not None or _is_chosen(before) or f'has("{key}")' in function


def _is_chosen(before: str) -> bool:
    return "?" in re.split("[,;]", before)[-1]


def _is_more_precise(kind: str, known: str) -> bool:
    """Returns whether the kind from another call for the same key contains more information than the known kind."""
    return known == _KINDS["ignore"] or (known == "a text" and kind.startswith(("one of", "a file")))


def read_keys(sources: dict[str, dict[str, list[str]]]) -> list[Key]:
    """Returns all keys that the reading functions in the sources read."""
    keys: dict[tuple[str, str], Key] = {}
    for source, functions in sources.items():
        function, above = "", ""
        lines = _read_text(SOURCE / source).splitlines()
        for number, line in enumerate(lines, 1):
            begins = _FUNCTION.match(line)
            if begins and re.match(r" {0,2}\S", line) and not _STATEMENT.match(line):
                function, above = begins[1], ""
            whole = line + " ".join(following.strip() for following in lines[number : number + 2])
            for call in _CALL.finditer(line):
                for key in _read_call(call, line, whole, function, above, functions, f"{source}:{number}"):
                    known = keys.get((key.table, key.name))
                    if known is None or _is_more_precise(key.kind, known.kind):
                        keys[key.table, key.name] = key
            above += line + "\n"
    return _complete(list(keys.values()))


def _read_call(call: re.Match, line: str, whole: str, function: str, above: str, functions: dict[str, list[str]],
                  position: str) -> list[Key]:  # fmt: skip
    """Returns the keys that one call reads: one for each table of the function that contains the call."""
    name = call[1].split("::")[-1].removeprefix("std::")
    if call[1].startswith(("std::", "fmt::", "drivers::")) or name in ("make_vocabulary", "parse_day"):
        return []
    if not call["key"] and name != "read_range":
        return []
    rest = whole[call.end("key") + 1 :]
    is_given = call["table"] or call["first"]
    name = f"table {name}" if is_given and f"table {name}" in _KINDS else name
    kind = _find_kind(name, call["first"] or "", rest, position)
    if kind is None:
        return []
    before = line[: call.start()]
    owner = re.search(r"(\w+)(?:\.|->)$", before) if not call["table"] else None
    variable = owner[1] if owner else (call["table"] or call["first"] or "").split(".")[0]
    tables = functions.get(f"{function}:{variable}", functions.get(function))
    if tables is None:
        raise ValueError(f"{position}: the table that {function} reads is unknown; add it to docs/site/keys.py")
    source = SOURCE / position.split(":")[0]
    arguments = _arguments(rest)[_ARGUMENTS_BEFORE_DEFAULT.get(name, 0) :]
    if name == "read_range":
        found = [(call["key"] + end, arguments[i : i + 1]) for i, end in enumerate(("lowest", "highest"))]
    else:
        found = [(call["key"], arguments)]
    keys = []
    for one, given in found:
        default = _DEFAULTS.get(name, "" if _is_chosen(before) else _find_default(given, kind, source))
        required = not (given or _is_guarded(one, before, above) or default or name in _OPTIONAL_READERS)
        keys += [Key(table, one, kind, required, default, position) for table in tables]
    return keys


def _complete(keys: list[Key]) -> list[Key]:
    """Corrects `required`: adds keys required by later checks, and makes a table optional if all of its keys are."""
    for key in keys:
        key.required = key.required or key.name in _REQUIRED_LATER.get(key.table, ())
        key.required = key.required and key.name not in _CONDITIONALLY_REQUIRED.get(key.table, ())
    of_table = {table: [key for key in keys if key.table == table] for table in {key.table for key in keys}}
    for key in sorted(keys, key=lambda k: -k.table.count(".")):
        if key.kind == _KINDS["table"] and key.required:
            below = f"{key.table}.{key.name}" if key.table else key.name
            key.required = any(inner.required for inner in of_table.get(below, ()))
    return keys


def read_meanings(name: str) -> dict[str, dict[str, dict[str, str]]]:
    """Reads a file of key_meanings. Returns table → key → fields."""
    with open(MEANINGS / f"{name}.toml", "rb") as file:
        tables = tomllib.load(file)
    return {
        ("" if table == "file" else table): {
            key: {"is": entry} if isinstance(entry, str) else entry for key, entry in entries.items()
        }
        for table, entries in tables.items()
    }


def _merge_fields(tables: dict[str, dict[str, dict[str, str]]], table: str, key: str) -> dict[str, str]:
    """Returns the fields of an entry, completed by those of the entry named in its field "like"."""
    entry = tables.get(table, {}).get(key, {})
    if "like" not in entry:
        return entry
    own = {name: value for name, value in entry.items() if name != "like"}
    return _merge_fields(tables, entry["like"], key) | own


def find_faults(name: str, keys: list[Key], tables: dict[str, dict[str, dict[str, str]]]) -> list[str]:
    """Compares the entries of key_meanings with the keys of the sources. Returns a message for each difference."""
    faults = []
    read = {(key.table, key.name) for key in keys}
    for table, entries in tables.items():
        for key in entries:
            if (table, key) not in read:
                at = f"key_meanings/{name}.toml: [{table or 'file'}] {key}"
                faults.append(f"{at} has a meaning, but no source reads it")
    known = {"is", "unit", "range", "count", "pattern", "example", "default", "required"}
    for key in keys:
        at = f"{key.position}: [{key.table or 'file'}] {key.name}"
        fields = _merge_fields(tables, key.table, key.name)
        if not fields.get("is"):
            faults.append(f"{at} has no meaning in key_meanings/{name}.toml")
            continue
        if unknown := fields.keys() - known:
            faults.append(f"{at}: unknown field {', '.join(sorted(unknown))}")
        if len(fields["is"]) > _MAX_MEANING_LENGTH or fields["is"].endswith("."):
            faults.append(f"{at}: the meaning is longer than {_MAX_MEANING_LENGTH} characters or ends with a period")
        if key.required and "default" in fields:
            faults.append(f"{at} is required and has a default")
        if not key.required and not (key.default or fields.get("default") or fields.get("required")):
            faults.append(f"{at} is optional and has no default")
        if key.default and fields.get("default") == f"`{key.default}`":
            faults.append(f"{at}: the source has the same default")
    return faults


def described_keys(name: str) -> list[Key]:
    """Returns the keys of a kind of file with their meanings, in the order of key_meanings. Fails for any fault."""
    keys, tables = read_keys(FILES[name].sources), read_meanings(name)
    if faults := find_faults(name, keys, tables):
        raise ValueError("\n".join(faults))
    for key in keys:
        fields = dict(_merge_fields(tables, key.table, key.name))
        key.meaning = Meaning(text=fields.pop("is"), condition=fields.pop("required", ""), **fields)
        if key.kind == _KINDS["expect"]:
            key.meaning = replace(key.meaning, range=f'`"{FILES[name].schema}"`')
            key.kind = "a text"
    order = [(table, key) for table, entries in tables.items() for key in entries]
    return sorted(keys, key=lambda key: order.index((key.table, key.name)))


def _title(table: str) -> str:
    if not table:
        return "The file itself"
    bare, _, of = table.partition(" ")
    return f"`[{bare}]`" + (f", {of}" if of else "")


def _chapter(name: str) -> list[str]:
    keys = described_keys(name)
    note = textwrap.fill(FILES[name].note, 120, break_on_hyphens=False, break_long_words=False)
    lines = [f"## {FILES[name].title}", "", note, ""]
    for table in dict.fromkeys(key.table for key in keys):
        lines += [f"### {_title(table)}", "", "| key | meaning | value | default |", "|---|---|---|---|"]
        for key in (key for key in keys if key.table == table):
            cells = [f"`{key.name}`", key.meaning.text, key.value_text(), key.default_text()]
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return lines


_OPENING = """# Keys of the files that people write

`docs/site/keys.py` writes this page from the functions that read the files and from `docs/site/key_meanings`. It lists
every key that these functions read. [Files](../files.md) describes the files, [Import](../importing.md) the keys of a
column map.

- "Required" means that the program refuses a table without the key. A table that is absent needs none of its keys.
- A duration is a text such as `"2 h"`, `"90 s"` or `"1 h 30 min"`. A temperature, a temperature difference and a rate
  are a number in the unit of the column, or a text with the unit, such as `"-40 °C"`.
- A name or path is the name of a shipped file, such as `"watlow_f4t"`, or a path that is relative to the file.
- The program refuses an unknown key and suggests the most similar one.

## Checks and completion in an editor

`docs/reference/schemas` contains a JSON schema (draft 07) of each kind of file: `profile.schema.json`,
`rig.schema.json`, `laboratory.schema.json`, `order.schema.json` and `site.schema.json`. The Debian package installs
them in `/usr/share/gyrotherm/schemas`. Editors with the language server Taplo use them to complete keys, to display the
meaning of a key and to check a file while you type: Visual Studio Code with the extension Even Better TOML, and any
editor that starts `taplo lsp stdio`. There are two ways to assign a schema:

- The first line of a file names the schema of this file:

```toml
#:schema file:///usr/share/gyrotherm/schemas/rig.schema.json
```

- A file `.taplo.toml` in the folder that you open in the editor names the schemas of all files in it:

```toml
[[rule]]
include = ["rigs/*.toml"]
schema = { path = "/usr/share/gyrotherm/schemas/rig.schema.json" }

[[rule]]
include = ["profiles/*.toml"]
schema = { path = "/usr/share/gyrotherm/schemas/profile.schema.json" }
```

A schema does not contain all checks: it does not compare values with each other and does not read other files.
`gyrotherm check` does.

"""


def page() -> str:
    """Returns docs/reference/keys.md."""
    lines = [line for name in FILES for line in _chapter(name)]
    return _OPENING + "\n".join(lines).rstrip() + "\n"


def written_keys(file: dict) -> set[tuple[str, str]]:
    """Returns all pairs (table, key) of a parsed TOML file. The table of a segment is always "segment"."""
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


def main() -> None:
    import key_schemas

    reference = SOURCE / "docs/reference"
    (reference / "keys.md").write_text(page(), encoding="utf-8")
    for name, text in key_schemas.schema_texts().items():
        (reference / "schemas" / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.modules["keys"] = sys.modules["__main__"]  # key_schemas imports this module under its name
    main()
