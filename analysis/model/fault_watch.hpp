// SPDX-License-Identifier: Apache-2.0
/// Detection of axis and thermometer faults from consecutive cluster means. These faults are too small to be detected
/// in a single second.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "analysis/fusion/change_detector.hpp"
#include "analysis/fusion/fault_test.hpp"
#include "analysis/fusion/voting.hpp"
#include "analysis/model/fused_axes.hpp"
#include "analysis/tracking/bias_tracker.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

struct WatchOptions {
  /// False-alarm probability of a single test: the parity test of one second or the vote on one cluster.
  double false_alarm_probability = 1e-6;
  /// Rate of false alarms of each cumulative sum.
  double false_alarms_per_h = 1e-3;
  /// Margin by which the best explanation must exceed the next (fault_test.hpp).
  double margin = 6;
};

enum class AlarmKind {
  /// Parity of a single second above its limit.
  parity,
  parity_hop,  ///< cumulative sum of the parity
  /// Cumulative sum of the axes at rest, each compared with its own thermal prediction.
  rest_hop,
  /// The last hour of a hold disagrees with the Earth's rotation and the priors of the axes.
  rest,
  gyro,         ///< vote on a cluster: gyro hopped
  thermometer,  ///< vote on a cluster: thermometer broken
  undecided     ///< vote on a cluster: unknown fault
};
[[nodiscard]] const char* name(AlarmKind kind);

/// Cluster means of the axes in a record without faults. The limits of the cumulative sums are learnt from them.
struct HealthyRates {
  std::vector<std::string> names;
  /// Clusters × axes, less the Earth rate if it is known. Missing means are NaN.
  Eigen::MatrixXd departures_deg_per_h;
  /// True if the Earth rate is known and subtracted.
  bool at_rest = false;
};

/// The limit of a cumulative sum.
struct SumLimit {
  /// Name of the AlarmKind.
  std::string kind{};
  double limit{};  ///< standard deviations
  /// Limit that would apply to white innovations.
  double white_limit{};
  /// True if the limit was learnt from a healthy record.
  bool learnt{};
};

void describe(auto& form, Like<SumLimit> auto& sum) {
  form("kind", sum.kind);
  form("limit", sum.limit);
  form("white_limit", sum.white_limit);
  form("learnt", sum.learnt);
}

/// A detected fault.
struct Alarm {
  AlarmKind kind{};
  /// Time of detection since the start of the run.
  double at_s{};
  /// Most likely beginning of the fault.
  double since_s{};
  /// End of the last alarm that was merged into this one.
  double until_s{};
  /// Name of the axis or thermometer; empty if unknown.
  std::string who{};
  /// Size of the fault, °/h or K.
  double size{};
  std::string statement{};
};

void describe(auto& form, Like<Alarm> auto& alarm) {
  form("kind", one_of(alarm.kind, {AlarmKind::parity, AlarmKind::parity_hop, AlarmKind::rest_hop, AlarmKind::rest,
                                   AlarmKind::gyro, AlarmKind::thermometer, AlarmKind::undecided}));
  form("at_s", alarm.at_s);
  form("since_s", alarm.since_s);
  form("until_s", alarm.until_s);
  form("who", alarm.who);
  form("size", alarm.size);
  form("statement", alarm.statement);
}

/// Detects a hop of an axis in a sequence of vectors. A bias tracker per component removes slow drift. Its innovations,
/// divided by their standard deviations, are white; a fusion::ChangeDetector processes them. After an alarm the
/// trackers restart, so each hop is reported once.
class HopWatch {
 public:
  /// `spaces` has one state space per component of a vector. `effects` has one column per candidate: the vector that a
  /// hop of 1 °/h causes.
  [[nodiscard]] static Result<HopWatch> make(AlarmKind kind, const std::vector<std::string>& candidates,
                                             const Eigen::MatrixXd& effects,
                                             const std::vector<tracking::StateSpace>& spaces,
                                             const WatchOptions& options);
  /// Processes the vector of the cluster that ended at `end_s`. Returns an alarm if a hop is detected. A vector with a
  /// NaN is not tested, but the uncertainty of the trackers grows. Push NaN for a missing cluster.
  [[nodiscard]] std::optional<Alarm> push(const Eigen::VectorXd& vector, double end_s);

  /// Tracks the vectors of a healthy record, one row per cluster, and computes the limit of the sum from their
  /// innovations (fusion::learn_sum_limit). The limit is unchanged if there are too few vectors or if they are too
  /// strongly correlated. Call it before the first push().
  void learn_limit(const Eigen::MatrixXd& healthy);
  [[nodiscard]] SumLimit limit() const;

