// SPDX-License-Identifier: Apache-2.0
/// Columns that `compensate` reads from a text table, and their conversion to temperatures and bias.
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

/// Table of temperatures and a bias. Either a plain table with a header like "A,B,C,bias" and an optional last column
/// "at_rest", or a record as `export` writes it. The comments of an exported table give the calibration of each
/// thermometer and the conversion of rotation to bias.
class CompensationTable {
 public:
  /// Reads the header. Fails with bad_file if the header is of neither kind, or if an exported table states neither
  /// the Earth rate nor that nothing is removed. Fails with usage if the table has no column for an input of the model
  /// or for the axis. `tracked` permits the column "at_rest".
  [[nodiscard]] static Result<CompensationTable> of(const std::vector<std::string>& header,
                                                    const std::vector<std::string>& comments, const model::Model& model,
                                                    const data::AxisChoice& axis, bool tracked);

  /// Returns the columns to read: the temperatures, the columns of the bias, then at_rest, if any, or the time and slot
  /// of an exported table.
  [[nodiscard]] const std::vector<std::size_t>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<std::string>& thermometers() const { return thermometers_; }
  [[nodiscard]] bool has_at_rest() const { return has_at_rest_; }
  /// Returns whether the table was exported and contains the second of each row. Rows of any other table are one second
  /// apart.
  [[nodiscard]] bool has_seconds() const { return rotation_.has_value(); }

  /// Returns the bias reference of an exported table (data::Dataset::bias_zero); empty if unknown.
  [[nodiscard]] const std::string& bias_zero() const { return bias_zero_; }

  /// Converts rows of columns() to temperatures in °C, the bias in °/h, whether the gyro was at rest, and the slot of
  /// an exported table.
  [[nodiscard]] data::SampleMatrix temperatures_c(const Eigen::Ref<const data::SampleMatrix>& rows) const;
  [[nodiscard]] Eigen::VectorXd bias_deg_per_h(const Eigen::Ref<const data::SampleMatrix>& rows) const;
  [[nodiscard]] bool is_at_rest(const Eigen::Ref<const data::SampleMatrix>& rows, Eigen::Index row) const;
  [[nodiscard]] Eigen::VectorXd slot(const Eigen::Ref<const data::SampleMatrix>& rows) const;
  /// Returns the seconds since the start of the run, for an exported table.
  [[nodiscard]] Eigen::VectorXd time_s(const Eigen::Ref<const data::SampleMatrix>& rows) const;

 private:
  [[nodiscard]] Eigen::Index temperatures() const { return static_cast<Eigen::Index>(thermometers_.size()); }

  std::vector<std::size_t> columns_;
  std::vector<std::string> thermometers_;
  std::string bias_zero_{};
  /// One calibration per thermometer; empty if the table is calibrated already.
  std::vector<record::Channel> calibrations_;
  struct Rotation {
    double scale{}, earth_rate_deg_per_h{};
    bool over_interval{};  ///< pulse counts; an interval column follows
    /// True if a further column contains the mounting, which determines the sign of the Earth rate.
    bool may_be_turned{};
  };
  std::optional<Rotation> rotation_;  ///< empty if the column is bias
  bool has_at_rest_ = false;
};

/// Returns what to do with rows that are `interval_s` apart if one row per second is required.
[[nodiscard]] std::string advice_for_spacing(double interval_s);

}  // namespace gyrotherm::app
