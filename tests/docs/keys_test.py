#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks docs/reference/keys.md: each key of a shipped file, or of a file in the documents, is on the page, each key has a
meaning, and the page is up to date."""

import re
import sys
import tomllib
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "docs/site"))
sys.path.insert(0, str(Path(__file__).parent))
import keys  # noqa: E402
from markdown import DOCS, blocks_of  # noqa: E402

ELSEWHERE = re.compile(r"^(gyro\.frame|metadata|accept|policy|limits\.channel)")  # explained in other pages
OPENER = re.compile(r"^(of|by|with|without|from|to|as|that|what|which|who|how|why|whether)\b", re.I)


def bare(table: str) -> str:
    return table.split(" ")[0].strip("[]")


def shipped(pattern: str) -> list[Path]:
    return sorted((SOURCE / "profiles").glob(pattern))


def read(path: Path) -> dict:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def files_in_documents(kind: str) -> list[tuple[str, dict]]:
    """Returns the position and the content of each file of a kind in the documents."""
    found = []
    for block in (block for page in sorted(DOCS.rglob("*.md")) for block in blocks_of(page)):
        if block.language == "toml" and f'schema = "gyrotherm-{kind}/1"' in block.lines:
            found.append((block.place, tomllib.loads("\n".join(block.lines))))
    return found


class Keys(unittest.TestCase):
    def check(self, sources, pattern):
        known = {(bare(key.table), key.name) for key in keys.keys_of(sources)}
        files = shipped(pattern)
        self.assertTrue(files)
        for path in files:
            for table, key in keys.written_keys(read(path)):
                if not ELSEWHERE.match(table) and key != "frame":
                    self.assertTrue((table, key) in known, f"{path.name}: [{table}] {key}")
        return known

    def test_profiles(self):
        self.assertGreater(len(self.check(keys.PROFILE, "*.toml")), 25)

    def test_rigs(self):
        self.assertGreater(len(self.check(keys.RIG | keys.VIRTUAL, "rigs/*.toml")), 200)

    def test_files_in_the_documents(self):
        for kind, sources in (("laboratory", keys.LABORATORY), ("order", keys.ORDER), ("site", keys.SITE)):
            known = {(bare(key.table), key.name) for key in keys.keys_of(sources)}
            files = files_in_documents(kind)
            for position, content in files:
                for table, key in keys.written_keys(content):
                    if not re.search(r"^(en|de)$", key) or table == "statement":
                        self.assertIn((table, key), known, position)
            self.assertGreater(len(files), 1, kind)

    def test_defaults_and_required_keys_are_those_of_the_sources(self):
        absent = {
            (bare(key.table), key.name): "required" if key.required else key.default
            for sources in (keys.PROFILE, keys.RIG, keys.VIRTUAL, keys.SITE)
            for key in keys.keys_of(sources)
        }
        for position, expected in (
            (("virtual.thermometers", "noise_k"), "required"),  # the last argument is a lower bound
            (("virtual.thermometers", "gain"), "0"),
            (("virtual.thermal.side_wind", "steady"), "required"),
            (("virtual.thermal.power_growth", "gain_per_k"), "0"),
            (("virtual.bias", "mirror_deg_per_h_per_k"), "required"),  # the last arguments are count and lower bound
            (("virtual.bias.growth", "gas_flow"), "required"),  # another table has a key of this name
            (("virtual.gyro.dead_band", "sags_below"), "required"),  # has() follows the reading
            (("analogue_input.channel", "input"), "required"),
            (("gyro", "latitude"), ""),
            (("limits.channel.NAME", "lowest"), ""),
            (("segment", "count"), ""),
            (("safe", "on_stop"), '"safe"'),
            (("virtual", "plant"), "required"),
            (("limits", "channel"), ""),
            (("notify.rule", "free_gb"), "5"),
            (("limits", "suspend_after"), '"5 s"'),  # the initialiser of a member
            (("limits", "thermometers_highest"), '"100 °C"'),
            (("thermometer.sensor", "a_per_k"), "3.9083e-3"),
            (("virtual.gyro", "instability_to_s"), "1e6"),
            (("segment", "least_step"), '"1 K"'),
        ):
            self.assertEqual(absent[position], expected, position)

    def test_a_function_on_one_line_is_found(self):
        self.assertNotIn(("[virtual.value]", "unit"), {(k.table, k.name) for k in keys.keys_of(keys.VIRTUAL)})

    def test_the_page_is_up_to_date(self):
        written = (SOURCE / "docs/reference/keys.md").read_text(encoding="utf-8")
        self.assertTrue(written == keys.page(), "run docs/site/keys.py")

    def test_each_is_documented(self):
        texts = [p.read_text(encoding="utf-8") for p in (SOURCE / "docs").glob("*.md")]
        texts += [p.read_text(encoding="utf-8") for p in (SOURCE / "profiles").rglob("*.toml")]
        texts.append((SOURCE / "sequencer/rig/thermometer_settings.cpp").read_text(encoding="utf-8"))
        whole = "\n".join(texts)
        seen = 0
        for sources in (keys.PROFILE, keys.RIG, keys.VIRTUAL, keys.LABORATORY, keys.ORDER, keys.SITE):
            for key in keys.keys_of(sources):
                in_prose, in_a_file = (
                    rf"`\[*([\w.]+\.)?{key.name}\b",
                    rf"^\s*(# )?{key.name} += |^\[+([\w.]+\.)?{key.name}\]",
                )
                found = re.search(f"{in_prose}|{in_a_file}", whole, re.M)
                self.assertTrue(found, f"{key.position}: {key.name} is not in the documents")
                seen += 1
        self.assertGreater(seen, 300)


class Meanings(unittest.TestCase):
    def test_each_key_has_a_meaning(self):
        seen = 0
        page = (SOURCE / "docs/reference/keys.md").read_text(encoding="utf-8")
        for name in keys.FILES:
            for key in keys.described_keys(name):
                self.assertTrue(f"| `{key.name}` | {key.meaning.text} |" in page, key.position)
                self.assertIsNone(OPENER.match(key.meaning.text), f"{key.name}: {key.meaning.text}")
                seen += 1
        self.assertGreater(seen, 525)

    def test_a_key_without_a_meaning_is_named(self):
        keys_removed = (("profile", "[segment] ramp", "to"), ("rig", "chamber.link", "echo"), ("site", "", "rig"))
        for name, table, key in keys_removed:
            tables = keys.read_meanings(name)
            del tables[table][key]
            faults = keys.faults_of(name, keys.keys_of(keys.FILES[name].sources), tables)
            self.assertTrue(any(f"[{table or 'file'}] {key} has no meaning" in fault for fault in faults), faults)

    def test_a_meaning_without_a_key_is_named(self):
        tables = keys.read_meanings("rig")
        tables["chamber"]["colour"] = {"is": "Colour of the chamber"}
        faults = keys.faults_of("rig", keys.keys_of(keys.RIG), tables)
        self.assertEqual(len(faults), 1, faults)
        self.assertIn("[chamber] colour has a meaning, but no source reads it", faults[0])

    def test_an_optional_key_without_a_default_is_named(self):
        tables = keys.read_meanings("rig")
        del tables["chamber"]["power"]["default"]
        key = next(key for key in keys.keys_of(keys.RIG) if key.name == "power")
        key.default = ""
        faults = keys.faults_of("rig", [k for k in keys.keys_of(keys.RIG) if k.name != "power"] + [key], tables)
        self.assertEqual(len(faults), 1, faults)
        self.assertIn("[chamber] power is optional and has no default", faults[0])


if __name__ == "__main__":
    unittest.main()
