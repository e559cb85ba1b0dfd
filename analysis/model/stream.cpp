// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/stream.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "core/quantity.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kNotYet = std::numeric_limits<double>::quiet_NaN();

Eigen::Index length_of(const Model& model) { return std::max<Eigen::Index>(1, std::llround(model.cluster_length_s)); }

}  // namespace

SlidingMeans::SlidingMeans(Eigen::Index length, Eigen::Index columns)
    : block_(data::SampleMatrix::Zero(length, columns)),
      ends_(data::SampleMatrix::Zero(length + 1, columns)),
      begun_(Eigen::RowVectorXd::Zero(columns)),
      means_(Eigen::RowVectorXd::Constant(columns, kNotYet)) {}

const Eigen::RowVectorXd& SlidingMeans::push(const Eigen::Ref<const Eigen::RowVectorXd>& row) {
  const Eigen::Index length = block_.rows();
  block_.row(at_) = row;
  begun_ += row;
  ++at_;
  if (full_ || at_ == length) means_ = (begun_ + ends_.row(at_)) / static_cast<double>(length);
  if (at_ < length) return means_;
  ends_.row(length).setZero();
  for (Eigen::Index i = length - 1; i >= 0; --i) ends_.row(i) = ends_.row(i + 1) + block_.row(i);
  begun_.setZero();
  at_ = 0;
  full_ = true;
  return means_;
}

Result<CompensationStream> CompensationStream::open(const Model& model, std::vector<std::string> columns,
                                                    Outside outside) {
  CompensationStream stream(model, std::move(columns), outside);
  if (const auto inputs = evaluate(model.terms, stream.latest_); !inputs) return failure(inputs.error());
  return stream;
}

CompensationStream::CompensationStream(const Model& model, std::vector<std::string> columns, Outside policy)
    : model_(model),
      policy_(policy),
      means_(length_of(model), static_cast<Eigen::Index>(columns.size())),
      rates_(std::ranges::any_of(model.terms, data::has_rate)) {
  const auto count = static_cast<Eigen::Index>(columns.size());
  if (rates_) past_.setConstant(length_of(model), count, kNotYet);
  latest_.length_s = model.cluster_length_s;
  latest_.thermometers = std::move(columns);
  latest_.temperature_c.setZero(1, count);
  latest_.rate_c_per_min.setZero(1, count);
}

Eigen::VectorXd CompensationStream::push(const Eigen::Ref<const data::SampleMatrix>& temperatures_c,
                                         const Eigen::Ref<const Eigen::VectorXd>& bias_deg_per_h) {
  assert(temperatures_c.cols() == latest_.temperature_c.cols() && temperatures_c.rows() == bias_deg_per_h.size());
  latest_.temperature_c.resize(temperatures_c.rows(), temperatures_c.cols());
  latest_.rate_c_per_min.resize(temperatures_c.rows(), rates_ ? temperatures_c.cols() : 0);
  for (Eigen::Index i = 0; i < temperatures_c.rows(); ++i, ++pushed_) {
    const Eigen::RowVectorXd& means = means_.push(temperatures_c.row(i));
    latest_.temperature_c.row(i) = means;
    if (!rates_) continue;
    auto before = past_.row(pushed_ % past_.rows());
    latest_.rate_c_per_min.row(i) = (means - before) * (kSecondsPerMinute / latest_.length_s);
    before = means;
  }
  auto inputs = evaluate(model_.terms, latest_);
  assert(inputs);
  RangedInputs ranged = within_range(model_, std::move(*inputs), policy_);
  outside_ += static_cast<long long>(ranged.rows.size());
  rows_outside_ = std::move(ranged.rows);
  return bias_deg_per_h - predict(model_, ranged.inputs);
}

}  // namespace gyrotherm::model
