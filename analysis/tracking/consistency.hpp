// SPDX-License-Identifier: Apache-2.0
/// Whether a filter's innovations are what it expects of them: as large as it says, and white.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/tracking/bias_tracker.hpp"
#include "core/form.hpp"

namespace gyrotherm::tracking {

/// The test of Ljung and Box (Biometrika 65 (1978) 297): Q = n(n + 2) Σ_k r_k²/n_k over the lags, n_k pairs k apart
/// and r_k their autocorrelation about 0, is χ² of as many degrees of freedom if the values are white.
struct Whiteness {
  double statistic{};
  int lags{};
  double probability{};  ///< of a statistic this large in white values; NaN if there are too few
};
/// Values that are NaN are missing; pairs are of those that are there.
[[nodiscard]] Whiteness whiteness_of(const Eigen::Ref<const Eigen::VectorXd>& values, int lags);

/// The innovations of a filter, judged (Bar-Shalom, Li, Kirubarajan, 2001, section 5.4).
struct Consistency {
  int innovations{};
  double mean_square{};  ///< NIS: the mean of the squared innovations, each over its expected variance; should be 1
  double low{}, high{};  ///< where chance leaves it in 95 of 100 cases, if it is χ²_n/n
  Whiteness whiteness{};
};
/// Leaves the first `settling` intervals out, in which the start's own uncertainty is most of the innovation.
[[nodiscard]] Consistency consistency_of(const std::vector<TrackedInterval>& intervals, std::size_t settling = 0);

void describe(auto& form, Like<Consistency> auto& consistency) {
  form("innovations", consistency.innovations);
  form("normalised_innovation_squared", consistency.mean_square);
  form("expected_from", consistency.low);
  form("expected_to", consistency.high);
  form("ljung_box", consistency.whiteness.statistic);
  form("ljung_box_lags", consistency.whiteness.lags);
  form("ljung_box_probability", consistency.whiteness.probability);
}

}  // namespace gyrotherm::tracking
