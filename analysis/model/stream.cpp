// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "core/quantity.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

}  // namespace

SlidingMeans::SlidingMeans(Eigen::Index length, Eigen::Index columns)
    : block_(data::SampleMatrix::Zero(length, columns)),
      previous_ends_(data::SampleMatrix::Zero(length + 1, columns)),
      current_sum_(Eigen::RowVectorXd::Zero(columns)),
      means_(Eigen::RowVectorXd::Constant(columns, kNoValue)) {}

const Eigen::RowVectorXd& SlidingMeans::push(const Eigen::Ref<const Eigen::RowVectorXd>& row) {
  const Eigen::Index length = block_.rows();
  block_.row(at_) = row;
  current_sum_ += row;
  ++at_;
  if (has_previous_block_ || at_ == length)
    means_ = (current_sum_ + previous_ends_.row(at_)) / static_cast<double>(length);
  if (at_ < length) return means_;
  previous_ends_.row(length).setZero();
  for (Eigen::Index i = length - 1; i >= 0; --i) previous_ends_.row(i) = previous_ends_.row(i + 1) + block_.row(i);
  current_sum_.setZero();
  at_ = 0;
  has_previous_block_ = true;
  return means_;
}

SlidingLags::SlidingLags(Eigen::Index length, const std::vector<Lag>& lags)
    : lags_(lags), latest_(Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(lags.size()))) {
  std::vector<Follower> followers;
  for (const Lag& lag : lags) followers.push_back({data::FirstOrderLag(lag.time_constant_s)});
  ring_.assign(static_cast<std::size_t>(length), followers);
}

const Eigen::RowVectorXd& SlidingLags::push(const Eigen::RowVectorXd& means) {
  const auto length_s = static_cast<double>(ring_.size());
  for (std::size_t i = 0; i < lags_.size(); ++i) {
    Follower& follower = ring_[at_][i];
    const double mean = means(lags_[i].thermometer);
    latest_(static_cast<Eigen::Index>(i)) =
        std::isnan(mean) ? kNoValue : follower.lag.push(mean, static_cast<double>(follower.steps) * length_s);
    follower.steps = std::isnan(mean) ? follower.steps + 1 : 1;
  }
  at_ = (at_ + 1) % ring_.size();
  return latest_;
}

void SlidingLags::skip_clusters(Eigen::Index cluster_lengths) {
  for (std::vector<Follower>& followers : ring_)
    for (Follower& follower : followers) follower.steps += cluster_lengths;
}

Result<CompensationStream> CompensationStream::open(const Model& model, std::vector<std::string> columns,
                                                    Outside outside) {
  std::vector<SlidingLags::Lag> lags;
  for (const data::Factor& lag : data::lags_in(model.terms)) {
    const auto at = std::ranges::find(columns, lag.first);
    if (at == columns.end()) {
      return failure(FaultKind::usage, fmt::format("input \"lag:{}:{}\"", lag.time_constant_s, lag.first),
                     fmt::format("no thermometer \"{}\"; the rows have {}", lag.first, fmt::join(columns, ", ")));
    }
    lags.push_back({at - columns.begin(), static_cast<double>(lag.time_constant_s)});
  }
  CompensationStream stream(model, std::move(columns), lags, outside);
  if (const auto inputs = evaluate(stream.model_.terms, stream.latest_); !inputs) return failure(inputs.error());
  return stream;
}

CompensationStream::CompensationStream(const Model& model, std::vector<std::string> columns,
                                       const std::vector<SlidingLags::Lag>& lags, Outside policy)
    : model_(model),
      policy_(policy),
      means_(rows_in_cluster(model), static_cast<Eigen::Index>(columns.size())),
      rates_(std::ranges::any_of(model.terms, data::has_rate)),
      lags_(rows_in_cluster(model), lags) {
  const auto count = static_cast<Eigen::Index>(columns.size());
  if (rates_) past_.setConstant(rows_in_cluster(model), count, kNoValue);
  if (is_led(model)) predictions_.setConstant(rows_in_cluster(model), kNoValue);
  latest_.length_s = model.cluster_length_s;
  latest_.thermometers = std::move(columns);
  for (const data::Factor& lag : data::lags_in(model.terms)) latest_.thermometers.push_back(lag_name(lag));
  std::ranges::transform(model.terms, model_.terms.begin(), data::replace_lags);
  latest_.temperature_c.setZero(1, count + static_cast<Eigen::Index>(lags.size()));
  latest_.rate_c_per_min.setZero(1, count);
}

