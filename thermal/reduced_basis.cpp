#include "thermal/reduced_basis.hpp"

#include <cassert>
#include <cmath>

#include "core/random.hpp"

namespace gyrotherm {
namespace {

constexpr std::uint64_t kSums = 1024;  ///< spread of a squared norm: sqrt(2 / 1024), 4 %
constexpr double kNewest = 1e-6;       ///< a field with less than this of itself outside the basis brings nothing

void grow_square(Eigen::MatrixXd& matrix, Eigen::Index size) {
  const auto before = matrix.rows();
  matrix.conservativeResize(size, size);
  matrix.rightCols(size - before).setZero();
  matrix.bottomRows(size - before).setZero();
}

}  // namespace

ReducedBasis::ReducedBasis(const ThermalSystem& system, ReducedModel about, Eigen::VectorXd weights,
                           Eigen::Index most_states)
    : system_(system), weights_(weights.cwiseSqrt()), model_(std::move(about)) {
  const auto unknowns = system.capacity.rows();
  assert(weights_.size() == unknowns && most_states >= 1);
  sums_.resize(static_cast<std::size_t>(unknowns));
  for (Eigen::Index i = 0; i < unknowns; ++i) {
    const auto bits = splitmix64(static_cast<std::uint64_t>(i));
    sums_[static_cast<std::size_t>(i)] = static_cast<int>(bits % kSums);
    if ((bits >> 63U) != 0) weights_[i] = -weights_[i];
  }
  basis_.resize(unknowns, most_states);
  model_.conduction.resize(0, 0);
  for (auto& matrix : model_.conduction_per) matrix.resize(0, 0);
  for (auto& matrix : sketched_parts_) matrix.resize(kSums, most_states);
  sketched_inputs_.resize(kSums, kThermalInputs);
  for (Eigen::Index i = 0; i < sketched_inputs_.cols(); ++i) sketched_inputs_.col(i) = sketch(system.inputs.col(i));
  sketched_film_ = sketch(system.film_ambient);
  grow(Eigen::MatrixXd::Ones(unknowns, 1));
}

const SparseMatrix& ReducedBasis::part(std::size_t index) const {
  if (index == 0) return system_.capacity;
  return index == 1 ? system_.conduction : system_.conduction_per[index - 2];
}

Eigen::VectorXd ReducedBasis::sketch(const Eigen::VectorXd& residual) const {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(kSums);
  for (Eigen::Index i = 0; i < residual.size(); ++i)
    sums[sums_[static_cast<std::size_t>(i)]] += weights_[i] * residual[i];
  return sums;
}

bool ReducedBasis::append(Eigen::VectorXd field) {
  if (states_ == basis_.cols()) return false;
  const double size = std::sqrt(field.dot(system_.capacity * field));
  if (!(size > 0)) return false;
  field /= size;
  // Gram and Schmidt twice: the second pass takes away what rounding left of the first.
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::VectorXd stored = system_.capacity * field;
    const Eigen::VectorXd known = basis().transpose() * stored;
    field -= basis() * known;
  }
  const double rest = std::sqrt(field.dot(system_.capacity * field));
  if (!(rest > kNewest)) return false;
  basis_.col(states_++) = field / rest;
  return true;
}

Eigen::Index ReducedBasis::grow(Eigen::MatrixXd fields) {
  const auto before = states_;
  for (Eigen::Index i = 0; i < fields.cols(); ++i) (void)append(fields.col(i));
  if (states_ > before) project(before);
  return states_ - before;
}

void ReducedBasis::project(Eigen::Index from) {
  const auto added = states_ - from;
  const Eigen::MatrixXd fields = basis_.middleCols(from, added);
  for (std::size_t p = 0; p < kParts; ++p) {
    const Eigen::MatrixXd product = part(p) * fields;
    for (Eigen::Index i = 0; i < added; ++i) sketched_parts_[p].col(from + i) = sketch(product.col(i));
    if (p == 0) continue;  // VᵀCV = I by construction
    auto& matrix = p == 1 ? model_.conduction : model_.conduction_per[p - 2];
    grow_square(matrix, states_);
    matrix.rightCols(added) = basis().transpose() * product;
    matrix.bottomRows(added) = matrix.rightCols(added).transpose().eval();
    matrix.bottomRightCorner(added, added) =
        ((matrix.bottomRightCorner(added, added) + matrix.bottomRightCorner(added, added).transpose()) / 2).eval();
  }
  model_.inputs.conservativeResize(states_, kThermalInputs);
  model_.inputs.bottomRows(added) = fields.transpose() * system_.inputs;
  model_.film_ambient.conservativeResize(states_);
  model_.film_ambient.tail(added) = fields.transpose() * system_.film_ambient;
  model_.outputs.conservativeResize(kThermalOutputs, states_);
  model_.outputs.rightCols(added) = system_.outputs * fields;
}

Eigen::VectorXd ReducedBasis::residuals(const ThermalPoint& point, const Eigen::MatrixXd& loads) const {
  const auto& c = point.coefficients;
  Eigen::MatrixXd balance = sketched_parts_[1].leftCols(states_);
  if (point.rate_per_s != 0) balance += point.rate_per_s * sketched_parts_[0].leftCols(states_);
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) balance += c[m] * sketched_parts_[2 + m].leftCols(states_);
  Eigen::MatrixXd residual = sketched_inputs_;
  residual.col(0) += c[static_cast<std::size_t>(ThermalCoefficient::film)] * sketched_film_;
  residual -= balance * states_at(model_, c, point.rate_per_s);
  return (residual * loads).colwise().norm();
}

ReducedModel projected(const ReducedModel& model, const Eigen::MatrixXd& directions) {
  ReducedModel smaller = model;
  const auto onto = [&](const Eigen::MatrixXd& matrix) -> Eigen::MatrixXd {
    const Eigen::MatrixXd square = directions.transpose() * matrix * directions;
    return (square + square.transpose()) / 2;
  };
  smaller.conduction = onto(model.conduction);
  for (auto& matrix : smaller.conduction_per) matrix = onto(matrix);
  smaller.inputs = directions.transpose() * model.inputs;
  smaller.film_ambient = directions.transpose() * model.film_ambient;
  smaller.outputs = model.outputs * directions;
  return smaller;
}

}  // namespace gyrotherm
