// SPDX-License-Identifier: Apache-2.0
/// Compensation as a stream: 1-Hz rows in, compensated bias out, memory bounded.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/features.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Means of each column over the last `length` rows. A window is the rest of the block of `length` rows before and the
/// beginning of this one, each summed anew: nothing is ever subtracted, so that nothing drifts and a NaN leaves with
/// its row.
class SlidingMeans {
 public:
  SlidingMeans(Eigen::Index length, Eigen::Index columns);
  /// The means that end with this row, of `columns` numbers; NaN before `length` rows have come.
  [[nodiscard]] const Eigen::RowVectorXd& push(const Eigen::Ref<const Eigen::RowVectorXd>& row);
  [[nodiscard]] Eigen::Index columns() const { return block_.cols(); }

 private:
  data::SampleMatrix block_;  ///< rows of this block as they come
  data::SampleMatrix ends_;   ///< sums of the block before from each row to its end
  Eigen::RowVectorXd begun_;  ///< sum of this block so far
  Eigen::RowVectorXd means_;
  Eigen::Index at_{};  ///< rows in this block
  bool full_{};        ///< a block has come before
};

/// Lags of sliding means, each second those of the means a cluster length apart that end with it: so many interleaved
/// series, the one that ends with the clusters among them. A mean that holds a NaN is a longer step for its series.
class SlidingLags {
 public:
  /// The thermometer and the time constant of each lag that is asked for.
  struct Of {
    Eigen::Index thermometer{};
    double time_constant_s{};
  };
  SlidingLags(Eigen::Index length, const std::vector<Of>& lags);
  /// The lags of the next second's means, K; 0 at the first mean of a series, NaN where the mean is.
  [[nodiscard]] const Eigen::RowVectorXd& push(const Eigen::RowVectorXd& means);
  /// As many cluster lengths without a mean in any second.
  void pass(Eigen::Index cluster_lengths);

 private:
  struct Follower {
    data::FirstOrderLag lag;
    Eigen::Index steps = 1;  ///< of a cluster length since the last mean that was known
  };
  std::vector<Of> lags_;
  std::vector<std::vector<Follower>> ring_;  ///< per second of a cluster length, of each lag
  std::size_t at_{};                         ///< second in it
  Eigen::RowVectorXd latest_;
};

/// Inputs are trailing means over the model's cluster length, one row a second (causal), rates the difference of two
/// neighbouring means, lags those of SlidingLags. At the end of each whole cluster they are that cluster's. What is
/// predicted from them is the bias of half a cluster length ago; a model that is_led() extrapolates it by as much, from
/// the prediction of one cluster length before, where there is one.
class CompensationStream {
 public:
  /// `columns`: the thermometers of each row, in order. Fails with usage if the model needs another one.
  [[nodiscard]] static Result<CompensationStream> open(const Model& model, std::vector<std::string> columns,
                                                       Outside outside = Outside::continued);
  /// The next rows: temperatures in °C in the order of `columns`, raw bias in °/h. Returns the compensated bias of
  /// each; NaN until a whole mean (two, where a rate is an input) has been seen, while one holds a NaN, and where the
  /// model refuses inputs outside its range. The same whether rows come one by one or together.
  [[nodiscard]] Eigen::VectorXd push(const Eigen::Ref<const data::SampleMatrix>& temperatures_c,
                                     const Eigen::Ref<const Eigen::VectorXd>& bias_deg_per_h);

  /// Seconds without a row, of which nothing is known. How many they are makes no difference to the time it takes.
  void pass(Eigen::Index seconds);

  /// The same of rows that have a time: seconds that are missing between them are passed. A logger's second may be a
  /// little off. `time_s` rises, also from what was pushed before.
  [[nodiscard]] Eigen::VectorXd push_at(const Eigen::Ref<const Eigen::VectorXd>& time_s,
                                        const Eigen::Ref<const data::SampleMatrix>& temperatures_c,
                                        const Eigen::Ref<const Eigen::VectorXd>& bias_deg_per_h);
  /// Seconds that are missing before one of the rows that push_at() took last.
  struct Gap {
    Eigen::Index row{}, seconds{};
  };
  [[nodiscard]] const std::vector<Gap>& gaps() const { return gaps_; }

  /// How many rows so far had an input outside the trained range.
  [[nodiscard]] long long outside() const { return outside_; }
  /// Of the rows last pushed, those with an input outside, rising; the first is 0.
  [[nodiscard]] const std::vector<Eigen::Index>& rows_outside() const { return rows_outside_; }
  /// Returns the excess of each row last pushed: the distance of its worst input from its range, in ranges; 0 inside.
  [[nodiscard]] const Eigen::VectorXd& excess() const { return excess_; }

 private:
  CompensationStream(const Model& model, std::vector<std::string> columns, const std::vector<SlidingLags::Of>& lags,
                     Outside policy);
  [[nodiscard]] Eigen::VectorXd led(Eigen::VectorXd predicted);
  Model model_;  ///< with the lags as temperatures
  Outside policy_;
  SlidingMeans means_;
  bool rates_{};  ///< the model asks for them
  SlidingLags lags_;
  data::SampleMatrix past_;  ///< the means of the last cluster length, as a ring; only where rates are asked for
  Eigen::Index pushed_{};    ///< rows in all
  long long outside_{};
  std::vector<Eigen::Index> rows_outside_;
  Eigen::VectorXd excess_;
  /// A ring of the predictions of the last cluster length; empty if the model is not led.
  Eigen::VectorXd told_;
  std::optional<double> last_s_;  ///< the time of the row that push_at() took last
  std::vector<Gap> gaps_;
  data::Clusters latest_;  ///< the means of the rows last pushed, and after them the lags
};

/// Computes what the lag of half a cluster length costs, from means that follow each other: with p the predictions,
/// half the root mean square of p_k − p_{k−1} where nothing is done, and of p_k − 2 p_{k−1} + p_{k−2} where the
/// prediction is led, p + ½(p − p before). Noise of the thermometers is in both, so that a model whose lead would cost
/// more noise than it gains is not led. Nothing of fewer than three means in a row.
[[nodiscard]] std::optional<Latency> latency_of(const Model& model, const data::Clusters& clusters,
                                                const Eigen::VectorXd& predicted_deg_per_h);

}  // namespace gyrotherm::model
