#include "analysis/methods/function.hpp"

#include "analysis/svm/gaussian_sum.hpp"

namespace gyrotherm {
namespace {

Eigen::VectorXd value(const SvrModel& svr, const SampleMatrix& scaled) {
  const Eigen::VectorXd widths = Eigen::VectorXd::Constant(svr.beta.size(), svr.parameters.sigma);
  return GaussianSum(svr.support_vectors, widths, svr.beta).at(scaled).array() + svr.b;
}

Eigen::VectorXd value(const LinearModel& linear, const SampleMatrix& scaled) {
  return (scaled * linear.weights).array() + linear.b;
}

Eigen::VectorXd value(const ExpansionModel& expansion, const SampleMatrix& scaled) {
  const auto in_lengths = [&](const SampleMatrix& rows) -> SampleMatrix {
    return rows.array().rowwise() / expansion.lengths.array();
  };
  const GaussianSum sum(in_lengths(expansion.centres), expansion.widths, expansion.weights);
  return sum.at(in_lengths(scaled)).array() + expansion.b;
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
