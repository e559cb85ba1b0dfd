# SPDX-License-Identifier: Apache-2.0
"""Hostile records: flipped, cut, edited, with a journal next to them, or empty."""
import json
import os
import shutil
import sqlite3
import struct

from laboratory import DONE, WRONG_FILE
from spoil import spoiled


def read_every_way(one, path, codes):
    one.expect(codes, "status", path)
    one.expect(codes, "status", path, "--json")
    one.expect(codes, "status", "--verify", path)
    one.expect(codes, "export", path, "--out", one.of("out/x.csv"))


def flipped_record(one):
    draw, laboratory = one.random, one.laboratory
    with_manifest = draw.randrange(2) == 0
    path = one.copy("finished.db", *(["finished.db.sha256"] if with_manifest else []))
    with open(path, "rb") as file:
        content = file.read()
    one.put("finished.db", spoiled(draw, content))
    read = [WRONG_FILE] if with_manifest else [DONE, WRONG_FILE]
    one.expect([DONE, WRONG_FILE], "status", path)
    one.expect(read, "status", "--verify", path)
    exported = one.expect(read, "export", path, "--out", one.of("out/x.csv"))
    if exported.code == DONE:
        with open(one.of("out/x.csv"), "rb") as file:
            if file.read() != laboratory.finished_rows:
                one.complain("other rows than were written passed for verified")
    one.expect([DONE, WRONG_FILE], "export", "--unverified", path, "--out", one.of("out/y.csv"))


def cut_record(one):
    path = one.copy("finished.db", *(["finished.db.sha256"] if one.random.randrange(2) else []))
    os.truncate(path, one.random.randrange(os.path.getsize(path)))
    read_every_way(one, path, [WRONG_FILE])


def flipped_log(one):
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    with open(path + "-wal", "rb") as file:
        content = file.read()
    one.put("unfinished.db-wal", spoiled(one.random, content, most=10))
    read_every_way(one, path, [DONE, WRONG_FILE])


def cut_log(one):
    """Lost acknowledged rows are reported, wherever the log ends. So is a file into which the log was being folded,
    which is not a database without it."""
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    whole = json.loads(one.expect([DONE], "status", "--json", path).out)["acknowledged"]
    os.truncate(path + "-wal", one.random.randrange(os.path.getsize(path + "-wal")))
    shown = one.expect([DONE, WRONG_FILE], "status", "--json", path)
    left = json.loads(shown.out)["acknowledged"] if shown.code == DONE else -1
    told = json.loads(open(path + ".status").read())["acknowledged"]
    one.expect([WRONG_FILE] if left < told else [DONE], "status", "--verify", path)
    one.expect([WRONG_FILE] if left < told else [DONE], "export", path, "--out", one.of("out/x.csv"))
    if left > whole:
        one.complain("a log that was cut holds more than before")


def resumed_after_damage(one):
    """A resume writes only the record itself. It may take as long as the run."""
    one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    victim = one.random.choice(["unfinished.db", "unfinished.db-wal"])
    with open(one.of(victim), "rb") as file:
        content = file.read()
    one.put(victim, spoiled(one.random, content, most=5))
    for name in ("unfinished.db", "unfinished.db-wal", "unfinished.db.status"):
        os.rename(one.of(name), one.of("out/" + name))
    one.expect([DONE, WRONG_FILE], "resume", one.of("out/unfinished.db"), patience_s=60)


EDITS = [
    ("DROP TABLE sample", "CREATE VIEW sample AS WITH RECURSIVE x(slot) AS "
     "(SELECT 0 UNION ALL SELECT slot + 1 FROM x) SELECT * FROM x"),
    ("DROP TABLE meta", "CREATE VIEW meta AS WITH RECURSIVE x(n) AS (SELECT 0 UNION ALL SELECT n + 1 FROM x) "
     "SELECT 'schema' AS key, 'gyrotherm-run/1' AS value FROM x"),
    ("DROP TABLE event", "CREATE VIEW event AS SELECT 1 AS id, 0 AS slot, 0 AS monotonic_ns, 0 AS utc_ns, "
     "'note' AS kind, hex(zeroblob(100000000)) AS text"),
    ("CREATE TRIGGER t AFTER INSERT ON event BEGIN DELETE FROM sample; END",),
    ("CREATE TRIGGER t BEFORE INSERT ON meta BEGIN SELECT load_extension('/tmp/x'); END",),
    ("CREATE INDEX i ON sample(pulses)",), ("CREATE TABLE more(x)",), ("DROP TABLE gap",), ("ANALYZE",),
    ("ALTER TABLE sample ADD COLUMN more REAL",), ("ALTER TABLE gap ADD COLUMN more AS (first + 1)",),
    ("ALTER TABLE channel RENAME COLUMN name TO title",),
    ("DROP TABLE list", "CREATE VIRTUAL TABLE list USING fts4(name, position, value)"),
    ("INSERT INTO gap VALUES(1000, 1000000000000000000, 'x', 0)",), ("INSERT INTO gap VALUES(-5, -1, 'x', 0)",),
    ("UPDATE sample SET slot = -slot - 1",), ("UPDATE sample SET slot = slot + 9000000000000000000",),
    ("UPDATE sample SET slot = slot + 200000000",), ("UPDATE event SET slot = -9223372036854775808",),
    ("UPDATE sample SET utc_ns = -9223372036854775807",), ("UPDATE sample SET soaked_ns = 9223372036854775807",),
    ("UPDATE meta SET value = -5 WHERE key = 'started_utc_ns'",),
    ("UPDATE meta SET value = zeroblob(100000000) WHERE key = 'profile_text'",),
    ("UPDATE meta SET value = 'x' WHERE key = 'schema'",), ("DELETE FROM meta",), ("DELETE FROM channel",),
    ("UPDATE channel SET name = 'x\"; DROP TABLE sample; --'",), ("UPDATE channel SET name = 'slot'",),
    ("PRAGMA user_version = 99",), ("PRAGMA user_version = 0",), ("PRAGMA application_id = 0",),
    ("UPDATE sample SET pulses = 1e300 WHERE slot = 5",), ("UPDATE sample SET A = 'warm' WHERE slot = 5",),
    ("UPDATE sample SET phase = X'FF00FF' WHERE slot = 5",), ("UPDATE event SET text = X'1B5B324AFF' WHERE id = 1",),
    ("UPDATE fault SET what = char(27) || ']0;x' || char(7)", "UPDATE event SET text = char(27) || '[2J'"),
    ("DELETE FROM sample WHERE slot = 7",), ("UPDATE sample SET segment = 99999",), ("UPDATE sample SET cycle = -7",),
]


