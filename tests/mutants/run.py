#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks one safety rule at a time and checks that a named test fails.

    tests/mutants/run.py BUILD [PART-OF-A-NAME]
    tests/mutants/run.py --lines               checks that the text that each mutant edits occurs exactly once, and that
                                               its test exists

BUILD is a folder built with Ninja, including all tests. A mutant is one edit of one source. It is compiled from a copy
(in a unity build together with the other sources of the unit) and linked instead of the original object. The named test
must pass without the mutant and fail with it. The test belongs to a test program, or is an attack of tests/edges on
gyrotherm. If the test program starts gyrotherm, the mutant replaces gyrotherm in the build folder.
Exits with 1 if a mutant survives or its text is missing.
"""
import contextlib
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import rules_of_a_run
import rules_of_access
import rules_of_self_ending_runs
import rules_of_the_edges
import rules_of_trust

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = ("gyrotherm", "gyrotherm-make-safe")  # attacked programs; an attack is given the path of the first
STARTER = "app_test"  # test program that starts these programs

# name, source, original text, replacement, test program (or gyrotherm), test (or attack) that must fail
MUTANTS = (rules_of_a_run.MUTANTS + rules_of_access.MUTANTS + rules_of_self_ending_runs.MUTANTS +
           rules_of_the_edges.MUTANTS + rules_of_trust.MUTANTS)


def commands(build, target):
    out = subprocess.run(["ninja", "-C", build, "-t", "commands", target], capture_output=True, text=True, check=True)
    return out.stdout.splitlines()


def passes(program, test):
    """Returns whether the test passes; None if there is no such test."""
    if program.name == PROGRAMS[0]:
        command = [sys.executable, ROOT / "tests/edges/run.py", program, test]
    else:
        command = [program, "--gtest_filter=" + test]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        return False  # a test that hangs has failed
    if ended.returncode == 0 and "[  PASSED  ] 1 test" not in ended.stdout and "1 attacks: 1 ok" not in ended.stdout:
        return None
    return ended.returncode == 0


def unity_sources(unity):
    return [pathlib.Path(source) for source in re.findall(r'#include "(\S+\.cpp)"', unity.read_text())]


class MutantBuild:
    """Compiles and links mutants with modified commands of the build."""

    def __init__(self, build):
        self.build = pathlib.Path(build).resolve()
        self.links, self.compiles = {}, {}

    def read_commands(self, program):
        """Reads the commands that link the program and compile its sources."""
        if program in self.links:
            return
        lines = commands(self.build, program)
        self.links[program] = lines[-1]
        for line in lines:
            source = re.search(r" -c (\S+)$", line)
            target = re.search(r" -o \S*CMakeFiles/([^/\s]+)\.dir/", line)
            if target and target.group(1) in PROGRAMS and target.group(1) != program:
                continue  # another program, built before this one
            path = (self.build / source.group(1)).resolve() if source else self.build
            for one in unity_sources(path) if "/Unity/" in str(path) else [path]:
                if source and one.is_relative_to(ROOT):
                    self.compiles[program, str(one.relative_to(ROOT))] = line, path

    def mutate(self, folder, program, source, old, new):
        """Compiles the mutant and links the program. Returns its path, or None if `old` does not occur exactly once."""
        text = (ROOT / source).read_text()
        if text.count(old) != 1:
            return None
        (folder / "mutant.cpp").write_text(text.replace(old, new))
        for name in PROGRAMS if program == PROGRAMS[0] else [program]:
            self.read_commands(name)
            if program == PROGRAMS[0] and (name, source) not in self.compiles:  # only the other program contains it
                shutil.copy2(self.build / name, folder)
            else:
                self.link(folder, name, self.compile(folder, source, *self.compiles[name, source]))
        return folder / program

    def compile(self, folder, source, line, compiled):
        """Compiles the mutant. Returns the object of the build and the object of the mutant."""
        original = re.search(r" -o (\S+)", line).group(1)
        mutated_object, text = shlex.quote(str(folder / "mutant.o")), folder / "mutant.cpp"
        if compiled != ROOT / source:
            text = folder / compiled.name
            text.write_text(compiled.read_text().replace(str(ROOT / source), str(folder / "mutant.cpp")))
        line = re.sub(r" -o \S+", " -o " + mutated_object, line)
        line = re.sub(r" -MF \S+", " -MF " + shlex.quote(str(folder / "mutant.d")), line)
        if "-include-pch" not in line:  # Clang takes a compiled header only with its own optimisation
            line = re.sub(r" -O[0-9]", " -O0", line)
        line = line.replace(" -Werror", "")  # a mutant may leave unused variables
        line = re.sub(r" -c \S+$", " -c " + shlex.quote(str(text)), line)
        subprocess.run(line, shell=True, cwd=self.build, check=True, capture_output=True)
        return original, mutated_object

    def link(self, folder, program, objects):
        """Links the mutant. Replaces the object, or precedes all libraries if the object is in one of them."""
        original, mutated_object = objects
        line = re.search(r"\S*(?:g\+\+|c\+\+|clang\+\+)\S* .*", self.links[program]).group(0)
        line = line.replace(f" {original} ", " ")
        line = re.sub(r" -o (\S+)", f" {mutated_object} -o " + shlex.quote(str(folder / program)), line, count=1)
        line = re.split(r" && ", line)[0]
        subprocess.run(line, shell=True, cwd=self.build, check=True, capture_output=True)


@contextlib.contextmanager
def installed_mutant(build, folder):
    """Installs the mutant's programs in the build folder, and restores the originals afterwards."""
    try:
        for name in PROGRAMS:
            (build / name).rename(build / f"{name}.kept")
            shutil.copy2(folder / name, build / name)
        yield
    finally:
        for name in PROGRAMS:
            if (build / f"{name}.kept").exists():
                (build / f"{name}.kept").replace(build / name)


