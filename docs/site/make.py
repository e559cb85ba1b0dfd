#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the site of the manual: make.py --pages FOLDER_OF_MANUAL_PAGES --out FOLDER [--version V].

The pages are those of docs/, without changes, and the manual page of each command. The navigation comes from
docs/index.md. A warning of Sphinx, for example about a dead link, is an error."""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

SITE = Path(__file__).resolve().parent
DOCS = SITE.parent
_ITALIC = re.compile(r"\\fI(.*?)\\fP")


def _plain(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: {"-": "-", "&": "", "e": "\\"}.get(m[1], m[1]), text)


def _inline(text: str) -> str:
    """Converts a line of a manual page to Markdown. Bold text becomes code font, because users type it."""
    parts = re.split(r"(\\fB.*?\\fP(?:\(\d\))?|\\fI.*?\\fP)", text)
    done = ""
    for part in parts:
        if bold := re.fullmatch(r"\\fB(.*?)\\fP(\(\d\))?", part):
            word = _plain(bold[1])
            done += f"[{word}]({word}.md)" if bold[2] and word.startswith("gyrotherm") else f"`{word}`"
        elif italic := _ITALIC.fullmatch(part):
            done += f"*{_plain(italic[1])}*"
        else:
            done += re.sub(r"([*_`<>\[\]{}|$])", r"\\\1", _plain(part))
    return done


def to_markdown(manual_page: str, name: str) -> str:
    """Converts a manual page to Markdown. Supports the requests of man(7) that gyrotherm's pages contain."""
    lines: list[str] = [f"# {name}", ""]
    expects_term = in_description = verbatim = False
    for line in manual_page.splitlines():
        if line.startswith(('.\\"', ".TH", ".nh")):
            continue
        if line in (".EX", ".EE"):
            lines += ["", "```text"] if line == ".EX" else ["```", ""]
            verbatim, in_description = line == ".EX", False
            continue
        if verbatim:
            lines.append(_plain(re.sub(r"\\f[BIP]", "", line)))
            continue
        if line.startswith((".SH ", ".SS ")):
            title = _plain(line[4:].strip('"'))
            lines += ["", f"## {title.capitalize()}" if line[2] == "H" else f"### {title}", ""]
            in_description = False
        elif line == ".br":
            lines[-1] += "\\"
        elif line in (".PP", ".P"):
            lines.append("")
            in_description = False
        elif line.startswith(".TP"):
            lines.append("")
            expects_term, in_description = True, False
        else:
            text = re.sub(r"^\.B (.*)$", r"\\fB\1\\fP", line)
            text = re.sub(r"^\.BR (\S+) (\S+)$", r"\\fB\1\\fP\2", text)
            if text.startswith("."):
                raise ValueError(f"{name}: {line}: unknown request; add it to docs/site/make.py")
            if expects_term:
                lines.append(_inline(text))
                expects_term, in_description = False, True
            else:
                lines.append((": " if in_description and not lines[-1].startswith((": ", "  ")) else
                              "  " if in_description else "") + _inline(text))  # fmt: skip
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).rstrip() + "\n"


def _make_toctrees(index: str) -> str:
    """Returns a hidden toctree of Sphinx for each heading of docs/index.md."""
    trees = ""
    for chapter in re.split(r"^## ", index, flags=re.M)[1:]:
        title = chapter.splitlines()[0]
        pages = re.findall(r"^- \[[^\]]+\]\(([^)]+)\.md\)", chapter, flags=re.M)
        if title == "Reference":
            pages.append("reference/commands")
        if title == "Explanation":
            pages.append("decisions/index")
        trees += f"\n```{{toctree}}\n:hidden:\n:caption: \"{title.split(':')[0]}\"\n" + "\n".join(pages) + "\n```\n"
    return trees


def copy_pages(pages: Path, source: Path) -> None:
    """Copies docs/ to `source` and adds the manual pages, the navigation and the settings of Sphinx."""
    shutil.rmtree(source, ignore_errors=True)
    skipped = {"man", "site"}
    shutil.copytree(DOCS, source, ignore=lambda folder, names: skipped if Path(folder) == DOCS else set())
    for name in ("conf.py", "site.css"):
        shutil.copy(SITE / name, source / name)
    index = source / "index.md"
    text = index.read_text(encoding="utf-8")
    index.write_text(text + _make_toctrees(text), encoding="utf-8")
    commands = source / "reference"
    names = []
    for page in sorted(pages.glob("gyrotherm*.1")):
        names.append(page.stem)
        (commands / f"{page.stem}.md").write_text(
            to_markdown(page.read_text(encoding="utf-8"), page.stem), encoding="utf-8"
        )
    if len(names) < 20:
        raise SystemExit(f"{pages}: {len(names)} manual pages, expected one for each command")
    listed = "\n".join(f"- [{name}]({name}.md)" for name in names)
    tree = "\n```{toctree}\n:hidden:\n" + "\n".join(names) + "\n```\n"
    (commands / "commands.md").write_text(f"# Commands\n\n{listed}\n{tree}", encoding="utf-8")
    (source / "decisions/index.md").write_text(
        "# Decisions\n\nChoices that a newcomer would question, and what each costs.\n\n"
        "```{toctree}\n:maxdepth: 1\n:glob:\n0*\n```\n", encoding="utf-8")  # fmt: skip


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--pages", type=Path, required=True)
    options.add_argument("--out", type=Path, required=True)
    options.add_argument("--version", default="")
    arguments = options.parse_args()
    source = arguments.out / "source"
    copy_pages(arguments.pages, source)
    return subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d",
         str(arguments.out / "doctrees"), "-D", f"release={arguments.version}", "-D", f"version={arguments.version}",
         str(source), str(arguments.out / "html")],
        check=False,
    ).returncode  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
