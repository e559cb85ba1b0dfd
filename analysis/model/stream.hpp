// SPDX-License-Identifier: Apache-2.0
/// Compensation as a stream: 1-Hz rows in, compensated bias out, bounded memory.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/features.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Means of each column over the last `length` rows. A window consists of the end of the previous block of `length`
/// rows and the beginning of the current one. Both parts are sums of rows; no row is ever subtracted. Rounding errors
/// therefore do not accumulate, and a NaN has no effect after its row has left the window.
class SlidingMeans {
 public:
  SlidingMeans(Eigen::Index length, Eigen::Index columns);
  /// Returns the means of the `columns` columns over the rows up to this one; NaN before `length` rows were pushed.
  [[nodiscard]] const Eigen::RowVectorXd& push(const Eigen::Ref<const Eigen::RowVectorXd>& row);
  [[nodiscard]] Eigen::Index columns() const { return block_.cols(); }

 private:
  /// Rows of the current block.
  data::SampleMatrix block_;
  /// Sums of the previous block from each row to its end.
  data::SampleMatrix previous_ends_;
  /// Sum of the current block so far.
  Eigen::RowVectorXd current_sum_;
  Eigen::RowVectorXd means_;
  /// Number of rows in the current block.
  Eigen::Index at_{};
  /// Set once a block is complete.
  bool has_previous_block_{};
};

/// Lags of sliding means. Means whose ends are a cluster length apart form a series, so there are as many interleaved
/// series as seconds in a cluster; one of them consists of the clusters themselves. Each second belongs to one series,
/// and its lag is the lag of that series. After a NaN mean, the next step of the series is longer.
class SlidingLags {
 public:
  /// Column of the thermometer and time constant of a lag.
  struct Lag {
    Eigen::Index thermometer{};
    double time_constant_s{};
  };
  SlidingLags(Eigen::Index length, const std::vector<Lag>& lags);
  /// Returns the lags at the next second, given its means, K: 0 at the first mean of a series, NaN if the mean is NaN.
  [[nodiscard]] const Eigen::RowVectorXd& push(const Eigen::RowVectorXd& means);
  /// Advances the lags over a gap of `cluster_lengths` clusters that have no mean.
  void skip_clusters(Eigen::Index cluster_lengths);

 private:
  struct Follower {
    data::FirstOrderLag lag;
    /// Cluster lengths since the last known mean.
    Eigen::Index steps = 1;
  };
  std::vector<Lag> lags_;
  /// One follower per lag, for each second of a cluster length.
  std::vector<std::vector<Follower>> ring_;
  /// Index of the current second.
  std::size_t at_{};
  Eigen::RowVectorXd latest_;
};

/// Stream of compensated bias. Inputs are trailing means over the model's cluster length, one row per second (causal);
/// rates are the difference of two adjacent means; lags are computed by SlidingLags. At the end of each whole cluster
/// the inputs equal those of the cluster. A prediction from these inputs applies to the time half a cluster length ago.
/// If is_led() is true for the model, the stream extrapolates the prediction by half a cluster length from the
/// prediction one cluster length earlier, if there is one.
class CompensationStream {
 public:
  /// Opens a stream for rows with these thermometers, in this order. Fails with usage if the model needs a thermometer
  /// that is not among them.
  [[nodiscard]] static Result<CompensationStream> open(const Model& model, std::vector<std::string> columns,
                                                       Outside outside = Outside::continued);
  /// Processes the next rows: temperatures in °C in the order of `columns`, raw bias in °/h. Returns the compensated
  /// bias of each row; NaN before a complete mean (two, if a rate is an input), while a mean contains a NaN, and where
  /// the model refuses inputs outside its range. The results do not depend on how the rows are divided into calls.
  [[nodiscard]] Eigen::VectorXd push(const Eigen::Ref<const data::SampleMatrix>& temperatures_c,
                                     const Eigen::Ref<const Eigen::VectorXd>& bias_deg_per_h);

  /// Advances by this many seconds without a row, in constant time.
  void skip_seconds(Eigen::Index seconds);

  /// Processes rows with their times, and advances over the missing seconds between them. The times of a logger may
  /// deviate slightly from whole seconds. `time_s` must be ascending and continue the times of earlier calls.
  [[nodiscard]] Eigen::VectorXd push_at(const Eigen::Ref<const Eigen::VectorXd>& time_s,
                                        const Eigen::Ref<const data::SampleMatrix>& temperatures_c,
                                        const Eigen::Ref<const Eigen::VectorXd>& bias_deg_per_h);
  /// Missing seconds before one of the rows of the last push_at().
  struct Gap {
    Eigen::Index row{}, seconds{};
  };
  [[nodiscard]] const std::vector<Gap>& gaps() const { return gaps_; }

  /// Returns the number of rows so far with an input outside the trained range.
  [[nodiscard]] long long outside() const { return outside_; }
  /// Returns the indices of the last pushed rows with an input outside, in ascending order; the first row is 0.
  [[nodiscard]] const std::vector<Eigen::Index>& rows_outside() const { return rows_outside_; }
  /// Returns the excess of each of the last pushed rows: the distance of its worst input from the trained range, as a
  /// fraction of that range; 0 inside.
  [[nodiscard]] const Eigen::VectorXd& excess() const { return excess_; }

 private:
  CompensationStream(const Model& model, std::vector<std::string> columns, const std::vector<SlidingLags::Lag>& lags,
                     Outside policy);
  [[nodiscard]] Eigen::VectorXd extrapolate(Eigen::VectorXd predicted);
  /// Copy of the model in which each lag is an input like a temperature.
  Model model_;
  Outside policy_;
  SlidingMeans means_;
  /// Set if the model has rates among its inputs.
  bool rates_{};
  SlidingLags lags_;
  /// Ring of the means of the last cluster length; only used with rates.
  data::SampleMatrix past_;
  Eigen::Index pushed_{};  ///< total rows
  long long outside_{};
  std::vector<Eigen::Index> rows_outside_;
  Eigen::VectorXd excess_;
  /// Ring of the predictions of the last cluster length; empty if the model is not led.
  Eigen::VectorXd predictions_;
  /// Time of the last row of push_at(), s.
  std::optional<double> last_s_;
  std::vector<Gap> gaps_;
  /// Means of the last pushed rows, then their lags.
  data::Clusters latest_;
};

/// Measures the error that the stream's lag of half a cluster length causes, from consecutive means. With p the
/// predictions, the error is half the root mean square of p_k − p_{k−1} without correction, and of p_k − 2 p_{k−1} +
/// p_{k−2} with the extrapolation p + ½(p − previous p). Both errors include the thermometer noise. Predictions are
/// therefore extrapolated only if this removes more lag error than it adds noise. Returns no value for fewer than three
/// consecutive means.
[[nodiscard]] std::optional<Latency> measure_latency(const Model& model, const data::Clusters& clusters,
                                                     const Eigen::VectorXd& predicted_deg_per_h);

}  // namespace gyrotherm::model
