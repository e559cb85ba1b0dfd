# SPDX-License-Identifier: Apache-2.0
"""What may go wrong, each as an exception of its own."""


class GyrothermError(Exception):
    """Any of the below: what was wrong, where, and what to do."""


class RecordError(GyrothermError):
    """The file is no record, is damaged, or lacks what was asked for."""


class NoRecord(RecordError):
    """The file is no record, or one of another version."""


class BeingWritten(RecordError):
    """Another process is writing the record."""


class ModelError(GyrothermError):
    """The file is no model of this version, or its inputs are not there."""
