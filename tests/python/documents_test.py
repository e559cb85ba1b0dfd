# SPDX-License-Identifier: Apache-2.0
"""The examples in the docstrings of the module and in docs/python.md are correct."""

import doctest
import importlib
import os
import pkgutil
import re
import unittest

from program import HERE, SOURCE, FolderTest, gyrotherm, record

import gyrotherm as module

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


class Documents(FolderTest):
    def test_examples_of_the_module(self):
        attempted = 0
        for name in (found.name for found in pkgutil.iter_modules(module.__path__)):
            result = doctest.testmod(importlib.import_module(f"gyrotherm.{name}"), optionflags=FLAGS)
            self.assertEqual(result.failed, 0, name)
            attempted += result.attempted
        self.assertGreater(attempted, 10)

    def test_examples_of_the_guide(self):
        """Works in a folder with ramp.db, random.db and model.json, as after `qualify`."""
        record(self.folder / "ramp.db")
        gyrotherm("run", HERE / "two_cycles.toml", "--rig", "profiles/rigs/virtual.toml", "--days-later", 30, "--out",
                  self.folder / "random.db", "--quiet")
        gyrotherm("train", self.folder / "ramp.db", "--method", "ridge-u", "--out", self.folder / "model.json")
        text = (SOURCE / "docs/python.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
        self.assertGreater(len(blocks), 3)
        for block in blocks:
            self.assertTrue(block.startswith(">>> "), f"shows no output:\n{block}")
        test = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, "docs/python.md", None, 0)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)
        self.assertEqual(doctest.DocTestRunner(optionflags=FLAGS).run(test).failed, 0)


if __name__ == "__main__":
    unittest.main()
