// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <random>

#include "analysis/methods/method.hpp"
#include "bench/measurement.hpp"
#include "bench/svr/judge.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/tuning_material.hpp"
#include "core/random.hpp"

namespace gyrotherm::bench {
namespace {

constexpr Eigen::Index kSupportVectors = 1000;
constexpr Eigen::Index kPoints = 100'000;
constexpr double kGamma = 0.1;

/// Returns points similar to the set: its rows repeatedly, each shifted slightly.
data::SampleMatrix points_like(const SampleSet& set) {
  std::mt19937_64 generator(1);
  data::SampleMatrix points(kPoints, set.x.cols());
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (Eigen::Index k = 0; k < points.cols(); ++k)
      points(i, k) = set.x(i % set.x.rows(), k) + 1e-3 * uniform(generator);
  return points;
}

methods::SvrModel model_of(const SampleSet& set) {
  std::mt19937_64 generator(2);
  methods::SvrModel model;
  model.support_vectors = set.x.topRows(kSupportVectors);
  model.beta = Eigen::VectorXd::NullaryExpr(kSupportVectors, [&] { return 2 * uniform(generator) - 1; });
  model.b = 0.25;
  model.parameters = own_parameters({.C = 1, .gamma = kGamma, .epsilon = 0.01});
  return model;
}

}  // namespace

Result<void> measure_prediction(const Bench& bench) {
  constexpr Eigen::Index kChecked = 200;
  const auto set = load_sample_set(bench.data, "gyro10000");
  if (!set) return failure(set.error());
  const methods::SvrModel model = model_of(*set);
  const data::SampleMatrix points = points_like(*set);
  Eigen::VectorXd out;
  const methods::Function function = model;
  const double seconds = median_seconds(3, [&] { out = evaluate_function(function, points); });
  const Eigen::VectorXd plain =
      plain_prediction(model.support_vectors, model.beta, model.b, kGamma, points.topRows(kChecked));
  const double worst = (out.head(kChecked) - plain).cwiseAbs().maxCoeff() / model.beta.lpNorm<1>();
  const data::SampleMatrix few = set->x.topRows(kSupportVectors);
  const Eigen::VectorXd targets = set->y.head(kSupportVectors);
  // A tiny ε makes nearly every sample a support vector. Both solvers therefore predict with the same number of them.
  const double peer = bench.peer.predictions_per_second(few, targets, {.C = 1, .gamma = kGamma, .epsilon = 1e-6});
  const double rate = static_cast<double>(kPoints) / seconds;
  print_progress(
      fmt::format("prediction with {} support vectors: {:.4g} points/s, LIBSVM {:.4g}; against a plain loop "
                  "{:.1e} of the sum of |beta|",
                  kSupportVectors, rate, peer, worst));
  print_figure(fmt::format("prediction, {} support vectors, d={}, points/s", kSupportVectors, set->x.cols()), rate,
               at_least(2e6), worst <= 1e-6);
  return {};
}

}  // namespace gyrotherm::bench
