# SPDX-License-Identifier: Apache-2.0
"""Common functions of the tests of python/: run the program and make records. The program's path is the first
argument."""

import importlib
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SKIPPED = 77
SOURCE = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # more threads are slower for small matrices
sys.path.insert(0, str(SOURCE / "python"))


def need(*modules):
    """Skips the test if one of the modules is missing."""
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            print(f"skipped: {error}; this test requires {', '.join(modules)}")
            sys.exit(SKIPPED)


need("numpy", "pandas", "xarray")
PROGRAM = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else Path("gyrotherm")


def gyrotherm(*words, accept=(0,)):
    """Runs the program from the source folder. Returns its output."""
    done = subprocess.run([PROGRAM, *map(str, words)], cwd=SOURCE, capture_output=True, text=True)
    if done.returncode not in accept:
        raise AssertionError(f"gyrotherm {' '.join(map(str, words))}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def start(*words, out):
    """Starts the program and leaves it running. Its output goes to a file."""
    with open(out, "wb") as printed:
        return subprocess.Popen([PROGRAM, *map(str, words)], cwd=SOURCE, stdout=printed, stderr=subprocess.DEVNULL)


_masters = {}
_folder_of_masters = tempfile.TemporaryDirectory(prefix="gyrotherm-python-")


def record(path, rig="virtual", profile=HERE / "two_cycles.toml"):
    """Makes the record of a profile at the path, by default of two short cycles. Each profile is run only once."""
    if (rig, profile) not in _masters:
        master = Path(_folder_of_masters.name) / f"{len(_masters)}.db"
        gyrotherm("run", profile, "--rig", f"profiles/rigs/{rig}.toml", "--out", master, "--quiet")
        _masters[rig, profile] = master
    shutil.copy(_masters[rig, profile], path)
    return path


class FolderTest(unittest.TestCase):
    """Tests of a class that share a temporary folder."""

    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory(prefix="gyrotherm-python-")
        cls.addClassCleanup(cls._folder.cleanup)
        cls.folder = Path(cls._folder.name)

    def files(self):
        """Returns all files of the folder, with their sizes and times."""
        return {p: (p.stat().st_size, p.stat().st_mtime_ns) for p in sorted(self.folder.rglob("*"))}
