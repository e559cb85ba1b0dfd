// SPDX-License-Identifier: Apache-2.0
/// The constant of each power-on in a training set. The bias of a gyro differs by a constant from one power-on to the
/// next (turn-on repeatability). A model that is fitted without these constants takes them for an effect of the
/// temperatures.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/features.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Inputs of the estimate.
struct PowerOnRule {
  /// Terms of the plane that separates the constants from the effect of the temperatures; none: no constants.
  std::vector<data::Term> terms;
  /// Standard uncertainty of each thermometer of the clusters, K, which limits the slopes of the plane.
  std::vector<double> thermometer_uncertainty_k;
  /// Standard deviation of the constants, °/h.
  double repeatability_deg_per_h{};
};

/// Returns the rule for records of one unit: thermal history, if the record has a thermometer, and the repeatability
/// that the record states.
[[nodiscard]] PowerOnRule power_on_rule(const data::Dataset& dataset);

/// Estimates the constant of the power-on of each cluster, °/h; all are 0 if there is only one power-on. Fits y = z·w +
/// b + a_s + e by penalised least squares: the penalty of w is that of the method ridge-u, and the constant a_s of
/// power-on s has the prior N(0, repeatability²) (best linear unbiased prediction: Robinson, Stat. Sci. 6 (1991) 15).
/// The variance of e is enlarged by n/n_eff, because neighbouring residuals are correlated. The constants of all
/// power-ons add up to 0; a short power-on, or one whose temperatures occur in no other, has a smaller constant. Fails
/// with usage if the clusters lack a thermometer of the rule.
[[nodiscard]] Result<Eigen::VectorXd> power_on_constants(const data::Clusters& clusters, const PowerOnRule& rule);

/// Returns the clusters with the constants subtracted from their bias.
[[nodiscard]] Result<data::Clusters> without_power_on_constants(data::Clusters clusters, const PowerOnRule& rule);

/// A power-on of a training, for model and report.
struct PowerOn {
  int clusters{};
  double constant_deg_per_h{};
};

void describe(auto& form, Like<PowerOn> auto& power_on) {
  form("clusters", power_on.clusters);
  form("constant_deg_per_h", power_on.constant_deg_per_h);
}

/// Lists the power-ons in order of appearance; empty if there is only one. `constants` holds one value per cluster.
[[nodiscard]] std::vector<PowerOn> list_power_ons(const data::Clusters& clusters, const Eigen::VectorXd& constants);

/// Returns a warning if the constants scatter more than the stated repeatability permits (χ² test at 1 %); empty
/// otherwise.
[[nodiscard]] std::string describe_scatter(const std::vector<PowerOn>& power_ons, double repeatability_deg_per_h);

}  // namespace gyrotherm::model
