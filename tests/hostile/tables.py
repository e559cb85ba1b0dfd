# SPDX-License-Identifier: Apache-2.0
"""Hostile models and tables."""
import os

from laboratory import DONE, TOML_MEMORY_MB, WRONG_FILE
from damage import mutate_text, flip_bits


def hostile_model(one):
    draw, laboratory = one.random, one.laboratory
    text = laboratory.read_text(laboratory.path(draw.choice(["linear.json", "svr.json"])))
    variants = [lambda: mutate_text(draw, text), lambda: flip_bits(draw, text.encode(), most=20),
             lambda: text[:draw.randrange(len(text))], lambda: "[" * draw.randrange(1, 3_000_000), lambda: '{"a":' * draw.randrange(1, 1_000_000),
             lambda: "[" + "1," * draw.randrange(1, 1_000_000) + "1]",
             lambda: '"' + "x" * draw.randrange(1, 20_000_000),
             lambda: text.replace("0.", draw.choice(["1e999", "-1e308", "null", '"x"', "[]", "1e-400"]),
                                  1 + draw.randrange(5)),
             lambda: text.replace(draw.choice(["terms", "scaling", "schema", "mean", "weights", "trained_on"]), "x", 1)]
    path = one.put("model.json", draw.choice(variants)())
    one.expect([DONE, WRONG_FILE], "verify", path, laboratory.path("table.db"))
    one.expect([DONE, WRONG_FILE], "export-model", path, "--as", "c", "--out", one.path("out/x.c"))
    with open(laboratory.path("table.csv"), "rb") as rows:
        one.expect([DONE, WRONG_FILE], "compensate", path, stdin=rows)


def hostile_table(one):
    draw, laboratory = one.random, one.laboratory
    text = laboratory.read_text(laboratory.path("table.csv"))
    lines = text.split("\n")
    variants = [lambda: mutate_text(draw, text), lambda: flip_bits(draw, text.encode(), most=20),
             lambda: text + "1," * draw.randrange(1, 20_000_000), lambda: text + "1" * draw.randrange(1, 20_000_000),
             lambda: "A,B,bias" + ",x" * draw.randrange(1, 100_000) + "\n1,2,3\n", lambda: text.replace("\n", "\r"),
             lambda: text.replace(",", draw.choice([";", "\t", "\0", '","', '"'])),
             lambda: "", lambda: "\n" * 1_000_000,
             lambda: text + draw.choice(["nan,1,1", "1e999,1,1", "1;1;1", "1,1", "1,1,1,1", '"1,1,1',
                                        "\x1b[2J,1,1"]) + "\n",
             lambda: "\n".join(draw.sample(lines, len(lines))), lambda: os.urandom(100_000)]
    path = one.put("table.csv", draw.choice(variants)())
    one.expect([DONE, WRONG_FILE], "import", path, "--map", laboratory.path("map.toml"), "--out", one.path("out/t.db"),
               memory_mb=TOML_MEMORY_MB)
    with open(path, "rb") as rows:
        one.expect([DONE, WRONG_FILE], "compensate", laboratory.path("linear.json"), stdin=rows,
                   memory_mb=TOML_MEMORY_MB)
