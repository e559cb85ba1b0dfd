#include "analysis/model/c_self_test.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>
#include <set>
#include <utility>

#include "analysis/model/trained_range.hpp"
#include "core/quantity.hpp"

namespace gyrotherm {
namespace {

constexpr Eigen::Index kInside = 6, kBeyond = 2;
constexpr double kRoom_c = 20;

Eigen::Index place_of(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) - names.begin();
}

/// Of the terms with one factor: what each is of the temperatures and the rates, side by side. Zero rows for others.
Eigen::MatrixXd slopes_of(const Model& model, const std::vector<std::string>& names) {
  const auto count = static_cast<Eigen::Index>(names.size());
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(model.terms.size()), 2 * count);
  for (Eigen::Index i = 0; i < slopes.rows(); ++i) {
    const auto& factors = model.terms[static_cast<std::size_t>(i)].factors;
    if (factors.size() != 1) continue;
    const Factor& factor = factors.front();
    const bool rate = factor.kind == FactorKind::rate;
    slopes(i, place_of(names, factor.first) + (rate ? count : 0)) = 1;
    if (factor.kind == FactorKind::gradient) slopes(i, place_of(names, factor.second)) -= 1;
  }
  return slopes;
}

/// Centres of the function, scaled; none if it has no centres.
SampleMatrix centres_of(const Function& function) {
  if (const auto* svr = std::get_if<SvrModel>(&function)) return svr->support_vectors;
  if (const auto* expansion = std::get_if<ExpansionModel>(&function)) return expansion->centres;
  return {};
}

/// Unscaled inputs like those of the training: near the function's centres, or anywhere in the trained range.
SampleMatrix wanted_inputs(const Model& model, Eigen::Index rows) {
  std::mt19937_64 generator(1);
  const auto below_one = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  const SampleMatrix centres = centres_of(model.function);
  SampleMatrix inputs(rows, model.input_min.size());
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

/// Short enough to be read in a table, and exact in it.
double rounded(double value) {
  constexpr double kParts = 1024;
  return std::round(value * kParts) / kParts;
}

}  // namespace

std::vector<std::string> thermometers_of(const Model& model) {
  std::set<std::string> names;
  for (const Term& term : model.terms) {
    for (const Factor& factor : term.factors) {
      names.insert(factor.first);
      if (factor.kind == FactorKind::gradient) names.insert(factor.second);
    }
  }
  return {names.begin(), names.end()};
}

KnownAnswers known_answers(const Model& model) {
  const std::vector<std::string> names = thermometers_of(model);
  const auto count = static_cast<Eigen::Index>(names.size());
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> slopes(slopes_of(model, names));
  const SampleMatrix wanted = wanted_inputs(model, kInside + kBeyond);
  Eigen::VectorXd room = Eigen::VectorXd::Zero(2 * count);
  room.head(count).setConstant(kRoom_c);
  const Eigen::VectorXd at_room = slopes_of(model, names) * room;
  KnownAnswers answers;
  answers.mean_c.resize(wanted.rows(), count);
  answers.before_c.resize(wanted.rows(), count);
  for (Eigen::Index i = 0; i < wanted.rows(); ++i) {
    const double reach = i < kInside ? 1 : 3;
    const Eigen::VectorXd away = slopes.solve(reach * (wanted.row(i).transpose() - at_room));
    const Eigen::VectorXd state = room + away;  // temperatures, then rates
    answers.mean_c.row(i) = state.head(count).transpose().unaryExpr(&rounded);
    const Eigen::VectorXd before = state.head(count) - state.tail(count) * (model.cluster_length_s / kSecondsPerMinute);
    answers.before_c.row(i) = before.transpose().unaryExpr(&rounded);
  }
  Clusters clusters;
  clusters.length_s = model.cluster_length_s;
  clusters.thermometers = names;
  clusters.temperature_c = answers.mean_c;
  clusters.rate_c_per_min = (answers.mean_c - answers.before_c) * (kSecondsPerMinute / model.cluster_length_s);
  auto inputs = evaluate(model.terms, clusters);
  assert(inputs);
  const RangedInputs ranged = within_range(model, std::move(*inputs), Outside::clamp);
  answers.bias_deg_per_h = predict(model, ranged.inputs);
  answers.outside.assign(static_cast<std::size_t>(wanted.rows()), false);
  for (const Eigen::Index row : ranged.rows) answers.outside[static_cast<std::size_t>(row)] = true;
  return answers;
}

}  // namespace gyrotherm
