# SPDX-License-Identifier: Apache-2.0
"""Links, pipes and devices in place of files, and files next to a record."""
import os

from laboratory import DONE, WRONG_FILE
from records import try_every_reader
from damage import flip_bits


def foreign_links(one):
    """Links with the names of the program's own files. It must not write through them."""
    draw, laboratory = one.random, one.laboratory
    names = ["r.db.status", "r.db.sha256", "r.db.status.part", "r.db.sha256.part", "r.db-wal", "r.db-shm",
             "r.db-journal", "x.csv.part", "m.json.part", "r.db.socket", "r.db.safe-state", "r.db.made-safe", "r.2.db"]
    chosen = [name for name in names if draw.randrange(2)]
    for name in chosen:
        os.symlink("../precious", one.path("out/" + name))
    record = one.path("out/r.db")
    if draw.randrange(2):
        one.expect([DONE, WRONG_FILE], "import", laboratory.path("table.csv"), "--map", laboratory.path("map.toml"),
                   "--out", record)
    else:
        one.expect([DONE, WRONG_FILE], "run", laboratory.path("profile.toml"), "--rig", laboratory.path("rig.toml"),
                   "--out", record, "--quiet")
    one.expect([DONE], "export", laboratory.path("finished.db"), "--out", one.path("out/x.csv"))
    if draw.randrange(2):
        os.symlink("../precious", one.path("out/link.db"))
        one.expect([WRONG_FILE], "run", laboratory.path("profile.toml"), "--rig", laboratory.path("rig.toml"), "--out",
                   one.path("out/link.db"), "--quiet")


def special_file(one):
    """Pipe, device, folder or kernel file in place of each argument."""
    draw, laboratory = one.random, one.laboratory
    os.mkfifo(one.path("pipe"))
    os.symlink("pipe", one.path("link"))
    os.symlink("link2", one.path("link2"))
    other = draw.choice([one.path("pipe"), one.path("link"), one.path("link2"), one.folder, "/dev/zero", "/dev/full",
                         "/dev/tty", "/proc/self/mem", "/proc/self/maps", "/proc/kmsg", "/proc/self/environ",
                         "/sys/kernel/mm/transparent_hugepage/enabled", one.path("absent")])
    ways = [["check", other], ["check", "--rig", other],
            ["import", other, "--map", laboratory.path("map.toml"), "--out", one.path("out/t.db")],
            ["import", laboratory.path("table.csv"), "--map", other, "--out", one.path("out/t.db")],
            ["status", other], ["status", "--verify", other], ["export", other, "--out", one.path("out/x.csv")],
            ["resume", other], ["train", other, "--out", one.path("out/m.json")],
            ["verify", other, laboratory.path("table.db")], ["verify", laboratory.path("linear.json"), other],
            ["compensate", other], ["export-model", other, "--as", "libsvm"],
            ["reduce", other, laboratory.path("table.db"), "--keep", "5", "--out", one.path("out/m.json")],
            ["placement", other], ["thermal", "--gyro", other, "--out", one.path("out/image")],
            ["run", other, "--rig", laboratory.path("rig.toml"), "--out", one.path("out/r.db")]]
    for way in draw.sample(ways, 4):
        one.expect([WRONG_FILE], *way)


def pipe_next_to_record(one):
    """Pipe in place of a file next to a record."""
    record, suffixes = one.random.choice([("unfinished.db", [".status", ".made-safe"]),
                                          ("finished.db", [".sha256", ".status", ".made-safe"])])
    path = one.copy(record, record + "-wal")
    suffix = one.random.choice(suffixes)
    os.mkfifo(path + suffix)
    try_every_reader(one, path, [DONE, WRONG_FILE])


def damaged_file_next_to_record(one):
    """Damaged file next to a record. It must be reported or ignored, and hostile text must not be printed unchanged."""
    draw = one.random
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    status = open(path + ".status", "rb").read()
    made_safe = (b'schema = "gyrotherm-made-safe/1"\nat = "now"\nutc_ns = 1\nbecause = "\\u001b[2J\xff"\n'
                 b'set_point_c = 20\nconfirmed = true\ndetails = "\xe2\x80\xae"\n')
    victim, content = draw.choice([(".status", status), (".made-safe", made_safe)])
    content = draw.choice([flip_bits(draw, content), content + b"x", content[:draw.randrange(len(content))], made_safe,
                           b"[" * 1_000_000, b"\xff" * 100])
    one.put("unfinished.db" + victim, content)
    try_every_reader(one, path, [DONE, WRONG_FILE])
