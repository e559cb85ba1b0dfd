// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/coregionalised_gp.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "analysis/methods/kernel_methods.hpp"

namespace gyrotherm::population {
namespace {

tl::unexpected<Fault> refuse_samples(std::string what) {
  return failure(FaultKind::usage, "coregionalised process", std::move(what));
}

Result<void> check_samples(const OutputSamples& samples) {
  if (samples.x.cols() == 0 || samples.outputs < 1) return refuse_samples("expected at least one input and one output");
  if (!samples.x.allFinite()) return refuse_samples("an input is not finite");
  std::vector<int> count(static_cast<std::size_t>(samples.outputs));
  for (const OutputValue& sample : samples.values) {
    if (sample.row < 0 || sample.row >= samples.x.rows() || sample.output < 0 || sample.output >= samples.outputs)
      return refuse_samples(
          fmt::format("a value refers to row {} of output {}, which does not exist", sample.row, sample.output));
    if (!std::isfinite(sample.value)) return refuse_samples("a value is not finite");
    ++count[static_cast<std::size_t>(sample.output)];
  }
  if (std::ranges::any_of(count, [](int values) { return values < 2; }))
    return refuse_samples("an output has fewer than two values");
  return {};
}

Eigen::VectorXd output_means(const OutputSamples& samples) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(samples.outputs), count = sum;
  for (const OutputValue& sample : samples.values) {
    sum(sample.output) += sample.value;
    count(sample.output) += 1;
  }
  return sum.cwiseQuotient(count);
}

Eigen::VectorXd output_variances(const OutputSamples& samples, const Eigen::VectorXd& mean) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(samples.outputs), count = sum;
  for (const OutputValue& sample : samples.values) {
    sum(sample.output) += std::pow(sample.value - mean(sample.output), 2);
    count(sample.output) += 1;
  }
  return sum.cwiseQuotient(count);
}

Eigen::VectorXd values_in(const OutputSamples& samples) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(samples.values.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) values(i) = samples.values[static_cast<std::size_t>(i)].value;
  return values;
}

/// Returns H, with 1 in the column of each value's output.
Eigen::MatrixXd output_indicators(const OutputSamples& samples) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(samples.values.size()), samples.outputs);
  for (Eigen::Index i = 0; i < all.rows(); ++i) all(i, samples.values[static_cast<std::size_t>(i)].output) = 1;
  return all;
}

/// Returns k between the rows of a and the rows of b.
Eigen::MatrixXd compute_kernel(const Coregionalisation& model, const data::SampleMatrix& a,
                               const data::SampleMatrix& b) {
  return methods::covariance_matrix({.lengths = model.lengths, .signal = 1, .noise = 0}, a, b);
}

/// Returns the covariance of each pair of values, B_ij k, without noise.
Eigen::MatrixXd value_covariance(const OutputSamples& samples, const Eigen::MatrixXd& kernel,
                                 const Eigen::MatrixXd& between) {
  const auto count = static_cast<Eigen::Index>(samples.values.size());
  Eigen::MatrixXd all(count, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const OutputValue& b = samples.values[static_cast<std::size_t>(j)];
    for (Eigen::Index i = 0; i < count; ++i) {
      const OutputValue& a = samples.values[static_cast<std::size_t>(i)];
      all(i, j) = between(a.output, b.output) * kernel(a.row, b.row);
    }
  }
  return all;
}

void add_noise(const OutputSamples& samples, const Eigen::VectorXd& noise, Eigen::MatrixXd& covariance) {
  for (std::size_t i = 0; i < samples.values.size(); ++i) {
    const double deviation = noise(samples.values[i].output);
    covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) += deviation * deviation;
  }
}

tl::unexpected<Fault> not_definite_fault() {
  return failure(FaultKind::numeric, "coregionalised process", "the covariance is not positive definite");
}

/// Intermediate results of the likelihood and its gradient.
struct Solution {
  Eigen::MatrixXd kernel;  ///< k of the inputs' rows
  Eigen::LLT<Eigen::MatrixXd> factor;
  Eigen::MatrixXd of_constants, constant_covariance;
  Eigen::VectorXd constant, alpha;
  double log_likelihood{};
};

