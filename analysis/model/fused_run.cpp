// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/fused_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "analysis/fusion/rate_fusion.hpp"
#include "core/json.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kNoRate = std::numeric_limits<double>::quiet_NaN();

/// Gains, parity test and covariance of a set of axes for one second.
struct SetOfAxes {
  fusion::Gains gains;
  fusion::FaultTest test;
  /// Covariance of the errors that training and use share, (°/h)².
  Eigen::MatrixXd learnt;
};

/// Returns U of the rate vector's components, °/h, with the variance `added` added to each axis.
Eigen::RowVector3d expanded_uncertainty(const SetOfAxes& set, const Eigen::VectorXd& added) {
  return kFusionCoverage * rate_covariance(set.gains, set.learnt, added).diagonal().cwiseSqrt().transpose();
}

/// Gains of each set of axes, computed when the set first occurs.
class FusionCache {
 public:
  FusionCache(const FusedAxes& axes, double averaging_s)
      : axes_(axes), second_(uncertainty_of_means(axes, 1)), averaged_(uncertainty_of_means(axes, averaging_s)) {}
  /// Returns null if these axes do not span all directions.
  const SetOfAxes* operator()(AxisSet set) {
    const auto [at, is_new] = by_set_.try_emplace(set);
    if (is_new) at->second = make_set(set);
    return at->second ? &*at->second : nullptr;
  }

 private:
  [[nodiscard]] std::optional<SetOfAxes> make_set(AxisSet set) const {
    const auto geometry = geometry_of_set(axes_, set, second_.varying_covariance());
    if (!geometry) return std::nullopt;
    const auto weights = geometry_of_set(axes_, set, averaged_.varying_covariance());
    if (!weights) return std::nullopt;
    SetOfAxes one{.gains = weighted_gains(*geometry, *weights), .test = {}, .learnt = {}};
    one.test = parity_test(one.gains, *geometry);
    const auto in = members(set);
    one.learnt = second_.learnt(in, in);
    return one;
  }
  const FusedAxes& axes_;
  FusedUncertainty second_, averaged_;
  std::map<AxisSet, std::optional<SetOfAxes>> by_set_;
};

AxisSet bit(Eigen::Index axis) { return AxisSet{1} << static_cast<unsigned>(axis); }

AxisSet find_finite_axes(const Eigen::Ref<const Eigen::VectorXd>& readings) {
  AxisSet set = 0;
  for (Eigen::Index a = 0; a < readings.size(); ++a)
    if (std::isfinite(readings(a))) set |= bit(a);
  return set;
}

/// Fuses a record second by second and stores the set of axes that are left out.
class RecordFuser {
 public:
  RecordFuser(const FusedAxes& axes, const std::optional<fusion::ThermometerParity>& thermometers,
              const FusionOptions& options, FusedRun& run)
      : axes_(axes), thermometers_(thermometers), options_(options), run_(run), cache_(axes, options.averaging_s) {
    test_ = {.false_alarm_probability = options.watch.false_alarm_probability, .margin = options.watch.margin};
    all_ = bit(axes.axes() - 1) | (bit(axes.axes() - 1) - 1);
  }
  Result<void> fuse_second(Eigen::Index row);
  Result<void> watch_cluster(const Eigen::VectorXd& rates, const Eigen::RowVectorXd& temperatures, double end_s);

 private:
  void record_alarm(Alarm alarm, double within_s);
  void clear_doubtful_axis(Alarm& alarm) const;
  void leave_out(const Alarm& alarm);

  const FusedAxes& axes_;
  const std::optional<fusion::ThermometerParity>& thermometers_;
  const FusionOptions& options_;
  FusedRun& run_;
  FusionCache cache_;
  fusion::TestOptions test_;
  std::optional<FaultWatch> watch_;
  AxisSet all_{}, left_out_{};
  /// Number of consecutive clusters whose axes differ from the watched set. Clusters without any axis are ignored.
  int other_set_{};
};

