#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of keys is whole: each key of a shipped profile or rig is on it, and each key on it is said
somewhere in the documents or in a shipped file."""

import re
import sys
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "docs/site"))
import keys  # noqa: E402

ELSEWHERE = re.compile(r"^(gyro\.frame|metadata|accept|policy|limits\.channel)")  # explained in other pages


def bare(table: str) -> str:
    return table.split(" ")[0].strip("[]")


class Keys(unittest.TestCase):
    def check(self, sources, pattern):
        known = {(bare(key.table), key.name) for key in keys.keys_of(sources)}
        shipped = sorted((SOURCE / "profiles").glob(pattern))
        self.assertTrue(shipped)
        for path in shipped:
            for table, key in keys.written_keys(path):
                if not ELSEWHERE.match(table) and key != "frame":
                    self.assertTrue((table, key) in known, f"{path.name}: [{table}] {key}")
        return known

    def test_profiles(self):
        self.assertGreater(len(self.check(keys.PROFILE, "*.toml")), 25)

    def test_rigs(self):
        self.assertGreater(len(self.check(keys.RIG | keys.VIRTUAL, "rigs/*.toml")), 200)

    def test_the_page_is_up_to_date(self):
        written = (SOURCE / "docs/reference/keys.md").read_text(encoding="utf-8")
        self.assertTrue(written == keys.page(), "docs/site/keys.py writes it anew")

    def test_each_is_documented(self):
        texts = [p.read_text(encoding="utf-8") for p in (SOURCE / "docs").glob("*.md")]
        texts += [p.read_text(encoding="utf-8") for p in (SOURCE / "profiles").rglob("*.toml")]
        texts.append((SOURCE / "rig/thermometer_settings.cpp").read_text(encoding="utf-8"))
        whole = "\n".join(texts)
        for sources in (keys.PROFILE, keys.RIG, keys.VIRTUAL):
            for key in keys.keys_of(sources):
                in_prose, in_a_file = (
                    rf"`\[*([\w.]+\.)?{key.name}\b",
                    rf"^\s*(# )?{key.name} += |^\[+([\w.]+\.)?{key.name}\]",
                )
                said = re.search(f"{in_prose}|{in_a_file}", whole, re.M)
                self.assertTrue(said, f"{key.place}: {key.name} is said nowhere")


if __name__ == "__main__":
    unittest.main()
