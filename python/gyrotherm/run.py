# SPDX-License-Identifier: Apache-2.0
"""A recorded run, as `gyrotherm.open` returns it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .axis import AxisColumns, choose_axis, make_axis_columns
from .clusters import Clusters, make_clusters
from .database import follow_links
from .errors import RecordError
from .folds import DEFAULT_BLOCKS, Rows, folds
from .info import Axis, RunInfo
from .record import EVENT_COLUMNS, FAULT_COLUMNS, Record, imported_gaps, read_record
from .table import Table, make_table, to_pandas, to_xarray

if TYPE_CHECKING:
    import pandas
    import xarray


class Run:
    """A recorded run. It is completely in memory, and the file is closed."""

    def __init__(self, path: str | os.PathLike[str], record: Record) -> None:
        self.path = Path(path)
        self.record = record  #: raw columns, one row per sample
        self._clusters: dict[tuple[str, str, float], Clusters] = {}

    def __repr__(self) -> str:
        kind = "SIMULATED run" if self.info.simulated else "run"
        axes = ", ".join(axis.label for axis in self.axes)
        rows = self.record.slot.size
        span = f"{rows} rows over {self.record.time_s[-1] if rows else 0:.10g} s" if self.info.imported else f"{rows} s"
        return f"<{kind} of {self.info.profile_name}, {span}, {axes or 'no gyro'}>"

    @property
    def info(self) -> RunInfo:
        """Description of the record, written before its first second."""
        return self.record.info

    @property
    def finished(self) -> bool:
        """True if the profile was completed."""
        return self.record.finished

    @property
    def axes(self) -> tuple[Axis, ...]:
        """All axes of all units under test."""
        return self.info.axes

    @property
    def events(self) -> pandas.DataFrame:
        """Returns the events in order: slot, time since the start, UTC, kind, …"""
        import pandas

        frame = pandas.DataFrame(self.record.events, columns=list(EVENT_COLUMNS))
        frame["time_s"] = frame.pop("monotonic_ns").astype(np.float64) / 1e9
        frame["utc"] = pandas.to_datetime(frame.pop("utc_ns").astype(np.int64), unit="ns", utc=True)
        return frame[["slot", "time_s", "utc", "kind", "interlock", "reaction", "segment", "channel", "text"]]

    @property
    def faults(self) -> pandas.DataFrame:
        """Returns the reasons for NaN values in samples: slot, channel, kind, where, what."""
        import pandas

        return pandas.DataFrame(self.record.faults, columns=list(FAULT_COLUMNS))

    @property
    def gaps(self) -> pandas.DataFrame:
        """Returns the ranges of slots without a sample, and the cause of each. For an imported record, returns the times
        of the rows before and after each gap that the import counted, in seconds since the first row."""
        import pandas

        if self.info.imported:
            return pandas.DataFrame(imported_gaps(self.record), columns=["first", "last", "cause"])
        rows = [(gap.first, gap.last, gap.cause) for gap in self.record.gaps]
        return pandas.DataFrame(rows, columns=["first", "last", "cause"])

    @property
    def segments(self) -> pandas.DataFrame:
        """Returns the segments of the expanded profile, with the number of samples of each in the record."""
        import pandas

        seconds = np.bincount(self.record.segment[self.record.segment >= 0], minlength=len(self.info.segments))
        rows = [{**vars(segment), "seconds": int(count)} for segment, count in zip(self.info.segments, seconds)]
        return pandas.DataFrame(rows)

    def _table(self, is_calibrated: bool) -> Table:
        return make_table(self.record, is_calibrated)

    def to_pandas(self, *, calibrated: bool = True) -> pandas.DataFrame:
        """Returns one row per second from the start to the end, NaN in gaps: temperatures (calibrated or raw), raw
        counts, bias in °/h. Units are in `attrs["columns"]`."""
        return to_pandas(self._table(calibrated))

    def to_xarray(self, *, calibrated: bool = True) -> xarray.Dataset:
        """Returns the content of `to_pandas` as a Dataset. Units are in the attributes of each variable."""
        return to_xarray(self._table(calibrated))

    def axis(self, unit: str = "", axis: str = "") -> AxisColumns:
        """Returns the columns of one axis. A name may be omitted if there is only one. `unit` may be a label such as
        "u1.x"."""
        try:
            return make_axis_columns(self.record, choose_axis(self.info, unit, axis))
        except RecordError as error:
            raise RecordError(f"{self.path}: {error}") from None

    def inputs_each_second(self, unit: str = "", axis: str = "") -> pandas.DataFrame:
        """Returns the possible model inputs and "bias", one row per second, NaN in gaps."""
        frame = self.axis(unit, axis).to_pandas()
        if self.info.imported:
            raise RecordError(f"{self.path}: an imported record has no grid of seconds; use its clusters")
        return frame.reindex(np.arange(int(frame.index[-1]) + 1, dtype=np.float64)).rename_axis("time_s")

    def clusters(self, unit: str = "", axis: str = "", length_s: float = 100) -> Clusters:
        """Returns the means of one axis over `length_s`, for training and verifying models. The result is cached."""
        if not self.finished:
            raise RecordError(f'{self.path}: the run has not finished; complete it with "gyrotherm resume"')
        key, info = (unit, axis, length_s), self.info
        if key not in self._clusters:
            columns = self.axis(unit, axis)
            try:
                made = make_clusters(columns, length_s, info.id, info.profile_name, info.simulated)
            except RecordError as error:
                raise RecordError(f"{self.path}: {error}") from None
            self._clusters[key] = made
        return self._clusters[key]

    def folds(self, by: str = "auto", *, unit: str = "", axis: str = "", blocks: int = DEFAULT_BLOCKS,
              guard_minutes: float | None = None) -> list[tuple[Rows, Rows]]:
        """Returns the training rows and held-out rows of `clusters(unit, axis)` for each fold, as the program does."""
        return folds(self.clusters(unit, axis), by, blocks=blocks, guard_minutes=guard_minutes)


def open_run(path: str | os.PathLike[str]) -> Run:
    """Reads all files of a record. Raises `BeingWritten` while the run is active; use `follow` for such a run. Does not
    verify the record; use `gyrotherm status RUN.db --verify`."""
    record = follow_links(path)
    return Run(record, read_record(record))
