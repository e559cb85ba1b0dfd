// SPDX-License-Identifier: Apache-2.0
/// Units of one type as draws from one population: estimation of the mean and the covariance of their coefficients from
/// the data of each unit, and the prior of the next unit. Pure linear algebra; type_prior.hpp defines the coefficients.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "core/result.hpp"

namespace gyrotherm::population {

// The hierarchical linear model: y_u = Z_u w_u + e_u for unit u, with w_u drawn from N(μ, Σ) and e_u of a known
// covariance and already whitened (Laird and Ware, Random-effects models for longitudinal data, Biometrics 38 (1982)
// 963; Lindley and Smith, J. R. Stat. Soc. B 34 (1972) 1; Gelman et al., Bayesian Data Analysis (2013), ch. 15).

/// Sufficient statistics of one unit's whitened values for its coefficients. All are 0 if there is no row.
struct UnitInformation {
  Eigen::MatrixXd precision;   ///< A = ZᵀZ
  Eigen::VectorXd projection;  ///< c = Zᵀy
  double square{};             ///< yᵀy
  /// Log determinant of the covariance before whitening.
  double log_determinant{};
  double rows{};
};

[[nodiscard]] UnitInformation unit_information(const Eigen::MatrixXd& z, const Eigen::VectorXd& y,
                                               double log_determinant = 0);
/// Returns the statistics of a unit without data, for this number of coefficients.
[[nodiscard]] UnitInformation no_information(Eigen::Index coefficients);
/// Adds the statistics of two independent records of one unit. Both must have the same coefficients.
[[nodiscard]] UnitInformation operator+(const UnitInformation& a, const UnitInformation& b);

/// Normal distribution of coefficients.
struct Coefficients {
  Eigen::VectorXd mean;
  /// May be singular: coefficients that do not vary between units are known exactly.
  Eigen::MatrixXd covariance;
};

/// Returns the posterior of a unit's coefficients: with its own A and c and the prior N(m, S), the mean is m + V(c −
/// Am) and the covariance V = (A + S⁻¹)⁻¹, computed as R(I + RᵀAR)⁻¹Rᵀ with RRᵀ = S, which needs no inverse of S.
[[nodiscard]] Coefficients posterior(const Coefficients& prior, const UnitInformation& own);

/// Returns log p of the unit's values for coefficients drawn from the prior.
[[nodiscard]] double log_predictive(const Coefficients& prior, const UnitInformation& unit);

/// Estimated distribution of the units of a type.
struct Population {
  Eigen::VectorXd mean;        ///< μ
  Eigen::MatrixXd covariance;  ///< Σ
  /// Covariance of the estimated μ.
  Eigen::MatrixXd mean_covariance;
};

/// Returns the prior of the next unit: N(μ, Σ + the covariance of μ).
[[nodiscard]] Coefficients next_unit(const Population& population);

/// Shrinkage of Σ towards a diagonal matrix, since few units determine the correlations of coefficients poorly. Σ is
/// estimated as if `worth_units` further units with this diagonal covariance had been measured. The result is the mode
/// of the posterior under an inverse Wishart prior (Gelman et al. (2013), §3.6).
struct Shrinkage {
  Eigen::VectorXd variances;  ///< diagonal, not negative
  double worth_units{};       ///< κ, above 0
};

struct PopulationOptions {
  /// True if coefficients vary independently: Σ is diagonal.
  bool independent = false;
  std::optional<Shrinkage> shrinkage = {};
  int most_iterations = 300;
  /// Least gain of an iteration, nats; the search ends below it.
  double tolerance = 1e-3;
};

struct PopulationFit {
  Population population;
  /// Restricted log likelihood, plus the log prior of Σ if Σ is shrunk, up to a constant.
  double log_likelihood{};
  int iterations{};
  bool converged{};
};

/// Estimates Σ by the EM algorithm for the restricted likelihood. μ is integrated out under a flat prior, so the
/// estimation of μ does not bias Σ (Laird and Ware (1982), eqs. 3.4 to 3.7; Dempster, Laird and Rubin, J. R. Stat. Soc.
/// B 39 (1977) 1: no iteration decreases the likelihood). It starts from `start`, which must be positive semidefinite;
/// a variance that starts at 0 remains 0. Fails with usage if there are fewer than three units, and with numeric if the
/// data of all units together do not determine the coefficients.
[[nodiscard]] Result<PopulationFit> fit_population(std::span<const UnitInformation> units, const Eigen::MatrixXd& start,
                                                   const PopulationOptions& options = {});

/// Returns μ and its covariance for a known Σ, and the restricted likelihood of that Σ. Fails with numeric like
/// fit_population().
[[nodiscard]] Result<PopulationFit> fit_population_mean(std::span<const UnitInformation> units,
                                                        const Eigen::MatrixXd& covariance);

}  // namespace gyrotherm::population
