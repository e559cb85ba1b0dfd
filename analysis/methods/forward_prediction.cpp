#include "analysis/methods/forward_prediction.hpp"

#include <cassert>

namespace gyrotherm {
namespace {

/// One past the last cluster of the stretch that begins at `first`.
Eigen::Index end_of_stretch(const Clusters& clusters, Eigen::Index first) {
  Eigen::Index next = first + 1;
  const auto follows = [&](Eigen::Index k) {
    const double apart = clusters.start_s(k) - clusters.start_s(k - 1);
    return apart > 0 && apart < 1.5 * clusters.length_s;
  };
  while (next < clusters.start_s.size() && follows(next)) ++next;
  return next;
}

}  // namespace

Eigen::VectorXd forward_prediction(const Eigen::Ref<const Eigen::VectorXd>& values, const ForwardPrediction& options) {
  assert(options.order > 0 && options.step > 0 && options.step < 2);
  const Eigen::Index order = options.order;
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(order, 1 / static_cast<double>(order));
  Eigen::VectorXd predicted = values;
  for (Eigen::Index n = order; n < values.size(); ++n) {
    const Eigen::VectorXd before = values.segment(n - order, order).reverse();
    predicted(n) = weights.dot(before);
    const double power = before.squaredNorm();
    if (power > 0) weights += options.step * (values(n) - predicted(n)) / power * before;
  }
  return predicted;
}

Eigen::VectorXd filter_bias(const Clusters& training) {
  Eigen::VectorXd filtered = training.bias_deg_per_h;
  for (Eigen::Index first = 0, end = 0; first < filtered.size(); first = end) {
    end = end_of_stretch(training, first);
    const auto stretch = training.bias_deg_per_h.segment(first, end - first);
    const double mean = stretch.mean();
    filtered.segment(first, end - first) = forward_prediction(stretch.array() - mean).array() + mean;
  }
  return filtered;
}

}  // namespace gyrotherm
