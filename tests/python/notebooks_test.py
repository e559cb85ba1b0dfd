# SPDX-License-Identifier: Apache-2.0
"""The notebooks run completely on records that the program makes, and are stored without outputs."""

import os
import unittest

from program import HERE, SOURCE, FolderTest, gyrotherm, need, record

need("matplotlib", "sklearn", "nbconvert", "nbformat", "ipykernel")

import nbformat  # noqa: E402
from nbconvert.preprocessors import ExecutePreprocessor  # noqa: E402

NOTEBOOKS = SOURCE / "python" / "notebooks"


class Notebooks(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        os.environ.update(PYTHONPATH=str(SOURCE / "python"), PYTHONDONTWRITEBYTECODE="1", MPLBACKEND="Agg",
                          IPYTHONDIR=str(cls.folder / "ipython"))
        record(cls.folder / "ramp.db")
        gyrotherm("run", HERE / "two_cycles.toml", "--rig", "profiles/rigs/virtual.toml", "--days-later", 30, "--out",
                  cls.folder / "random.db", "--quiet")
        gyrotherm("train", cls.folder / "ramp.db", "--method", "ridge-u", "--out", cls.folder / "model.json")

    def executed(self, name):
        """Returns the texts of all cells, joined."""
        notebook = nbformat.read(NOTEBOOKS / name, as_version=4)
        cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
        self.assertFalse([cell.outputs for cell in cells if cell.outputs or cell.execution_count])
        ExecutePreprocessor(timeout=300, kernel_name="python3").preprocess(
            notebook, {"metadata": {"path": str(self.folder)}})
        outputs = [output for cell in cells for output in cell.outputs]
        return "\n".join(output.get("text", "") or output["data"].get("text/plain", "") for output in outputs)

    def test_notebook_of_run(self):
        text = self.executed("look_at_a_run.ipynb")
        self.assertIn("SIMULATED", text)
        self.assertIn("hold 20 °C", text)
        self.assertRegex(text, r"[A-H]-[A-H]")

    def test_notebook_of_scikit_learn(self):
        text = self.executed("scikit_learn_on_our_folds.ipynb")
        for row in ("ridge (scikit-learn)", "kernel ridge (scikit-learn)", "ridge-u (gyrotherm)", "nothing"):
            self.assertIn(row, text)

    def test_covers_all_notebooks(self):
        self.assertEqual(sorted(path.name for path in NOTEBOOKS.iterdir()),
                         ["look_at_a_run.ipynb", "scikit_learn_on_our_folds.ipynb"])


if __name__ == "__main__":
    unittest.main()