 private:
  struct WatchedVector {
    double end_s{};
    Eigen::VectorXd vector;
  };
  HopWatch(AlarmKind kind, std::vector<tracking::StateSpace> spaces, fusion::ChangeDetector detector);
  [[nodiscard]] Alarm make_alarm(const fusion::Change& change, double end_s) const;
  void restart(const Eigen::VectorXd& departure);

  AlarmKind kind_;
  WatchOptions options_;
  std::vector<tracking::StateSpace> spaces_;
  std::vector<tracking::BiasTracker> trackers_;
  fusion::ChangeDetector detector_;
  double white_limit_{};
  bool learnt_ = false;
  /// Effects of a hop of 1 °/h.
  Eigen::MatrixXd effects_;
  /// Effects of a hop of 1 °/h on the normalised innovations of settled trackers.
  fusion::FaultTest innovations_;
  /// Vectors without a NaN, the oldest first.
  std::deque<WatchedVector> recent_;
};

/// Runs the fault tests of a set of axes: comparison of the axes with each other, of each axis with its prediction at
/// rest, and the vote of axes and thermometers.
class FaultWatch {
 public:
  /// `thermometers` was learnt from a record without faults (healthy_thermometers()); without it no vote takes place.
  /// Axes are compared with each other if there are four or more, and each with its own prediction if the attitude is
  /// known.
  [[nodiscard]] static Result<FaultWatch> make(const FusedAxes& axes, AxisSet set,
                                               const std::optional<fusion::ThermometerParity>& thermometers,
                                               double cluster_s, const WatchOptions& options);

  /// Processes the means of all axes (°/h) and of all thermometers (°C) over the cluster that ended at `end_s`. Returns
  /// the new alarms. Axes outside the set are ignored. A watch reports nothing if one of its readings is missing.
  [[nodiscard]] std::vector<Alarm> push(const Eigen::VectorXd& rates, const Eigen::RowVectorXd& temperatures,
                                        double end_s);

  /// Learns the limits of the cumulative sums from these rates of all axes, in the order of make(). The limit of the
  /// sum at rest is learnt only if the Earth rate is known. Call it before the first push().
  void learn_limits(const HealthyRates& healthy);

  [[nodiscard]] AxisSet set() const { return set_; }
  [[nodiscard]] std::vector<SumLimit> sum_limits() const;

 private:
  struct WatchedAxes;
  /// Compares the axes with each other if there are four or more.
  [[nodiscard]] Result<void> watch_parity(const FusedAxes& axes, const WatchedAxes& watched);
  /// Compares each axis with its own prediction if the attitude is known.
  [[nodiscard]] Result<void> watch_at_rest(const FusedAxes& axes, const fusion::Geometry& geometry,
                                           const WatchedAxes& watched);
  /// Sets the axes and thermometers that vote. Sets none if `thermometers` has a thermometer that the axes do not have.
  void set_voters(const FusedAxes& axes, const std::vector<std::string>& names,
                  const fusion::ThermometerParity& thermometers, const Eigen::MatrixXd& whitening);
  [[nodiscard]] std::optional<Alarm> vote_on_cluster(const Eigen::VectorXd& rates,
                                                     const Eigen::RowVectorXd& temperatures, double end_s) const;

  AxisSet set_{};
  double cluster_s_{};
  WatchOptions options_;
  std::vector<Eigen::Index> in_;
  /// Expected rates of the axes at rest; empty if unknown.
  Eigen::VectorXd expected_;
  /// Parity matrix V of cluster means; it has no rows if there is no parity.
  Eigen::MatrixXd parity_;
  std::optional<HopWatch> rest_, hops_;
  std::optional<fusion::Voters> voters_;
  /// Columns of the voting thermometers in the temperatures.
  std::vector<Eigen::Index> voting_thermometers_;
};

/// Learns the normal relations of thermometers from cluster means of a record without faults. Includes only
/// thermometers to which a model is sensitive. The number of modes is the number of principal components whose variance
/// exceeds that of every thermometer's uncertainty. It is at least one, and leaves at least two components for the test
/// if there are enough thermometers. Fails like learn_thermometer_parity().
[[nodiscard]] Result<fusion::ThermometerParity> healthy_thermometers(const FusedAxes& healthy, double cluster_s);

/// Means of one-second rows over the clusters of a record. A NaN row makes its cluster's mean NaN. Clusters with a
/// missing second are omitted.
struct ClusterMeans {
  Eigen::VectorXd end_s;
  Eigen::MatrixXd mean;
};
[[nodiscard]] ClusterMeans cluster_means(const Eigen::VectorXd& time_s, const Eigen::MatrixXd& rows, double cluster_s);

}  // namespace gyrotherm::model
