// SPDX-License-Identifier: Apache-2.0
/// The verdict on a model: whether its residual bias is smaller than the raw bias by more than chance explains, and
/// whether its intervals hold.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/statistics.hpp"
#include "core/form.hpp"

namespace gyrotherm::model {

enum class Gain { improves, does_not_improve, undecided, not_enough_data, in_sample };

/// Returns "improves", "does not improve", "undecided", "not enough data" or "in-sample".
[[nodiscard]] const char* name(Gain gain);

/// Reduction of a figure of the bias by a model, and its standard error; NaN if it is unknown or has no meaning. A
/// negative value is a deterioration.
struct Reduction {
  double value = std::numeric_limits<double>::quiet_NaN();
  double error = std::numeric_limits<double>::quiet_NaN();
};

struct Verdict {
  Gain gain = Gain::not_enough_data;
  /// Figures or reason of the gain, as text.
  std::string statement = {};
  Reduction std_deg_per_h = {}, rmse_deg_per_h = {};
  /// Effective number of clusters of the bias that the prediction leaves over. 0 if unknown.
  double effective{};
  /// True if the gain is undecided because the RMSE is smaller and the STD is not: the model removes an offset only.
  bool only_offset{};
  /// False if the share of means inside their intervals is significantly below the nominal share. No value in-sample,
  /// without intervals, or if the bias reference is a mean of the record.
  std::optional<bool> intervals_hold = {};
};

void describe(auto& form, Like<Reduction> auto& reduction) {
  form("value", reduction.value);
  form("error", reduction.error);
}

void describe(auto& form, Like<Verdict> auto& verdict) {
  form("result", one_of(verdict.gain, {Gain::improves, Gain::does_not_improve, Gain::undecided, Gain::not_enough_data,
                                       Gain::in_sample}));
  form("statement", verdict.statement);
  form.if_present("std_reduction_deg_per_h", std::isfinite(verdict.std_deg_per_h.value), verdict.std_deg_per_h);
  form.if_present("rmse_reduction_deg_per_h", std::isfinite(verdict.rmse_deg_per_h.value), verdict.rmse_deg_per_h);
  form("effective_count", verdict.effective);
  form.if_present("only_offset", verdict.only_offset, verdict.only_offset);  // since 0.2.0
  form.if_present("intervals_hold", verdict.intervals_hold.has_value(), verdict.intervals_hold);
}

/// Meaning of the zero of the bias, which decides whether the RMSE counts.
enum class BiasZero { known, mean_of_first_hold, mean_of_raw };

/// Judges whether the residual is smaller than the raw bias of the same clusters; both vectors belong to the clusters
/// `rows`, without missing values.
///
/// The prediction p is the raw bias b minus the residual. The model reduces the variance of the bias if and only if the
/// slope β of b over p exceeds ½, because var b − var(b − p) = (2β − 1)·var p (Pitman, Biometrika 31 (1939) 9; Morgan,
/// ibid. 13). The mean squares also differ by those of the means, 2·mean(b)·mean(p) − mean(p)². The uncertainties of β
/// and of mean(b) come from fit_with_correlated_noise() with correlations of up to the whole record, the 95 % limits
/// from Student's t with the effective number of values of b − βp minus 2. The verdict is
/// - `does not improve` if STD or RMSE are larger than that of the raw bias, and the limits exclude chance;
/// - `improves` if the STD is smaller and the limits exclude chance;
/// - `not enough data` for fewer than `fewest` clusters, or if neither holds and fewer than 5 values are effective;
/// - `undecided` otherwise.
/// The RMSE does not count if the zero of the bias is the mean of the record's first hold, because its value then
/// depends on this hold only.
[[nodiscard]] Verdict judge_gain(const Eigen::VectorXd& bias, const Eigen::VectorXd& residual,
                                 const data::Clusters& clusters, const std::vector<Eigen::Index>& rows, BiasZero zero,
                                 int fewest);

/// Judges the held-out residual of a training against the raw bias of the same clusters minus its mean. A NaN marks a
/// cluster without a residual. The verdict is `not enough data` for fewer than 20 clusters or fewer than 5 clusters per
/// effective parameter; 0 parameters are unknown.
[[nodiscard]] Verdict judge_held_out(const Eigen::VectorXd& residual, const data::Clusters& clusters,
                                     double effective_parameters);

/// Returns a warning, such as "no better than no model: …", unless STD and RMSE of the residual are below those of the
/// raw bias. `residual_name` names the residual, such as "compensated bias". No warning if neither is known.
[[nodiscard]] std::optional<std::string> make_no_gain_warning(std::string_view residual_name, const Verdict& verdict);

/// Returns true if the share `seen` of `effective` independent means inside their intervals is below the nominal share,
/// and a binomial distribution gives such a share with a probability below 2.5 %.
[[nodiscard]] bool is_below_nominal(double seen, double nominal, double effective);

/// Returns "verdict: improves; std 1.073 → 0.082 °/h, …".
[[nodiscard]] std::string describe_verdict(const Verdict& verdict);

}  // namespace gyrotherm::model
