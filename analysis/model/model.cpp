#include "analysis/model/model.hpp"

#include <cassert>
#include <limits>

namespace gyrotherm {
Result<Eigen::VectorXd> predict(const Model& model, const Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  return predict(model, *inputs);
}

Eigen::VectorXd predict(const Model& model, const SampleMatrix& inputs) {
  assert(inputs.cols() == static_cast<Eigen::Index>(model.terms.size()));
  const SampleMatrix scaled = apply(model.scaling, inputs);
  Eigen::VectorXd f = value_of(model.function, scaled);
  for (Eigen::Index k = 0; k < f.size(); ++k) {
    if (!inputs.row(k).allFinite()) f(k) = std::numeric_limits<double>::quiet_NaN();
  }
  return f.array() * model.target_std_deg_per_h + model.target_mean_deg_per_h;
}

}  // namespace gyrotherm
