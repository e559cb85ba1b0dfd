// SPDX-License-Identifier: Apache-2.0
/// Faults of axes and thermometers that a second does not show: watched in means over a cluster, as they come.
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
  double false_alarm_probability = 1e-6;  ///< of one test: the parity of a second, a vote on a cluster
  double false_alarms_per_h = 1e-3;       ///< of each cumulative sum
  double margin = 6;                      ///< by which one explanation must be ahead of the next (fault_test.hpp)
};

enum class AlarmKind {
  parity,       ///< the parity of single seconds is above its limit
  parity_hop,   ///< the cumulative sum of the parity
  rest_hop,     ///< the cumulative sum of the axes at rest, each against its own thermal prediction
  rest,         ///< readings of the last hour of holds against the Earth and what is known of the axes
  gyro,         ///< a vote on a cluster: a gyro hopped
  thermometer,  ///< … a thermometer is broken
  undecided     ///< … something is at fault that is not known
};
[[nodiscard]] const char* name(AlarmKind kind);

/// Cluster means of the axes in a healthy record. The limits of the cumulative sums are learnt from them.
struct HealthyRates {
  std::vector<std::string> names;
  /// Clusters × axes, less the Earth's rate where it is known. Missing means are NaN.
  Eigen::MatrixXd departures_deg_per_h;
  bool at_rest = false;  ///< the Earth's rate is known
};

/// The limit of a cumulative sum.
struct SumLimit {
  std::string kind{};    ///< name of its AlarmKind
  double limit{};        ///< standard deviations
  double white_limit{};  ///< if innovations were white
  bool learnt{};         ///< a healthy record gave it
};

void describe(auto& form, Like<SumLimit> auto& sum) {
  form("kind", sum.kind);
  form("limit", sum.limit);
  form("white_limit", sum.white_limit);
  form("learnt", sum.learnt);
}

/// Something is at fault, as far as is known then.
struct Alarm {
  AlarmKind kind{};
  double at_s{};            ///< when it was said, since the run started
  double since_s{};         ///< when it began, likeliest
  double until_s{};         ///< of the last one of its kind in a row
  std::string who{};        ///< the axis or thermometer; empty if it cannot be told
  double size{};            ///< of its fault, °/h or K; 0 if it is nobody's
  std::string statement{};  ///< in words
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

/// A hop of an axis in a sequence of vectors whose slow wander is tracked away: each number of a vector has a bias
/// tracker of its own, and the innovations, each over its standard deviation, are white and go through a
/// fusion::ChangeDetector. After an alarm the trackers begin anew, so that a hop is told once.
class HopWatch {
 public:
  /// `spaces`: of each number of a vector. `effects`: what a hop of each candidate by 1 °/h does to it, a column each.
  [[nodiscard]] static Result<HopWatch> make(AlarmKind kind, const std::vector<std::string>& candidates,
                                             const Eigen::MatrixXd& effects,
                                             const std::vector<tracking::StateSpace>& spaces,
                                             const WatchOptions& options);
  /// The vector of the cluster that ended at `end_s`; one with a NaN passes unseen, but the trackers grow unsure. A
  /// cluster that is missing is to be pushed as NaN.
  [[nodiscard]] std::optional<Alarm> push(const Eigen::VectorXd& vector, double end_s);

  /// Tracks the vectors of a healthy record, a row per cluster, and takes the limit of the sum from their innovations
  /// (fusion::limit_of_healthy). The limit remains as it is if there are too few. Call it before the first push().
  void learn_limit(const Eigen::MatrixXd& healthy);
  [[nodiscard]] SumLimit limit() const;

 private:
  struct Seen {
    double end_s{};
    Eigen::VectorXd vector;
  };
  HopWatch(AlarmKind kind, std::vector<tracking::StateSpace> spaces, fusion::ChangeDetector detector);
  [[nodiscard]] Alarm alarm_of(const fusion::Change& change, double end_s) const;
  void begin_anew(const Eigen::VectorXd& departure);

