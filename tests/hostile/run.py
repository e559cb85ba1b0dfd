#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Passes hostile files to the program. It must read each or refuse it with one message, within seconds and bounded
memory, and must not change any other file.

    run.py PROGRAM SOURCE [--count N] [--first N] [--seed N] [--sanitized] [--keep DIR]

Each input has its own seed, so --first NUMBER --count 1 reproduces a failing one."""
import argparse
import collections
import concurrent.futures
import json
import os
import random
import resource
import shutil
import sqlite3
import stat
import sys
import time

from laboratory import Input, Laboratory
from neighbours import damaged_file_next_to_record, foreign_links, pipe_next_to_record, special_file
from records import (cut_log, cut_record, edited_record, emptied_record, flipped_log, flipped_record,
                     journal_next_to_record, not_a_record, resumed_after_damage, unusual_name)
from tables import hostile_model, hostile_table
from texts import hostile_text_in_record, toml_bomb, toml_mutation

# Makers of inputs and their shares in percent.
KINDS = [(toml_mutation, 16), (toml_bomb, 10), (hostile_text_in_record, 2), (flipped_record, 12), (cut_record, 3),
         (flipped_log, 5), (cut_log, 4), (resumed_after_damage, 3), (edited_record, 9), (journal_next_to_record, 5),
         (emptied_record, 1), (not_a_record, 2), (unusual_name, 1), (foreign_links, 4), (special_file, 8),
         (pipe_next_to_record, 2), (damaged_file_next_to_record, 3), (hostile_model, 6), (hostile_table, 4)]


def pipes(folder, names):
    return [name for name in names if stat.S_ISFIFO(os.lstat(os.path.join(folder, name)).st_mode)]


def run_input(laboratory, number, seed, keep):
    """Makes and checks one input. Spreads the kinds evenly, so any range of inputs has all of them."""
    turns = [kind for kind, share in KINDS for _ in range(share)]
    random.Random(seed).shuffle(turns)
    kind = turns[number % len(turns)]
    one = Input(laboratory, number, seed)
    began = time.monotonic()
    try:
        kind(one)
    except (OSError, sqlite3.Error, json.JSONDecodeError, UnicodeDecodeError) as error:
        one.report_failure("the input could not be made or checked: %r" % error)
    if one.failures and keep:
        shutil.copytree(one.folder, os.path.join(keep, "input-%d" % number), symlinks=True, dirs_exist_ok=True,
                        ignore=pipes)
    shutil.rmtree(one.folder)
    return number, kind.__name__, one.failures, time.monotonic() - began


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("source")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=16)
    parser.add_argument("--sanitized", action="store_true", help="permit the time and memory of a sanitized program")
    parser.add_argument("--keep", help="copy the inputs that failed to this folder")
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if not options.sanitized:
        resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    laboratory = Laboratory(options.program, options.source, options.sanitized)
    failed, times, counts = 0, collections.Counter(), collections.Counter()
    try:
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            numbers = range(options.first, options.first + options.count)
            for number, kind, failures, seconds in pool.map(
                    lambda n: run_input(laboratory, n, options.seed, options.keep), numbers):
                times[kind] += seconds
                counts[kind] += 1
                failed += 1 if failures else 0
                for failure in failures:
                    print("%d %s: %s" % (number, kind, failure), flush=True)
    finally:
        shutil.rmtree(laboratory.folder, ignore_errors=True)
    for kind, count in counts.most_common():
        print("%5d %-22s %.2f s each" % (count, kind, times[kind] / count))
    print("%d inputs, %d failed" % (sum(counts.values()), failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
