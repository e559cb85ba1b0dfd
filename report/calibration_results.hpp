// SPDX-License-Identifier: Apache-2.0
/// Computes the results of a calibration report from the records of one axis and its models as found and as left.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::report {

/// One axis: its data from each record, and its models as found and as left.
struct CalibratedAxis {
  std::string label{};
  std::vector<data::RecordedRun> runs{};
  std::optional<model::Model> found{}, left{};
};

/// Adds the results, budgets and figures of the axis. Each record contributes results for the uncompensated bias and
/// for the bias as found and as left, in the order of Group. The turn-on repeatability is computed over the starts in
/// all records.
///
/// The stated uncertainty covers the measurement: type A from the noise of the record, with its degrees of freedom
/// where known, and type B from the removed Earth rate and the scale factor, for each quantity that depends on the bias
/// reference. A model trained in the same mount has learnt the type B error as part of the bias and does not reduce it.
/// For an Earth rate measured in two positions, the only type B uncertainty is that of the scale factor. Temperatures
/// have the calibration uncertainty of the gradient thermometers and their drift until the run, assumed fully
/// correlated. The compensated bias of the unit is the mean over the record, with the model's budget of a 1 h mean in
/// that run. That budget includes the thermometer drift until the run, except for a record used in training, and a row
/// for the use outside the trained range, if there is any.
///
/// Fails with usage if a record has no channel for a thermometer of a model, or if a model rejects the whole record.
[[nodiscard]] Result<void> add_results(CalibrationReport& report, const CalibratedAxis& axis);

}  // namespace gyrotherm::report
