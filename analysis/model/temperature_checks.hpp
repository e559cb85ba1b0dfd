// SPDX-License-Identifier: Apache-2.0
/// Checks whether records contain what a model of the temperature must be learnt from.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/features.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Returns the fault of a record without a thermometer.
[[nodiscard]] Fault no_thermometer_fault(const data::Dataset& dataset);

/// Fails with usage if the cluster means of all thermometers in the terms vary by
/// less than three times their noise, so that a model would only learn noise. Terms with other inputs pass.
[[nodiscard]] Result<void> check_temperatures_vary(const std::vector<data::Term>& terms,
                                                   const std::vector<data::Dataset>& datasets,
                                                   const std::vector<data::Clusters>& records);

/// Returns a warning if a drift of the gyro cannot be distinguished from an effect of the temperature: in every record,
/// the mean of the thermometers in the terms has a correlation above 0.9 with time, and no reversal of more than a
/// tenth of its range.
[[nodiscard]] std::optional<std::string> find_confusion_with_time(const std::vector<data::Term>& terms,
                                                                  const std::vector<data::Clusters>& records);

}  // namespace gyrotherm::model
