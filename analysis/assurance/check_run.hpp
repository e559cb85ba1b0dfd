// SPDX-License-Identifier: Apache-2.0
/// Results of one check run of a golden gyro: bias on each plateau, temperature coefficient, scatter, and the
/// differences between thermometers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::assurance {

/// Kinds of results. `earth_rate` exists only if the unit was turned around: it is half the difference between the
/// rates in both positions, minus the Earth rate of the rig file.
enum class CheckKind { bias, temperature_coefficient, scatter, earth_rate, thermometer };
/// Returns "bias", "temperature_coefficient", and so on.
[[nodiscard]] std::string name(CheckKind kind);

/// One result with its standard uncertainty within the run (type A). It does not contain what differs from run to run,
/// such as the turn-on; the charts estimate that.
struct CheckResult {
  CheckKind kind{};
  std::string axis{};         ///< label of the axis; of a thermometer, the unit that it belongs to
  std::string thermometer{};  ///< only for CheckKind::thermometer
  std::string plateau{};      ///< "50 °C", "20 °C, turned", "20 °C (2)"; empty for the whole run
  double at_c{};              ///< set point of the plateau
  bool turned{};
  double value{};
  double u{};
  std::string unit{};
};
/// Returns the identity of a result in a history: "bias x 50 °C".
[[nodiscard]] std::string label(const CheckResult& result);

void describe(auto& form, Like<CheckResult> auto& result) {
  form("kind", one_of(result.kind, {CheckKind::bias, CheckKind::temperature_coefficient, CheckKind::scatter,
                                    CheckKind::earth_rate, CheckKind::thermometer}));
  form("axis", result.axis);
  form("thermometer", result.thermometer);
  form("plateau", result.plateau);
  form("at_c", result.at_c);
  form("turned", result.turned);
  form("value", result.value);
  form("u", result.u);
  form("unit", result.unit);
}

/// Length at the end of each hold that is evaluated. Shorter holds are skipped.
inline constexpr double kPlateauSeconds = 1800;

/// Measures the results of the golden axes of one record; every element of `axes` is an axis of the same run.
///
/// The bias of a plateau is the mean over the last 30 min of the hold. The scatter is the standard deviation of 100-s
/// means about a cubic polynomial on each plateau. The temperature coefficient is the difference between the biases of
/// the hottest and the coldest plateau, divided by the difference between the mean temperatures of the gradient
/// thermometers. The difference of a thermometer is its mean minus the mean of all other thermometers of the unit.
/// Fails with usage if the record has no complete plateau, if its bias has no common reference because the Earth rate
/// is unknown, or if a value is missing on a plateau.
[[nodiscard]] Result<std::vector<CheckResult>> measure_check_run(const std::vector<data::Dataset>& axes);

}  // namespace gyrotherm::assurance
