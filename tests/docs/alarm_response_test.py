#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks docs/alarm-response.md: each interlock of the program has one row with the priority of its default reaction,
a cause, a consequence, a response and a time, and no row describes an alarm that does not exist."""

import re
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
PRIORITY = {"abort": "high", "hold": "medium", "suspend": "medium", "warn": "low"}
COLUMNS = 6
TIME = re.compile(r"^(at once|before the next run|end of the (soak|run)|\d+ (min|h))$")


def interlocks() -> dict[str, str]:
    """Returns the default reaction of each interlock."""
    text = (SOURCE / "sequencer/interlocks/interlocks.cpp").read_text()
    return dict(re.findall(r'\.name = "([a-z_]+)",\s*\.usual = Reaction::([a-z]+)', text))


def rows() -> list[list[str]]:
    """Returns the rows of the first table of the page."""
    lines = (SOURCE / "docs/alarm-response.md").read_text().split("\n## ")[0].splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| `")]
    return [[cell[0].strip("`"), *cell[1:]] for cell in cells]


class AlarmResponses(unittest.TestCase):
    def test_each_interlock_has_one_row(self):
        self.assertGreater(len(interlocks()), 40)
        names = [row[0] for row in rows()]
        self.assertEqual(sorted(set(names)), sorted(names))
        self.assertEqual(set(interlocks()) - set(names), set())

    def test_other_rows_are_alarms_of_the_program(self):
        program = "".join(path.read_text() for folder in ("sequencer", "acquisition") for path in
                          (SOURCE / folder).rglob("*.[ch]pp"))
        for row in rows():
            self.assertTrue(f'"{row[0]}"' in program, row[0])

    def test_priority_follows_the_default_reaction(self):
        for name, reaction in interlocks().items():
            row = next(row for row in rows() if row[0] == name)
            self.assertEqual(row[1], PRIORITY[reaction], name)

    def test_rows_are_complete(self):
        for row in rows():
            self.assertEqual(len(row), COLUMNS, row[0])
            self.assertTrue(all(row), row[0])
            self.assertRegex(row[-1], TIME)


if __name__ == "__main__":
    unittest.main()