Eigen::VectorXd CompensationStream::push(const Eigen::Ref<const data::SampleMatrix>& temperatures_c,
                                         const Eigen::Ref<const Eigen::VectorXd>& bias_deg_per_h) {
  const Eigen::Index count = temperatures_c.cols(), columns = latest_.temperature_c.cols();
  assert(count <= columns && temperatures_c.rows() == bias_deg_per_h.size());
  latest_.temperature_c.resize(temperatures_c.rows(), columns);
  latest_.rate_c_per_min.resize(temperatures_c.rows(), rates_ ? count : 0);
  for (Eigen::Index i = 0; i < temperatures_c.rows(); ++i, ++pushed_) {
    const Eigen::RowVectorXd& means = means_.push(temperatures_c.row(i));
    latest_.temperature_c.row(i) << means, lags_.push(means);
    if (!rates_) continue;
    auto before = past_.row(pushed_ % past_.rows());
    latest_.rate_c_per_min.row(i) = (means - before) * (kSecondsPerMinute / latest_.length_s);
    before = means;
  }
  auto inputs = evaluate(model_.terms, latest_);
  assert(inputs);
  RangedInputs ranged = apply_range_policy(model_, std::move(*inputs), policy_);
  outside_ += static_cast<long long>(ranged.rows.size());
  rows_outside_ = std::move(ranged.rows);
  excess_ = std::move(ranged.excess);
  return bias_deg_per_h - extrapolate(predict(model_, ranged));
}

/// Extrapolates the predictions of the last pushed rows by half a cluster length.
Eigen::VectorXd CompensationStream::extrapolate(Eigen::VectorXd predicted) {
  if (predictions_.size() == 0) return predicted;
  const Eigen::Index first = pushed_ - predicted.size();
  for (Eigen::Index i = 0; i < predicted.size(); ++i) {
    double& before = predictions_((first + i) % predictions_.size());
    const double now = predicted(i);
    if (std::isfinite(before)) predicted(i) = now + 0.5 * (now - before);
    before = now;
  }
  return predicted;
}

void CompensationStream::skip_seconds(Eigen::Index seconds) {
  // After two cluster lengths no earlier mean remains; further whole cluster lengths only advance the time of the lags.
  constexpr Eigen::Index kRememberedClusters = 2;
  const Eigen::Index length = rows_in_cluster(model_);
  const Eigen::Index beyond = std::max<Eigen::Index>(0, seconds / length - kRememberedClusters);
  const Eigen::Index rows = seconds - beyond * length;
  lags_.skip_clusters(beyond);
  (void)push(data::SampleMatrix::Constant(rows, means_.columns(), kNoValue), Eigen::VectorXd::Constant(rows, kNoValue));
}

Eigen::VectorXd CompensationStream::push_at(const Eigen::Ref<const Eigen::VectorXd>& time_s,
                                            const Eigen::Ref<const data::SampleMatrix>& temperatures_c,
                                            const Eigen::Ref<const Eigen::VectorXd>& bias_deg_per_h) {
  assert(time_s.size() == bias_deg_per_h.size());
  gaps_.clear();
  for (Eigen::Index row = 0; row < time_s.size(); last_s_ = time_s(row++)) {
    const auto missing = last_s_ ? static_cast<Eigen::Index>(std::llround(time_s(row) - *last_s_)) - 1 : 0;
    if (missing > 0) gaps_.push_back({row, missing});
  }
  Eigen::VectorXd compensated(time_s.size()), excess(time_s.size());
  std::vector<Eigen::Index> outside;
  const auto push_stretch = [&](Eigen::Index from, Eigen::Index end) {
    if (from == end) return;
    compensated.segment(from, end - from) =
        push(temperatures_c.middleRows(from, end - from), bias_deg_per_h.segment(from, end - from));
    for (const Eigen::Index row : rows_outside_) outside.push_back(from + row);
    excess.segment(from, end - from) = excess_;
  };
  Eigen::Index from = 0;
  for (const Gap& gap : gaps_) {
    push_stretch(from, gap.row);
    skip_seconds(gap.seconds);
    from = gap.row;
  }
  push_stretch(from, time_s.size());
  rows_outside_ = std::move(outside);
  excess_ = std::move(excess);
  return compensated;
}

std::optional<Latency> measure_latency(const Model& model, const data::Clusters& clusters,
                                       const Eigen::VectorXd& predicted_deg_per_h) {
  const Eigen::VectorXd& p = predicted_deg_per_h;
  const auto follows = [&](Eigen::Index k) {
    return std::abs(clusters.start_s(k) - clusters.start_s(k - 1) - clusters.length_s) < clusters.length_s / 2;
  };
  double first = 0, second = 0, count = 0;
  for (Eigen::Index k = 2; k < p.size(); ++k) {
    if (!follows(k) || !follows(k - 1) || !p.segment(k - 2, 3).allFinite()) continue;
    first += std::pow(p(k) - p(k - 1), 2);
    second += std::pow(p(k) - 2 * p(k - 1) + p(k - 2), 2);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Latency{.lag_s = model.cluster_length_s / 2,
                 .lagging_rms_deg_per_h = std::sqrt(first / count) / 2,
                 .led_rms_deg_per_h = std::sqrt(second / count) / 2,
                 .is_led = second < first};
}

}  // namespace gyrotherm::model
