// SPDX-License-Identifier: Apache-2.0
/// Small deterministic experiment with the same structure as a real one.
#pragma once

#include "report/report.hpp"

namespace gyrotherm::report {

class SyntheticExperiment {
 public:
  /// `stretch` multiplies the duration of every hold. With 1, the ramp run has about 200 clusters.
  explicit SyntheticExperiment(int stretch = 1, bool simulated = true);

  /// Returns the report with one limit, which is met.
  [[nodiscard]] Report report() const;

  data::RecordedRun rate, random, later;
  model::Qualification qualification;
};

}  // namespace gyrotherm::report
