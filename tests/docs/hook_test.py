#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests .githooks/commit-msg on good and bad subjects, and in a new repository if git is installed."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
HOOK = SOURCE / ".githooks/commit-msg"

GOOD = (
    "verify: share the parameter count between callers",
    "Word comments plainly",
    "report, core: keep the house rules for words and lines",
    "safe sequence: report an acknowledged command as sent",
    "foreign_set_point: see a program that refuses",
    "CMakeLists.txt: embed the page",
    "interlocks: drop an overload that nothing calls",
    "gyro: feed the decoder one byte at a time",
    "line: string frames together",
    "process: pass the environment on",
    "records: address each part by its number",
    "import: re-read a table that has changed",
    "site: focus the first question of the page",
    "tests: name what is not a reading of the chamber…",
    "budget: add " + "u" * (60 - len("budget: add ")),
    "budget: add " + "µ" * (60 - len("budget: add ")),  # characters count, not bytes
)

BY_GIT = (
    "Merge branch 'drivers' of https://example.org/a-very-long-address/gyrotherm.git into main",
    'Revert "layout: move the sources into eight modules and everything that belongs to them"',
    'Reapply "What is asked once is asked in one place."',
    "fixup! What is asked once is asked in one place.",
    "squash! added things",
    "amend! added things",
)

# subject: part of the reported cause
BAD = {
    "budget: add " + "u" * (61 - len("budget: add ")): "61 characters",
    "verify: share the parameter count.": "period",
    "verify: added a parameter count": "past tense",
    "verify: adds a parameter count": "third person",
    "verify: adding a parameter count": "participle",
    "Tests for the parameter count": "plural",
    "the parameter count is shared": "not a verb",
    "What is asked once is asked in one place": "not a verb",
    "New interlock for frozen thermometers": "not a verb",
    "WIP": "not a verb",
    "Text is wrapped": "statement",
    "feat(verify): share the parameter count": "does not begin with a word",
    "0.2.0": "does not begin with a word",
    "verify: `count` is shared": "does not begin with a word",
}


def run_hook(message: str) -> subprocess.CompletedProcess:
    with tempfile.TemporaryDirectory(prefix="gyrotherm-hook-") as folder:
        file = Path(folder) / "COMMIT_EDITMSG"
        file.write_text(message, encoding="utf-8")
        return subprocess.run([sys.executable, HOOK, file], capture_output=True, text=True, check=False)


class CommitMessage(unittest.TestCase):
    def expect_passed(self, message: str) -> None:
        result = run_hook(message)
        self.assertEqual((result.returncode, result.stderr), (0, ""), message)

    def expect_refused(self, message: str, cause: str) -> None:
        result = run_hook(message)
        self.assertEqual(result.returncode, 1, message)
        first = result.stderr.splitlines()[0]
        self.assertTrue(first.startswith("commit-msg: "), first)
        self.assertIn(cause, first)
        self.assertIn("A good subject:", result.stderr)

    def test_hook_is_executable(self):
        self.assertTrue(os.access(HOOK, os.X_OK), f"chmod +x {HOOK}")

    def test_good_subjects_pass(self):
        for subject in GOOD:
            self.expect_passed(subject + "\n")
            self.expect_passed(subject + "\n\nThe body gives the reason. It may be long.\n")

    def test_subjects_that_git_writes_pass(self):
        for subject in BY_GIT:
            self.expect_passed(subject + "\n")

    def test_bad_subjects_are_refused_with_their_cause(self):
        for subject, cause in BAD.items():
            self.expect_refused(subject + "\n", cause)

    def test_each_cause_is_printed(self):
        result = run_hook("added a great many things that one subject can hardly hold at all.\n")
        self.assertEqual(result.stderr.count("commit-msg: "), 3, result.stderr)

    def test_a_body_follows_an_empty_line(self):
        self.expect_refused("verify: share the count\nIt was computed twice.\n", "second line")

    def test_comments_and_what_follows_the_scissors_are_ignored(self):
        self.expect_passed(
            "# Please enter the commit message.\n\nverify: share the count\n# On branch main\n"
            "# ------------------------ >8 ------------------------\ndiff --git a/a b/a\n"
        )
        self.expect_passed("# Nothing but comments: git refuses an empty message itself.\n")

    @unittest.skipUnless(shutil.which("git"), "git is not installed")
    def test_git_refuses_a_commit_with_a_bad_subject(self):
        with tempfile.TemporaryDirectory(prefix="gyrotherm-hook-") as folder:
            environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
            environment |= {"HOME": folder, "GIT_CONFIG_NOSYSTEM": "1"}

            def git(*words: str) -> int:
                settings = ["-c", f"core.hooksPath={HOOK.parent}", "-c", "user.name=A", "-c", "user.email=a@example.org"]
                called = ["git", *settings, *words]
                return subprocess.run(called, cwd=folder, env=environment, capture_output=True, check=False).returncode

            self.assertEqual(git("init"), 0)
            self.assertEqual(git("commit", "--allow-empty", "-m", "Added nothing."), 1)
            self.assertEqual(git("commit", "--allow-empty", "-m", "tests: add nothing"), 0)


if __name__ == "__main__":
    unittest.main()
