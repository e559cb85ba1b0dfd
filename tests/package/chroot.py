#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the Debian packages as a user gets them.

Builds them in a clean Debian 12 by the commands of docs/installing.md. Then installs them in another one without the
source, uses them, upgrades them during a run, and purges them. Packages of an earlier release are upgraded, too.

    chroot.py [FOLDER]        keeps the systems in FOLDER, and uses packages that already exist there: in packages/first
                              and packages/later, and those of an earlier release in packages/earlier
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/docs"))

from markdown import read_blocks

SKIPPED = 77
INSTALLED = ["gyrotherm", "gyrotherm-monitor", "gyrotherm-site", "libgyrotherm-dev", "python3-gyrotherm",
             "gyrotherm-doc"]
FOLLOWED_PAGES = ["tutorial/first-dry-run.md", "tutorial/first-real-rig.md", "tutorial/first-import.md"]
LATER = "0.2.0+later"
ENVIRONMENT = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8",
               "DEBIAN_FRONTEND": "noninteractive"}


def report_progress(what: str) -> None:
    print(time.strftime("%H:%M:%S"), what, flush=True)


class Failed(Exception):
    pass


class System:
    """A clean Debian 12 in a folder."""

    def __init__(self, folder: Path, name: str):
        self.root = folder / name
        if (self.root / "etc").is_dir():
            return
        report_progress(f"creating a clean Debian 12: {name}")
        made = subprocess.run(["mmdebstrap", "--variant=apt", "--quiet", "bookworm", str(self.root),
                               "deb http://deb.debian.org/debian bookworm main",
                               "deb http://deb.debian.org/debian bookworm-updates main",
                               "deb http://deb.debian.org/debian-security bookworm-security main"],
                              capture_output=True, text=True)
        if made.returncode:
            raise Failed(made.stderr)

    def command(self, line: str) -> list[str]:
        return ["chroot", str(self.root), "sh", "-euc", line]

    def run(self, line: str) -> str:
        """Runs a command line in the system and returns its output. Raises `Failed` if it fails."""
        done = subprocess.run(self.command(line), env=ENVIRONMENT, text=True, timeout=7200, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if done.returncode:
            raise Failed(f"{line}\nexit code {done.returncode}:\n{done.stdout[-4000:]}")
        return done.stdout

    def copy_source(self, to: str) -> None:
        """Copies the source tree without build folders and .git."""
        target = self.root / to
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(SOURCE, target, symlinks=True, ignore=shutil.ignore_patterns("build", ".git", "__pycache__"))

    @contextmanager
    def mounted(self):
        mounts = [("proc", ["-t", "proc", "proc"]), ("dev", ["--bind", "/dev"])]
        for name, how in mounts:
            subprocess.run(["mount", *how, str(self.root / name)], check=True)
        try:
            yield self
        finally:
            for name, _ in reversed(mounts):
                subprocess.run(["umount", "-l", str(self.root / name)], check=False)


def build(system: System, packages: Path) -> None:
    """Builds the packages by the first block of docs/installing.md, without its last line, which installs them. Builds
    a later version, too."""
    block = read_blocks(SOURCE / "docs/installing.md")[0]
    lines = [line.replace("apt-get install", "apt-get install -y").replace("build-dep", "build-dep -y")
             for line in "\n".join(block.lines).replace("\\\n", "").splitlines() if "install ../" not in line]
    system.copy_source("src/gyrotherm")
    system.run("apt-get update")
    for line in lines:
        report_progress(line)
        system.run(f"cd /src/gyrotherm; {line}")
    collect(system, packages / "first")
    changelog = system.root / "src/gyrotherm/debian/changelog"
    newest = changelog.read_text(encoding="utf-8")
    stanza = newest[:newest.index("\n -- ")] + newest[newest.index("\n -- "):].split("\n\n")[0] + "\n\n"
    changelog.write_text(stanza.replace(newest.split("(")[1].split(")")[0], LATER, 1) + newest, encoding="utf-8")
    report_progress(f"{lines[-1]} -nc, as {LATER}")
    system.run(f"cd /src/gyrotherm; {lines[-1]} -nc")
    collect(system, packages / "later")


def collect(system: System, into: Path) -> None:
    into.mkdir(parents=True)
    for package in (system.root / "src").glob("*.deb"):
        package.rename(into / package.name)


def lint(packages: Path) -> None:
    if not shutil.which("lintian"):
        report_progress("lintian is not installed; skipped")
        return
    found = subprocess.run(["lintian", "--allow-root", "--fail-on", "error", *(packages / "first").glob("*.deb")],
                           capture_output=True, text=True)
    print(found.stdout, end="")
    if found.returncode:
        raise Failed("lintian finds errors")


def install(system: System, packages: Path) -> None:
    shutil.copytree(packages, system.root / "packages", dirs_exist_ok=True)
    system.run("apt-get update")
    report_progress("installing the packages")
    packages_to_install = " ".join(f"/packages/first/{name}_*.deb" for name in INSTALLED)
    system.run(f"apt-get install -y --no-install-recommends {packages_to_install}")


def use(system: System) -> None:
    report_progress("debian/tests/installed")
    shutil.copy(SOURCE / "debian/tests/installed", system.root / "tmp/installed")
    system.run("apt-get install -y --no-install-recommends bash-completion man-db systemd")
    system.run("rm -f /etc/dpkg/dpkg.cfg.d/excludes; sh /tmp/installed")
    security = system.run("for unit in gyrotherm@ gyrotherm-monitor gyrotherm-publish; do "
                          "systemd-analyze security --offline=true /lib/systemd/system/$unit.service | tail -1; done")
    print(security, end="")
    for page in FOLLOWED_PAGES:
        report_progress(f"{page}, followed with the installed programs")
        for part in ("docs", "tests/docs", "tests/support"):
            shutil.copytree(SOURCE / part, system.root / "manual" / part, dirs_exist_ok=True)
        system.run(f"/manual/tests/docs/follow.py /usr/bin {page}")
    report_progress("gyrotherm qualify --quick")
    system.run("mkdir /srv/trial; cd /srv/trial; gyrotherm qualify --quick --out out; test -s out/report/report.html")


def read_rig_commands() -> str:
    """Returns the commands of the tutorial that write the rig file."""
    tutorial = (SOURCE / "docs/tutorial/first-real-rig.md").read_text(encoding="utf-8")
    commands = re.findall(r"^\$ ((?:gyrotherm new rig rig\.toml|sed -i)[^\n]*(?:\n> [^\n]*)*)", tutorial, re.M)
    return "\n".join(command.replace("\n> ", "\n") for command in commands)


def upgrade_during_run(system: System) -> None:
    """Upgrades the packages during a run of 90 s on the rig of the tutorial."""
    bench = system.root / "srv/bench"
    bench.mkdir()
    (bench / "short.toml").write_text('schema = "gyrotherm-profile/1"\nname = "short"\n\n[[segment]]\n'
                                      'kind = "hold"\nat = "20 °C"\ntime = "90 s"\n', encoding="utf-8")
    laboratory = subprocess.Popen(system.command("exec gyrotherm simulate --pace real --port 15020"), env=ENVIRONMENT,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(3)
    system.run(f"cd /srv/bench; {read_rig_commands()}")
    command = "cd /srv/bench; exec gyrotherm run ./short.toml --rig ./rig.toml --unit 0042 --out run.db"
    run = subprocess.Popen(system.command(command), env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                           text=True)
    time.sleep(15)
    report_progress("upgrading during a run")
    packages_to_install = " ".join(f"/packages/later/{name}_*.deb" for name in INSTALLED)
    try:
        system.run(f"apt-get install -y --no-install-recommends {packages_to_install}")
        if run.poll() is not None:
            raise Failed(f"the upgrade ended the run: {run.communicate()[0]}")
        output, _ = run.communicate(timeout=300)
    finally:
        run.kill()
        laboratory.send_signal(signal.SIGTERM)
        laboratory.wait()
    if run.returncode:
        raise Failed(f"exit code {run.returncode} of the run:\n{output}")
    kept = system.run("cd /srv/bench; gyrotherm status run.db --verify; dpkg-query -W -f '${Version}\\n' gyrotherm")
    if LATER not in kept:
        raise Failed(f"expected version {LATER}: {kept}")


def upgrade_from_release(system: System, packages: Path) -> None:
    """Upgrades the packages of an earlier release. Their record, site store and users must remain as they were."""
    shutil.copytree(packages, system.root / "packages", dirs_exist_ok=True)
    system.run("apt-get update")
    names = " ".join(INSTALLED)
    report_progress("installing the packages of an earlier release")
    system.run("apt-get install -y --no-install-recommends systemd /packages/earlier/*.deb")
    earlier = system.run("dpkg-query -W -f '${Version}' gyrotherm")
    system.run("mkdir /srv/earlier; cd /srv/earlier; gyrotherm run two-position --rig virtual --out run.db; "
               "cp run.db /var/lib/gyrotherm/; getent passwd | sort > users")
    report_progress(f"upgrading from {earlier}")
    system.run(f"apt-get install -y --no-install-recommends $(for name in {names}; do "
               "echo /packages/first/${name}_*.deb; done)")
    kept = system.run("cd /srv/earlier; gyrotherm status run.db --verify; gyrotherm export run.db --out run.csv; "
                      "getent passwd | sort | comm -23 users -; cmp run.db /var/lib/gyrotherm/run.db; "
                      "dpkg --audit; dpkg-query -W -f '${Version}\\n' gyrotherm")
    if earlier in kept.splitlines():
        raise Failed(f"expected a later version than {earlier}: {kept}")
    print(kept, end="")


def purge(system: System) -> None:
    report_progress("purging")
    (system.root / "var/lib/gyrotherm/run.db").write_bytes(b"data")
    system.run(f"apt-get purge -y {' '.join(INSTALLED)}")
    ours = " -o ".join(f"-path /{part}" for part in ("root", "srv", "packages", "manual", "tmp", "var/cache", "var/log",
                                                     "var/lib/apt"))
    left = system.run(f"find / -xdev \\( {ours} \\) -prune -o -iname '*gyrotherm*' -print")
    if left.split() != ["/var/lib/gyrotherm"]:
        raise Failed(f"files left after purge, other than data:\n{left}")


def main() -> int:
    if os.geteuid() != 0 or not shutil.which("mmdebstrap"):
        print("skipped: requires root and mmdebstrap (apt-get install mmdebstrap)")
        return SKIPPED
    with tempfile.TemporaryDirectory(prefix="gyrotherm-packages-") as temporary:
        folder = Path(sys.argv[1] if len(sys.argv) > 1 else temporary).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        try:
            if not (folder / "packages/later").is_dir():
                with System(folder, "build").mounted() as system:
                    build(system, folder / "packages")
            lint(folder / "packages")
            with System(folder, "use").mounted() as system:
                install(system, folder / "packages")
                use(system)
                upgrade_during_run(system)
                purge(system)
            if (folder / "packages/earlier").is_dir():
                with System(folder, "upgrade").mounted() as system:
                    upgrade_from_release(system, folder / "packages")
                    purge(system)
        except Failed as failed:
            print(failed)
            return 1
    report_progress("all tests passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
