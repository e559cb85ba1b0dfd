/// What every method ends in: a function of the scaled inputs z, in units of the target's STD from the target's mean.
#pragma once

#include <Eigen/Core>
#include <variant>

#include "analysis/svm/svr.hpp"

namespace gyrotherm {

/// f(z) = Σ β_i exp(−‖z − v_i‖²/(2σ²)) + b.
struct SvrModel {
  SampleMatrix support_vectors;  ///< scaled
  Eigen::VectorXd beta;
  double b{};
  SvrParameters parameters;
  double relative_gap{};
  double kkt_violation{};
};

/// f(z) = w·z + b.
struct LinearModel {
  Eigen::VectorXd weights;
  double b{};
};

/// f(z) = Σ_k w_k exp(−½ Σ_j ((z_j − c_kj)/(l_j s_k))²) + b.
struct ExpansionModel {
  SampleMatrix centres;        ///< k × inputs, scaled
  Eigen::RowVectorXd lengths;  ///< l, > 0, one per input; ones unless the method weighs its inputs
  Eigen::VectorXd widths;      ///< s, > 0, one per centre
  Eigen::VectorXd weights;     ///< w, one per centre
  double b{};
};

/// f(z) = Σ_k v_k tanh(w_k·z + u_k) + b.
struct NetworkModel {
  SampleMatrix weights;     ///< w, hidden units × inputs
  Eigen::VectorXd offsets;  ///< u, one per hidden unit
  Eigen::VectorXd out;      ///< v, one per hidden unit
  double b{};
};

using Function = std::variant<SvrModel, LinearModel, ExpansionModel, NetworkModel>;

/// f of each row. `scaled` has the function's number of inputs.
[[nodiscard]] Eigen::VectorXd value_of(const Function& function, const SampleMatrix& scaled);

/// How many numbers the function stores: its size in a navigation computer.
[[nodiscard]] int numbers_in(const Function& function);

}  // namespace gyrotherm
