# SPDX-License-Identifier: Apache-2.0
"""Runs the program on hostile inputs. Makes the valid files from which the inputs are derived."""
import hashlib
import os
import random
import re
import shutil
import stat
import subprocess
import sys
import tempfile
import time

PATIENCE_S = 5
TOML_MEMORY_MB = 200
DONE, WRONG_FILE = 0, 4

PROFILE = """schema = "gyrotherm-profile/1"
name = "strange"
[metadata]
article = "nobody's"
[defaults]
soak_band = "1 K"
[[segment]]
kind = "hold"
at = "20 °C"
time = "100 s"
[[segment]]
kind = "repeat"
count = 2
  [[segment.segment]]
  kind = "ramp"
  to = "22 °C"
  rate = "5 °C/min"
  [[segment.segment]]
  kind = "ramp"
  to = "20 °C"
  time = "2 min"
"""
LONG_PROFILE = PROFILE + '[[segment]]\nkind = "hold"\ntime = "15000 s"\n'
MOVE_TO_LOG = """
import os, sqlite3, sys
record = sqlite3.connect(sys.argv[1], isolation_level=None)
record.execute("PRAGMA locking_mode = EXCLUSIVE")
rows = record.execute("SELECT * FROM sample ORDER BY slot DESC LIMIT 1000").fetchall()[::-1]
record.execute("DELETE FROM sample WHERE slot >= ?", rows[0][:1])
record.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
for first in range(0, len(rows), 100):
    record.execute("BEGIN")
    record.executemany("INSERT INTO sample VALUES(%s)" % ", ".join("?" * len(rows[0])), rows[first:first + 100])
    record.execute("COMMIT")
os._exit(0)  # closing would write the log into the database
"""
IMPORT_MAP = """schema = "gyrotherm-import/1"
name = "small"
[file]
separator = ","
header = true
[time]
interval = "1 s"
[[thermometer]]
name = "A"
column = "A"
[[thermometer]]
name = "B"
column = "B"
[gyro]
column = "bias"
kind = "rate"
scale = 1.0
[analysis]
gradients = ["A", "B"]
"""


def table(rows):
    draw = random.Random(1)
    lines = ["A,B,bias"]
    for i in range(rows):
        a = 20 + 15 * ((i / 700.0) % 2 - 1)
        b = 20 + 14 * (((i - 40) / 700.0) % 2 - 1)
        lines.append("%.3f,%.3f,%.5f" % (a, b, 0.3 * (a - b) + draw.gauss(0, 0.2)))
    return "\n".join(lines) + "\n"


def resident_mb(pid):
    """Returns the peak resident memory of a process so far. wait4() would include the forked copy of this process."""
    try:
        with open("/proc/%d/status" % pid) as status:
            return next((int(line.split()[1]) / 1024 for line in status if line.startswith("VmHWM")), 0)
    except OSError:
        return 0


class ProcessResult:
    def __init__(self, code, out, err, seconds, memory_mb):
        self.code, self.out, self.err, self.seconds, self.memory_mb = code, out, err, seconds, memory_mb


class Laboratory:
    """Program under test, and valid files of which inputs contain damaged copies."""

    def __init__(self, program, source, sanitized):
        self.program, self.source = os.path.abspath(program), os.path.abspath(source)
        self.patience_s = 12 * PATIENCE_S if sanitized else PATIENCE_S
        self.sanitized = sanitized
        self.folder = tempfile.mkdtemp(prefix="gyrotherm-hostile-")
        self.valid = os.path.join(self.folder, "valid")
        os.mkdir(self.valid)
        self.make_valid_files()

    def path(self, name):
        return os.path.join(self.valid, name)

    def read_text(self, *parts):
        with open(os.path.join(self.source, *parts), encoding="utf-8") as file:
            return file.read()

    def run(self, arguments, patience_s=None, cwd=None, stdin=None):
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            began = time.monotonic()
            child = subprocess.Popen([self.program] + arguments, stdin=stdin or subprocess.DEVNULL, stdout=out,
                                     stderr=err, cwd=cwd or self.folder)
            deadline = began + (patience_s or self.patience_s)
            code, memory_mb = child.poll(), 0
            while code is None:
                memory_mb = max(memory_mb, resident_mb(child.pid))
                time.sleep(0.002)
                code = child.poll()
                if code is None and time.monotonic() > deadline:
                    child.kill()
                    child.wait()
                    code = "hang"
            out.seek(0)
            err.seek(0)
            return ProcessResult(code, out.read(), err.read(), time.monotonic() - began, memory_mb)

    def must(self, arguments):
        ran = self.run(arguments, patience_s=600)
        if ran.code != DONE:
            sys.exit("%s ended with %s: %s" % (arguments, ran.code, ran.err.decode(errors="replace")))

    def make_valid_files(self):
        rig = self.read_text("profiles", "rigs", "virtual.toml").replace('"../', '"%s/profiles/' % self.source)
        mixed = self.read_text("profiles", "rigs", "virtual-mixed.toml").replace('"../', '"%s/profiles/' % self.source)
        for name, text in {"profile.toml": PROFILE, "long.toml": LONG_PROFILE, "rig.toml": rig, "mixed.toml": mixed,
                           "map.toml": IMPORT_MAP, "table.csv": table(3000),
                           "chamber.toml": self.read_text("profiles", "chambers", "watlow_f4t.toml"),
                           "stream.toml": self.read_text("profiles", "gyro-streams", "kvh-17xx-a.toml"),
                           "gyro.toml": self.read_text("profiles", "gyros", "calibrated.toml")}.items():
            with open(self.path(name), "w", encoding="utf-8") as file:
                file.write(text)
        self.must(["run", self.path("profile.toml"), "--rig", self.path("rig.toml"), "--out", self.path("finished.db")])
        self.must(["export", self.path("finished.db"), "--out", self.path("finished.csv")])
        self.must(["import", self.path("table.csv"), "--map", self.path("map.toml"), "--out", self.path("table.db")])
        self.must(["train", self.path("table.db"), "--method", "linear", "--inputs", "A-B,A", "--folds", "blocks",
                   "--out", self.path("linear.json")])
        self.must(["train", self.path("table.db"), "--inputs", "A-B,A", "--folds", "blocks", "--quick", "--out",
                   self.path("svr.json")])
        self.make_unfinished_run()
        with open(self.path("finished.csv"), "rb") as file:
            self.finished_rows = file.read()

    def make_unfinished_run(self):
        """Makes a record of a killed run whose last thousand rows are only in the write-ahead log."""
        with open(os.devnull, "w") as nowhere:
            child = subprocess.Popen([self.program, "run", self.path("long.toml"), "--rig", self.path("rig.toml"),
                                      "--json", "--quiet", "--out", self.path("unfinished.db")], stdout=subprocess.PIPE,
                                     stderr=nowhere)
            child.stdout.readline()
            child.kill()
            child.wait()
        subprocess.run([sys.executable, "-c", MOVE_TO_LOG, self.path("unfinished.db")], check=True)
        if not os.path.getsize(self.path("unfinished.db-wal")):
            sys.exit("the killed run has no write-ahead log")