Result<Solution> solve(const Coregionalisation& model, const OutputSamples& samples) {
  Solution solved;
  solved.kernel = compute_kernel(model, samples.x, samples.x);
  Eigen::MatrixXd covariance = value_covariance(samples, solved.kernel, output_covariance(model));
  add_noise(samples, model.noise, covariance);
  solved.factor.compute(covariance);
  if (solved.factor.info() != Eigen::Success) return not_definite_fault();
  solved.of_constants = solved.factor.matrixL().solve(output_indicators(samples));
  const Eigen::VectorXd y = solved.factor.matrixL().solve(values_in(samples));
  const Eigen::LLT<Eigen::MatrixXd> precision(solved.of_constants.transpose() * solved.of_constants);
  if (precision.info() != Eigen::Success) return not_definite_fault();
  solved.constant = precision.solve(solved.of_constants.transpose() * y);
  solved.constant_covariance = precision.solve(Eigen::MatrixXd::Identity(samples.outputs, samples.outputs));
  const Eigen::VectorXd left = y - solved.of_constants * solved.constant;
  solved.alpha = solved.factor.matrixU().solve(left);
  const double determinants =
      solved.factor.matrixLLT().diagonal().array().log().sum() + precision.matrixLLT().diagonal().array().log().sum();
  const auto freedom = static_cast<double>(y.size() - samples.outputs);
  solved.log_likelihood = -0.5 * left.squaredNorm() - determinants - 0.5 * freedom * std::log(2 * std::numbers::pi);
  if (!std::isfinite(solved.log_likelihood)) return not_definite_fault();
  return solved;
}

Eigen::Index parameters_in(Eigen::Index inputs, Eigen::Index outputs) {
  return inputs + outputs * (outputs + 1) / 2 + outputs;
}

Eigen::VectorXd to_coordinates(const Coregionalisation& model) {
  const Eigen::Index inputs = model.lengths.size(), outputs = model.noise.size();
  Eigen::VectorXd all(parameters_in(inputs, outputs));
  all.head(inputs) = model.lengths.transpose().array().log();
  Eigen::Index at = inputs;
  for (Eigen::Index column = 0; column < outputs; ++column)
    for (Eigen::Index row = column; row < outputs; ++row, ++at)
      all(at) = row == column ? std::log(model.root(row, column)) : model.root(row, column);
  all.tail(outputs) = model.noise.array().log();
  return all;
}

Coregionalisation from_coordinates(const Eigen::VectorXd& coordinates, Eigen::Index inputs, Eigen::Index outputs) {
  Coregionalisation model{.lengths = coordinates.head(inputs).transpose().array().exp(),
                          .root = Eigen::MatrixXd::Zero(outputs, outputs),
                          .noise = coordinates.tail(outputs).array().exp()};
  Eigen::Index at = inputs;
  for (Eigen::Index column = 0; column < outputs; ++column)
    for (Eigen::Index row = column; row < outputs; ++row, ++at)
      model.root(row, column) = row == column ? std::exp(coordinates(at)) : coordinates(at);
  return model;
}

/// Clamps the coordinates so that a search cannot diverge: lengths to 0.05 … 200; for outputs of unit variance, the
/// root to ± 100 and its diagonal to 0.001 … 100, noises to 0.001 … 10.
Eigen::VectorXd clamp_coordinates(Eigen::VectorXd at, Eigen::Index inputs, Eigen::Index outputs) {
  const auto clamp = [&](Eigen::Index k, double low, double high) { at(k) = std::clamp(at(k), low, high); };
  for (Eigen::Index k = 0; k < inputs; ++k) clamp(k, std::log(0.05), std::log(200));
  Eigen::Index k = inputs;
  for (Eigen::Index column = 0; column < outputs; ++column) {
    for (Eigen::Index row = column; row < outputs; ++row, ++k)
      row == column ? clamp(k, std::log(0.001), std::log(100)) : clamp(k, -100, 100);
  }
  for (; k < at.size(); ++k) clamp(k, std::log(0.001), std::log(10));
  return at;
}

/// The samples with each output in units of its standard deviation.
struct StandardisedSamples {
  OutputSamples samples;
  Eigen::VectorXd deviation;
};

Result<StandardisedSamples> standardise(const OutputSamples& samples) {
  const Eigen::VectorXd mean = output_means(samples);
  StandardisedSamples all{samples, output_variances(samples, mean).cwiseSqrt()};
  for (Eigen::Index j = 0; j < samples.outputs; ++j) {
    constexpr double kRounding = 1e-12;
    if (!(all.deviation(j) > kRounding * std::abs(mean(j)))) return refuse_samples("an output does not vary");
  }
  for (OutputValue& sample : all.samples.values)
    sample.value = (sample.value - mean(sample.output)) / all.deviation(sample.output);
  return all;
}

