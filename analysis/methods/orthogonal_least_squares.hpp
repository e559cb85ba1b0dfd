/// Forward selection of regressors by orthogonal least squares (Chen, Cowan and Grant, IEEE Trans. Neural Networks 2
/// (1991) 302).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrotherm {

/// Candidates in the order in which they were taken, each the one that then explained most of the target's spread.
struct OrthogonalPath {
  std::vector<Eigen::Index> order;
  std::vector<double> ratios;  ///< error-reduction ratio g_k² q_kᵀq_k / yᵀy of each; they sum to at most 1
  Eigen::MatrixXd triangle;    ///< unit upper triangle A of the orthogonalisation: columns taken = QA
  Eigen::VectorXd orthogonal;  ///< g_k = q_kᵀy / q_kᵀq_k
  Eigen::RowVectorXd means;    ///< of the candidates
  double target_mean{};
};

/// Modified Gram–Schmidt on the centred candidates (columns) and target: takes the largest ratio until 1 − Σ of the
/// ratios is below `tolerance`, `most` are taken, or no candidate has a part of its own left.
[[nodiscard]] OrthogonalPath orthogonal_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& candidates,
                                                      const Eigen::Ref<const Eigen::VectorXd>& y, double tolerance,
                                                      Eigen::Index most);

/// How many of the path's candidates are taken until 1 − Σ is below the tolerance; all if it never is.
[[nodiscard]] Eigen::Index taken_at(const OrthogonalPath& path, double tolerance);

/// Weights of the first `count` candidates taken, in the path's order, by back substitution.
[[nodiscard]] Eigen::VectorXd weights_of(const OrthogonalPath& path, Eigen::Index count);
/// The constant that belongs to them.
[[nodiscard]] double offset_of(const OrthogonalPath& path, const Eigen::VectorXd& weights);

}  // namespace gyrotherm
