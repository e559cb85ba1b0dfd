# SPDX-License-Identifier: Apache-2.0
"""Hostile records: flipped, cut, edited, with a journal next to them, or empty."""
import json
import os
import shutil
import sqlite3
import struct

from laboratory import DONE, WRONG_FILE
from damage import flip_bits


def try_every_reader(one, path, codes):
    one.expect(codes, "status", path)
    one.expect(codes, "status", path, "--json")
    one.expect(codes, "status", "--verify", path)
    one.expect(codes, "export", path, "--out", one.path("out/x.csv"))


def flipped_record(one):
    draw, laboratory = one.random, one.laboratory
    with_manifest = draw.randrange(2) == 0
    path = one.copy("finished.db", *(["finished.db.sha256"] if with_manifest else []))
    with open(path, "rb") as file:
        content = file.read()
    one.put("finished.db", flip_bits(draw, content))
    read = [WRONG_FILE] if with_manifest else [DONE, WRONG_FILE]
    one.expect([DONE, WRONG_FILE], "status", path)
    one.expect(read, "status", "--verify", path)
    exported = one.expect(read, "export", path, "--out", one.path("out/x.csv"))
    if exported.code == DONE:
        with open(one.path("out/x.csv"), "rb") as file:
            if file.read() != laboratory.finished_rows:
                one.report_failure("rows that differ from the written ones were verified")
    one.expect([DONE, WRONG_FILE], "export", "--unverified", path, "--out", one.path("out/y.csv"))


def cut_record(one):
    path = one.copy("finished.db", *(["finished.db.sha256"] if one.random.randrange(2) else []))
    os.truncate(path, one.random.randrange(os.path.getsize(path)))
    try_every_reader(one, path, [WRONG_FILE])


def flipped_log(one):
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    with open(path + "-wal", "rb") as file:
        content = file.read()
    one.put("unfinished.db-wal", flip_bits(one.random, content, most=10))
    try_every_reader(one, path, [DONE, WRONG_FILE])


def cut_log(one):
    """Log that is cut at a random position. If acknowledged rows are lost, the program must report it. It must also
    report a database that was being checkpointed and is not readable without its log."""
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    whole = json.loads(one.expect([DONE], "status", "--json", path).out)["acknowledged"]
    os.truncate(path + "-wal", one.random.randrange(os.path.getsize(path + "-wal")))
    shown = one.expect([DONE, WRONG_FILE], "status", "--json", path)
    left = json.loads(shown.out)["acknowledged"] if shown.code == DONE else -1
    description = json.loads(open(path + ".status").read())["acknowledged"]
    one.expect([WRONG_FILE] if left < description else [DONE], "status", "--verify", path)
    one.expect([WRONG_FILE] if left < description else [DONE], "export", path, "--out", one.path("out/x.csv"))
    if left > whole:
        one.report_failure("the cut log contains more rows than before")


def resumed_after_damage(one):
    """Damaged record that is resumed. The resume must write only the record, and may take as long as the run."""
    one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    victim = one.random.choice(["unfinished.db", "unfinished.db-wal"])
    with open(one.path(victim), "rb") as file:
        content = file.read()
    one.put(victim, flip_bits(one.random, content, most=5))
    for name in ("unfinished.db", "unfinished.db-wal", "unfinished.db.status"):
        os.rename(one.path(name), one.path("out/" + name))
    one.expect([DONE, WRONG_FILE], "resume", one.path("out/unfinished.db"), patience_s=60)


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
    """Record whose database was edited. Nothing in it may be executed, and the changed content must not be verified."""
    name = one.random.choice(["finished.db", "unfinished.db"])
    path = one.copy(name, name + "-wal")
    for statement in one.random.choice(EDITS):
        database = sqlite3.connect(path, isolation_level=None)
        database.execute(statement)
        database.close()
    one.expect([DONE, WRONG_FILE], "status", path)
    one.expect([DONE, WRONG_FILE], "status", path, "--json")
    one.expect([WRONG_FILE], "status", "--verify", path)
    one.expect([WRONG_FILE], "export", path, "--out", one.path("out/x.csv"))
    one.expect([DONE, WRONG_FILE], "export", "--unverified", path, "--out", one.path("out/y.csv"))
    shutil.copy2(path, one.path("out/r.db"))
    one.expect([2, WRONG_FILE], "resume", one.path("out/r.db"))


def hot_journal(path, super_journal):
    """Returns the journal of an interrupted transaction. It names `super_journal` unless that is empty."""
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


def journal_next_to_record(one):
    draw = one.random
    path = one.copy(draw.choice(["finished.db", "table.db"]))
    journal = path + "-journal"
    kind = draw.randrange(6)
    if kind <= 2:
        with open(journal, "wb") as file:
            file.write(hot_journal(path, one.path("precious") if kind > 0 else ""))
    elif kind == 3:
        with open(journal, "wb") as file:
            file.write(bytes(draw.randrange(256) for _ in range(draw.randrange(2000))))
    elif kind == 4:
        os.symlink(draw.choice(["precious", "nowhere"]), journal)
    else:
        os.mkfifo(journal)
    try_every_reader(one, path, [WRONG_FILE])
    one.expect([WRONG_FILE], "verify", one.laboratory.path("linear.json"), path)


def emptied_record(one):
    """Empty or truncated database with a log. A reader must not change the log."""
    path = one.copy("unfinished.db", "unfinished.db-wal", "unfinished.db.status")
    os.truncate(path, one.random.choice([0, 1, 99, 100, 511, 4096]))
    try_every_reader(one, path, [DONE, WRONG_FILE])


def not_a_record(one):
    draw = one.random
    path = one.put("r.db", draw.choice([b"", b"SQLite format 3\0", b"x" * 5000,
                                        bytes(draw.randrange(256) for _ in range(4096)),
                                        b"SQLite format 3\0" + bytes(draw.randrange(256) for _ in range(8176))]))
    if draw.randrange(2):
        one.copy("unfinished.db-wal")
        os.rename(one.path("unfinished.db-wal"), path + "-wal")
    try_every_reader(one, path, [WRONG_FILE])


def unusual_name(one):
    name = one.random.choice(["a?b.db", "a%41.db", "#.db", "file:r.db?mode=rwc", "a&b.db", "é.db", "a b.db", "a'b.db"])
    one.copy("unfinished.db", "unfinished.db-wal")
    for suffix in ("", "-wal"):
        os.rename(one.path("unfinished.db" + suffix), one.path(name + suffix))
    try_every_reader(one, one.path(name), [DONE])
