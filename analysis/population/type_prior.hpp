// SPDX-License-Identifier: Apache-2.0
/// Units of one type: what n of them have shown is the prior of the next one, so that a few hours of its own data
/// complete a model that it would otherwise need a whole program for.
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

// The bias of unit u is b = w_0 + Σ_j w_j z_j + e: z_j are terms of the thermometers, scaled alike for all units, e is
// the noise of unexplained_noise.hpp, and the w of each unit are a draw from the type's population (population.hpp).

/// What one unit of the type has shown: the clusters of its runs, each run by itself.
struct UnitClusters {
  std::string unit;
  std::vector<data::Clusters> runs;
};

struct TypePriorOptions {
  std::string type = {};  ///< its name, for people
  /// Empty: the first thermometer of the clusters and its differences with the others; the unit's own temperature where
  /// there is none.
  std::vector<data::Term> terms = {};
  /// How far one turn-on is from the next, °/h; what the rig file says. Not learnt, for units of one run do not show
  /// it.
  double turn_on_deg_per_h = 0.001;
  /// How well each thermometer of the clusters is known in use, K: its certificate and the drift until then. Empty:
  /// exactly.
  std::vector<double> thermometer_uncertainty_k = {};
  bool quick = false;      ///< a try: the correlations of coefficients are not learnt
  bool simulated = false;  ///< whether any of the units is a virtual one
};

/// A record that a prior was learnt from. The name of its unit is the user's, so that it does not say which gyro that
/// is.
struct PriorRecord {
  std::string name;            ///< of its unit, in TypePrior::units
  std::string run_id;          ///< and of that run:
  std::string unit{}, axis{};  ///< empty where it has one
  std::string identity{};      ///< which gyro that is, as far as the record says
  std::string bias_zero{};     ///< what its bias is counted from; empty: not known
};

/// What is known of a unit of this type before it has been in the chamber.
struct TypePrior {
  std::string type;
  std::vector<std::string> units;    ///< those it was learnt from
  std::vector<PriorRecord> records;  ///< of these; empty where they are not known
  bool simulated{};                  ///< any of them
  double cluster_length_s = 100;
  std::vector<data::Term> terms;
  data::Scaling scaling;                    ///< of the terms, over the clusters of all units
  Eigen::RowVectorXd input_min, input_max;  ///< range of each term over the same, unscaled
  Eigen::MatrixXd term_spread;              ///< covariance of the scaled terms within runs, over the same
  Eigen::MatrixXd error_covariance;  ///< of the scaled terms: what the thermometers' uncertainty makes; 0 if none
  Coefficients next_unit;            ///< °/h: the constant, then per STD of each term
  UnexplainedNoise noise;
  double correlations_worth_units{};  ///< how strongly correlations were drawn to 0: see Shrinkage; 0: taken as 0
};

/// Learns the prior from at least three units of the same thermometers and cluster length. Terms are scaled over all
/// clusters together; clusters without a value of every term are left out. The covariance of the coefficients is found
/// in the principal components of the scaled terms: thermometers of one block see nearly the same, and what is not to
/// be told apart there must not count. Directions of less than 10⁻⁵ of the greatest spread are left out; no unit's
/// coefficients go there.
///
/// In turn, the coefficients' variances are found with noises that are held, and the noises (but for the turn-on) with
/// variances that are held, each by the restricted likelihood; what remembers less than three clusters counts as white.
/// Then the correlations between coefficients are learnt, drawn to 0 as if so many more units of uncorrelated
/// coefficients had been seen; how many, or that there is no correlation at all, is chosen by leaving each unit out: by
/// what the others predict of all that it has shown (log_predictive). With a dozen units that is a choice between a
/// few, not an estimate.
///
/// Fails with usage (too few units, a unit given twice or without a run, clusters that do not go together, a term that
/// does not vary or is not there, uncertainties that are not one per thermometer or below 0) or numeric.
[[nodiscard]] Result<TypePrior> learn_type_prior(std::span<const UnitClusters> units,
                                                 const TypePriorOptions& options = {});

/// What is known of one unit.
struct LearntUnit {
  Coefficients coefficients;      ///< the likeliest, and how well they are known
  Eigen::VectorXd centre;         ///< mean of the scaled terms over its own clusters; 0 of none
  double effective_parameters{};  ///< how many coefficients its own clusters decide: tr(VA) of population.hpp's V and A
};

/// What is known of a unit once its own runs are seen, which may be none, or the beginning of one: the posterior of its
/// coefficients, in closed form. Fails with usage if clusters lack a thermometer or are of another length.
[[nodiscard]] Result<LearntUnit> learn_unit(const TypePrior& prior, std::span<const data::Clusters> own);

/// The constant and slopes to compensate with, °/h, per STD: those that err least where readings are in error as much
/// as the thermometers' uncertainty says. The slopes v = (M + C)⁻¹Mm minimise (v − m)ᵀM(v − m) + vᵀCv, M the spread of
/// the terms within a run and C the covariance of their errors, m the likeliest slopes; the constant is such that the
/// mean over the unit's own clusters stays. It is the penalty of methods::penalised_plane, with what is known in the
/// place of the samples. The likeliest slopes themselves lean on differences of thermometers that a year's drift moves.
/// Where C is 0 these are taken.
[[nodiscard]] Eigen::VectorXd careful_coefficients(const TypePrior& prior, const LearntUnit& unit);

/// A bias that is predicted for a run that the unit has not made, in each cluster, °/h; NaN where an input is unknown.
struct UnitPrediction {
  Eigen::VectorXd bias_deg_per_h;
  Eigen::VectorXd expanded_deg_per_h;  ///< U, k = 2
};

inline constexpr double kUnitCoverageFactor = 2;

/// Predicts a run's bias by the careful coefficients. `drift_k` is how far each thermometer of the clusters may have
/// drifted since the unit's own runs, K, standard uncertainty; empty: not at all. U combines the covariance of the
/// coefficients, the distance of the careful ones from the likeliest, that drift, and the wander and the turn-on of the
/// run. It leaves out the white noise of a mean, which is no error of the compensation, and calibration errors, which
/// the own runs share. Fails as learn_unit does, or with usage where `drift_k` is not one per thermometer.
[[nodiscard]] Result<UnitPrediction> predict(const TypePrior& prior, const LearntUnit& unit,
                                             const data::Clusters& clusters, std::span<const double> drift_k = {});

/// The file of a prior.
[[nodiscard]] std::string to_json(const TypePrior& prior);
/// Reads a file of a prior. Fails with bad_file: syntax, schema, missing or non-finite numbers, lengths that do not
/// fit, a covariance that is not symmetric or is negative.
[[nodiscard]] Result<TypePrior> type_prior_from_json(std::string_view json, const std::string& file);

}  // namespace gyrotherm::population
