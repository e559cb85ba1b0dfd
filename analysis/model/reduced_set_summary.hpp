/// What it cost to make a model smaller.
#pragma once

namespace gyrotherm {

struct ReducedSetSummary {
  int vectors_before{}, vectors{};
  double bound_deg_per_h{};       ///< no prediction, for any input, has changed by more
  double max_change_deg_per_h{};  ///< of the predictions on the training clusters
  double rms_change_deg_per_h{};
  int clusters{};  ///< how many those were
};

}  // namespace gyrotherm
