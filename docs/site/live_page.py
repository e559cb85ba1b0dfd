#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures of the live page: live_page.py PROGRAMS [FOLDER]. A run on the rig of the tutorial "The first real
rig" goes on for two minutes, in real time; then headless chromium looks at it. It needs chromium-driver and
python3-selenium."""

from __future__ import annotations

import json
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


def free_ports() -> int:
    """The first of four ports that are free."""
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
    raise SystemExit("no four ports in a row are free")


def wait_for(path: Path, words: str) -> str:
    for _ in range(300):
        if path.exists() and re.search(words, text := path.read_text(encoding="utf-8")):
            return text
        time.sleep(0.1)
    raise SystemExit(f"{path} does not say {words}")


def main() -> int:
    programs = Path(sys.argv[1]).resolve()
    pictures = Path(sys.argv[2]) if len(sys.argv) > 2 else DOCS / "figures"
    first = free_ports()
    tutorial = (DOCS / "tutorial/first-real-rig.md").read_text(encoding="utf-8")
    rig = re.search(r"```toml\n(# rig\.toml\n.*?)```", tutorial, re.S)[1]
    for i in range(4):
        rig = rig.replace(str(TUTORIAL_PORT + i), str(first + i))
    started = []
    with tempfile.TemporaryDirectory(prefix="gyrotherm-pictures-") as name:
        folder = Path(name)
        (folder / "rig.toml").write_text(rig, encoding="utf-8")
        (folder / "warm-up.toml").write_text(PROFILE, encoding="utf-8")

        def start(program: str, *words: str) -> None:
            with open(folder / f"{words[0].strip('-')}.txt", "wb") as said:
                started.append(subprocess.Popen([programs / program, *words], cwd=folder, stdout=said, stderr=said))

        try:
            start("gyrotherm", "simulate", "--port", str(first))
            wait_for(folder / "simulate.txt", "gyro  ")
            start("gyrotherm", "run", "./warm-up.toml", "--rig", "./rig.toml", "--out", "warm-up.db")
            start("gyrotherm-monitor", "--folder", ".", "--listen", "127.0.0.1:0", "--state", "state")
            page = re.search(r"http://\S+:\d+/", wait_for(folder / "folder.txt", r"http://\S+:\d+/"))[0]
            time.sleep(60)
            tell = [programs / "gyrotherm", "tell", "warm-up.db"]
            subprocess.run([*tell, "note", "heater hums"], cwd=folder, check=True)
            time.sleep(60)
            runs = json.load(urllib.request.urlopen(f"{page}api/v1/runs"))["runs"]
            options = Options()
            for word in ("--headless=new", "--no-sandbox", "--hide-scrollbars"):
                options.add_argument(word)
            browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
            browser.set_window_size(1100, 900)
            for view in ("now", "trend"):
                browser.get("about:blank")
                browser.get(f"{page}#/run/{runs[0]['key']}/{view}")
                time.sleep(3)
                browser.save_screenshot(str(pictures / f"live-{view}.png"))
            browser.quit()
            subprocess.run([*tell, "stop"], cwd=folder, check=True)
            started[1].wait(30)
        finally:
            for process in reversed(started):
                process.terminate()
                process.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
