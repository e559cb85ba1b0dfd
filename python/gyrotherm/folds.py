# SPDX-License-Identifier: Apache-2.0
"""Which clusters are held out together, as the program does it: cycles, whole records, programs, or blocks with a
guard. Never clusters at random: neighbours are nearly copies of each other."""

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
FEWEST_FOR_RECORDS = 3
KINDS = ("auto", "cycles", "records", "programs", "blocks")
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class _Cut:
    """Clusters of one record with the fold in which each is held out."""

    fold: Rows
    folds: int
    guard_s: float = 0.0


def _cut_at_cycles(record: Clusters, guard_minutes: float | None) -> _Cut:
    """Clusters outside any cycle go with the one before them, the first ones with the first."""
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
    """Seconds between each cluster and the nearest one of the fold, edge to edge."""
    starts = record.start_s[held_out]
    at = np.searchsorted(starts, record.start_s)
    before = record.start_s - starts[np.maximum(at - 1, 0)]
    after = starts[np.minimum(at, starts.size - 1)] - record.start_s
    return np.minimum(np.abs(before), np.abs(after)) - record.length_s


def _by_programs(records: Sequence[Clusters]) -> list[tuple[Rows, Rows]]:
    names = list(dict.fromkeys(record.profile_name for record in records))
    if len(names) < 2:
        raise RecordError(f'folds: by programs: all records are of "{"".join(names)}"; one of another is needed')
    program = np.concatenate([np.full(len(record), names.index(record.profile_name)) for record in records])
    return [(np.flatnonzero(program != p), np.flatnonzero(program == p)) for p in range(len(names))]


def _cuts(records: Sequence[Clusters], by: str, blocks: int, guard_minutes: float | None) -> list[_Cut]:
    cycles = [int(np.unique(record.cycle[record.cycle >= 0]).size) for record in records]
    if by == "auto":
        by = "records" if len(records) >= FEWEST_FOR_RECORDS and not any(cycles) else "cycles"
    if by == "records" and len(records) < 2:
        raise RecordError("folds: by records: a single record cannot be both held out and used for training")
    alone = len(records) == 1 and sum(cycles) == 1
    cuts = []
    for record, its_cycles in zip(records, cycles):
        if by == "records":
            cuts.append(_Cut(np.zeros(len(record), dtype=np.int64), 1))
        elif by == "cycles" and its_cycles and not alone:
            cuts.append(_cut_at_cycles(record, guard_minutes))
        else:
            cuts.append(_cut_into_blocks(record, blocks, guard_minutes))
    return cuts


def folds(records: Sequence[Clusters] | Clusters, by: str = "auto", *, blocks: int = DEFAULT_BLOCKS,
          guard_minutes: float | None = None) -> list[tuple[Rows, Rows]]:
    """Rows to learn from and rows held out, of each fold: what scikit-learn takes as `cv`. Rows number the clusters of
    all records, one after the other. `by` is "cycles" (a record without two is cut into blocks), "records", "programs",
    "blocks", or "auto": records where there are three or more and none has a cycle, else cycles. Clusters within the
    guard of what is held out are on neither side: none between cycles, around blocks 45 min but at most half a
    block."""
    if isinstance(records, Clusters):
        records = [records]
    if by not in KINDS:
        raise RecordError(f'folds: "{by}" is none of {", ".join(KINDS)}')
    if blocks < 2:
        raise RecordError(f"folds: {blocks} blocks are too few, expected two or more")
    if by == "programs":
        return _by_programs(records)
    plan: list[tuple[Rows, Rows]] = []
    everything = sum(len(record) for record in records)
    first = 0
    for record, cut in zip(records, _cuts(records, by, blocks, guard_minutes)):
        for fold in range(cut.folds):
            held_out = cut.fold == fold
            learnt = np.ones(everything, dtype=bool)
            far = _distance_to(record, held_out) >= cut.guard_s - 1e-6 * record.length_s
            learnt[first:first + len(record)] = far & ~held_out
            if not learnt.any():
                raise RecordError("folds: no training data remain outside a held-out fold; use a shorter guard")
            plan.append((np.flatnonzero(learnt), first + np.flatnonzero(held_out)))
        first += len(record)
    return plan