Result<void> RecordFuser::fuse_second(Eigen::Index row) {
  const Eigen::VectorXd readings = axes_.rate_deg_per_h.row(row).transpose();
  AxisSet set = find_finite_axes(readings) & ~left_out_;
  const SetOfAxes* fused_set = cache_(set);
  if (fused_set == nullptr) return {};
  const Eigen::VectorXd parity = fused_set->gains.parity * readings(members(set));
  const bool has_parity = parity.size() > 0;
  if (has_parity) run_.statistic(row) = parity.squaredNorm();
  const auto at = static_cast<std::size_t>(row);
  if (const fusion::Finding found = examine(fused_set->test, parity, test_); has_parity && found.fault) {
    run_.contradicts[at] = true;
    ++run_.summary.contradictions;
    Alarm alarm{.kind = AlarmKind::parity,
                .at_s = axes_.time_s(row),
                .since_s = axes_.time_s(row),
                .until_s = axes_.time_s(row),
                .statement = fmt::format("χ² {:.3g} of {}, limit {:.3g}", found.statistic, found.freedom, found.limit)};
    if (found.isolation && found.isolation->candidate) {
      const Eigen::Index axis = members(set)[static_cast<std::size_t>(*found.isolation->candidate)];
      alarm.who = axes_.names[static_cast<std::size_t>(axis)];
      alarm.size = found.isolation->size;
      if (const SetOfAxes* others = cache_(set & ~bit(axis))) {
        set &= ~bit(axis);
        fused_set = others;
      }
    }
    constexpr double kMergeWithin_s = 600;
    record_alarm(std::move(alarm), kMergeWithin_s);
  }
  run_.rate_deg_per_h.row(row) = (fused_set->gains.rate * readings(members(set))).transpose();
  run_.expanded_deg_per_h.row(row) =
      expanded_uncertainty(*fused_set, axes_.added_variance.row(row).transpose()(members(set)));
  run_.used[at] = set;
  return {};
}

/// Records an alarm. If an alarm of the same kind and name ended at most `within_s` before, extends that alarm instead.
void RecordFuser::record_alarm(Alarm alarm, double within_s) {
  auto& alarms = run_.summary.alarms;
  const auto last = std::find_if(alarms.rbegin(), alarms.rend(), [&](const Alarm& before) {
    return before.kind == alarm.kind && before.who == alarm.who;
  });
  if (last != alarms.rend() && alarm.since_s - last->until_s <= within_s) {
    last->until_s = alarm.until_s;
    return;
  }
  alarms.push_back(std::move(alarm));
}

Result<void> RecordFuser::watch_cluster(const Eigen::VectorXd& rates, const Eigen::RowVectorXd& temperatures,
                                        double end_s) {
  constexpr int kClustersUntilChange = 6;
  const AxisSet requested = find_finite_axes(rates) & ~left_out_;
  const bool differs = !watch_ || watch_->set() != requested;
  if (requested != 0) other_set_ = differs ? other_set_ + 1 : 0;
  const bool is_left_out = watch_ && (watch_->set() & left_out_) != 0;
  if (differs && requested != 0 && (!watch_ || is_left_out || other_set_ >= kClustersUntilChange)) {
    auto watch = FaultWatch::make(axes_, requested, thermometers_, options_.cluster_s, options_.watch);
    if (!watch) return failure(watch.error());
    watch_ = std::move(*watch);
    if (options_.healthy && options_.healthy->names == axes_.names) watch_->learn_limits(*options_.healthy);
    if (run_.summary.sum_limits.empty()) run_.summary.sum_limits = watch_->sum_limits();
    other_set_ = 0;
  }
  if (!watch_) return {};
  std::vector<Alarm> alarms = watch_->push(rates, temperatures, end_s);
  // A vote against a thermometer is more reliable than the alarm of a cumulative sum and is handled first.
  std::ranges::stable_partition(alarms, [](const Alarm& alarm) { return alarm.kind == AlarmKind::thermometer; });
  for (Alarm& alarm : alarms) {
    clear_doubtful_axis(alarm);
    leave_out(alarm);
    record_alarm(std::move(alarm), kSecondsPerHour);
  }
  return {};
}

/// Clears the axis in the alarm of a cumulative sum if a recent vote found a thermometer faulty: a sum monitors only
/// axes and would name one that has no fault.
void RecordFuser::clear_doubtful_axis(Alarm& alarm) const {
  if (alarm.kind != AlarmKind::rest_hop && alarm.kind != AlarmKind::parity_hop) return;
  const auto& alarms = run_.summary.alarms;
  const auto verdict = std::find_if(alarms.rbegin(), alarms.rend(), [&](const Alarm& before) {
    return before.kind == AlarmKind::thermometer && before.until_s + kSecondsPerHour >= alarm.at_s;
  });
  if (alarm.who.empty() || verdict == alarms.rend()) return;
  alarm.who.clear();
  alarm.size = 0;
  alarm.statement += "; no axis is named, because a vote found a thermometer faulty";
}

