# SPDX-License-Identifier: Apache-2.0
"""Exceptions of the package."""


class GyrothermError(Exception):
    """Base of all exceptions below. The text states cause, location and remedy."""


class RecordError(GyrothermError):
    """The file is not a record, is damaged, or does not contain the requested data."""


class NoRecord(RecordError):
    """The file is not a record, or is a record of another version."""


class BeingWritten(RecordError):
    """Another process is writing the record."""


class ModelError(GyrothermError):
    """The file is not a model of this version, or inputs of the model are missing."""
