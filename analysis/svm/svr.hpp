// SPDX-License-Identifier: Apache-2.0
/// ε-insensitive support vector regression with a Gaussian kernel, solved to certified optimality (errata 2.1, which
/// replaces eqs. 1–7 of the paper).
///
/// Dual, β_i = α_i − α_i*: minimise D(β) = ½βᵀKβ − yᵀβ + ε‖β‖₁ subject to Σβ_i = 0, −C ≤ β_i ≤ C, with K_ij = exp(−‖x_i
/// − x_j‖² / (2σ²)). Prediction f(x) = Σ β_i K(x_i, x) + b.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::svm {

/// Row-major matrix with one sample per row; each sample is contiguous.
using SampleMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class GaussianSamples;
class KernelMemory;

struct SvrParameters {
  /// Bound, > 0, in units of the training STD of the target.
  double C{};
  /// Kernel width, > 0, in units of standardised inputs.
  double sigma{};
  /// Insensitivity, ≥ 0, in units of the training STD of the target.
  double epsilon{};
};

void describe(auto& form, Like<SvrParameters> auto& parameters) {
  form("C", positive(parameters.C));
  form("sigma", positive(parameters.sigma));
  form("epsilon", not_negative(parameters.epsilon));
}

struct SvrOptions {
  /// Upper limit for SvrSolution::relative_gap.
  double relative_gap = 1e-3;
  int max_newton_steps = 400;
  /// Memory for the kernel of one training. The 4n² bytes for its rows are required; up to 8n² more bytes save time.
  std::size_t memory_bytes = std::size_t{2} << 30;
};

/// Solution with its certificate. `beta` is exactly 0 for non-support vectors and exactly ±C at the bounds.
struct SvrSolution {
  Eigen::VectorXd beta;
  double b{};
  /// Certified gap (P + D)/max(|D|, floor) of the returned (β, b), recomputed from scratch in double precision. It
  /// bounds the distance of D from its optimum. P = ½βᵀKβ + C Σ max(0, |y_i − (Kβ)_i − b| − ε). The floor, 1e-9 C Σ|y_i
  /// − ȳ|, gives the gap a scale if the optimum is β = 0 and D = 0.
  double relative_gap{};
  /// Stopping measure of LIBSVM for the returned β. At most 0 at an exact optimum.
  double kkt_violation{};
  double objective{};  ///< D(β)
  int support_vectors{};
  /// Newton steps. 0 if sequential minimal optimisation sufficed.
  int iterations{};
};

/// Approximate solution from a similar problem, as the start of a training.
struct SvrStart {
  Eigen::VectorXd beta;
  /// Upper bound C of |β| in the problem that `beta` solves.
  double bound{};
};

/// Returns the rows of the support vectors, those with β ≠ 0.
[[nodiscard]] std::vector<Eigen::Index> support_rows(const Eigen::VectorXd& beta);

/// Returns the kernel between two sets of samples, exp(−‖a_i − b_j‖²/(2σ²)), as a matrix of rows of a × rows of b. Both
/// must have the same number of columns.
[[nodiscard]] Eigen::MatrixXd gaussian_kernel(const Eigen::Ref<const SampleMatrix>& a,
                                              const Eigen::Ref<const SampleMatrix>& b, double sigma);
/// Returns the kernel of one set of samples with itself. Only its lower triangle is valid.
[[nodiscard]] Eigen::MatrixXd gaussian_kernel_lower(const Eigen::Ref<const SampleMatrix>& x, double sigma);

/// Solves one training. Fails with usage on bad parameters, shapes or NaN (the message names value and constraint).
/// Fails with numeric if the certificate is not reached; `what` then contains the gap.
///
/// Runs sequential minimal optimisation first. If that does not reach the certificate, a semismooth Newton method
/// continues from its result (smo.hpp, newton.hpp).
[[nodiscard]] Result<SvrSolution> solve_svr(const Eigen::Ref<const SampleMatrix>& x,
                                            const Eigen::Ref<const Eigen::VectorXd>& y, const SvrParameters& parameters,
                                            const SvrOptions& options = {});

/// Solves like the other solve_svr, with samples already laid out and memory reused between trainings (kernel.hpp). The
/// samples must be finite. Begins at `start` if given, which must have one β per sample. The start does not change the
/// required certificate.
[[nodiscard]] Result<SvrSolution> solve_svr(const GaussianSamples& samples, KernelMemory& memory,
                                            const Eigen::Ref<const Eigen::VectorXd>& y, const SvrParameters& parameters,
                                            const SvrOptions& options, const SvrStart* start = nullptr);

}  // namespace gyrotherm::svm
