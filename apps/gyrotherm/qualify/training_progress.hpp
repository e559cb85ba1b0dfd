// SPDX-License-Identifier: Apache-2.0
/// Progress of all trainings of one axis as a single number.
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::app {

/// Combines the progress of the trainings into one fraction, which never decreases and reaches 1 only at the end. Each
/// model has a weight: its measured share of the time on the default rig. Not thread-safe.
class TrainingProgress {
 public:
  /// `compares` is true if the methods of comparison are trained, too. `show` receives the combined progress; may be
  /// empty.
  TrainingProgress(ProgressSink show, bool compares);

  /// Takes the progress of one training: "training multi-point: tuning" and its fraction. Returns false if the
  /// trainings must stop.
  bool operator()(std::string_view stage, double fraction);

 private:
  ProgressSink show_;
  double total_{};
  std::string model_;  ///< "training multi-point"
  double before_{};    ///< weights of the earlier models
  double weight_{};    ///< weight of the present model
  double shown_{};     ///< last combined fraction
};

}  // namespace gyrotherm::app
