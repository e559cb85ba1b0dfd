// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/fault_watch.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/data/statistics.hpp"
#include "analysis/fusion/rate_fusion.hpp"
#include "analysis/fusion/rest.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::model {
namespace {

constexpr Eigen::Index kFewestWithParity = 4;
/// Most clusters before a hop that are averaged for its size: one hour of 100 s clusters.
constexpr std::size_t kHourOfClusters = 36;
constexpr std::size_t kMostStoredVectors = 600;  ///< vectors, about 17 h

/// Returns the noise model of an axis's residual bias. If the training could not determine it, returns white noise
/// about an unknown constant.
tracking::BiasNoise axis_noise(const FusedAxes& axes, Eigen::Index a, const FusedUncertainty& uncertainty,
                               double cluster_s) {
  const Model& model = axes.models[static_cast<std::size_t>(a)];
  const double start = std::sqrt(uncertainty.bias(a, a) + uncertainty.learnt(a, a));
  if (model.residual_noise) {
    tracking::BiasNoise noise = *model.residual_noise;
    noise.start_deg_per_h = std::max(noise.start_deg_per_h, start);
    return noise;
  }
  return {.angle_random_walk_deg_per_sqrt_h = std::sqrt(uncertainty.noise(a) * cluster_s / kSecondsPerHour),
          .start_deg_per_h = start};
}

/// Returns the noise model of a parity vector whose white noise has variance 1. All components have the same model, so
/// the trackers preserve the direction of a hop.
tracking::BiasNoise parity_noise(const Eigen::MatrixXd& parity, const std::vector<tracking::BiasNoise>& of_axes,
                                 double cluster_s) {
  const auto together = [&](auto of) {
    Eigen::VectorXd variances(parity.cols());
    for (Eigen::Index a = 0; a < variances.size(); ++a)
      variances(a) = std::pow(of_axes[static_cast<std::size_t>(a)].*of, 2);
    return std::sqrt((parity.cwiseAbs2() * variances).mean());
  };
  using Noise = tracking::BiasNoise;
  return {.angle_random_walk_deg_per_sqrt_h = std::sqrt(cluster_s / kSecondsPerHour),
          .instability_deg_per_h = together(&Noise::instability_deg_per_h),
          .rate_random_walk_deg_per_h_per_sqrt_h = together(&Noise::rate_random_walk_deg_per_h_per_sqrt_h),
          .start_deg_per_h = together(&Noise::start_deg_per_h)};
}

/// Returns the innovations divided by their standard deviations. If a component is not finite, returns no value and
/// lets the trackers' uncertainty grow.
std::optional<Eigen::VectorXd> push_all(std::vector<tracking::BiasTracker>& trackers, const Eigen::VectorXd& vector) {
  if (!vector.allFinite()) {
    for (tracking::BiasTracker& tracker : trackers) (void)tracker.push(std::nan(""));
    return std::nullopt;
  }
  Eigen::VectorXd innovations(vector.size());
  for (Eigen::Index i = 0; i < vector.size(); ++i) {
    const tracking::TrackedInterval tracked = trackers[static_cast<std::size_t>(i)].push(vector(i));
    innovations(i) = tracked.innovation / std::sqrt(tracked.innovation_variance);
  }
  return innovations;
}

/// Returns the whitening matrix of the axes' departures, in the order of the geometry. If the attitude is known, a
/// departure is the difference of an axis from its own thermal prediction; otherwise the matrix is the parity matrix.
/// It has no rows if the attitude is unknown and there are only three axes, which have no parity.
Result<Eigen::MatrixXd> departure_whitening(const FusedAxes& axes, const fusion::Geometry& geometry,
                                            const Eigen::VectorXd& noise, const Eigen::MatrixXd& bias) {
  if (!axes.attitude) {
    if (geometry.axes() < kFewestWithParity) return Eigen::MatrixXd{};
    return compute_gains(geometry).parity;
  }
  fusion::Geometry reading = geometry;
  reading.covariance = noise.asDiagonal();
  const fusion::BiasPrior prior{.mean_deg_per_h = Eigen::VectorXd::Zero(geometry.axes()), .covariance = bias};
  auto test = rest_test(reading, *axes.attitude, prior);
  if (!test) return failure(test.error());
  return std::move(test->whitening);
}

}  // namespace

const char* name(AlarmKind kind) {
  return enumerator_text<AlarmKind::undecided>(
      {"parity", "parity_hop", "rest_hop", "rest", "gyro", "thermometer", "undecided"}, kind);
}

HopWatch::HopWatch(AlarmKind kind, std::vector<tracking::StateSpace> spaces, fusion::ChangeDetector detector)
    : kind_(kind), spaces_(std::move(spaces)), detector_(std::move(detector)), white_limit_(detector_.limit()) {
  for (const tracking::StateSpace& space : spaces_) trackers_.emplace_back(space);
}

