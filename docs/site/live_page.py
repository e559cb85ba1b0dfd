#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Takes the screenshots of the live page: live_page.py PROGRAMS [FOLDER].

Starts a run in real time on the rig of the tutorial "The first real rig". After two minutes headless Chromium opens its
page. Needs chromium-driver and python3-selenium."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

DOCS = Path(__file__).resolve().parents[1]
TUTORIAL_PORT = 15020
PROFILE = """schema = "gyrotherm-profile/1"
name = "warm-up"
title = "Up by eight kelvins, for the pictures"

[[segment]]
kind = "hold"
at = "20 °C"
time = "20 s"

[[segment]]
kind = "ramp"
to = "28 °C"
rate = "5 °C/min"

[[segment]]
kind = "hold"
time = "30 min"
"""


def find_free_ports() -> int:
    """Returns the first of four consecutive free TCP ports."""
    for first in range(17020, 20000, 10):
        lines = []
        try:
            for port in range(first, first + 4):
                lines.append(socket.socket())
                lines[-1].bind(("127.0.0.1", port))
            return first
        except OSError:
            continue
        finally:
            for line in lines:
                line.close()
    raise SystemExit("four consecutive free ports not found between 17020 and 20000")


def wait_for_text(path: Path, pattern: str) -> str:
    """Waits until a file matches a pattern, at most 30 s. Returns the content of the file."""
    for _ in range(300):
        if path.exists() and re.search(pattern, text := path.read_text(encoding="utf-8")):
            return text
        time.sleep(0.1)
    raise SystemExit(f"{path} does not contain {pattern} after 30 s")


def read_rig_commands(first: int) -> str:
    """Returns the commands of the tutorial that write the rig file, with the ports from `first`."""
    tutorial = (DOCS / "tutorial/first-real-rig.md").read_text(encoding="utf-8")
    commands = re.findall(r"^\$ ((?:gyrotherm new rig rig\.toml|sed -i)[^\n]*(?:\n> [^\n]*)*)", tutorial, re.M)
    text = "\n".join(command.replace("\n> ", "\n") for command in commands)
    for i in range(4):
        text = text.replace(str(TUTORIAL_PORT + i), str(first + i))
    return text


def main() -> int:
    programs = Path(sys.argv[1]).resolve()
    pictures = Path(sys.argv[2]) if len(sys.argv) > 2 else DOCS / "figures"
    first = find_free_ports()
    started = []
    with tempfile.TemporaryDirectory(prefix="gyrotherm-pictures-") as name:
        folder = Path(name)
        (folder / "warm-up.toml").write_text(PROFILE, encoding="utf-8")

        def start(program: str, *arguments: str) -> None:
            with open(folder / f"{arguments[0].strip('-')}.txt", "wb") as out:
                started.append(subprocess.Popen([programs / program, *arguments], cwd=folder, stdout=out, stderr=out))

        try:
            start("gyrotherm", "simulate", "--port", str(first))
            wait_for_text(folder / "simulate.txt", "gyro  ")
            subprocess.run(["sh", "-euc", read_rig_commands(first)], cwd=folder, check=True, stdout=subprocess.DEVNULL,
                           env=os.environ | {"PATH": f"{programs}:{os.environ['PATH']}"})
            start("gyrotherm", "run", "./warm-up.toml", "--rig", "./rig.toml", "--unit", "0042", "--out", "warm-up.db")
            start("gyrotherm-monitor", "--folder", ".", "--listen", "127.0.0.1:0", "--state", "state")
            page = re.search(r"http://\S+:\d+/", wait_for_text(folder / "folder.txt", r"http://\S+:\d+/"))[0]
            time.sleep(60)
            request = [programs / "gyrotherm", "tell", "warm-up.db"]
            subprocess.run([*request, "note", "heater hums"], cwd=folder, check=True)
            time.sleep(60)
            runs = json.load(urllib.request.urlopen(f"{page}api/v1/runs"))["runs"]
            options = Options()
            for argument in ("--headless=new", "--no-sandbox", "--hide-scrollbars"):
                options.add_argument(argument)
            browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
            browser.set_window_size(1100, 900)
            for view in ("now", "trend"):
                browser.get("about:blank")
                browser.get(f"{page}#/run/{runs[0]['key']}/{view}")
                time.sleep(3)
                browser.save_screenshot(str(pictures / f"live-{view}.png"))
            browser.quit()
            subprocess.run([*request, "stop"], cwd=folder, check=True)
            started[1].wait(30)
        finally:
            for process in reversed(started):
                process.terminate()
                process.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
