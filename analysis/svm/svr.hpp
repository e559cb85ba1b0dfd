// SPDX-License-Identifier: Apache-2.0
/// ε-insensitive support vector regression with a Gaussian kernel, solved to certified optimality (errata 2.1, which
/// replaces eqs. 1–7 of the paper).
///
/// Dual, β_i = α_i − α_i*: minimise D(β) = ½βᵀKβ − yᵀβ + ε‖β‖₁ subject to Σβ_i = 0, −C ≤ β_i ≤ C, with
/// K_ij = exp(−‖x_i − x_j‖² / (2σ²)). Prediction f(x) = Σ β_i K(x_i, x) + b.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::svm {

/// Rows are samples, row-major so that a sample is contiguous.
using SampleMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class GaussianSamples;
class KernelMemory;

struct SvrParameters {
  double C{};        ///< > 0, in units of the target's training STD
  double sigma{};    ///< > 0, kernel width in units of standardised inputs
  double epsilon{};  ///< ≥ 0, in units of the target's training STD
};

void describe(auto& form, Like<SvrParameters> auto& parameters) {
  form("C", positive(parameters.C));
  form("sigma", positive(parameters.sigma));
  form("epsilon", not_negative(parameters.epsilon));
}

struct SvrOptions {
  double relative_gap = 1e-3;  ///< the certificate asked for: SvrSolution::relative_gap ≤ this
  int max_newton_steps = 400;
  /// For the kernel of one training: 4n² bytes, without which it is refused, and up to 8n² more that save time.
  std::size_t memory_bytes = std::size_t{2} << 30;
};

/// A solution and its certificate. `beta` has exact zeros for non-support vectors and exact ±C for bounded ones.
struct SvrSolution {
  Eigen::VectorXd beta;
  double b{};
  /// (P + D)/max(|D|, floor) of the returned (β, b), recomputed from scratch in double precision; it bounds how far D
  /// is from its optimum. P = ½βᵀKβ + C Σ max(0, |y_i − (Kβ)_i − b| − ε); the floor, a billionth of C Σ|y_i − ȳ|, gives
  /// the gap a scale where the optimum is β = 0 and D = 0.
  double relative_gap{};
  double kkt_violation{};  ///< LIBSVM's stopping measure of the returned β; ≤ 0 at an exact optimum
  double objective{};      ///< D(β)
  int support_vectors{};
  int iterations{};  ///< Newton steps; 0 if sequential minimal optimisation sufficed
};

/// A β near the solution, for a training to begin at: that of a like problem.
struct SvrStart {
  Eigen::VectorXd beta;
  double bound{};  ///< of |β| there
};

/// The rows of the support vectors: those whose β is not 0.
[[nodiscard]] std::vector<Eigen::Index> support_of(const Eigen::VectorXd& beta);

/// The kernel between two sets of samples, exp(−‖a_i − b_j‖²/(2σ²)): rows of a × rows of b, which have as many columns.
[[nodiscard]] Eigen::MatrixXd gaussian_kernel(const Eigen::Ref<const SampleMatrix>& a,
                                              const Eigen::Ref<const SampleMatrix>& b, double sigma);
/// The same of one set of samples with itself, of which only the lower triangle is to be read.
[[nodiscard]] Eigen::MatrixXd gaussian_kernel_lower(const Eigen::Ref<const SampleMatrix>& x, double sigma);

/// Solves for one training set. Fails with usage on bad parameters, shapes or NaN (named by value and constraint), with
/// numeric if the certificate is not reached; then `what` holds the gap that was.
///
/// Sequential minimal optimisation first; if that does not earn the certificate, a semismooth Newton method goes on
/// from there (smo.hpp, newton.hpp).
[[nodiscard]] Result<SvrSolution> solve_svr(const Eigen::Ref<const SampleMatrix>& x,
                                            const Eigen::Ref<const Eigen::VectorXd>& y, const SvrParameters& parameters,
                                            const SvrOptions& options = {});

/// Solves like the other solve_svr, from samples that are laid out already and with memory handed on from training to
/// training (kernel.hpp). The samples are finite. It begins at `start` if there is one, which is of as many samples;
/// the certificate is the same.
[[nodiscard]] Result<SvrSolution> solve_svr(const GaussianSamples& samples, KernelMemory& memory,
                                            const Eigen::Ref<const Eigen::VectorXd>& y, const SvrParameters& parameters,
                                            const SvrOptions& options, const SvrStart* start = nullptr);

}  // namespace gyrotherm::svm
