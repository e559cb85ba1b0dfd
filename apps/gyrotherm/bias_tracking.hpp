// SPDX-License-Identifier: Apache-2.0
/// Options and noise for commands that track the residual bias of a model.
#pragma once

#include <optional>
#include <string>

#include "analysis/tracking/bias_noise.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/recorded_run.hpp"

namespace gyrotherm::app {

struct BiasTrackingArguments {
  bool track = false;
  /// Record from which the noise is estimated; empty for the noise stored in the model.
  std::string noise;
};
/// Adds the options --track and --noise. `what` is the help text of --track.
void add_tracking_options(CLI::App& command, BiasTrackingArguments& arguments, const std::string& what);

/// Returns the noise of the residual bias, or nothing if tracking was not requested. The noise is taken from the record
/// of --noise or, without it, from the model file, where it was estimated on held-out training clusters. Fails with
/// usage if neither source is given, or if --noise was given without --track. Fails also like load_recorded_run, verify
/// and estimate_bias_noise.
[[nodiscard]] Result<std::optional<tracking::BiasNoise>> find_tracking_noise(Console& console,
                                                                             const model::Model& model,
                                                                             const BiasTrackingArguments& arguments,
                                                                             const RecordedRunOptions& options);

/// Returns "N 0.00029 °/√h, B 0.00072 °/h, K 0 °/h/√h, at the start ± 0.0021 °/h".
[[nodiscard]] std::string describe(const tracking::BiasNoise& noise);

}  // namespace gyrotherm::app
