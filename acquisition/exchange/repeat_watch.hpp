// SPDX-License-Identifier: Apache-2.0
/// Finds failed sensors in an imported file: a value that is repeated for longer than the noise and the resolution of
/// its channel permit, and a lasting jump of a temperature.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::exchange {

/// Channel of a RepeatWatch.
struct WatchedChannel {
  std::string name{}, unit{};
  bool is_temperature = false;
  /// The rotation of the gyro, which cannot be removed from the map.
  bool is_axis = false;
  /// Value = number of the file × scale + offset.
  double scale = 1, offset = 0;
  /// The map can mark missing values by their text.
  bool has_missing_texts = false;
};

/// Watches the values of a file in order. The memory used does not depend on the number of rows.
class RepeatWatch {
 public:
  void add(WatchedChannel channel) { columns_.emplace_back().about = std::move(channel); }

  /// Takes the values of a row, one per channel; NaN if missing. A missing value does not end a repetition.
  void push(Duration time, std::span<const double> values);

  /// Describes each implausible repetition and each lasting jump: channel, rows, times, value, and the remedy in the
  /// map. A constant channel at rest with a coarse resolution is not reported, unless another temperature moves far.
  [[nodiscard]] Notes warnings() const;

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  static constexpr std::size_t kRuns = 8, kSteps = 9, kBlocks = 1024, kFirstRowsOfBlock = 32;

  /// A row of the file, counted from 0, and its time.
  struct Moment {
    std::size_t row{};
    Duration time{};
  };
  /// Consecutive equal values.
  struct Run {
    double value = kNone;
    std::size_t count{};
    Moment first{}, last{};
    double before = kNone, after = kNone;  ///< the values next to it
  };
  /// A step between two values.
  struct Step {
    double from{}, to{};
    Moment at{};
    std::size_t seen{}, stayed{};  ///< later values, and those near `to`
    [[nodiscard]] double size() const;
  };
  /// Statistics of the values of several consecutive rows.
  struct Block {
    double least = std::numeric_limits<double>::infinity(), greatest = -std::numeric_limits<double>::infinity();
    double sum{};
    std::size_t values{};
    double steps_sum{}, steps_squared{};
    std::size_t pairs{}, equal_pairs{};
    std::size_t reversals{};  ///< reversals of the direction
    void join(const Block& next);
  };
  struct Column {
    WatchedChannel about{};
    Run run{};
    std::vector<Run> longest{};  ///< the longest first
    std::vector<Step> steps{};   ///< the largest first
    Duration spacing{};          ///< time between its last two values
    double last_step{};          ///< the last one other than 0
    double resolution = std::numeric_limits<double>::infinity();
    std::vector<Block> blocks{};
  };
  /// Properties of a channel outside a repetition.
  struct Usual {
    double noise{};       ///< std of one value, from steps
    double step{};        ///< rms step
    double equal_part{};  ///< part of equal pairs; most blocks have at most this part
    double reversals{};   ///< part of steps that change the direction, upper quartile of the blocks
    std::size_t values{};
    double least{}, greatest{};
  };
  /// The motion of another temperature during a repetition.
  struct Motion {
    std::string name{};
    double least{}, greatest{};
  };

  void take(Column& column, double value, Moment at);
  void take_step(Column& column, double value, Moment at);
  void merge_blocks();
  static void keep(Column& column, const Run& run);
  [[nodiscard]] bool overlaps(const Run& run, std::size_t block) const;
  [[nodiscard]] std::optional<Usual> usual_outside(const Column& column, const Run& run) const;
  [[nodiscard]] std::optional<Motion> motion_during(const Column& column, const Run& run, const Usual& usual) const;
  [[nodiscard]] double largest_motion(const Column& column, const Run& run) const;
  [[nodiscard]] bool stands_out(const Column& column, const Run& run) const;
  [[nodiscard]] bool is_beyond_noise(const Column& column, const Run& run, const Usual& usual) const;
  /// The reason why a repetition is implausible.
  struct Finding {
    std::string evidence{};
    bool is_error_value = false;  ///< the value is not a reading
  };
  [[nodiscard]] std::optional<Finding> judge(const Column& column, const Run& run) const;
  [[nodiscard]] std::string describe(const Column& column, const Run& run, const Finding& finding) const;
  void add_jumps(const Column& column, const std::vector<Run>& reported, Notes& notes) const;

  std::vector<Column> columns_{};
  std::size_t rows_{};
  std::size_t rows_of_block_ = kFirstRowsOfBlock;
  Moment last_{};
};

}  // namespace gyrotherm::exchange
