#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the sessions of a page of the manual in a new folder: follow.py PROGRAMS PAGE [nightly].

A page with "<!-- follows other.md -->" continues after the end of that page. A page with "<!-- needs cc -->" is skipped
if that program is missing."""

import re
import shutil
import socket
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))

from markdown import DOCS, follow
from standstill import Standstill

_PORT = re.compile(r"--port (\d+)")
SKIPPED = 77
ATTEMPTS = 3  # repeated only if the machine itself stalled
_INSTRUMENTS = 4  # consecutive ports of `simulate --port`


def wait_for_ports(page: Path) -> None:
    """Waits until the ports of the page are free. Another run of the page on this machine uses them for a minute."""
    for first in {int(port) for port in _PORT.findall(page.read_text(encoding="utf-8"))}:
        for port in range(first, first + _INSTRUMENTS):
            for _ in range(180):
                with socket.socket() as line:
                    line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                    try:
                        line.bind(("127.0.0.1", port))
                        break
                    except OSError:
                        time.sleep(1)


def main() -> int:
    programs, page = Path(sys.argv[1]).resolve(), (DOCS / sys.argv[2]).resolve()
    nightly = "nightly" in sys.argv[3:]
    text = page.read_text(encoding="utf-8")
    previous = re.search(r"<!-- follows ([\w.-]+) -->", text)
    requirements = re.search(r"<!-- needs ([\w -]+?) -->", text)
    missing = [program for program in (requirements[1].split() if requirements else []) if not shutil.which(program)]
    if missing:
        print(f"skipped: {', '.join(missing)} is not installed")
        return SKIPPED
    wait_for_ports(page)
    for _ in range(ATTEMPTS):
        standstill = Standstill()
        with tempfile.TemporaryDirectory(prefix="gyrotherm-manual-") as name:
            differences = follow(page.parent / previous[1], Path(name), programs, False, 120) if previous else []
            began = time.monotonic()
            differences += follow(page, Path(name), programs, nightly, 900 if nightly else 180)
            print(f"{page.relative_to(DOCS)} ran in {time.monotonic() - began:.1f} s")
        print("\n\n".join(differences))
        if not differences or not standstill.total():
            break
        print(f"the machine stalled for {standstill.total():.1f} s")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
