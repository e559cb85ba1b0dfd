# SPDX-License-Identifier: Apache-2.0
"""A record of 102 h becomes a Dataset within 2 s of processor time."""

import time
import unittest

from program import FolderTest, record

import gyrotherm as module

SECONDS = 102 * 3600
PROFILE = """schema = "gyrotherm-profile/1"
name = "long"
title = "102 h between 0 and 20 °C"
[[segment]]
kind = "hold"
at = "20 °C"
time = "2 h"
[[segment]]
kind = "repeat"
count = 25
""" + "".join(f"""[[segment.segment]]
kind = "ramp"
to = "{to} °C"
rate = "1 °C/min"
[[segment.segment]]
kind = "hold"
time = "100 min"
""" for to in (0, 20))


class LongRecord(FolderTest):
    def test_is_a_dataset_in_two_seconds(self):
        (self.folder / "long.toml").write_text(PROFILE, encoding="utf-8")
        path = record(self.folder / "long.db", profile=self.folder / "long.toml")
        begun = time.process_time()
        dataset = module.open(path).to_xarray()
        took = time.process_time() - begun
        print(f"{SECONDS} s, {len(dataset)} variables: {took:.2f} s of processor time")
        self.assertEqual(dataset.sizes["time_s"], SECONDS)
        self.assertLess(took, 2)


if __name__ == "__main__":
    unittest.main()
