// SPDX-License-Identifier: Apache-2.0
/// From one axis of a record, and the models it came and leaves with, to the results of a calibration report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::report {

/// One axis: its part of each record, and its models.
struct CalibratedAxis {
  std::string label{};  ///< as in CalibrationReport.item
  std::vector<data::RecordedRun> runs{};
  std::optional<model::Model> found{}, left{};
};

/// Adds results, budgets and figures of the axis: of each record its bias uncompensated, as found and as left, in the
/// order of Group, and how far the final biases of several starts differ over all of them.
///
/// What is stated as uncertain is the measurement: the record's own noise (type A, with its degrees of freedom where
/// these are known) and, of whatever counts from the zero of the bias, the Earth's rate that was taken away and the
/// scale factor (type B), which a model that was trained in the same mount has learnt and not got rid of; of the
/// Earth's rate that two positions give, the scale factor. Temperatures have the calibration of the gradient
/// thermometers and their drift until the run, as if all of them erred together. The compensated bias of the unit is
/// the mean over the record with the model's own budget of a mean over 1 h, as it is in that run: the thermometers'
/// drift until then is in it, but for a record that the model was trained on.
///
/// Fails with usage if a record lacks a thermometer that a model needs, or a model refuses all of it.
[[nodiscard]] Result<void> add_results(CalibrationReport& report, const CalibratedAxis& axis);

}  // namespace gyrotherm::report