struct Optimum {
  Coregionalisation model;
  int evaluations{};
};

Result<Optimum> maximise_likelihood(const OutputSamples& samples, int most) {
  constexpr double kFlatEnough = 0.05;  // nats per unit of a coordinate
  const Eigen::Index inputs = samples.x.cols(), outputs = samples.outputs;
  const double half = std::sqrt(0.5);
  Eigen::VectorXd at =
      to_coordinates({.lengths = Eigen::RowVectorXd::Constant(inputs, std::sqrt(static_cast<double>(inputs))),
                      .root = half * Eigen::MatrixXd::Identity(outputs, outputs),
                      .noise = Eigen::VectorXd::Constant(outputs, half)});
  auto likelihood = marginal_likelihood(from_coordinates(at, inputs, outputs), samples);
  if (!likelihood) return failure(likelihood.error());
  Eigen::VectorXd best = at;
  double highest = likelihood->log_value;
  int evaluations = 1;
  methods::RpropSteps steps(at.size());
  while (evaluations < most && likelihood->gradient.cwiseAbs().maxCoeff() > kFlatEnough) {
    at = clamp_coordinates(at + steps.next(likelihood->gradient), inputs, outputs);
    likelihood = marginal_likelihood(from_coordinates(at, inputs, outputs), samples);
    ++evaluations;
    if (!likelihood) break;
    if (!(likelihood->log_value > highest)) continue;
    best = at;
    highest = likelihood->log_value;
  }
  return Optimum{from_coordinates(best, inputs, outputs), evaluations};
}

}  // namespace

OutputSamples samples_from_table(const data::SampleMatrix& x, const Eigen::MatrixXd& table) {
  OutputSamples samples{.x = x, .values = {}, .outputs = table.cols()};
  for (Eigen::Index j = 0; j < table.cols(); ++j)
    for (Eigen::Index i = 0; i < table.rows(); ++i)
      if (!std::isnan(table(i, j))) samples.values.push_back({i, j, table(i, j)});
  return samples;
}

Eigen::MatrixXd output_covariance(const Coregionalisation& model) { return model.root * model.root.transpose(); }

Eigen::MatrixXd correlation_between_outputs(const Coregionalisation& model) {
  const Eigen::MatrixXd between = output_covariance(model);
  const Eigen::VectorXd inverse = between.diagonal().cwiseSqrt().cwiseInverse();
  return inverse.asDiagonal() * between * inverse.asDiagonal();
}

Result<CoregionalisedLikelihood> marginal_likelihood(const Coregionalisation& model, const OutputSamples& samples) {
  if (const auto checked = check_samples(samples); !checked) return failure(checked.error());
  const auto solved = solve(model, samples);
  if (!solved) return failure(solved.error());
  const Eigen::Index inputs = samples.x.cols(), outputs = samples.outputs, rows = samples.x.rows();
  const auto count = static_cast<Eigen::Index>(samples.values.size());
  // The gradient is ½ tr(Q ∂K/∂θ), Q = ααᵀ − K⁻¹ + K⁻¹H(HᵀK⁻¹H)⁻¹HᵀK⁻¹. Sums of Q ∘ k over the values of each pair of
  // outputs give the gradient with respect to B; sums of Q ∘ B over the values of each pair of rows give the gradient
  // with respect to k.
  const Eigen::MatrixXd with_constants = solved->factor.matrixU().solve(solved->of_constants);
  Eigen::MatrixXd q = -solved->factor.solve(Eigen::MatrixXd::Identity(count, count));
  q += solved->alpha * solved->alpha.transpose() +
       with_constants * solved->constant_covariance * with_constants.transpose();
  const Eigen::MatrixXd between = output_covariance(model);
  Eigen::MatrixXd by_between = Eigen::MatrixXd::Zero(outputs, outputs);
  Eigen::MatrixXd by_kernel = Eigen::MatrixXd::Zero(rows, rows);
  Eigen::VectorXd by_noise = Eigen::VectorXd::Zero(outputs);
  for (Eigen::Index j = 0; j < count; ++j) {
    const OutputValue& b = samples.values[static_cast<std::size_t>(j)];
    by_noise(b.output) += q(j, j) * model.noise(b.output) * model.noise(b.output);
    for (Eigen::Index i = 0; i < count; ++i) {
      const OutputValue& a = samples.values[static_cast<std::size_t>(i)];
      by_between(a.output, b.output) += q(i, j) * solved->kernel(a.row, b.row);
      by_kernel(a.row, b.row) += q(i, j) * between(a.output, b.output);
    }
  }
  CoregionalisedLikelihood likelihood{.log_value = solved->log_likelihood,
                                      .gradient = Eigen::VectorXd(parameters_in(inputs, outputs))};
  by_kernel.array() *= solved->kernel.array();
  const Eigen::VectorXd sums = by_kernel.rowwise().sum();
  const Eigen::MatrixXd products = by_kernel * samples.x;
  for (Eigen::Index k = 0; k < inputs; ++k) {
    const double spread = samples.x.col(k).cwiseAbs2().dot(sums) - samples.x.col(k).dot(products.col(k));
    likelihood.gradient(k) = spread / (model.lengths(k) * model.lengths(k));
  }
  const Eigen::MatrixXd by_root = by_between * model.root;
  Eigen::Index at = inputs;
  for (Eigen::Index column = 0; column < outputs; ++column)
    for (Eigen::Index row = column; row < outputs; ++row, ++at)
      likelihood.gradient(at) = by_root(row, column) * (row == column ? model.root(row, column) : 1);
  likelihood.gradient.tail(outputs) = by_noise;
  return likelihood;
}

