#include "analysis/model.hpp"

#include <cassert>
#include <limits>

namespace gyrotherm {
namespace {

Eigen::VectorXd value_of(const SvrModel& svr, const SampleMatrix& scaled) {
  const Eigen::MatrixXd kernel = gaussian_kernel(scaled, svr.support_vectors, svr.parameters.sigma);
  return (kernel * svr.beta).array() + svr.b;
}

Eigen::VectorXd value_of(const LinearModel& linear, const SampleMatrix& scaled) {
  return (scaled * linear.weights).array() + linear.b;
}

}  // namespace

Result<Eigen::VectorXd> predict(const Model& model, const Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  return predict(model, *inputs);
}

Eigen::VectorXd predict(const Model& model, const SampleMatrix& inputs) {
  assert(inputs.cols() == static_cast<Eigen::Index>(model.terms.size()));
  const SampleMatrix scaled = apply(model.scaling, inputs);
  Eigen::VectorXd f = std::visit([&](const auto& function) { return value_of(function, scaled); }, model.function);
  for (Eigen::Index k = 0; k < f.size(); ++k) {
    if (!inputs.row(k).allFinite()) f(k) = std::numeric_limits<double>::quiet_NaN();
  }
  return f.array() * model.target_std_deg_per_h + model.target_mean_deg_per_h;
}

}  // namespace gyrotherm
