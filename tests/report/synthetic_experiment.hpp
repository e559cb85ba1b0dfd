/// A small made-up experiment for the tests of the report: shaped like the real one, made by hand, the same every time.
#pragma once

#include <cstdint>

#include "report/report_json.hpp"

namespace gyrotherm {

class SyntheticExperiment {
 public:
  /// `stretch` lengthens every hold: 1 gives about 200 clusters in the rate run.
  explicit SyntheticExperiment(int stretch = 1, bool simulated = true);

  [[nodiscard]] ReportInput input() const;

  struct Run {
    Dataset dataset;
    Clusters clusters;
    Verification three_point, multi_point, multi_point_t;
    HoldNoise noise;
  };
  Run rate, random;
  Model three_point, multi_point, multi_point_t;
  Correlation correlation;
};

}  // namespace gyrotherm
