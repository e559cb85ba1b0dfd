# SPDX-License-Identifier: Apache-2.0
"""Links, pipes and devices in place of files, and files next to a record."""
import os

from laboratory import DONE, WRONG_FILE
from records import read_every_way
from spoil import spoiled


def links_beside(one):
    """The program writes nothing through a foreign link."""
    draw, laboratory = one.random, one.laboratory
    names = ["r.db.status", "r.db.sha256", "r.db.status.part", "r.db.sha256.part", "r.db-wal", "r.db-shm",
             "r.db-journal", "x.csv.part", "m.json.part", "r.db.socket", "r.db.safe-state", "r.db.made-safe", "r.2.db"]
    chosen = [name for name in names if draw.randrange(2)]
    for name in chosen:
        os.symlink("../precious", one.of("out/" + name))
    record = one.of("out/r.db")
    if draw.randrange(2):
        one.expect([DONE, WRONG_FILE], "import", laboratory.of("table.csv"), "--map", laboratory.of("map.toml"),
                   "--out", record)
    else:
        one.expect([DONE, WRONG_FILE], "run", laboratory.of("profile.toml"), "--rig", laboratory.of("rig.toml"),
                   "--out", record, "--quiet")
    one.expect([DONE], "export", laboratory.of("finished.db"), "--out", one.of("out/x.csv"))
    if draw.randrange(2):
        os.symlink("../precious", one.of("out/link.db"))
        one.expect([WRONG_FILE], "run", laboratory.of("profile.toml"), "--rig", laboratory.of("rig.toml"), "--out",
                   one.of("out/link.db"), "--quiet")


def something_else(one):
    """A pipe, a device, a folder or a kernel file in place of any file."""
    draw, laboratory = one.random, one.laboratory
    os.mkfifo(one.of("pipe"))
    os.symlink("pipe", one.of("link"))
    os.symlink("link2", one.of("link2"))
    other = draw.choice([one.of("pipe"), one.of("link"), one.of("link2"), one.folder, "/dev/zero", "/dev/full",
                         "/dev/tty", "/proc/self/mem", "/proc/self/maps", "/proc/kmsg", "/proc/self/environ",
                         "/sys/kernel/mm/transparent_hugepage/enabled", one.of("absent")])
    ways = [["check", other], ["check", "--rig", other],
            ["import", other, "--map", laboratory.of("map.toml"), "--out", one.of("out/t.db")],
            ["import", laboratory.of("table.csv"), "--map", other, "--out", one.of("out/t.db")],
            ["status", other], ["status", "--verify", other], ["export", other, "--out", one.of("out/x.csv")],
            ["resume", other], ["train", other, "--out", one.of("out/m.json")],
            ["verify", other, laboratory.of("table.db")], ["verify", laboratory.of("linear.json"), other],
            ["compensate", other], ["export-model", other, "--as", "libsvm"],
            ["reduce", other, laboratory.of("table.db"), "--out", one.of("out/m.json")],
            ["placement", other], ["thermal", "--gyro", other, "--out", one.of("out/image")],
            ["run", other, "--rig", laboratory.of("rig.toml"), "--out", one.of("out/r.db")]]
    for way in draw.sample(ways, 4):
        one.expect([WRONG_FILE], *way)


def pipe_beside(one):
    """Pipes in place of the files next to a record."""
    record, suffixes = one.random.choice([("unfinished.db", [".status", ".made-safe"]),
                                          ("finished.db", [".sha256", ".status", ".made-safe"])])
    path = one.copy(record, record + "-wal")
    suffix = one.random.choice(suffixes)
    os.mkfifo(path + suffix)
    read_every_way(one, path, [DONE, WRONG_FILE])


def file_beside(one):
    """Damaged files next to a record: they are reported or ignored, and never shown unchanged."""
    draw = one.random
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    status = open(path + ".status", "rb").read()
    made_safe = (b'schema = "gyrotherm-made-safe/1"\nat = "now"\nutc_ns = 1\nbecause = "\\u001b[2J\xff"\n'
                 b'set_point_c = 20\nconfirmed = true\ndetails = "\xe2\x80\xae"\n')
    victim, content = draw.choice([(".status", status), (".made-safe", made_safe)])
    content = draw.choice([spoiled(draw, content), content + b"x", content[:draw.randrange(len(content))], made_safe,
                           b"[" * 1_000_000, b"\xff" * 100])
    one.put("unfinished.db" + victim, content)
    read_every_way(one, path, [DONE, WRONG_FILE])