def test_mutant(mutant_build, source, old, new, program, test):
    """Tests one mutant. Returns "caught", "SURVIVES", or the reason why it cannot be tested."""
    if not passes(mutant_build.build / program, test):
        return "NO TEST"
    with tempfile.TemporaryDirectory() as folder:
        try:
            mutated = PROGRAMS[0] if program == STARTER else program
            mutant = mutant_build.mutate(pathlib.Path(folder), mutated, source, old, new)
        except subprocess.CalledProcessError as error:
            print(error.stderr.decode()[-400:])
            return "NO BUILD"
        if mutant is None:
            return "NO TEXT"
        if program != STARTER:
            return "SURVIVES" if passes(mutant, test) else "caught"
        with installed_mutant(mutant_build.build, pathlib.Path(folder)):
            return "SURVIVES" if passes(mutant_build.build / program, test) else "caught"


def unknown_tests():
    """Returns the mutants whose test is in no source below tests."""
    sources = "".join(path.read_text() for path in sorted((ROOT / "tests").rglob("*.cpp")))
    known = {f"{suite}.{name}" for suite, name in re.findall(r"TEST(?:_F|_P)?\((\w+), (\w+)\)", sources)}
    return [name for name, _, _, _, program, test in MUTANTS
            if program not in PROGRAMS and "/".join(re.findall(r"\w*[A-Za-z]\w*\.\w+", test)) not in known]


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if sys.argv[1] == "--lines":
        gone = [name for name, source, old, *_ in MUTANTS if (ROOT / source).read_text().count(old) != 1]
        wrong = [f"text to edit does not occur exactly once: {name}" for name in gone]
        wrong += [f"no such test: {name}" for name in unknown_tests()]
        sys.exit("\n".join(wrong) or 0)
    mutant_build = MutantBuild(sys.argv[1])
    chosen = [m for m in MUTANTS if len(sys.argv) < 3 or sys.argv[2] in m[0]]
    if not chosen:
        sys.exit(f"no mutant has {sys.argv[2]} in its name; see tests/mutants/rules_of_*.py")
    caught = 0
    for name, source, old, new, program, test in chosen:
        found = test_mutant(mutant_build, source, old, new, program, test)
        caught += found == "caught"
        print(f"{found:<9} {name}: {test}", flush=True)
    print(f"{caught} of {len(chosen)} mutants caught")
    sys.exit(caught != len(chosen))


if __name__ == "__main__":
    main()
