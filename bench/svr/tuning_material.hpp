/// What a measurement of the tuning job starts from: a set, its folds, and the stored trace of the peer's job on it.
#pragma once

#include <string>
#include <vector>

#include "bench/svr/sample_set.hpp"
#include "bench/svr/trace.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Best error of our job over the peer's: no more than this.
inline constexpr double kBestErrorRatio = 1.01;

struct TuningMaterial {
  SampleSet set;
  std::vector<TuningFold> folds;
  std::vector<TracePosition> trace;

  [[nodiscard]] const TracePosition& best() const;  ///< of the trace: where the job ended
  /// "n=600: figure".
  [[nodiscard]] std::string name(const std::string& figure) const;
};

/// The set `name` of one folder and its trace, NAME.trace, of another. Fails with bad_file.
[[nodiscard]] Result<TuningMaterial> tuning_material(const std::string& data, const std::string& traces,
                                                     const std::string& name);

}  // namespace gyrotherm
