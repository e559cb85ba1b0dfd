#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks one rule of safety at a time and shows that a named test notices.

    tests/mutants/run.py BUILD [PART-OF-A-NAME]
    tests/mutants/run.py --lines               whether what each of them edits is there, once

BUILD is a folder built with Ninja, all tests in it. Each mutant is one edit of one source: it is compiled from a copy
(together with its neighbours where the build compiles several as one), linked in the place of what the build has of it,
and the test that holds the rule must fail; before, the same test must pass unchanged. The test is a law of a test program,
or an attack of tests/edges on gyrotherm itself. For a test program that starts gyrotherm the mutant takes its place.
Exit code 1 if a mutant survives or its line is not there any more.
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
import rules_of_the_edges
import rules_of_trust

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = ("gyrotherm", "gyrotherm-make-safe")  # what an attack is made on, the first by name
STARTER = "app_test"  # starts these programs of the build

# name, source, what it says, what the mutant says, test program (or gyrotherm), test (or attack) that must fail
MUTANTS = (rules_of_a_run.MUTANTS + rules_of_access.MUTANTS + rules_of_the_edges.MUTANTS +
           rules_of_trust.MUTANTS)


def commands(build, target):
    out = subprocess.run(["ninja", "-C", build, "-t", "commands", target], capture_output=True, text=True, check=True)
    return out.stdout.splitlines()


def passes(program, test):
    """Whether the test passes; None if there is no such test."""
    if program.name == PROGRAMS[0]:
        command = [sys.executable, ROOT / "tests/edges/run.py", program, test]
    else:
        command = [program, "--gtest_filter=" + test]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        return False  # a law that never ends is broken too
    if ended.returncode == 0 and "[  PASSED  ] 1 test" not in ended.stdout and "1 attacks: 1 ok" not in ended.stdout:
        return None
    return ended.returncode == 0


def compiled_as_one(unity):
    return [pathlib.Path(source) for source in re.findall(r'#include "(\S+\.cpp)"', unity.read_text())]


class Bench:
    """The compile and link commands of the build, bent to a mutant."""

    def __init__(self, build):
        self.build = pathlib.Path(build).resolve()
        self.links, self.compiles = {}, {}

    def learn(self, program):
        """How the program is linked, and each source of ours that it is made of compiled."""
        if program in self.links:
            return
        lines = commands(self.build, program)
        self.links[program] = lines[-1]
        for line in lines:
            source = re.search(r" -c (\S+)$", line)
            of_target = re.search(r" -o \S*CMakeFiles/([^/\s]+)\.dir/", line)
            if of_target and of_target.group(1) in PROGRAMS and of_target.group(1) != program:
                continue  # is built before it, and no part of it
            path = (self.build / source.group(1)).resolve() if source else self.build
            for one in compiled_as_one(path) if "/Unity/" in str(path) else [path]:
                if source and one.is_relative_to(ROOT):
                    self.compiles[program, str(one.relative_to(ROOT))] = line, path

    def mutate(self, folder, program, source, old, new):
        """The mutant compiled and the program linked with it; None if the source does not say what it should."""
        text = (ROOT / source).read_text()
        if text.count(old) != 1:
            return None
        (folder / "mutant.cpp").write_text(text.replace(old, new))
        for name in PROGRAMS if program == PROGRAMS[0] else [program]:
            self.learn(name)
            if program == PROGRAMS[0] and (name, source) not in self.compiles:  # only the other one is made of it
                shutil.copy2(self.build / name, folder)
            else:
                self.link(folder, name, self.compile(folder, source, *self.compiles[name, source]))
        return folder / program

    def compile(self, folder, source, line, compiled):
        """Returns the object that the build has and the one of the mutant."""
        theirs = re.search(r" -o (\S+)", line).group(1)
        ours, text = shlex.quote(str(folder / "mutant.o")), folder / "mutant.cpp"
        if compiled != ROOT / source:
            text = folder / compiled.name
            text.write_text(compiled.read_text().replace(str(ROOT / source), str(folder / "mutant.cpp")))
        line = re.sub(r" -o \S+", " -o " + ours, line)
        line = re.sub(r" -MF \S+", " -MF " + shlex.quote(str(folder / "mutant.d")), line)
        line = re.sub(r" -O[0-9]", " -O0", line).replace(" -Werror", "")  # a mutant may leave something unused
        line = re.sub(r" -c \S+$", " -c " + shlex.quote(str(text)), line)
        subprocess.run(line, shell=True, cwd=self.build, check=True, capture_output=True)
        return theirs, ours

    def link(self, folder, program, objects):
        """In the place of the object if the program is linked with it, in front of all libraries if one of them has it."""
        theirs, ours = objects
        line = re.search(r"\S*(?:g\+\+|c\+\+|clang\+\+)\S* .*", self.links[program]).group(0)
        line = line.replace(f" {theirs} ", " ")
        line = re.sub(r" -o (\S+)", f" {ours} -o " + shlex.quote(str(folder / program)), line, count=1)
        line = re.split(r" && ", line)[0]
        subprocess.run(line, shell=True, cwd=self.build, check=True, capture_output=True)


@contextlib.contextmanager
def in_the_place_of_the_build(build, folder):
    """Puts the mutant's programs where a test program starts them, and the build's back afterwards."""
    try:
        for name in PROGRAMS:
            (build / name).rename(build / f"{name}.kept")
            shutil.copy2(folder / name, build / name)
        yield
    finally:
        for name in PROGRAMS:
            if (build / f"{name}.kept").exists():
                (build / f"{name}.kept").replace(build / name)


def verdict(bench, source, old, new, program, test):
    """What becomes of one mutant, in a word."""
    if not passes(bench.build / program, test):
        return "NO LAW"
    with tempfile.TemporaryDirectory() as place:
        try:
            mutated = PROGRAMS[0] if program == STARTER else program
            mutant = bench.mutate(pathlib.Path(place), mutated, source, old, new)
        except subprocess.CalledProcessError as error:
            print(error.stderr.decode()[-400:])
            return "NO BUILD"
        if mutant is None:
            return "NO LINE"
        if program != STARTER:
            return "SURVIVES" if passes(mutant, test) else "caught"
        with in_the_place_of_the_build(bench.build, pathlib.Path(place)):
            return "SURVIVES" if passes(bench.build / program, test) else "caught"


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if sys.argv[1] == "--lines":
        gone = [name for name, source, old, *_ in MUTANTS if (ROOT / source).read_text().count(old) != 1]
        sys.exit("\n".join(f"its line is not there once: {name}" for name in gone) or 0)
    bench = Bench(sys.argv[1])
    chosen = [m for m in MUTANTS if len(sys.argv) < 3 or sys.argv[2] in m[0]]
    if not chosen:
        sys.exit(f"no mutant has {sys.argv[2]} in its name")
    caught = 0
    for name, source, old, new, program, test in chosen:
        found = verdict(bench, source, old, new, program, test)
        caught += found == "caught"
        print(f"{found:<9} {name}: {test}", flush=True)
    print(f"{caught} of {len(chosen)} mutants caught")
    sys.exit(caught != len(chosen))


if __name__ == "__main__":
    main()
