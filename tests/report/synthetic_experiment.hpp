// SPDX-License-Identifier: Apache-2.0
/// A small synthetic experiment for the tests of the report: the same shape as a real one, deterministic.
#pragma once

#include "report/report.hpp"

namespace gyrotherm::report {

class SyntheticExperiment {
 public:
  /// Multiplies the duration of every hold by `stretch`; 1 gives about 200 clusters in the ramp run.
  explicit SyntheticExperiment(int stretch = 1, bool simulated = true);

  /// Returns the report with one limit, which is met.
  [[nodiscard]] Report report() const;

  data::RecordedRun rate, random, later;
  model::Qualification qualification;
};

}  // namespace gyrotherm::report
