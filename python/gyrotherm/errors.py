# SPDX-License-Identifier: Apache-2.0
"""Exceptions of the package."""


class GyrothermError(Exception):
    """Base class of all exceptions below. The message states cause, location and remedy."""


class RecordError(GyrothermError):
    """The file is not a record, is damaged, or does not contain the requested data."""


class NotARecord(RecordError):
    """The file is not a record, or is a record of another version."""


class BeingWritten(RecordError):
    """Another process is writing the record."""


class ModelError(GyrothermError):
    """The file is not a model of this version, or inputs of the model are missing."""
