// SPDX-License-Identifier: Apache-2.0
/// The methods that solve with a kernel matrix beside the support vector machine: its least-squares form, and Gaussian
/// processes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/methods/method.hpp"
#include "analysis/svm/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm::methods {

// Least-squares support vector machine (Suykens et al. 2002); for ring laser gyros: Wei, Li and Long, Measurement 44
// (2011) 1898, and Li et al., Opt. Express 23 (2015) 13320, refs. 15 and 24 of the paper.
//
// Solves M [b; α] = [0; y] with M = [0 1ᵀ; 1 H], H = K + I/γ: Hη = 1, Hν = y, b = 1ᵀν/1ᵀη, α = ν − bη.
// ŷ(z) = Σ α_i K(z_i, z) + b, K(z, z') = exp(−‖z − z'‖²/(2σ²)).

/// A machine, and what its solution leaves for other questions.
struct LsSvm {
  Eigen::MatrixXd factor;  ///< L of H = LLᵀ, lower triangle
  Eigen::VectorXd eta;     ///< H⁻¹1
  Eigen::VectorXd alpha;
  double b{};
};

/// Solves for a kernel matrix (symmetric, finite) and γ > 0. Fails with numeric if H is not positive definite in
/// double.
[[nodiscard]] Result<LsSvm> solve_ls_svm(const Eigen::Ref<const Eigen::MatrixXd>& kernel,
                                         const Eigen::Ref<const Eigen::VectorXd>& y, double gamma);

/// The diagonal d of M⁻¹ over the samples: e_i = α_i/d_i is the residual of a sample by the machine trained without it
/// (same kernel and γ; Cawley 2006; An, Liu and Venkatesh 2007), and n − Σd_i/γ the trace of the matrix from y to
/// fitted values.
[[nodiscard]] Eigen::VectorXd inverse_diagonal_of(const LsSvm& machine);

/// Chooses "gamma" and "sigma" by held-out error: from a grid over log2 γ = 2 … 18 and log2 σ = −½ … 5½ in steps of 4
/// and 1½, then around the best with half and with a quarter of these steps (quick: the grid alone). Folds are scaled
/// each by itself, so each is solved anew. Warns of a choice at the edge of the grid.
[[nodiscard]] ChooseFunction choose_ls_svm;

/// The effective parameters are the trace; the particulars name the closed-form leave-one-out error.
[[nodiscard]] FitFunction fit_ls_svm;

// Gaussian process regression (Rasmussen and Williams 2006): a plane, and of what it leaves a squared-exponential
// covariance with one length per input, which says which inputs matter, and a noise. One of the two modern methods
// beside the paper's; the only one here that gives a standard deviation with each prediction.
//
// The plane's slope has the prior N(0, A), A⁻¹ the slope_penalty of ridge_u.hpp with the variance σ_n²: without the
// Gaussians the plane would be that of ridge-u, so that what the process learns lasts while the thermometers drift, and
// far from what was seen it goes on as a plane.

/// The covariance σ_f² exp(−½ Σ_j ((z_j − z'_j)/l_j)²), and noise of variance σ_n² on each target.
struct Covariance {
  Eigen::RowVectorXd lengths;  ///< l
  double signal{};             ///< σ_f
  double noise{};              ///< σ_n
};

/// What the search moves in: log l_1 … log l_d, log σ_f, log σ_n.
[[nodiscard]] Eigen::VectorXd logarithms_of(const Covariance& covariance);
[[nodiscard]] Covariance covariance_of(const Eigen::VectorXd& logarithms);

/// The covariance between the rows of a and b, without noise.
[[nodiscard]] Eigen::MatrixXd covariance_matrix(const Covariance& covariance, const data::SampleMatrix& a,
                                                const data::SampleMatrix& b);

struct Likelihood {
  double log_value{};        ///< log p(y | X)
  Eigen::VectorXd gradient;  ///< by the logarithms
};
/// The marginal likelihood of targets y at inputs x, and its gradient (Rasmussen and Williams, Gaussian Processes for
/// Machine Learning (2006), eqs. 5.8 and 5.9). Fails with numeric if the
/// covariance is not positive definite in double.
[[nodiscard]] Result<Likelihood> marginal_likelihood(const Covariance& covariance, const data::SampleMatrix& x,
                                                     const Eigen::VectorXd& y);

/// Rprop (Blum and Riedmiller, Optimization of Gaussian process hyperparameters using Rprop, ESANN 2013): each
/// coordinate has a step of its own, which grows while its derivative keeps its sign and shrinks where that turns.
class RpropSteps {
 public:
  /// Steps of 0.2 in each of so many coordinates; they stay within 1e-6 … 1.
  explicit RpropSteps(Eigen::Index coordinates);

  /// The step uphill from where this is the gradient. A coordinate whose derivative has turned since the step before
  /// stands still for one step.
  [[nodiscard]] Eigen::VectorXd next(Eigen::VectorXd gradient);

 private:
  Eigen::VectorXd sizes_, before_;
};

struct Ascent {
  Covariance covariance;
  double log_likelihood{};
  int evaluations{};
};
/// Climbs from a start by RpropSteps: the sign of each derivative sets the step of its logarithm; ends after `most`
/// evaluations or when no derivative exceeds 0.05. Lengths stay within 0.05 … 200, σ_f within 0.01 … 100, σ_n within
/// 0.001 … 2. Fails like marginal_likelihood, at the start only.
[[nodiscard]] Result<Ascent> climb_likelihood(const Covariance& start, const data::SampleMatrix& x,
                                              const Eigen::VectorXd& y, int most);

/// How many samples the stored variance of a Gaussian process rests on.
inline constexpr Eigen::Index kVarianceCentres = 60;

/// Nothing is chosen on held-out folds: each fit finds its own covariance by the marginal likelihood of what the plane
/// of ridge-u leaves of its training samples, and held-out samples choose nothing. The likelihood is climbed from three
/// starts, one in the middle and two at random (quick: from the middle alone), on every k-th sample such that at most
/// 400 remain; the function, plane and Gaussians together, is then made from all, its variance from every k-th such
/// that at most kVarianceCentres remain. The prediction goes on as a plane far from what was seen. The effective
/// parameters are the trace; the particulars name the lengths and the predictive standard deviation. Fails with numeric
/// if no start has a positive definite covariance.
[[nodiscard]] FitFunction fit_gaussian_process;

}  // namespace gyrotherm::methods