  AlarmKind kind_;
  WatchOptions options_;
  std::vector<tracking::StateSpace> spaces_;
  std::vector<tracking::BiasTracker> trackers_;
  fusion::ChangeDetector detector_;
  double white_limit_{};
  bool learnt_ = false;
  Eigen::MatrixXd effects_;        ///< of one °/h
  fusion::FaultTest innovations_;  ///< the same, of innovations once the trackers have settled
  std::deque<Seen> recent_;        ///< vectors without a NaN, the oldest first
};

/// All watches of some of the axes.
class FaultWatch {
 public:
  /// `thermometers`: of a record in which nothing was at fault; nothing: they have no vote. Axes are seen against each
  /// other if there are four or more, and each against its own prediction if the attitude is known.
  [[nodiscard]] static Result<FaultWatch> make(const FusedAxes& axes, AxisSet set,
                                               const std::optional<fusion::ThermometerParity>& thermometers,
                                               double cluster_s, const WatchOptions& options);

  /// Means of all axes (°/h) and of all thermometers (°C) over the cluster that ended at `end_s`; those of other axes
  /// are not looked at. With a reading missing, what needs it says nothing.
  [[nodiscard]] std::vector<Alarm> push(const Eigen::VectorXd& rates, const Eigen::RowVectorXd& temperatures,
                                        double end_s);

  /// Learns the limits of the cumulative sums from these rates of all axes, in the order of make(). The sum at rest
  /// learns where the Earth's rate is known. Call it before the first push().
  void learn_limits(const HealthyRates& healthy);

  [[nodiscard]] AxisSet set() const { return set_; }
  [[nodiscard]] std::vector<SumLimit> sum_limits() const;

 private:
  struct WatchedAxes;
  /// Watches the axes against each other if they are four or more.
  [[nodiscard]] Result<void> watch_parity(const FusedAxes& axes, const WatchedAxes& watched);
  /// Watches each axis against its own prediction if the attitude is known.
  [[nodiscard]] Result<void> watch_at_rest(const FusedAxes& axes, const fusion::Geometry& geometry,
                                           const WatchedAxes& watched);
  /// Makes axes and thermometers the voters, unless the thermometers are of another record.
  void set_voters(const FusedAxes& axes, const std::vector<std::string>& names,
                  const fusion::ThermometerParity& thermometers, const Eigen::MatrixXd& whitening);
  [[nodiscard]] std::optional<Alarm> voted(const Eigen::VectorXd& rates, const Eigen::RowVectorXd& temperatures,
                                           double end_s) const;

  AxisSet set_{};
  double cluster_s_{};
  WatchOptions options_;
  std::vector<Eigen::Index> in_;
  Eigen::VectorXd expected_;  ///< of those axes at rest; empty: not known
  Eigen::MatrixXd parity_;    ///< V of cluster means; no row: no parity
  std::optional<HopWatch> rest_, hops_;
  std::optional<fusion::Voters> voters_;
  std::vector<Eigen::Index> voting_thermometers_;  ///< columns of the temperatures
};

/// Learns how thermometers agree from the axes of a record in which nothing is at fault: of those that a model asks for
/// or that have a gradient, cluster means; as many ways to move as principal components stand out of what is not known
/// of a thermometer, and two fewer than there are thermometers at the most. Fails as thermometer_parity_of() does.
[[nodiscard]] Result<fusion::ThermometerParity> healthy_thermometers(const FusedAxes& healthy, double cluster_s);

/// Means of rows of a second each over clusters of the record; a row that is NaN makes its cluster's mean NaN, and a
/// cluster in which a second is missing is not there.
struct ClusterMeans {
  Eigen::VectorXd end_s;
  Eigen::MatrixXd mean;
};
[[nodiscard]] ClusterMeans cluster_means(const Eigen::VectorXd& time_s, const Eigen::MatrixXd& rows, double cluster_s);

}  // namespace gyrotherm::model
