#include "analysis/function.hpp"

namespace gyrotherm {
namespace {

Eigen::VectorXd value(const SvrModel& svr, const SampleMatrix& scaled) {
  return (gaussian_kernel(scaled, svr.support_vectors, svr.parameters.sigma) * svr.beta).array() + svr.b;
}

Eigen::VectorXd value(const LinearModel& linear, const SampleMatrix& scaled) {
  return (scaled * linear.weights).array() + linear.b;
}

Eigen::VectorXd value(const ExpansionModel& expansion, const SampleMatrix& scaled) {
  Eigen::VectorXd f(scaled.rows());
  for (Eigen::Index i = 0; i < scaled.rows(); ++i) {
    const auto apart = (expansion.centres.rowwise() - scaled.row(i)).array().rowwise() / expansion.lengths.array();
    const Eigen::ArrayXd squares = apart.square().rowwise().sum() / expansion.widths.array().square();
    f(i) = ((-0.5 * squares).exp() * expansion.weights.array()).sum() + expansion.b;
  }
  return f;
}

Eigen::VectorXd value(const NetworkModel& network, const SampleMatrix& scaled) {
  const Eigen::MatrixXd sums = (scaled * network.weights.transpose()).rowwise() + network.offsets.transpose();
  return (sums.array().tanh().matrix() * network.out).array() + network.b;
}

int numbers(const SvrModel& svr) { return static_cast<int>(svr.support_vectors.size() + svr.beta.size()) + 2; }
int numbers(const LinearModel& linear) { return static_cast<int>((linear.weights.array() != 0).count()) + 1; }
int numbers(const ExpansionModel& expansion) {
  return static_cast<int>(expansion.centres.size() + expansion.lengths.size() + expansion.widths.size() +
                          expansion.weights.size()) +
         1;
}
int numbers(const NetworkModel& network) {
  return static_cast<int>(network.weights.size() + network.offsets.size() + network.out.size()) + 1;
}

}  // namespace

Eigen::VectorXd value_of(const Function& function, const SampleMatrix& scaled) {
  return std::visit([&](const auto& form) { return value(form, scaled); }, function);
}

int numbers_in(const Function& function) {
  return std::visit([](const auto& form) { return numbers(form); }, function);
}

}  // namespace gyrotherm