/// Returns the mean square error of the rate vector of these axes if each axis has the error given by `off_deg_per_h`;
/// infinite if the axes do not span all directions.
double mean_square_error(const FusedAxes& axes, AxisSet set, const Eigen::MatrixXd& covariance,
                         const Eigen::VectorXd& off_deg_per_h) {
  const auto geometry = geometry_of_set(axes, set, covariance);
  if (!geometry) return std::numeric_limits<double>::infinity();
  const fusion::Gains gains = compute_gains(*geometry);
  return gains.covariance.trace() + (gains.rate * off_deg_per_h(members(set))).squaredNorm();
}

void RecordFuser::leave_out(const Alarm& alarm) {
  if (!options_.leave_out || alarm.who.empty()) return;
  Eigen::VectorXd off = Eigen::VectorXd::Zero(axes_.axes());
  const auto axis = std::ranges::find(axes_.names, alarm.who) - axes_.names.begin();
  const auto thermometer = std::ranges::find(axes_.thermometers, alarm.who) - axes_.thermometers.begin();
  if (alarm.kind == AlarmKind::thermometer && thermometer < std::ssize(axes_.thermometers)) {
    off = -alarm.size * axes_.sensitivity_deg_per_h_per_k.col(thermometer);
  } else if (alarm.kind != AlarmKind::thermometer && axis < std::ssize(axes_.names)) {
    off(axis) = alarm.size;
  }
  const Eigen::MatrixXd covariance = uncertainty_of_means(axes_, options_.cluster_s).varying_covariance();
  AxisSet set = all_ & ~left_out_;
  double least = mean_square_error(axes_, set, covariance, off);
  for (bool better = true; better;) {
    better = false;
    AxisSet best = set;
    for (const Eigen::Index a : members(set)) {
      const double without = off(a) != 0 ? mean_square_error(axes_, set & ~bit(a), covariance, off) : least;
      if (without >= least) continue;
      least = without;
      best = set & ~bit(a);
      better = true;
    }
    set = best;
  }
  left_out_ = all_ & ~set;
}

void summarise_axes(const FusedAxes& axes, FusedRun& run) {
  const FusedUncertainty second = uncertainty_of_means(axes, 1), hour = uncertainty_of_means(axes, kSecondsPerHour);
  for (Eigen::Index a = 0; a < axes.axes(); ++a) {
    const auto at = static_cast<std::size_t>(a);
    FusedAxisSummary summary{.name = axes.names[at],
                             .inputs = axes.models[at].inputs,
                             .method = axes.models[at].method,
                             .direction = {axes.directions(a, 0), axes.directions(a, 1), axes.directions(a, 2)}};
    summary.second_std_deg_per_h = std::sqrt(second.noise(a) + second.bias(a, a));
    summary.hour_std_deg_per_h = std::sqrt(hour.noise(a) + hour.bias(a, a) + hour.learnt(a, a));
    summary.error_rms_deg_per_h = kNoRate;
    summary.outside_s = std::ranges::count_if(axes.outside, [&](AxisSet outside) { return (outside & bit(a)) != 0; });
    for (const AxisSet used : run.used) summary.left_out_s += used != 0 && (used & bit(a)) == 0 ? 1 : 0;
    run.summary.axes.push_back(std::move(summary));
  }
}

/// Returns the rates, with NaN where an input is outside the trained range, because the model's budget does not apply
/// there.
Eigen::MatrixXd mask_rates_outside(const FusedAxes& axes) {
  Eigen::MatrixXd rates = axes.rate_deg_per_h;
  for (Eigen::Index row = 0; row < rates.rows(); ++row)
    for (const Eigen::Index a : members(axes.outside[static_cast<std::size_t>(row)])) rates(row, a) = kNoRate;
  return rates;
}

/// Returns the means on a regular grid, with NaN for missing clusters. The watches must see the gap, because a drift
/// continues during it.
ClusterMeans insert_missing_clusters(const ClusterMeans& means, double cluster_s) {
  if (means.end_s.size() == 0) return means;
  const double first = means.end_s(0);
  const auto grid_index = [&](Eigen::Index k) {
    return static_cast<Eigen::Index>(std::llround((means.end_s(k) - first) / cluster_s));
  };
  const Eigen::Index count = grid_index(means.end_s.size() - 1) + 1;
  ClusterMeans all{.end_s = first + cluster_s * Eigen::ArrayXd::LinSpaced(count, 0, static_cast<double>(count - 1)),
                   .mean = Eigen::MatrixXd::Constant(count, means.mean.cols(), kNoRate)};
  for (Eigen::Index k = 0; k < means.end_s.size(); ++k) all.mean.row(grid_index(k)) = means.mean.row(k);
  return all;
}

