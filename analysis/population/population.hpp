// SPDX-License-Identifier: Apache-2.0
/// Units of one type as draws of one population: the mean and the covariance of their coefficients, from what each of
/// them has shown, and what that says of the next one. Pure linear algebra; what the coefficients are of is for
/// type_prior.hpp to say.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "core/result.hpp"

namespace gyrotherm::population {

// The hierarchical linear model: y_u = Z_u w_u + e_u of unit u, w_u drawn from N(μ, Σ), e_u of a known covariance and
// whitened before (Laird and Ware, Random-effects models for longitudinal data, Biometrics 38 (1982) 963; Lindley and
// Smith, J. R. Stat. Soc. B 34 (1972) 1; Gelman et al., Bayesian Data Analysis (2013), ch. 15).

/// All that one unit's whitened values say of its coefficients. Without any row all of it is 0.
struct UnitInformation {
  Eigen::MatrixXd precision;   ///< A = ZᵀZ
  Eigen::VectorXd projection;  ///< c = Zᵀy
  double square{};             ///< yᵀy
  double log_determinant{};    ///< of the covariance before it was whitened
  double rows{};
};

[[nodiscard]] UnitInformation information_of(const Eigen::MatrixXd& z, const Eigen::VectorXd& y,
                                             double log_determinant = 0);
/// What nothing says of so many coefficients.
[[nodiscard]] UnitInformation no_information(Eigen::Index coefficients);
/// What two independent records of one unit say together. Both are of the same coefficients.
[[nodiscard]] UnitInformation operator+(const UnitInformation& a, const UnitInformation& b);

/// Coefficients as far as they are known: normal.
struct Coefficients {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;  ///< may be singular: what does not vary between the units is known
};

/// What is known of a unit's coefficients once it has been seen: with A and c of its own and the prior N(m, S) the mean
/// is m + V(c − Am), the covariance V = (A + S⁻¹)⁻¹, computed as R(I + RᵀAR)⁻¹Rᵀ with RRᵀ = S, which needs no inverse.
[[nodiscard]] Coefficients posterior(const Coefficients& prior, const UnitInformation& own);

/// log p of the unit's values, its coefficients drawn from the prior.
[[nodiscard]] double log_predictive(const Coefficients& prior, const UnitInformation& unit);

/// What is known of a population.
struct Population {
  Eigen::VectorXd mean;             ///< μ
  Eigen::MatrixXd covariance;       ///< Σ
  Eigen::MatrixXd mean_covariance;  ///< of μ as estimated
};

/// The prior of the next unit: N(μ, Σ + the covariance of μ).
[[nodiscard]] Coefficients next_unit(const Population& population);

/// Few units say little of how coefficients vary together. Σ is drawn to a diagonal matrix as if `worth_units` more
/// units had been seen that vary as that: the mode under an inverse Wishart prior (Gelman et al. (2013), §3.6).
struct Shrinkage {
  Eigen::VectorXd variances;  ///< of the diagonal, not negative
  double worth_units{};       ///< κ, above 0
};

struct PopulationOptions {
  bool independent = false;  ///< coefficients vary independently: Σ is diagonal
  std::optional<Shrinkage> shrinkage = {};
  int most_iterations = 300;
  double tolerance = 1e-3;  ///< nats: it ends when an iteration gains less
};

struct PopulationFit {
  Population population;
  double log_likelihood{};  ///< restricted; of a shrunk Σ with its log prior, but for a constant
  int iterations{};
  bool converged{};
};

/// Finds Σ by the EM algorithm for the restricted likelihood, μ being integrated out with a flat prior, so that Σ is
/// not too small by the units that μ cost (Laird and Ware (1982), eqs. 3.4 to 3.7; Dempster, Laird and Rubin, J. R.
/// Stat. Soc. B 39 (1977) 1: no iteration loses likelihood). It starts from `start`, which is not negative; a variance
/// that starts at 0 stays there. Fails with usage if there are fewer than three units, and with numeric if all units
/// together do not tell the coefficients apart.
[[nodiscard]] Result<PopulationFit> fit_population(std::span<const UnitInformation> units, const Eigen::MatrixXd& start,
                                                   const PopulationOptions& options = {});

/// μ and its covariance for a Σ that is known, and the restricted likelihood of it. Fails with numeric as above.
[[nodiscard]] Result<PopulationFit> population_with(std::span<const UnitInformation> units,
                                                    const Eigen::MatrixXd& covariance);

}  // namespace gyrotherm::population
