// SPDX-License-Identifier: Apache-2.0
/// Progress of all trainings of one axis as a single number.
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::app {

/// The options of a training that change how its time is distributed.
struct TrainingKind {
  bool compares = false;  ///< the methods of comparison are trained, too
  bool quick = false;     ///< a small swarm
  bool nested = false;    ///< nested cross-validation after each training
};

/// Combines the progress of the trainings into one fraction, which never decreases and reaches 1 only at the end. Each
/// model and each step of its training have a weight: their measured share of the time on the default rig. Not
/// thread-safe.
class TrainingProgress {
 public:
  /// `show` receives the combined progress; may be empty.
  TrainingProgress(ProgressSink show, TrainingKind kind);

  /// Takes the progress of one training: "training multi-point: tuning" and its fraction. Returns false if the
  /// trainings must stop.
  bool operator()(std::string_view stage, double fraction);

 private:
  /// Returns the completed part of the training of a model.
  [[nodiscard]] double completed_part(std::string_view step, double fraction) const;

  ProgressSink show_;
  TrainingKind kind_;
  double total_{};
  std::string model_;  ///< "training multi-point"
  double before_{};    ///< weights of the earlier models
  double weight_{};    ///< weight of the present model
  double shown_{};     ///< last combined fraction
};

}  // namespace gyrotherm::app
