#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the manual as a site and checks it for warnings and dead links: site_test.py PROGRAMS."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from urllib.parse import unquote

SOURCE = Path(__file__).resolve().parents[2]
try:
    import myst_parser  # noqa: F401
    import sphinx  # noqa: F401
except ImportError as error:
    print(f"skipped: {error}; this test requires python3-sphinx and python3-myst-parser")
    sys.exit(77)


def main() -> int:
    pages = Path(sys.argv[1]) / "man"
    with tempfile.TemporaryDirectory(prefix="gyrotherm-site-") as name:
        made = subprocess.run(
            [sys.executable, SOURCE / "docs/site/make.py", "--pages", pages, "--out", name, "--version", "0"],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        print(made.stdout + made.stderr)
        if made.returncode != 0:
            return 1
        site = Path(name) / "html"
        wrong = 0
        for page in site.rglob("*.html"):
            text = page.read_text(encoding="utf-8")
            for target in re.findall(r'(?:href|src)="([^"]+)"', text):
                path, _, anchor = target.partition("#")
                if re.match(r"https?:|mailto:", target):
                    if not target.startswith("https:") and "sphinx" not in target and "alabaster" not in target:
                        print(f"{page.relative_to(site)}: {target}")
                        wrong += 1
                    continue
                destination = page.parent / unquote(path) if path else page
                exists = destination.exists() and (not anchor or destination.suffix != ".html" or f'id="{unquote(anchor)}"' in
                                          destination.read_text(encoding="utf-8"))  # fmt: skip
                if not exists:
                    print(f"{page.relative_to(site)}: {target}: dead link")
                    wrong += 1
            if re.search(r'<(?:script|link)[^>]*(?:src|href)="https?:', text):
                print(f"{page.relative_to(site)} loads a resource from another server")
                wrong += 1
        count = len(list(site.rglob("*.html")))
        print(f"{count} pages, {wrong} dead or forbidden links")
        return 1 if wrong or count < 80 else 0


if __name__ == "__main__":
    sys.exit(main())