Result<HopWatch> HopWatch::make(AlarmKind kind, const std::vector<std::string>& candidates,
                                const Eigen::MatrixXd& effects, const std::vector<tracking::StateSpace>& spaces,
                                const WatchOptions& options) {
  auto detector = fusion::ChangeDetector::make({.dimension = static_cast<int>(spaces.size()),
                                                .shift = 1,
                                                .false_alarms_per_h = options.false_alarms_per_h,
                                                .interval_s = spaces.front().interval_s});
  if (!detector) return failure(detector.error());
  HopWatch watch(kind, spaces, std::move(*detector));
  watch.options_ = options;
  watch.effects_ = effects;
  watch.innovations_ = {.candidates = candidates, .effects = effects};
  for (std::size_t i = 0; i < spaces.size(); ++i) {
    const double settled = steady_state(spaces[i]).predicted.sum() + spaces[i].white;
    watch.innovations_.effects.row(static_cast<Eigen::Index>(i)) /= std::sqrt(settled);
  }
  return watch;
}

std::optional<Alarm> HopWatch::push(const Eigen::VectorXd& vector, double end_s) {
  const auto innovations = push_all(trackers_, vector);
  if (!innovations) return std::nullopt;
  recent_.push_back({end_s, vector});
  if (recent_.size() > kMostStoredVectors) recent_.pop_front();
  const auto change = detector_.push(*innovations);
  if (!change) return std::nullopt;
  Alarm alarm = make_alarm(*change, end_s);
  restart(vector);
  return alarm;
}

Alarm HopWatch::make_alarm(const fusion::Change& change, double end_s) const {
  const auto steps = std::min<std::size_t>(static_cast<std::size_t>(change.steps), recent_.size());
  const std::size_t before = std::min(recent_.size() - steps, kHourOfClusters);
  const auto mean_of = [&](auto from, std::size_t count) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(effects_.rows());
    for (auto seen = from; seen != from + static_cast<std::ptrdiff_t>(count); ++seen) sum += seen->vector;
    return Eigen::VectorXd(sum / std::max<double>(1, static_cast<double>(count)));
  };
  const auto start = recent_.end() - static_cast<std::ptrdiff_t>(steps);
  const Eigen::VectorXd by = mean_of(start, steps) - mean_of(start - static_cast<std::ptrdiff_t>(before), before);
  Alarm alarm{.kind = kind_, .at_s = end_s, .since_s = start->end_s - spaces_.front().interval_s, .until_s = end_s};
  const auto isolation =
      fusion::isolate(innovations_, change.root_sum(),
                      {.false_alarm_probability = options_.false_alarm_probability, .margin = options_.margin});
  if (!isolation) return alarm;
  const std::string& likeliest = innovations_.candidates[static_cast<std::size_t>(isolation->likeliest)];
  const Eigen::VectorXd effect = effects_.col(isolation->likeliest);
  const double size = effect.dot(by) / effect.squaredNorm();
  const double minutes = (end_s - alarm.since_s) / kSecondsPerMinute;
  if (isolation->rivals.empty()) {
    alarm.who = likeliest;
    alarm.size = size;
    alarm.statement = fmt::format("{} hopped by {:.4f} °/h about {:.0f} min earlier", likeliest, size, minutes);
    return alarm;
  }
  std::string rivals;
  for (const Eigen::Index rival : isolation->rivals)
    rivals += ", " + innovations_.candidates[static_cast<std::size_t>(rival)];
  alarm.statement = fmt::format("one of these hopped about {:.0f} min earlier: {}{}", minutes, likeliest, rivals);
  return alarm;
}

void HopWatch::learn_limit(const Eigen::MatrixXd& healthy) {
  std::vector<tracking::BiasTracker> trackers(spaces_.begin(), spaces_.end());
  Eigen::MatrixXd innovations(std::ssize(spaces_), healthy.rows());
  Eigen::Index count = 0;
  for (Eigen::Index row = 0; row < healthy.rows(); ++row)
    if (const auto seen = push_all(trackers, healthy.row(row).transpose())) innovations.col(count++) = *seen;
  const double run_length = kSecondsPerHour / (spaces_.front().interval_s * options_.false_alarms_per_h);
  const auto limit = fusion::learn_sum_limit(innovations.leftCols(count), detector_.slack(), run_length);
  if (!limit) return;
  detector_ = detector_.with_limit(*limit);
  learnt_ = true;
}

SumLimit HopWatch::limit() const {
  return {.kind = name(kind_), .limit = detector_.limit(), .white_limit = white_limit_, .learnt = learnt_};
}