def listing(folder):
    """Returns attributes and content of every file in the folder, except out/, which contains requested output."""
    found = {}
    for root, folders, files in os.walk(folder):
        if root == folder and "out" in folders:
            folders.remove("out")
        for name in folders + files:
            path = os.path.join(root, name)
            facts = os.lstat(path)
            content = os.readlink(path) if stat.S_ISLNK(facts.st_mode) else ""
            if stat.S_ISREG(facts.st_mode) and facts.st_size < 20_000_000:
                with open(path, "rb") as file:
                    content = hashlib.sha256(file.read()).hexdigest()
            times = facts.st_mtime_ns if stat.S_ISREG(facts.st_mode) else 0
            found[os.path.relpath(path, folder)] = (facts.st_mode, facts.st_ino, facts.st_size, times, content)
    return found


class Input:
    """Hostile input in its own folder. Checks how the program handles it."""

    def __init__(self, laboratory, number, seed):
        self.laboratory, self.number = laboratory, number
        self.random = random.Random("%d %d" % (seed, number))
        self.folder = os.path.join(laboratory.folder, "input-%d" % number)
        self.failures = []
        os.mkdir(self.folder)
        os.mkdir(self.path("out"))
        self.put("precious", b"precious\0")

    def path(self, name):
        return os.path.join(self.folder, name)

    def put(self, name, content):
        with open(self.path(name), "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return self.path(name)

    def copy(self, *names):
        for name in names:
            if os.path.exists(self.laboratory.path(name)):
                shutil.copy2(self.laboratory.path(name), self.path(name))
        return self.path(names[0])

    def report_failure(self, what):
        self.failures.append(what)

    def expect(self, codes, *arguments, memory_mb=None, stdin=None, patience_s=None):
        """Runs the program. Requires an exit code in `codes`, a message if it refuses, output without control
        characters, bounded memory, and no change of files outside out/."""
        before = listing(self.folder)
        ran = self.laboratory.run(list(arguments), patience_s=patience_s, cwd=self.folder, stdin=stdin)
        description = "%s -> %s in %.2f s, %.0f MB: %r" % (" ".join(arguments), ran.code, ran.seconds, ran.memory_mb,
                                                    ran.err[:300])
        if ran.code not in codes:
            self.report_failure("expected %s: %s" % (" or ".join(map(str, codes)), description))
        if memory_mb and not self.laboratory.sanitized and ran.memory_mb > memory_mb:
            self.report_failure("more than %d MB: %s" % (memory_mb, description))
        if ran.code == WRONG_FILE and not re.search(rb"gyrotherm(-[a-z]+)?: ", ran.err):
            self.report_failure("refused without a message: " + description)
        for stream in (ran.out, ran.err):
            if any((byte < 32 and byte not in b"\n\t") or byte == 127 for byte in stream):
                self.report_failure("control characters in the output: " + description)
        after = listing(self.folder)
        if after != before:
            changed = sorted(name for name in before.keys() | after.keys() if before.get(name) != after.get(name))
            self.report_failure("changed %s: %s" % (", ".join(changed), description))
        return ran
