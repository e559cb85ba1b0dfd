# SPDX-License-Identifier: Apache-2.0
"""Hostile TOML from third parties: profiles, rigs, maps and gyro models."""
import os
import sqlite3

from laboratory import DONE, PROFILE, TOML_MEMORY_MB, WRONG_FILE
from damage import mutate_text


def toml_mutation(one):
    draw, laboratory = one.random, one.laboratory
    read = [DONE, WRONG_FILE]
    kind = draw.choice(["profile", "rig", "map", "chamber", "stream", "gyro"])
    text = laboratory.read_text(laboratory.path(("map" if kind == "map" else kind) + ".toml"))
    path = one.put(kind + ".toml", mutate_text(draw, text))
    if kind == "profile":
        one.expect(read, "check", path, "--rig", laboratory.path("rig.toml"), memory_mb=TOML_MEMORY_MB)
    elif kind == "rig":
        one.expect(read, "check", "--rig", path, memory_mb=TOML_MEMORY_MB)
    elif kind == "map":
        one.expect(read, "import", laboratory.path("table.csv"), "--map", path, "--out", one.path("out/t.db"),
                   memory_mb=TOML_MEMORY_MB)
    elif kind == "gyro":
        one.expect([WRONG_FILE], "thermal", "--gyro", path + ".absent", "--out", one.path("out/image"))
    else:
        rig = laboratory.read_text(laboratory.path("mixed.toml"))
        name = {"chamber": "chambers/watlow_f4t", "stream": "gyro-streams/kvh-17xx-a"}[kind]
        rig = one.put("rig.toml", rig.replace("%s/profiles/%s.toml" % (laboratory.source, name), path))
        one.expect(read, "check", "--rig", rig, memory_mb=TOML_MEMORY_MB)


def bomb(draw):
    """Returns a text that every reader must refuse, because it is invalid or too expensive to read."""
    many = lambda least, most: int(least * (most / least) ** draw.random())
    key = lambda parts: ".".join(["a"] * parts)
    variants = [
        lambda: key(many(40, 100_000)) + " = 1\n",
        lambda: "[" + key(many(40, 100_000)) + "]\n",
        lambda: "a = " + "[" * many(40, 1_000_000),
        lambda: "a = " + "{b=" * many(40, 1_000_000),
        lambda: "".join("[%s]\n" % key(i) for i in range(1, many(40, 1000))),
        lambda: "[[segment]]\n" * many(1000, 1_000_000),
        lambda: "".join("k%d = 1\n" % i for i in range(many(1000, 1_000_000))),
        lambda: "a = '" + "x" * many(65_537, 100_000_000) + "'\n",
        lambda: 'a = """' + "\n" * many(65_537, 10_000_000) + '"""\n',
        lambda: "a = " + draw.choice(['"""', "'''", '""', "'", '"']) * many(1000, 3_000_000),
        lambda: "a = [" + draw.choice(["1,", "{},", "[],", "'',", "1.5,"]) * many(1000, 2_000_000) + "]\n",
        lambda: "x" * many(2000, 3_000_000) + " = 1\n",
        lambda: "a = " + "1" * many(2000, 3_000_000) + "\n",
        lambda: "#" * many(5_000_000, 50_000_000),
        lambda: PROFILE.encode("utf-16"),
        lambda: PROFILE.replace("hold", "ho\0ld"),
        lambda: PROFILE.replace("count = 2", "count = %d" % many(30_000, 10**18)),
        lambda: PROFILE.replace("time = \"100 s\"", "time = \"%s\"" % ("1 s " * many(17_000, 100_000))),
        lambda: PROFILE + '[[segment]]\nkind = "hold"\nat = 20\ntime = "1 s"\n' * many(25_000, 80_000),
        lambda: b"\xff\xfe" * many(10, 100_000),
    ]
    return draw.choice(variants)()


def toml_bomb(one):
    laboratory = one.laboratory
    path = one.put("bomb.toml", bomb(one.random))
    one.expect([WRONG_FILE], "check", path, memory_mb=TOML_MEMORY_MB)
    reader = one.random.randrange(4)
    if reader == 0:
        one.expect([WRONG_FILE], "check", "--rig", path, memory_mb=TOML_MEMORY_MB)
    elif reader == 1:
        one.expect([WRONG_FILE], "import", laboratory.path("table.csv"), "--map", path, "--out", one.path("out/t.db"),
                   memory_mb=TOML_MEMORY_MB)
    elif reader == 2:
        rig = laboratory.read_text(laboratory.path("mixed.toml"))
        rig = rig.replace("%s/profiles/chambers/watlow_f4t.toml" % laboratory.source, path)
        one.expect([WRONG_FILE], "check", "--rig", one.put("rig.toml", rig), memory_mb=TOML_MEMORY_MB)
    else:
        one.expect([WRONG_FILE], "thermal", "--gyro", path, "--out", one.path("out/image"), memory_mb=TOML_MEMORY_MB)


def hostile_text_in_record(one):
    """Record with a malicious text. It must not be resumed."""
    laboratory = one.laboratory
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    name = one.random.choice(["profile_text", "rig_text", "chamber_map_text", "gyro_model_text"])
    content = bomb(one.random)
    with sqlite3.connect(path) as database:
        database.execute("UPDATE meta SET value = ? WHERE key = ?",
                         (content if isinstance(content, bytes) else content[:3_000_000], name))
    database.close()
    os.rename(path, one.path("out/u.db"))
    one.expect([WRONG_FILE], "resume", one.path("out/u.db"))