/// Restarts the trackers with an uncertainty that includes the size of the hop.
void HopWatch::restart(const Eigen::VectorXd& departure) {
  trackers_.clear();
  for (std::size_t i = 0; i < spaces_.size(); ++i) {
    tracking::StateSpace space = spaces_[i];
    space.start(0) += std::pow(departure(static_cast<Eigen::Index>(i)), 2);
    trackers_.emplace_back(space);
  }
  recent_.clear();
}

/// Names and noise models of the axes of the set.
struct FaultWatch::WatchedAxes {
  std::vector<std::string> names;
  std::vector<tracking::BiasNoise> noises;
  std::vector<tracking::StateSpace> spaces;
};

Result<FaultWatch> FaultWatch::make(const FusedAxes& axes, AxisSet set,
                                    const std::optional<fusion::ThermometerParity>& thermometers, double cluster_s,
                                    const WatchOptions& options) {
  FaultWatch watch;
  watch.set_ = set;
  watch.cluster_s_ = cluster_s;
  watch.options_ = options;
  watch.in_ = members(set);
  const FusedUncertainty uncertainty = uncertainty_of_means(axes, cluster_s);
  WatchedAxes watched;
  for (const Eigen::Index a : watch.in_) {
    watched.names.push_back(axes.names[static_cast<std::size_t>(a)]);
    watched.noises.push_back(axis_noise(axes, a, uncertainty, cluster_s));
    watched.spaces.push_back(state_space(watched.noises.back(), cluster_s));
  }
  if (const auto made = watch.watch_parity(axes, watched); !made) return failure(made.error());
  const auto geometry = geometry_of_set(axes, set, uncertainty.varying_covariance());
  if (!geometry) return watch;
  if (const auto made = watch.watch_at_rest(axes, *geometry, watched); !made) return failure(made.error());
  const auto whitening =
      departure_whitening(axes, *geometry, uncertainty.noise(watch.in_), uncertainty.bias(watch.in_, watch.in_));
  if (!whitening) return failure(whitening.error());
  if (thermometers && whitening->rows() > 0) watch.set_voters(axes, watched.names, *thermometers, *whitening);
  return watch;
}

Result<void> FaultWatch::watch_parity(const FusedAxes& axes, const WatchedAxes& watched) {
  const auto count = std::ssize(in_);
  Eigen::MatrixXd white = Eigen::MatrixXd::Identity(axes.axes(), axes.axes());
  for (std::size_t i = 0; i < in_.size(); ++i) white(in_[i], in_[i]) = watched.spaces[i].white;
  const auto geometry = geometry_of_set(axes, set_, white);
  if (!geometry || count < kFewestWithParity) return {};
  parity_ = compute_gains(*geometry).parity;
  const auto noise = parity_noise(parity_, watched.noises, cluster_s_);
  auto made = HopWatch::make(AlarmKind::parity_hop, watched.names, parity_,
                             {static_cast<std::size_t>(parity_.rows()), state_space(noise, cluster_s_)}, options_);
  if (!made) return failure(made.error());
  hops_ = std::move(*made);
  return {};
}

Result<void> FaultWatch::watch_at_rest(const FusedAxes& axes, const fusion::Geometry& geometry,
                                       const WatchedAxes& watched) {
  if (!axes.attitude) return {};
  const auto count = std::ssize(in_);
  expected_ = geometry.directions * earth_in_fixture(*axes.attitude);
  auto made = HopWatch::make(AlarmKind::rest_hop, watched.names, Eigen::MatrixXd::Identity(count, count),
                             watched.spaces, options_);
  if (!made) return failure(made.error());
  rest_ = std::move(*made);
  return {};
}

void FaultWatch::set_voters(const FusedAxes& axes, const std::vector<std::string>& names,
                            const fusion::ThermometerParity& thermometers, const Eigen::MatrixXd& whitening) {
  std::vector<Eigen::Index> columns;
  for (const std::string& one : thermometers.names) {
    const auto at = std::ranges::find(axes.thermometers, one) - axes.thermometers.begin();
    if (at == std::ssize(axes.thermometers)) return;  // another record's thermometers
    columns.push_back(at);
  }
  voting_thermometers_ = columns;
  voters_ = fusion::Voters{.axes = names,
                           .whitening = whitening,
                           .sensitivity_deg_per_h_per_k = axes.sensitivity_deg_per_h_per_k(in_, columns),
                           .thermometers = thermometers};
}

void FaultWatch::learn_limits(const HealthyRates& healthy) {
  const Eigen::MatrixXd rates_in_set = healthy.departures_deg_per_h(Eigen::all, in_);
  if (hops_) hops_->learn_limit(rates_in_set * parity_.transpose());
  if (rest_ && healthy.at_rest) rest_->learn_limit(rates_in_set);
}

std::vector<SumLimit> FaultWatch::sum_limits() const {
  std::vector<SumLimit> limits;
  for (const auto* watch : {&hops_, &rest_})
    if (*watch) limits.push_back((*watch)->limit());
  return limits;
}

