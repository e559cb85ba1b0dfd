#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the page of keys is complete.

Each key of a shipped profile or rig, and of a file in the documents, must be on the page. Each key on the page must
occur in the documents or in a shipped file."""

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


def bare(table: str) -> str:
    return table.split(" ")[0].strip("[]")


class Keys(unittest.TestCase):
    def check(self, sources, pattern):
        known = {(bare(key.table), key.name) for key in keys.keys_of(sources)}
        shipped = sorted((SOURCE / "profiles").glob(pattern))
        self.assertTrue(shipped)
        for path in shipped:
            for table, key in keys.written_keys(tomllib.loads(path.read_text(encoding="utf-8"))):
                if not ELSEWHERE.match(table) and key != "frame":
                    self.assertTrue((table, key) in known, f"{path.name}: [{table}] {key}")
        return known

    def test_profiles(self):
        self.assertGreater(len(self.check(keys.PROFILE, "*.toml")), 25)

    def test_rigs(self):
        self.assertGreater(len(self.check(keys.RIG | keys.VIRTUAL, "rigs/*.toml")), 200)

    def test_files_in_the_documents(self):
        for schema, sources in (("laboratory", keys.LABORATORY), ("order", keys.ORDER), ("site", keys.SITE)):
            known = {(bare(key.table), key.name) for key in keys.keys_of(sources)}
            files = 0
            for block in (block for page in DOCS.rglob("*.md") for block in blocks_of(page) if block.language == "toml"):
                if f'schema = "gyrotherm-{schema}/1"' in block.lines:
                    files += 1
                    for table, key in keys.written_keys(tomllib.loads("\n".join(block.lines))):
                        if not re.search(r"^(en|de)$", key) or table == "statement":
                            self.assertIn((table, key), known, block.place)
            self.assertGreater(files, 1, schema)

    def test_defaults_and_required_keys(self):
        absent = {
            (bare(key.table), key.name): "a mistake" if key.required else key.default
            for sources in (keys.PROFILE, keys.RIG, keys.VIRTUAL, keys.SITE)
            for key in keys.keys_of(sources)
        }
        for place, said in (
            (("virtual.thermometers", "noise_k"), "a mistake"),  # followed by its minimum
            (("virtual.thermometers", "gain"), "0"),
            (("virtual.thermal.side_wind", "steady"), "a mistake"),
            (("virtual.thermal.power_growth", "gain_per_k"), "0"),
            (("virtual.bias", "mirror_deg_per_h_per_k"), "a mistake"),  # list of a fixed length
            (("virtual.bias.growth", "gas_flow"), "a mistake"),  # key of another table too
            (("virtual.gyro.dead_band", "sags_below"), "a mistake"),  # checked after reading
            (("analogue_input.channel", "input"), "a mistake"),
            (("gyro", "latitude"), ""),
            (("limits.channel.NAME", "lowest"), ""),
            (("segment", "count"), ""),
            (("safe", "on_stop"), '"safe"'),
            (("virtual", "plant"), "a mistake"),
            (("limits", "channel"), ""),
            (("notify.rule", "free_gb"), "5"),
        ):
            self.assertEqual(absent[place], said, place)

    def test_the_page_is_up_to_date(self):
        written = (SOURCE / "docs/reference/keys.md").read_text(encoding="utf-8")
        self.assertTrue(written == keys.page(), "docs/site/keys.py writes it anew")

    def test_each_key_is_documented(self):
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
                said = re.search(f"{in_prose}|{in_a_file}", whole, re.M)
                self.assertTrue(said, f"{key.place}: {key.name} is said nowhere")
                seen += 1
        self.assertGreater(seen, 300)


if __name__ == "__main__":
    unittest.main()
