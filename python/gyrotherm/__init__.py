# SPDX-License-Identifier: Apache-2.0
"""Records and models of gyrotherm in NumPy, pandas and xarray.

    import gyrotherm

    run = gyrotherm.open("ramp.db")
    run.to_pandas()                              # every second, NaN in gaps, temperatures calibrated, bias in °/h
    model = gyrotherm.load_model("model.json")
    residual = run.clusters().bias_deg_per_h - model.predict(run.clusters())
    gyrotherm.figures(residual).std

Reading does not change a record and creates no files.
"""

from .budget import Uncertainty
from .clusters import Clusters
from .errors import BeingWritten, GyrothermError, ModelError, RecordError
from .figures import Figures, figures
from .folds import folds
from .info import Axis, RunInfo, Segment, Thermometer, Unit, Value
from .live import follow
from .model import Model, load_model
from .run import Run
from .run import open_run as open  # noqa: A004
from .terms import Term, parse_term

__version__ = "0.2.0"
__all__ = ["Axis", "BeingWritten", "Clusters", "Figures", "GyrothermError", "Model", "ModelError", "RecordError", "Run",
           "RunInfo", "Segment", "Term", "Thermometer", "Uncertainty", "Unit", "Value", "figures", "folds", "follow",
           "load_model", "open", "parse_term"]