std::vector<Alarm> FaultWatch::push(const Eigen::VectorXd& rates, const Eigen::RowVectorXd& temperatures,
                                    double end_s) {
  std::vector<Alarm> alarms;
  const Eigen::VectorXd rates_in_set = rates(in_);
  if (hops_)
    if (auto alarm = hops_->push(parity_ * rates_in_set, end_s)) alarms.push_back(std::move(*alarm));
  if (rest_)
    if (auto alarm = rest_->push(rates_in_set - expected_, end_s)) alarms.push_back(std::move(*alarm));
  if (auto alarm = vote_on_cluster(rates_in_set, temperatures, end_s)) alarms.push_back(std::move(*alarm));
  return alarms;
}

std::optional<Alarm> FaultWatch::vote_on_cluster(const Eigen::VectorXd& rates, const Eigen::RowVectorXd& temperatures,
                                                 double end_s) const {
  if (!voters_ || !rates.allFinite()) return std::nullopt;
  const Eigen::RowVectorXd voter_temperatures = temperatures(voting_thermometers_);
  if (!voter_temperatures.allFinite()) return std::nullopt;
  const Eigen::VectorXd departures = expected_.size() > 0 ? Eigen::VectorXd(rates - expected_) : rates;
  const fusion::Verdict verdict =
      vote(*voters_, departures, voter_temperatures,
           {.false_alarm_probability = options_.false_alarm_probability, .margin = options_.margin});
  if (verdict.kind == fusion::VerdictKind::accord) return std::nullopt;
  return Alarm{.kind = verdict.kind == fusion::VerdictKind::gyro_hop             ? AlarmKind::gyro
                       : verdict.kind == fusion::VerdictKind::broken_thermometer ? AlarmKind::thermometer
                                                                                 : AlarmKind::undecided,
               .at_s = end_s,
               .since_s = end_s - cluster_s_,
               .until_s = end_s,
               .who = verdict.who,
               .size = verdict.size,
               .statement = verdict.reason};
}

Result<fusion::ThermometerParity> healthy_thermometers(const FusedAxes& healthy, double cluster_s) {
  std::vector<Eigen::Index> columns;
  std::vector<std::string> names;
  std::vector<double> uncertainty_k;
  for (std::size_t t = 0; t < healthy.thermometers.size(); ++t) {
    const auto at = static_cast<Eigen::Index>(t);
    if (healthy.sensitivity_deg_per_h_per_k.col(at).isZero(0)) continue;
    columns.push_back(at);
    names.push_back(healthy.thermometers[t]);
    uncertainty_k.push_back(healthy.thermometer_in_a_year_k[t]);
  }
  const auto count = static_cast<int>(columns.size());
  const Eigen::MatrixXd means =
      cluster_means(healthy.time_s, healthy.temperature_c(Eigen::all, columns), cluster_s).mean;
  const Eigen::MatrixXd known = means(data::finite_rows(means), Eigen::all);
  const Eigen::VectorXd known_k = Eigen::Map<const Eigen::VectorXd>(uncertainty_k.data(), count);
  int modes = 1;
  if (known.rows() > 1 && count > 0) {
    const Eigen::MatrixXd centred = known.rowwise() - known.colwise().mean();
    const Eigen::MatrixXd covariance = centred.transpose() * centred / static_cast<double>(known.rows() - 1);
    const Eigen::VectorXd variances = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).eigenvalues();
    const auto significant = (variances.array() > known_k.cwiseAbs2().maxCoeff()).count();
    modes = std::clamp(static_cast<int>(significant), 1, std::max(1, count - 2));
  }
  return fusion::learn_thermometer_parity(means, names, known_k, modes);
}

ClusterMeans cluster_means(const Eigen::VectorXd& time_s, const Eigen::MatrixXd& rows, double cluster_s) {
  ClusterMeans means;
  const Eigen::Index count = rows.rows();
  const auto length = static_cast<Eigen::Index>(std::lround(cluster_s));
  means.end_s.resize(count / length + 1);
  means.mean.resize(count / length + 1, rows.cols());
  Eigen::Index made = 0;
  for (Eigen::Index from = 0; from < count;) {
    const double cluster = std::floor((time_s(from) - time_s(0)) / cluster_s);
    Eigen::Index to = from;
    while (to < count && std::floor((time_s(to) - time_s(0)) / cluster_s) == cluster) ++to;
    if (to - from == length) {
      means.end_s(made) = time_s(0) + (cluster + 1) * cluster_s;
      means.mean.row(made++) = rows.middleRows(from, length).colwise().mean();
    }
    from = to;
  }
  means.end_s.conservativeResize(made);
  means.mean.conservativeResize(made, rows.cols());
  return means;
}

}  // namespace gyrotherm::model
