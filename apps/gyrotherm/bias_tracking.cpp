// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/bias_tracking.hpp"

#include <fmt/format.h>

#include "analysis/model/verification.hpp"

namespace gyrotherm::app {

void add_tracking_options(CLI::App& command, BiasTrackingArguments& arguments, const std::string& what) {
  command.add_flag("--track", arguments.track, what);
  command
      .add_option("--noise", arguments.noise,
                  "with --track: a record from whose residual the noise of the bias is identified, instead of the "
                  "model's own held-out training clusters")
      ->type_name(value::kRecord);
}

Result<std::optional<tracking::BiasNoise>> find_tracking_noise(Console& console, const model::Model& model,
                                                               const BiasTrackingArguments& arguments,
                                                               const RecordedRunOptions& options) {
  if (!arguments.track) {
    if (arguments.noise.empty()) return std::nullopt;
    return failure(FaultKind::usage, "--noise", "requires --track");
  }
  if (arguments.noise.empty()) {
    if (model.residual_noise) return model.residual_noise;
    return failure(FaultKind::usage, "--track",
                   "the model does not contain the noise of its residual bias; name a record of the gyro with --noise");
  }
  const auto recorded = load_recorded_run(console, arguments.noise,
                                          {.unverified = options.unverified,
                                           .axis = axis_for(model, options.axis),
                                           .cluster_length_s = model.cluster_length_s});
  if (!recorded) return failure(recorded.error());
  const auto verification = verify(model, recorded->dataset, recorded->clusters);
  if (!verification) return failure(verification.error());
  if (verification->trained_on_this) {
    console.print_message(
        fmt::format("warning: {}: the model was trained on this record, so its residual understates the bias drift",
                    arguments.noise));
  }
  const auto noise = tracking::estimate_bias_noise(verification->residual_deg_per_h, recorded->clusters,
                                                   verification->floor.deg_per_h);
  if (!noise) return failure(noise.error());
  return *noise;
}

std::string describe(const tracking::BiasNoise& noise) {
  return fmt::format("N {:.3g} °/√h, B {:.3g} °/h, K {:.3g} °/h/√h, at the start ± {:.2g} °/h",
                     noise.angle_random_walk_deg_per_sqrt_h, noise.instability_deg_per_h,
                     noise.rate_random_walk_deg_per_h_per_sqrt_h, noise.start_deg_per_h);
}

}  // namespace gyrotherm::app
