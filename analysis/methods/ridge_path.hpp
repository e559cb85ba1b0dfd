/// Ridge regression for any penalty from one decomposition: minimise ‖y − Zw − b‖² + λn‖w‖², b free.
#pragma once

#include <Eigen/Core>

namespace gyrotherm {

class RidgePath {
 public:
  /// Rows of z are samples; there is at least one of them and one column.
  RidgePath(const Eigen::Ref<const Eigen::MatrixXd>& z, const Eigen::Ref<const Eigen::VectorXd>& y);
  /// λ > 0.
  [[nodiscard]] Eigen::VectorXd weights(double lambda) const;
  /// b for these weights.
  [[nodiscard]] double offset(const Eigen::VectorXd& weights) const;
  /// Trace of the matrix from y to fitted values, the constant's 1 included.
  [[nodiscard]] double effective_parameters(double lambda) const;

 private:
  Eigen::RowVectorXd z_mean_;
  double y_mean_{};
  double samples_{};
  Eigen::VectorXd singular_;  ///< values of the centred Z
  Eigen::MatrixXd right_;     ///< its right singular vectors
  Eigen::VectorXd target_;    ///< y in its left singular vectors
};

}  // namespace gyrotherm
