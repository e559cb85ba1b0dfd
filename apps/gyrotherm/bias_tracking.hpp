// SPDX-License-Identifier: Apache-2.0
/// What a command needs to follow the bias that a model leaves.
#pragma once

#include <optional>
#include <string>

#include "analysis/tracking/bias_noise.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/recorded_run.hpp"

namespace gyrotherm::app {

struct BiasTrackingArguments {
  bool track = false;
  std::string noise;  ///< a record to take the noise of its residual from, instead of the model's
};
/// Adds the options --track, which does `what`, and --noise.
void add_tracking_options(CLI::App& command, BiasTrackingArguments& arguments, const std::string& what);

/// Nothing if tracking was not asked for; else the noise of what the model leaves: of its held-out training clusters,
/// as its file has it, or of the record that was named. Fails with usage if there is neither, or a record was named for
/// nothing, and like load_recorded_run, verify and noise_of_residual.
[[nodiscard]] Result<std::optional<tracking::BiasNoise>> noise_to_track(Console& console, const model::Model& model,
                                                                        const BiasTrackingArguments& arguments,
                                                                        const RecordedRunOptions& options);

/// "N 0.00029 °/√h, B 0.00072 °/h, K 0 °/h/√h, at the start ± 0.0021 °/h".
[[nodiscard]] std::string describe(const tracking::BiasNoise& noise);

}  // namespace gyrotherm::app
