/// A growing basis of temperature fields, orthonormal in the heat capacity (VᵀCV = I), the full system's projection
/// onto it, and an estimate of how far the projection misses at any coefficients and rate.
#pragma once

#include "thermal/affine_matrix.hpp"
#include "thermal/reduced/reduced_model.hpp"

namespace gyrotherm {

/// Where an answer is asked for: (K(c) + s C) X = B(c).
struct ThermalPoint {
  ThermalCoefficients coefficients{};
  double rate_per_s{};  ///< s ≥ 0; 0 is the rest
};

class ReducedBasis final {
 public:
  /// Begins with the constant field, so that a model without power rests at the ambient exactly. `weights` scale the
  /// residual of each unknown (a diagonal preconditioner's, W). `about` gives the projection all that is no matrix.
  ReducedBasis(const ThermalSystem& system, ReducedModel about, Eigen::VectorXd weights, Eigen::Index most_states);

  /// Makes the fields orthonormal and takes what is new of them; returns how many that were.
  Eigen::Index grow(Eigen::MatrixXd fields);

  /// Estimate, within some per cent, of sqrt(rᵀ W r) for each column u of `loads` (inputs × columns), r the residual
  /// B u − (K + s C) V x: it is sketched by random signs into few sums (Charikar, Chen & Farach-Colton 2004; for
  /// reduced bases Balabanov & Nouy 2019), so that an estimate costs as the states do and not as the unknowns.
  [[nodiscard]] Eigen::VectorXd residuals(const ThermalPoint& point, const Eigen::MatrixXd& loads) const;

  [[nodiscard]] const ReducedModel& model() const { return model_; }
  [[nodiscard]] auto basis() const { return basis_.leftCols(states_); }

 private:
  /// The full matrices in the order C, K₀, K_m.
  static constexpr std::size_t kParts = 2 + kThermalCoefficients;
  [[nodiscard]] const SparseMatrix& part(std::size_t index) const;
  [[nodiscard]] Eigen::VectorXd sketch(const Eigen::VectorXd& residual) const;
  [[nodiscard]] bool append(Eigen::VectorXd field);
  void project(Eigen::Index from);

  const ThermalSystem& system_;
  Eigen::VectorXd weights_;  ///< square roots, with random signs
  std::vector<int> sums_;    ///< which sum of the sketch each unknown goes to
  Eigen::MatrixXd basis_;    ///< room for all states
  Eigen::Index states_ = 0;
  ReducedModel model_;
  std::array<Eigen::MatrixXd, kParts> sketched_parts_;
  Eigen::MatrixXd sketched_inputs_;
  Eigen::VectorXd sketched_film_;
};

/// The model on the span of `directions` (orthonormal columns) of its states.
[[nodiscard]] ReducedModel projected(const ReducedModel& model, const Eigen::MatrixXd& directions);

}  // namespace gyrotherm
