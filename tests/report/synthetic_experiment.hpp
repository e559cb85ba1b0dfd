// SPDX-License-Identifier: Apache-2.0
/// A small made-up experiment for the tests of the report: shaped like the real one, made by hand, the same every time.
#pragma once

#include "report/report.hpp"

namespace gyrotherm::report {

class SyntheticExperiment {
 public:
  /// `stretch` lengthens every hold: 1 gives about 200 clusters in the rate run.
  explicit SyntheticExperiment(int stretch = 1, bool simulated = true);

  /// With one limit, which is met.
  [[nodiscard]] Report report() const;

  data::RecordedRun rate, random, later;
  model::Qualification qualification;
};

}  // namespace gyrotherm::report