FusedRun empty_run(const FusedAxes& axes, const FusionOptions& options, const fusion::Geometry& geometry,
                   const fusion::Geometry& weights) {
  const Eigen::Index rows = axes.time_s.size();
  FusedRun run{.time_s = axes.time_s,
               .rate_deg_per_h = Eigen::MatrixX3d::Constant(rows, 3, kNoRate),
               .expanded_deg_per_h = Eigen::MatrixX3d::Constant(rows, 3, kNoRate),
               .statistic = Eigen::VectorXd::Constant(rows, kNoRate),
               .used = std::vector<AxisSet>(static_cast<std::size_t>(rows)),
               .contradicts = std::vector<bool>(static_cast<std::size_t>(rows)),
               .geometry = geometry,
               .weights = weights,
               .summary = {}};
  run.summary.simulated = axes.simulated;
  run.summary.run_id = axes.run_id;
  run.summary.profile = axes.profile_name;
  run.summary.false_alarm_probability = options.watch.false_alarm_probability;
  run.summary.averaging_s = options.averaging_s;
  run.summary.false_alarms_per_h = options.watch.false_alarms_per_h;
  run.summary.latitude_deg = kNoRate;
  run.summary.warnings = axes.warnings;
  const auto test = parity_test(compute_gains(geometry), geometry);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(test.degrees_of_freedom());
  run.summary.limit =
      test.degrees_of_freedom() > 0
          ? examine(test, none, {.false_alarm_probability = options.watch.false_alarm_probability}).limit
          : kNoRate;
  return run;
}

}  // namespace

Result<FusedRun> fuse(const FusedAxes& axes, const std::optional<fusion::ThermometerParity>& thermometers,
                      const FusionOptions& options) {
  const AxisSet all = bit(axes.axes() - 1) | (bit(axes.axes() - 1) - 1);
  const auto geometry = geometry_of_set(axes, all, uncertainty_of_means(axes, 1).varying_covariance());
  if (!geometry) return failure(geometry.error());
  const auto weights = geometry_of_set(axes, all, uncertainty_of_means(axes, options.averaging_s).varying_covariance());
  if (!weights) return failure(weights.error());
  FusedRun run = empty_run(axes, options, *geometry, *weights);
  run.summary.thermometers_vote = thermometers.has_value();
  const auto gridded_means = [&](const Eigen::MatrixXd& rows) {
    return insert_missing_clusters(cluster_means(axes.time_s, rows, options.cluster_s), options.cluster_s);
  };
  const ClusterMeans rates = gridded_means(mask_rates_outside(axes)), temperatures = gridded_means(axes.temperature_c);
  RecordFuser fuser(axes, thermometers, options, run);
  Eigen::Index cluster = 0;
  // A cluster is watched after its last second has been fused.
  const auto watch_until = [&](double now_s) -> Result<void> {
    for (; cluster < rates.end_s.size() && rates.end_s(cluster) <= now_s; ++cluster) {
      const auto watched = fuser.watch_cluster(rates.mean.row(cluster).transpose(), temperatures.mean.row(cluster),
                                               rates.end_s(cluster));
      if (!watched) return watched;
    }
    return {};
  };
  for (Eigen::Index row = 0; row < axes.time_s.size(); ++row) {
    if (const auto watched = watch_until(axes.time_s(row)); !watched) return failure(watched.error());
    if (const auto fused = fuser.fuse_second(row); !fused) return failure(fused.error());
  }
  constexpr double kAll = std::numeric_limits<double>::infinity();
  if (const auto watched = watch_until(kAll); !watched) return failure(watched.error());
  run.summary.seconds = axes.time_s.size();
  run.summary.fused = std::ranges::count_if(run.used, [](AxisSet used) { return used != 0; });
  summarise_axes(axes, run);
  evaluate_at_rest(axes, options, run);
  return run;
}

HealthyRates healthy_rates(const FusedAxes& healthy, double cluster_s) {
  HealthyRates rates{
      .names = healthy.names,
      .departures_deg_per_h =
          insert_missing_clusters(cluster_means(healthy.time_s, mask_rates_outside(healthy), cluster_s), cluster_s)
              .mean,
      .at_rest = healthy.attitude.has_value()};
  if (rates.at_rest)
    rates.departures_deg_per_h.rowwise() -=
        (healthy.directions * earth_in_fixture(*healthy.attitude)).transpose().eval();
  return rates;
}

std::string to_json(const FusionSummary& summary) {
  Json json{{"schema", kFusionSchema}};
  json.update(make_json(summary));
  return json_text(json, 1) + "\n";
}

}  // namespace gyrotherm::model
