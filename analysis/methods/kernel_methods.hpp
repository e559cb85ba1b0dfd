// SPDX-License-Identifier: Apache-2.0
/// Methods with a kernel matrix other than the support vector machine: the least-squares support vector machine and
/// Gaussian processes.
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
// Solves M [b; α] = [0; y] with M = [0 1ᵀ; 1 H], H = K + I/γ: Hη = 1, Hν = y, b = 1ᵀν/1ᵀη, α = ν − bη. ŷ(z) = Σ α_i
// K(z_i, z) + b, K(z, z') = exp(−‖z − z'‖²/(2σ²)).

/// Trained machine, with the intermediate results that other computations use.
struct LsSvm {
  Eigen::MatrixXd factor;  ///< L of H = LLᵀ, lower triangle
  Eigen::VectorXd eta;     ///< H⁻¹1
  Eigen::VectorXd alpha;
  double b{};
};

/// Solves the machine for a kernel matrix (symmetric, finite) and γ > 0. Fails with numeric if H is not positive
/// definite in double precision.
[[nodiscard]] Result<LsSvm> solve_ls_svm(const Eigen::Ref<const Eigen::MatrixXd>& kernel,
                                         const Eigen::Ref<const Eigen::VectorXd>& y, double gamma);

/// Returns the diagonal d of M⁻¹, one element per sample. e_i = α_i/d_i is the residual of sample i for the machine
/// trained without that sample (same kernel and γ; Cawley 2006; An, Liu and Venkatesh 2007). n − Σd_i/γ is the trace of
/// the matrix from y to fitted values.
[[nodiscard]] Eigen::VectorXd bordered_inverse_diagonal(const LsSvm& machine);

/// Chooses "gamma" and "sigma" by held-out error. First searches a grid over log2 γ = 2…18 and log2 σ = −½…5½ in steps
/// of 4 and 1½, then around the best position with one half and one quarter of these steps (quick: the grid only). Each
/// fold has its own scaling, so folds share no kernel matrix. Warns if the choice is at the edge of the grid.
[[nodiscard]] ChooseFunction choose_ls_svm;

/// Fits the machine. The number of effective parameters is the trace of the matrix from y to fitted values. The
/// particulars contain the closed-form leave-one-out error.
[[nodiscard]] FitFunction fit_ls_svm;

// Gaussian process regression (Rasmussen and Williams 2006): a plane, noise, and for the residual of the plane a
// squared-exponential covariance. The covariance has one length per input, which shows the relevance of that input.
// This is one of two modern methods added to those of the paper. Of the methods in this file, only this one gives a
// standard deviation with each prediction.
//
// The slope of the plane has the prior N(0, A); A⁻¹ is the slope_penalty of ridge_u.hpp with the variance σ_n². Without
// the Gaussians the plane would be equal to that of ridge-u. The penalty keeps the trained process valid while the
// thermometers drift. Far from the training data the process continues as a plane.

/// Covariance σ_f² exp(−½ Σ_j ((z_j − z'_j)/l_j)²), with noise of variance σ_n² on each target.
struct Covariance {
  Eigen::RowVectorXd lengths;  ///< l
  double signal{};             ///< σ_f
  double noise{};              ///< σ_n
};

/// Converts to and from the coordinates of the search: log l_1 … log l_d, log σ_f, log σ_n.
[[nodiscard]] Eigen::VectorXd to_logarithms(const Covariance& covariance);
[[nodiscard]] Covariance from_logarithms(const Eigen::VectorXd& logarithms);

/// Computes the covariance between the rows of a and b, without noise.
[[nodiscard]] Eigen::MatrixXd covariance_matrix(const Covariance& covariance, const data::SampleMatrix& a,
                                                const data::SampleMatrix& b);

struct Likelihood {
  double log_value{};        ///< log p(y | X)
  Eigen::VectorXd gradient;  ///< one element per logarithm
};
/// Computes the logarithm of the marginal likelihood of targets y at inputs x, and its gradient (Rasmussen and
/// Williams, Gaussian Processes for Machine Learning (2006), eqs. 5.8 and 5.9). Fails with numeric if the covariance is
/// not positive definite in double precision.
[[nodiscard]] Result<Likelihood> marginal_likelihood(const Covariance& covariance, const data::SampleMatrix& x,
                                                     const Eigen::VectorXd& y);

/// Rprop (Blum and Riedmiller, Optimization of Gaussian process hyperparameters using Rprop, ESANN 2013). Each
/// coordinate has its own step size, which grows while its derivative keeps its sign and shrinks when the sign changes.
class RpropSteps {
 public:
  /// Starts with a step size of 0.2 in each coordinate. Step sizes remain within 1e-6…1.
  explicit RpropSteps(Eigen::Index coordinates);

  /// Returns the uphill step at a point with this gradient. A coordinate whose derivative has changed its sign does not
  /// move in this step.
  [[nodiscard]] Eigen::VectorXd next(Eigen::VectorXd gradient);

 private:
  Eigen::VectorXd sizes_, before_;
};

struct Ascent {
  Covariance covariance;
  double log_likelihood{};
  int evaluations{};
};
/// Climbs from a start with RpropSteps. Ends after `most` evaluations or when no derivative exceeds 0.05 in magnitude.
/// Lengths are limited to 0.05…200, σ_f to 0.01…100, σ_n to 0.001…2. Fails as marginal_likelihood does, but only if it
/// fails at the start.
[[nodiscard]] Result<Ascent> climb_likelihood(const Covariance& start, const data::SampleMatrix& x,
                                              const Eigen::VectorXd& y, int most);

/// Number of samples stored for the variance of a Gaussian process.
inline constexpr Eigen::Index kVarianceCentres = 60;

/// Fits a Gaussian process. Nothing is chosen on held-out folds. Each fit finds its covariance by maximising the
/// marginal likelihood of the residual of the ridge-u plane on the training samples.
///
/// The search has three starts, one in the middle and two at random (quick: only the middle). It uses every k-th
/// sample, at most 400. The function, plane and Gaussians together, is then fitted to all samples. Its variance uses
/// every k-th sample, at most kVarianceCentres. Far from the training data the prediction continues as a plane. The
/// number of effective parameters is the trace of the matrix from targets to fitted values. The particulars contain the
/// lengths and the predictive standard deviation. Fails with numeric if the covariance is not positive definite at any
/// start.
[[nodiscard]] FitFunction fit_gaussian_process;

}  // namespace gyrotherm::methods