Result<CoregionalisedGp> condition(const Coregionalisation& model, OutputSamples samples) {
  if (const auto checked = check_samples(samples); !checked) return failure(checked.error());
  auto solved = solve(model, samples);
  if (!solved) return failure(solved.error());
  return CoregionalisedGp{model,
                          std::move(samples),
                          std::move(solved->constant),
                          std::move(solved->constant_covariance),
                          std::move(solved->alpha),
                          solved->factor.matrixL(),
                          std::move(solved->of_constants),
                          solved->log_likelihood,
                          0};
}

Result<CoregionalisedGp> learn_coregionalised(OutputSamples samples, int most_evaluations) {
  if (const auto checked = check_samples(samples); !checked) return failure(checked.error());
  const auto unit = standardise(samples);
  if (!unit) return failure(unit.error());
  auto optimum = maximise_likelihood(unit->samples, most_evaluations);
  if (!optimum) return failure(optimum.error());
  optimum->model.root = unit->deviation.asDiagonal() * optimum->model.root;
  optimum->model.noise = unit->deviation.cwiseProduct(optimum->model.noise);
  auto process = condition(optimum->model, std::move(samples));
  if (process) process->evaluations = optimum->evaluations;
  return process;
}

OutputPredictions predict(const CoregionalisedGp& process, const data::SampleMatrix& x) {
  const Eigen::Index outputs = process.samples.outputs;
  const auto count = static_cast<Eigen::Index>(process.samples.values.size());
  const Eigen::MatrixXd kernel = compute_kernel(process.model, process.samples.x, x);
  const Eigen::MatrixXd between = output_covariance(process.model);
  OutputPredictions predictions{Eigen::MatrixXd(x.rows(), outputs), Eigen::MatrixXd(x.rows(), outputs)};
  for (Eigen::Index j = 0; j < outputs; ++j) {
    Eigen::MatrixXd cross_covariance(count, x.rows());
    for (Eigen::Index i = 0; i < count; ++i) {
      const OutputValue& value = process.samples.values[static_cast<std::size_t>(i)];
      cross_covariance.row(i) = between(value.output, j) * kernel.row(value.row);
    }
    predictions.mean.col(j) = (cross_covariance.transpose() * process.alpha).array() + process.constant(j);
    process.factor.triangularView<Eigen::Lower>().solveInPlace(cross_covariance);
    // e_j − HᵀK⁻¹k, one column per row of x.
    Eigen::MatrixXd unexplained = -process.of_constants.transpose() * cross_covariance;
    unexplained.row(j).array() += 1;
    const Eigen::RowVectorXd of_constants =
        (process.constant_covariance * unexplained).cwiseProduct(unexplained).colwise().sum();
    predictions.variance.col(j) =
        ((between(j, j) - cross_covariance.colwise().squaredNorm().array()).max(0) + of_constants.array()).transpose();
  }
  return predictions;
}

}  // namespace gyrotherm::population
