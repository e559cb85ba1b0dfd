#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks references in the documents: documents_test.py PROGRAMS.

Links and their anchors, files in code font, figures with their source, and commands and options in blocks that no test
runs must exist. Each block must name its language."""

import re
import subprocess
import sys
import unittest
from functools import cache
from pathlib import Path

sys.dont_write_bytecode = True
from markdown import DOCS, SOURCE, read_blocks, read_commands, read_prose  # noqa: E402

PROGRAMS = Path(sys.argv.pop(1)).resolve()
COMMANDS_WITH_SUBCOMMANDS = {"gyrotherm-monitor": {"user", "token"}}
LANGUAGES = {"console", "sh", "text", "toml", "python", "ini", "c", "json", "yaml"}
FOLLOWED = ("adding-an-instrument.md", "mistakes.md")  # besides the tutorials and how-tos
FOLDERS = ("*.md", "docs/**/*.md", "bench/*.md", "profiles/**/*.md")
PAGES = sorted(page for folder in FOLDERS for page in SOURCE.glob(folder))
MANUAL = [page for page in PAGES if DOCS in page.parents]
SOURCES = (".md", ".toml", ".cpp", ".hpp", ".py", ".txt", ".yml", ".json", ".rules")
_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*[a-z]")
_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
_NAMED = re.compile(
    r"`((?:acquisition|analysis|apps|bench|cmake|core|debian|docs|drivers|profiles|python|report|sequencer|simulator"
    r"|tests)/[\w./-]*\w)`"
)
_INVENTED = re.compile(r"acme|NAME|^report/\w+\.json$")  # invented names, and files that a run leaves


def find_anchors(page: Path) -> set[str]:
    found = set()
    for _, line in read_prose(page):
        if heading := re.match(r"#+ (.*)", line):
            found.add(re.sub(r"[^\w\- ]", "", heading[1].lower()).strip().replace(" ", "-"))
    return found


def format_position(page: Path, line: int) -> str:
    return f"{page.relative_to(SOURCE)}:{line}"


@cache
def read_help(program: str, *words: str) -> str:
    return subprocess.run([PROGRAMS / program, *words, "--help"], capture_output=True, text=True, check=False).stdout


@cache
def commands() -> set[str]:
    return set(re.findall(r"^  ([a-z-]+) ", read_help("gyrotherm").split("Subcommands:")[-1], re.M))


class Documents(unittest.TestCase):
    def test_links_resolve(self):
        links = 0
        for page in PAGES:
            for line, text in read_prose(page):
                for figure, words, target in _LINK.findall(text):
                    links += 1
                    at = format_position(page, line)
                    self.assertFalse(figure and not words, f"{at}: the figure has no alternative text")
                    if re.match(r"[a-z]+:", target):
                        self.assertTrue(target.startswith(("https://", "mailto:")), f"{at}: {target}")
                        continue
                    path, _, anchor = target.partition("#")
                    destination = (page.parent / path).resolve() if path else page
                    self.assertTrue(destination.exists(), f"{at}: {target} does not exist")
                    if anchor:
                        self.assertIn(anchor, find_anchors(destination), f"{at}: {target}")
        self.assertGreater(links, 50)

    def test_files_in_code_font_exist(self):
        seen = 0
        for page in PAGES:
            for line, text in read_prose(page):
                for name in _NAMED.findall(text):
                    if name.endswith(SOURCES) and not _INVENTED.search(name):
                        seen += 1
                        self.assertTrue((SOURCE / name).exists(), f"{format_position(page, line)}: {name} does not exist")
        self.assertGreater(seen, 150)

    def test_blocks_name_their_language(self):
        """Sessions may only occur on pages that follow.py runs."""
        sessions = 0
        for page in MANUAL:
            for block in read_blocks(page):
                self.assertIn(block.language, LANGUAGES, block.position)
                if block.language == "console":
                    self.assertTrue(page.parent.name in ("tutorial", "how-to") or page.name in FOLLOWED, block.position)
                    self.assertTrue(read_commands(block), block.position)
                    sessions += 1
        self.assertGreater(sessions, 20)

    def test_commands_and_options_exist(self):
        seen = 0
        for page in PAGES:
            shown = [line for block in read_blocks(page) if block.language == "sh" for line in block.lines]
            sessions = [b for b in read_blocks(page) if b.language == "console" and "fails" not in b.words]
            shown += [command.text for session in sessions for command in read_commands(session)]
            whole = "\n".join(shown).replace("\\\n", " ")
            for line in re.split(r"\n|[|;&] |\bdo |#", whole):
                called = re.match(r"(?:sudo -u [\w-]+ )?(gyrotherm(?:-[a-z]+)*) +([a-z-]+)(.*)", line)
                known_by = COMMANDS_WITH_SUBCOMMANDS.get(called[1], commands()) if called else set()
                if not called or not (PROGRAMS / called[1]).exists() or called[2] not in known_by:
                    continue
                words = [called[2]]
                if called[1] in COMMANDS_WITH_SUBCOMMANDS and (below := re.match(r" ([a-z-]+)", called[3])):
                    words.append(below[1])
                if called[2] in ("new", "site") and (below := re.match(r" ([a-z-]+)", called[3])):
                    words.append(below[1])
                if called[2] == "standard" and called[3].startswith(" explain"):
                    words.append("explain")
                if called[2] == "report" and (below := re.match(r" (sign|verify|compare|authorise)\b", called[3])):
                    words.append(below[1])
                known = set(_OPTION.findall(read_help(called[1], *words)))
                self.assertTrue(known, line)
                own = called[3].split(" -- ")[0]  # after "--": another command
                for option in _OPTION.findall(own):
                    seen += 1
                    self.assertIn(option, known, f"{page.relative_to(SOURCE)}: {line}")
        self.assertGreater(seen, 60)

    def test_each_figure_has_its_source(self):
        table = (DOCS / "figures/README.md").read_text(encoding="utf-8")
        listed = set(re.findall(r"^\| `([\w.-]+)` \|", table, re.M))
        existing = {f.name for f in (DOCS / "figures").iterdir() if f.suffix in (".svg", ".png")}
        self.assertEqual(listed, existing)
        self.assertGreater(len(existing), 3)

    def test_index_lists_each_page(self):
        index = (DOCS / "index.md").read_text(encoding="utf-8")
        pages = [*DOCS.glob("*.md"), *DOCS.glob("tutorial/*.md"), *DOCS.glob("how-to/*.md")]
        self.assertGreater(len(pages), 30)
        for page in pages:
            if page.name != "index.md":
                self.assertIn(f"({page.relative_to(DOCS)})", index)

    def test_each_module_has_an_owner(self):
        text = (SOURCE / ".github/CODEOWNERS").read_text(encoding="utf-8")
        rules = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
        for path, *owners in rules:
            self.assertTrue(path == "*" or (SOURCE / path.strip("/")).exists(), f"{path} does not exist")
            self.assertTrue(owners and all(owner.startswith("@") for owner in owners), path)
        lists = (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8")
        modules = re.search(r"^foreach\(folder ([a-z ]+)\)$", lists, re.M)[1].split()
        self.assertEqual(len(modules), 8)
        self.assertLessEqual({f"/{module}/" for module in modules}, {rule[0] for rule in rules})


if __name__ == "__main__":
    unittest.main()
