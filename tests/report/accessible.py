#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the accessibility of the program's pages with axe-core in Chromium.

    accessible.py GYROTHERM

Runs a small experiment with three gyros on the virtual rig, makes its calibration reports in both languages, and checks
each page at the widths of a phone, a tablet and a desktop. Takes axe-core from npm. The exit code is 1 if it finds a
violation, and 77 if Chromium, its driver, Selenium or npm is missing.
"""
from __future__ import annotations

import pathlib
import subprocess
import sys
import tarfile
import tempfile

SKIPPED = 77
ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDTHS = (360, 800, 1280)
FIRST_PAINT_MS = 1000
PAINTED = """const done = arguments[0], end = performance.now() + 10000;
function look() {
  const paints = performance.getEntriesByType('paint').map(paint => paint.startTime);
  if (paints.length > 0 || performance.now() > end) done(paints); else requestAnimationFrame(look);
}
look();"""

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
except ModuleNotFoundError:
    print("skipped: python3-selenium is not there")
    sys.exit(SKIPPED)


def axe(folder: pathlib.Path) -> str:
    packed = subprocess.run(["npm", "pack", "axe-core@4", "--silent"], cwd=folder, capture_output=True, text=True,
                            check=True)
    with tarfile.open(folder / packed.stdout.strip()) as archive:
        return archive.extractfile("package/axe.min.js").read().decode()


def browser() -> webdriver.Chrome:
    options = Options()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu"):
        options.add_argument(argument)
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


def pages(program: str, folder: pathlib.Path) -> list[pathlib.Path]:
    out = folder / "out"
    for command in (["qualify", "--quick", "--rig", ROOT / "profiles/rigs/virtual-triad.toml", "--out", out, "--quiet"],
                    ["report", out, "--out", out / "calibration", "--language", "en,de", "--quiet"]):
        subprocess.run([program, *map(str, command)], check=True, stdout=subprocess.DEVNULL, cwd=ROOT)
    return sorted(out.rglob("*.html"))


def find_violations(driver: webdriver.Chrome, script: str, page: pathlib.Path, width: int) -> list[str]:
    driver.set_window_size(width, 900)
    driver.get(page.as_uri())
    paints = driver.execute_async_script(PAINTED)
    driver.execute_script(script)
    found = driver.execute_async_script("const done = arguments[0]; axe.run(document).then(done)")["violations"]
    violations = [f"{one['id']}: {one['help']}: {node['html'][:120]}" for one in found for node in one["nodes"]]
    if not paints or max(paints) > FIRST_PAINT_MS:
        violations.append(f"first paint after {paints} ms, expected at most {FIRST_PAINT_MS}")
    return violations


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        try:
            script, driver = axe(folder), browser()
        except Exception as missing:  # Chromium, its driver or npm is missing
            print(f"skipped: {missing}")
            return SKIPPED
        failed = False
        for page in pages(sys.argv[1], folder):
            for width in WIDTHS:
                violations = find_violations(driver, script, page, width)
                failed = failed or bool(violations)
                print(f"{page.relative_to(folder)} at {width} px: {len(violations)} found", *violations, sep="\n    ")
        driver.quit()
        return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
