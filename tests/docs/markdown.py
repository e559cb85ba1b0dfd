# SPDX-License-Identifier: Apache-2.0
"""Functions shared by the tests of the documents: blocks and links of a page, and execution of its sessions.

A block ```console is a session: a line "$ …" is a command, "> …" continues it, and the following lines are its complete
output. In the output "…" matches any text in a line; alone on a line it matches any number of lines. In a block
```console fails each command must fail. A block is a file if its first line is a comment with a file name, such as
"# day.toml"."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
DOCS = SOURCE / "docs"
_FENCE = re.compile(r"^(`{3,})(.*)$")
_FILE = re.compile(r"^(?:#|//) ([\w./-]+\.\w+)$")
_PROGRESS = re.compile(r": +\d+ %(, .*)?$")
_JOB = re.compile(r"^\[\d+\]|line \d+: +\d+ (Killed|Terminated)")


@dataclass
class Block:
    page: Path
    line: int
    language: str
    words: list[str]
    lines: list[str] = field(default_factory=list)

    @property
    def position(self) -> str:
        return f"{self.page.relative_to(SOURCE)}:{self.line}"

    @property
    def file(self) -> str | None:
        named = _FILE.match(self.lines[0]) if self.lines and self.language not in ("console", "text", "sh") else None
        return named[1] if named else None


@dataclass
class Command:
    position: str
    text: str
    must_fail: bool
    expected: list[str] = field(default_factory=list)


def read_blocks(page: Path) -> list[Block]:
    blocks: list[Block] = []
    inside = ""
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        fence = _FENCE.match(line)
        if inside:
            if line.rstrip() == inside:
                inside = ""
            else:
                blocks[-1].lines.append(line)
        elif fence:
            words = fence[2].split()
            blocks.append(Block(page, number, words[0] if words else "", words[1:]))
            inside = fence[1]
    return blocks


def read_prose(page: Path) -> list[tuple[int, str]]:
    """Returns the lines outside blocks, with their numbers."""
    lines, inside = [], ""
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        fence = _FENCE.match(line)
        if inside:
            inside = "" if line.rstrip() == inside else inside
        elif fence:
            inside = fence[1]
        elif not line.startswith("    "):
            lines.append((number, line))
    return lines


def read_commands(block: Block) -> list[Command]:
    commands: list[Command] = []
    for number, line in enumerate(block.lines, block.line + 1):
        if line.startswith("$ "):
            position = f"{block.page.relative_to(SOURCE)}:{number}"
            commands.append(Command(position, line[2:], "fails" in block.words))
        elif not commands:
            raise ValueError(f"{block.position}: a session begins with a command")
        elif line.startswith("> ") and not commands[-1].expected:
            commands[-1].text += "\n" + line[2:]
        else:
            commands[-1].expected.append(line.rstrip())
    return commands


def is_printed(expected: list[str], printed: str) -> bool:
    pattern = ""
    for line in expected:
        pattern += r"(?:.*\n)*?" if line == "…" else re.escape(line).replace("…", ".*") + r"\n"
    return re.fullmatch(pattern, printed) is not None


def _remove_transient_lines(text: str) -> str:
    """Removes progress lines, which a terminal overwrites, and job messages of the shell."""
    kept = [line.rstrip() for line in text.splitlines() if not _PROGRESS.search(line) and not _JOB.search(line)]
    return "".join(line + "\n" for line in kept if line or text.strip())


def follow(page: Path, folder: Path, programs: Path, nightly: bool, seconds: float) -> list[str]:
    """Runs the sessions of a page in the folder, with `programs` first in the path. Returns the differences."""
    commands: list[Command] = []
    script = ""
    for block in read_blocks(page):
        if block.file:
            quoted = "\n".join(block.lines)
            script += f"mkdir -p \"$(dirname {block.file})\"\ncat > {block.file} <<'@@'\n{quoted}\n@@\n"
        if block.language != "console" or ("nightly" in block.words and not nightly):
            continue
        for command in read_commands(block):
            script += f"{command.text}\n_code=$?; printf '@@%s@@\\n' $_code; (exit $_code)\n"
            commands.append(command)
    (folder / ".followed").write_text(script, encoding="utf-8")
    environment = os.environ | {
        "PATH": f"{programs}:{os.environ['PATH']}", "HOME": str(folder), "LC_ALL": "C.UTF-8", "TERM": "dumb",
    }  # fmt: skip
    printed = folder / ".printed"
    with open(printed, "wb") as out:
        shell = subprocess.Popen(
            ["bash", str(folder / ".followed")], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=out,
            stderr=out, start_new_session=True,
        )  # fmt: skip
        try:
            shell.wait(seconds)
        except subprocess.TimeoutExpired:
            pass
        try:
            os.killpg(shell.pid, signal.SIGKILL)  # background processes
        except ProcessLookupError:
            pass
        shell.wait()
    parts = re.split(r"@@(\d+)@@\n", printed.read_text(encoding="utf-8", errors="replace"))
    done = [(_remove_transient_lines(parts[i]), int(parts[i + 1])) for i in range(0, len(parts) - 1, 2)]
    wrong = []
    for index, (command, (text, code)) in enumerate(zip(commands, done)):
        code_is_checked = index + 1 < len(commands) and commands[index + 1].text == "echo $?"
        if (code != 0) != command.must_fail and not code_is_checked:
            wrong.append(f"{command.position}: exit code {code}: {command.text}\n{text}")
        elif not is_printed(command.expected, text):
            expected_text = "\n".join(command.expected)
            wrong.append(f"{command.position}: {command.text}\nexpected:\n{expected_text}\nprinted:\n{text}")
    if len(done) < len(commands):
        wrong.append(f"{commands[len(done)].position}: did not end within {seconds} s: {commands[len(done)].text}")
    return wrong
