// SPDX-License-Identifier: Apache-2.0
/// Computes known answers of an exported model and writes the tables of its self-test.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>
#include <utility>
#include <variant>

#include "analysis/model/export_parts.hpp"
#include "core/quantity.hpp"
#include "core/random.hpp"

namespace gyrotherm::model {
namespace {

constexpr Eigen::Index kRowsInside = 6, kRowsOutside = 2;
constexpr double kAmbient_c = 20;

/// Returns the coefficients of each single-factor term in the temperatures, rates and lags, side by side; a row of
/// zeros for other terms.
Eigen::MatrixXd term_coefficients(const Model& model, const std::vector<std::string>& names) {
  const auto count = static_cast<Eigen::Index>(names.size());
  const std::vector<data::Factor> lags = data::lags_in(model.terms);
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(model.terms.size()),
                                                 2 * count + static_cast<Eigen::Index>(lags.size()));
  for (Eigen::Index i = 0; i < slopes.rows(); ++i) {
    const auto& factors = model.terms[static_cast<std::size_t>(i)].factors;
    if (factors.size() != 1) continue;
    const data::Factor& factor = factors.front();
    const Eigen::Index thermometer = index_in(names, factor.first);
    const bool rate = factor.kind == data::FactorKind::rate, lag = factor.kind == data::FactorKind::lag;
    slopes(i, lag ? 2 * count + index_in(lags, factor) : rate ? count + thermometer : thermometer) = 1;
    if (factor.kind == data::FactorKind::gradient) slopes(i, index_in(names, factor.second)) -= 1;
  }
  return slopes;
}

/// Returns the scaled centres of the function; empty if it has none.
data::SampleMatrix function_centres(const methods::Function& function) {
  if (const auto* svr = std::get_if<methods::SvrModel>(&function)) return svr->support_vectors;
  if (const auto* expansion = std::get_if<methods::ExpansionModel>(&function)) return expansion->centres;
  return {};
}

/// Draws unscaled inputs similar to the training: near the function's centres, or in the trained range if there are
/// none.
data::SampleMatrix draw_inputs(const Model& model, Eigen::Index rows) {
  std::mt19937_64 generator(1);
  const auto below_one = [&] { return uniform(generator); };
  const data::SampleMatrix centres = function_centres(model.function);
  data::SampleMatrix inputs(rows, model.input_min.size());
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto from = Eigen::RowVectorXd::NullaryExpr(inputs.cols(), below_one).eval();
    if (centres.rows() == 0) {
      inputs.row(i) = model.input_min.array() + from.array() * (model.input_max - model.input_min).array();
    } else {
      const Eigen::Index centre = i * centres.rows() / rows;
      const Eigen::RowVectorXd near = centres.row(centre).array() + 0.1 * (from.array() - 0.5);
      inputs.row(i) = near.array() * model.scaling.std.array() + model.scaling.mean.array();
    }
  }
  return inputs;
}

/// Rounds to a value that has few digits and is printed exactly in a table.
double rounded(double value) {
  constexpr double kParts = 1024;
  return std::round(value * kParts) / kParts;
}

/// Predicts from these means and lags.
void fill_predictions(const Model& model, const std::vector<std::string>& names, KnownAnswers& answers) {
  data::Clusters clusters;
  clusters.length_s = model.cluster_length_s;
  clusters.thermometers = names;
  for (const data::Factor& lag : data::lags_in(model.terms)) clusters.thermometers.push_back(lag_name(lag));
  clusters.temperature_c.resize(answers.mean_c.rows(), static_cast<Eigen::Index>(clusters.thermometers.size()));
  clusters.temperature_c << answers.mean_c, answers.lag_k;
  clusters.rate_c_per_min = (answers.mean_c - answers.before_c) * (kSecondsPerMinute / model.cluster_length_s);
  std::vector<data::Term> terms = model.terms;
  std::ranges::transform(model.terms, terms.begin(), data::replace_lags);
  auto inputs = evaluate(terms, clusters);
  assert(inputs);
  Model with_lags = model;
  with_lags.terms = terms;
  const RangedInputs ranged = apply_range_policy(with_lags, std::move(*inputs), Outside::continued);
  answers.bias_deg_per_h = predict(with_lags, ranged);
  answers.outside.assign(static_cast<std::size_t>(answers.mean_c.rows()), false);
  for (const Eigen::Index row : ranged.rows) answers.outside[static_cast<std::size_t>(row)] = true;
}

std::string format_results(const KnownAnswers& answers) {
  std::vector<int> results;
  for (const bool outside : answers.outside) results.push_back(outside ? 1 : 0);
  return fmt::format("{}", fmt::join(results, ", "));
}

}  // namespace

KnownAnswers known_answers(const Model& model, const std::vector<std::string>& names) {
  const auto count = static_cast<Eigen::Index>(names.size());
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> slopes(term_coefficients(model, names));
  const data::SampleMatrix requested = draw_inputs(model, kRowsInside + kRowsOutside);
  Eigen::VectorXd ambient = Eigen::VectorXd::Zero(slopes.cols());
  ambient.head(count).setConstant(kAmbient_c);
  const Eigen::VectorXd at_ambient = term_coefficients(model, names) * ambient;
  KnownAnswers answers;
  answers.mean_c.resize(requested.rows(), count);
  answers.before_c.resize(requested.rows(), count);
  answers.lag_k.resize(requested.rows(), slopes.cols() - 2 * count);
  for (Eigen::Index i = 0; i < requested.rows(); ++i) {
    const double reach = i < kRowsInside ? 1 : 3;
    const Eigen::VectorXd away = slopes.solve(reach * (requested.row(i).transpose() - at_ambient));
    const Eigen::VectorXd state = ambient + away;  // temperatures, rates, lags
    const double minutes = model.cluster_length_s / kSecondsPerMinute;
    answers.mean_c.row(i) = state.head(count).transpose().unaryExpr(&rounded);
    const Eigen::VectorXd before = state.head(count) - state.segment(count, count) * minutes;
    answers.before_c.row(i) = before.transpose().unaryExpr(&rounded);
    answers.lag_k.row(i) = state.tail(answers.lag_k.cols()).transpose().unaryExpr(&rounded);
  }
  fill_predictions(model, names, answers);
  return answers;
}

CPlaceholders self_test_placeholders(const KnownAnswers& answers) {
  return {{"test_mean", c_table("test_mean", answers.mean_c)},
          {"test_before", c_table("test_before", answers.before_c)},
          {"test_lag", answers.lag_k.cols() > 0 ? c_table("test_lag", answers.lag_k) : ""},
          {"test_bias", c_vector("test_bias", answers.bias_deg_per_h)},
          {"test_result", format_results(answers)}};
}

}  // namespace gyrotherm::model
