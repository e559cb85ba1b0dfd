// SPDX-License-Identifier: Apache-2.0
/// Which columns of a text table `compensate` reads, and what makes temperatures and a bias of them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/features.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// A table of temperatures and a bias: one with a header like "A,B,C,bias" and perhaps a last column "at_rest", or the
/// text that `export` makes of a record, whose readings are calibrated, and whose rotation becomes a bias, by what its
/// comments say.
class CompensationTable {
 public:
  /// Fails with bad_file (a header that is neither; a table of export that does not say the Earth's rate) or usage (a
  /// table without an input of the model or without the axis). `tracked`: a column "at_rest" may be there.
  [[nodiscard]] static Result<CompensationTable> of(const std::vector<std::string>& header,
                                                    const std::vector<std::string>& comments, const model::Model& model,
                                                    const data::AxisChoice& axis, bool tracked);

  /// The columns to be read: the temperatures, then what the bias is made of, then perhaps at_rest or, of a table of
  /// export, the time and the slot.
  [[nodiscard]] const std::vector<std::size_t>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<std::string>& thermometers() const { return thermometers_; }
  [[nodiscard]] bool says_rest() const { return says_rest_; }
  /// Whether it is of export and says in which second each row was; of any other, rows are a second apart.
  [[nodiscard]] bool says_second() const { return rotation_.has_value(); }

  /// Of rows of columns(): temperatures in °C, the bias in °/h, whether the gyro was at rest, and the slot, where the
  /// table says it.
  [[nodiscard]] data::SampleMatrix temperatures_c(const Eigen::Ref<const data::SampleMatrix>& rows) const;
  [[nodiscard]] Eigen::VectorXd bias_deg_per_h(const Eigen::Ref<const data::SampleMatrix>& rows) const;
  [[nodiscard]] bool at_rest(const Eigen::Ref<const data::SampleMatrix>& rows, Eigen::Index row) const;
  [[nodiscard]] Eigen::VectorXd slot(const Eigen::Ref<const data::SampleMatrix>& rows) const;
  /// Seconds since the run started, of a table of export.
  [[nodiscard]] Eigen::VectorXd time_s(const Eigen::Ref<const data::SampleMatrix>& rows) const;

 private:
  [[nodiscard]] Eigen::Index temperatures() const { return static_cast<Eigen::Index>(thermometers_.size()); }

  std::vector<std::size_t> columns_;
  std::vector<std::string> thermometers_;
  std::vector<record::Channel> calibrations_;  ///< of each thermometer; empty of a table that is calibrated
  struct Rotation {
    double scale{}, earth_rate_deg_per_h{};
    bool over_interval{};  ///< pulses, with a column of the interval after them
    bool may_be_turned{};  ///< with a column after these of how the unit was mounted, by which the Earth's rate counts
  };
  std::optional<Rotation> rotation_;  ///< nothing: the column is a bias
  bool says_rest_ = false;
};

}  // namespace gyrotherm::app