def edited_record(one):
    """Nothing in a record is executed, and changed content is not accepted as original."""
    name = one.random.choice(["finished.db", "unfinished.db"])
    path = one.copy(name, name + "-wal")
    for statement in one.random.choice(EDITS):
        database = sqlite3.connect(path, isolation_level=None)
        database.execute(statement)
        database.close()
    one.expect([DONE, WRONG_FILE], "status", path)
    one.expect([DONE, WRONG_FILE], "status", path, "--json")
    one.expect([WRONG_FILE], "status", "--verify", path)
    one.expect([WRONG_FILE], "export", path, "--out", one.of("out/x.csv"))
    one.expect([DONE, WRONG_FILE], "export", "--unverified", path, "--out", one.of("out/y.csv"))
    shutil.copy2(path, one.of("out/r.db"))
    one.expect([2, WRONG_FILE], "resume", one.of("out/r.db"))


def hot_journal(path, super_journal):
    """The journal of an interrupted transaction, which names another journal."""
    other = path + ".other"
    shutil.copy2(path, other)
    writer = sqlite3.connect(other, isolation_level=None)
    writer.execute("PRAGMA journal_mode = DELETE")
    writer.execute("PRAGMA cache_size = 2")
    writer.execute("BEGIN IMMEDIATE")
    writer.execute("UPDATE sample SET set_point_c = 0")
    with open(other + "-journal", "rb") as file:
        journal = file.read()
    shutil.copy2(other, path)
    writer.rollback()
    writer.close()
    os.remove(other)
    if super_journal:
        name = super_journal.encode()
        lock_page = 0x40000000 // 4096 + 1
        journal += struct.pack(">I", lock_page) + name
        journal += struct.pack(">II", len(name), sum(name)) + b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7"
    return journal


def journal_beside(one):
    draw = one.random
    path = one.copy(draw.choice(["finished.db", "table.db"]))
    journal = path + "-journal"
    kind = draw.randrange(6)
    if kind <= 2:
        with open(journal, "wb") as file:
            file.write(hot_journal(path, one.of("precious") if kind > 0 else ""))
    elif kind == 3:
        with open(journal, "wb") as file:
            file.write(bytes(draw.randrange(256) for _ in range(draw.randrange(2000))))
    elif kind == 4:
        os.symlink(draw.choice(["precious", "nowhere"]), journal)
    else:
        os.mkfifo(journal)
    read_every_way(one, path, [WRONG_FILE])
    one.expect([WRONG_FILE], "verify", one.laboratory.of("linear.json"), path)


def emptied_record(one):
    """A reader that finds the record empty does not change its log."""
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    os.truncate(path, one.random.choice([0, 1, 99, 100, 511, 4096]))
    read_every_way(one, path, [DONE, WRONG_FILE])


def no_record(one):
    draw = one.random
    path = one.put("r.db", draw.choice([b"", b"SQLite format 3\0", b"x" * 5000,
                                        bytes(draw.randrange(256) for _ in range(4096)),
                                        b"SQLite format 3\0" + bytes(draw.randrange(256) for _ in range(8176))]))
    if draw.randrange(2):
        one.copy("unfinished.db-wal")
        os.rename(one.of("unfinished.db-wal"), path + "-wal")
    read_every_way(one, path, [WRONG_FILE])


def strange_name(one):
    name = one.random.choice(["a?b.db", "a%41.db", "#.db", "file:r.db?mode=rwc", "a&b.db", "é.db", "a b.db", "a'b.db"])
    one.copy("unfinished.db", "unfinished.db-wal")
    for suffix in ("", "-wal"):
        os.rename(one.of("unfinished.db" + suffix), one.of(name + suffix))
    read_every_way(one, one.of(name), [DONE])
