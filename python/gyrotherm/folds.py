# SPDX-License-Identifier: Apache-2.0
"""Folds for cross-validation, the same as the program's: cycles, whole records, programs, or blocks with a guard.
Clusters are never held out at random, because neighbouring clusters are nearly equal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .clusters import SECONDS_PER_MINUTE, Clusters
from .errors import RecordError
from .record import Numbers

DEFAULT_BLOCKS = 4
DEFAULT_GUARD_MINUTES = 45.0
MIN_RECORDS = 3
KINDS = ("auto", "cycles", "records", "programs", "blocks")
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class _Cut:
    """Division of one record into folds."""

    fold: Rows  #: of each cluster, the fold that holds it out
    folds: int
    guard_s: float = 0.0


def _cut_at_cycles(record: Clusters, guard_minutes: float | None) -> _Cut:
    """Makes one fold per cycle. Clusters outside a cycle belong to the previous cycle, the first ones to the first."""
    numbers: dict[int, int] = {}
    fold, current = [], 0
    for cycle in record.cycle.tolist():
        if cycle >= 0:
            current = numbers.setdefault(cycle, len(numbers))
        fold.append(current)
    return _Cut(np.array(fold, dtype=np.int64), len(numbers), (guard_minutes or 0.0) * SECONDS_PER_MINUTE)


def _cut_into_blocks(record: Clusters, blocks: int, guard_minutes: float | None) -> _Cut:
    rows = len(record)
    if rows < 2 * blocks:
        raise RecordError(f"folds: a record of {rows} clusters is too short for {blocks} blocks")
    guard_s = min(DEFAULT_GUARD_MINUTES * SECONDS_PER_MINUTE, math.floor(rows // blocks / 2) * record.length_s)
    if guard_minutes is not None:
        guard_s = guard_minutes * SECONDS_PER_MINUTE
    return _Cut(np.arange(rows, dtype=np.int64) * blocks // rows, blocks, guard_s)


def _distance_to(record: Clusters, held_out: NDArray[np.bool_]) -> Numbers:
    """Returns the time between each cluster and the nearest held-out cluster, edge to edge, s."""
    starts = record.start_s[held_out]
    at = np.searchsorted(starts, record.start_s)
    before = record.start_s - starts[np.maximum(at - 1, 0)]
    after = starts[np.minimum(at, starts.size - 1)] - record.start_s
    return np.minimum(np.abs(before), np.abs(after)) - record.length_s


def _folds_by_program(records: Sequence[Clusters]) -> list[tuple[Rows, Rows]]:
    names = list(dict.fromkeys(record.profile_name for record in records))
    if len(names) < 2:
        raise RecordError(f'folds: by programs: all records are of program "{"".join(names)}"; add a record of'
                          " another program")
    program = np.concatenate([np.full(len(record), names.index(record.profile_name)) for record in records])
    return [(np.flatnonzero(program != p), np.flatnonzero(program == p)) for p in range(len(names))]


def _cut_records(records: Sequence[Clusters], by: str, blocks: int, guard_minutes: float | None) -> list[_Cut]:
    cycles = [int(np.unique(record.cycle[record.cycle >= 0]).size) for record in records]
    if by == "auto":
        by = "records" if len(records) >= MIN_RECORDS and not any(cycles) else "cycles"
    if by == "records" and len(records) < 2:
        raise RecordError("folds: by records: a single record cannot be both held out and used for training")
    has_one_cycle = len(records) == 1 and sum(cycles) == 1
    cuts = []
    for record, cycle_count in zip(records, cycles):
        if by == "records":
            cuts.append(_Cut(np.zeros(len(record), dtype=np.int64), 1))
        elif by == "cycles" and cycle_count and not has_one_cycle:
            cuts.append(_cut_at_cycles(record, guard_minutes))
        else:
            cuts.append(_cut_into_blocks(record, blocks, guard_minutes))
    return cuts


def folds(records: Sequence[Clusters] | Clusters, by: str = "auto", *, blocks: int = DEFAULT_BLOCKS,
          guard_minutes: float | None = None) -> list[tuple[Rows, Rows]]:
    """Returns the training rows and the held-out rows of each fold, for the parameter `cv` of scikit-learn. A row is an
    index into the clusters of all records, in order.

    `by` is one of:
    - "cycles": one fold per cycle. A record without cycles, or a single record with one cycle, is divided into blocks.
    - "records" or "programs": one fold per record or per program.
    - "blocks": `blocks` blocks of each record.
    - "auto": "records" if there are at least three and none has cycles, otherwise "cycles".

    Clusters within the guard around the held-out ones are in neither set. By default the guard is 0 around cycles, and
    45 min around blocks, but at most half a block."""
    if isinstance(records, Clusters):
        records = [records]
    if by not in KINDS:
        raise RecordError(f'folds: unknown kind "{by}", expected {", ".join(KINDS)}')
    if blocks < 2:
        raise RecordError(f"folds: {blocks} blocks are too few, expected two or more")
    if by == "programs":
        return _folds_by_program(records)
    plan: list[tuple[Rows, Rows]] = []
    cluster_count = sum(len(record) for record in records)
    first = 0
    for record, cut in zip(records, _cut_records(records, by, blocks, guard_minutes)):
        for fold in range(cut.folds):
            held_out = cut.fold == fold
            training = np.ones(cluster_count, dtype=bool)
            is_outside_guard = _distance_to(record, held_out) >= cut.guard_s - 1e-6 * record.length_s
            training[first:first + len(record)] = is_outside_guard & ~held_out
            if not training.any():
                raise RecordError("folds: no training data remain outside a held-out fold; use a shorter guard")
            plan.append((np.flatnonzero(training), first + np.flatnonzero(held_out)))
        first += len(record)
    return plan
