// SPDX-License-Identifier: Apache-2.0
/// Prior of a unit from n other units of its type. With the prior, a few hours of the unit's own data are sufficient
/// for a model that would otherwise need a complete profile.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "analysis/population/population.hpp"
#include "analysis/population/unexplained_noise.hpp"
#include "core/result.hpp"

namespace gyrotherm::population {

inline constexpr const char* kTypePriorSchema = "gyrotherm-type-prior/1";

// The bias of unit u is b = w_0 + Σ_j w_j z_j + e: z_j are terms of the thermometers, scaled equally for all units, e
// is the noise of unexplained_noise.hpp, and the w of each unit are a draw from the type's population (population.hpp).

/// Data of one unit of the type: the clusters of its runs, one element per run.
struct UnitClusters {
  std::string unit;
  std::vector<data::Clusters> runs;
};

struct TypePriorOptions {
  std::string type = {};
  /// Terms of the model. If empty: the first thermometer of the clusters and its differences with the others, or the
  /// unit's own temperature if there is no thermometer.
  std::vector<data::Term> terms = {};
  /// Standard deviation between turn-ons, °/h, from the rig file. It is not learnt, because units with one run do not
  /// show it.
  double turn_on_deg_per_h = 0.001;
  /// Uncertainty of each thermometer of the clusters in use, K: its certificate and the drift until then. If empty, the
  /// thermometers are exact.
  std::vector<double> thermometer_uncertainty_k = {};
  /// Skips learning the correlations of the coefficients, for a quick trial.
  bool quick = false;
  /// True if at least one of the units is virtual.
  bool simulated = false;
};

/// A record from which a prior was learnt. The user chooses the name of the unit, so the name does not identify the
/// gyro.
struct PriorRecord {
  /// Name of the unit as in TypePrior::units.
  std::string name;
  std::string run_id;
  /// Unit and axis in that run; empty for a record with a single one.
  std::string unit{}, axis{};
  /// Identity of the gyro, as far as the record states it.
  std::string identity{};
  /// Bias reference; empty if unknown.
  std::string bias_zero{};
};

/// Prior of a unit of this type before its first run.
struct TypePrior {
  std::string type;
  std::vector<std::string> units;
  /// Records of these units; empty if unknown.
  std::vector<PriorRecord> records;
  /// True if at least one of the units is virtual.
  bool simulated{};
  double cluster_length_s = 100;
  std::vector<data::Term> terms;
  /// Scaling of the terms over the clusters of all units.
  data::Scaling scaling;
  /// Range of each term over these clusters, unscaled.
  Eigen::RowVectorXd input_min, input_max;
  /// Covariance of the scaled terms within runs, over these clusters.
  Eigen::MatrixXd term_spread;
  /// Covariance of the scaled terms due to the thermometers' uncertainty; 0 if there is none.
  Eigen::MatrixXd error_covariance;
  /// Coefficients of the next unit: the constant, °/h, then the slopes, °/h per STD of each term.
  Coefficients next_unit;
  UnexplainedNoise noise;
  /// Weight of the shrinkage of the correlations (see Shrinkage); 0: no correlations.
  double correlations_worth_units{};
};

/// Learns the prior from at least three units with the same thermometers and cluster length. Terms are scaled over all
/// clusters together; clusters with a missing value of a term are ignored. The covariance of the coefficients is
/// estimated in the principal components of the scaled terms: thermometers of one block have nearly equal readings, and
/// the data do not determine coefficients along their small differences. Components with less than 10⁻⁵ of the greatest
/// spread are therefore omitted; the coefficients along them are 0.
///
/// The variances of the coefficients and the noises (except the turn-on) are estimated alternately, each with the
/// others held constant, by the restricted likelihood; noise with a correlation time below three clusters is treated as
/// white. The correlations between coefficients are then learnt and shrunk towards 0. The shrinkage has the weight of a
/// number of additional units without correlations. Leave-one-unit-out chooses this number, or no correlation at all,
/// by the predictive density of each unit's data given the other units (log_predictive). The population, including the
/// variances to which it is shrunk, is then fitted to the other units only; the noise parameters are learnt from all
/// units. A dozen units permit only a choice between a few values.
///
/// Fails with usage for too few units, a unit given twice or without a run, inconsistent clusters, a term that does not
/// vary or does not exist, or uncertainties that are negative or not one per thermometer. Fails with numeric.
[[nodiscard]] Result<TypePrior> learn_type_prior(std::span<const UnitClusters> units,
                                                 const TypePriorOptions& options = {});

/// Posterior of one unit.
struct LearntUnit {
  Coefficients coefficients;
  /// Mean of the scaled terms over the unit's own clusters; 0 without clusters.
  Eigen::VectorXd centre;
  /// Number of coefficients that the unit's own clusters determine: tr(VA), with V and A as in population.hpp.
  double effective_parameters{};
};

/// Returns the posterior of a unit's coefficients given its own runs, in closed form. `own` may be empty or contain
/// only the beginning of a run. Fails with usage if a thermometer is missing from the clusters or if their length is
/// not that of the prior.
[[nodiscard]] Result<LearntUnit> learn_unit(const TypePrior& prior, std::span<const data::Clusters> own);

/// Returns the constant, °/h, and the slopes, °/h per STD, that give the least error of compensation for readings with
/// the thermometers' uncertainty. The slopes v = (M + C)⁻¹Mm minimise (v − m)ᵀM(v − m) + vᵀCv, with M the spread of the
/// terms within a run, C the covariance of their errors and m the most likely slopes. The constant keeps the mean over
/// the unit's own clusters. This is the penalty of methods::penalised_plane(), with the posterior instead of samples.
/// The most likely slopes are not used directly, because they depend on differences between thermometers that change
/// with a year's drift. If C is 0, the most likely slopes are returned.
[[nodiscard]] Eigen::VectorXd noise_aware_coefficients(const TypePrior& prior, const LearntUnit& unit);

/// Predicted bias of each cluster of a run that the unit has not made yet, °/h; NaN if an input is unknown.
struct UnitPrediction {
  Eigen::VectorXd bias_deg_per_h;
  Eigen::VectorXd expanded_deg_per_h;  ///< U, k = 2
};

inline constexpr double kUnitCoverageFactor = 2;

/// Predicts a run's bias with the noise-aware coefficients. `drift_k` is the standard uncertainty of each thermometer's
/// drift since the unit's own runs, K; no drift if it is empty. U combines the covariance of the coefficients, the
/// distance of the noise-aware coefficients from the most likely ones, the drift, and the wander and the turn-on of the
/// run. It excludes the white noise of a mean, which is not an error of the compensation, and calibration errors, which
/// are the same in the unit's own runs. Fails like learn_unit(), or with usage if `drift_k` does not have one value per
/// thermometer.
[[nodiscard]] Result<UnitPrediction> predict(const TypePrior& prior, const LearntUnit& unit,
                                             const data::Clusters& clusters, std::span<const double> drift_k = {});

/// Formats the file of a prior.
[[nodiscard]] std::string to_json(const TypePrior& prior);
/// Parses the file of a prior. Fails with bad_file if the syntax or the schema is wrong, if a number is missing or not
/// finite, if lengths do not match, or if a covariance is not symmetric and positive semidefinite.
[[nodiscard]] Result<TypePrior> type_prior_from_json(std::string_view json, const std::string& file);

}  // namespace gyrotherm::population
