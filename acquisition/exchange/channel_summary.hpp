// SPDX-License-Identifier: Apache-2.0
/// Counts the values of an imported file per channel and checks whether they fit the map.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/repeat_watch.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// A channel of an imported record, with statistics of its column.
struct ChannelSummary {
  /// The name in the record: "T1", "gyro", "imu.x".
  std::string name{};
  /// Name of the column in messages.
  std::string column{};
  /// The unit of `least` and `greatest`.
  std::string unit{};
  std::size_t values{}, missing{};
  MissingTexts missing_texts{};
  std::size_t outside{};  ///< missing values outside the valid range
  double least = std::numeric_limits<double>::quiet_NaN(), greatest = std::numeric_limits<double>::quiet_NaN();
};

/// Describes a channel: "T1: 1080 values, 19.98 to 40.3 °C, 2 missing ("---" 2)".
[[nodiscard]] std::string describe(const ChannelSummary& channel);

/// Limits of possible temperatures and rates. Values outside them are error codes or have another unit.
inline constexpr double kAbsoluteZero_c = -273.15, kHottest_c = 5000, kFastest_deg_per_h = 1e8;

/// Collects the statistics of all numbers of a file.
class ChannelTally {
 public:
  explicit ChannelTally(const ImportMap& map);
  /// Makes push() fail at a number that is impossible for its channel.
  void refuse_impossible() { refuses_impossible_ = true; }

  /// Adds the numbers of a row at `time`, and replaces each number outside the valid range of its column by NaN. Fails
  /// with bad_file, without a position, at a number that becomes infinite with the map's scale. After
  /// refuse_impossible(), also fails at a temperature below absolute zero or above 5000 °C, a rate over 10⁸ °/h, and a
  /// number of 10³⁰ or more, which instruments send for an overload.
  [[nodiscard]] Result<void> push(Duration time, std::span<double> numbers);

  /// Returns the summaries of the channels so far. `missing` has the texts that the reader treated as missing.
  [[nodiscard]] std::vector<ChannelSummary> channels(const std::vector<MissingTexts>& missing) const;

  /// Adds notes for users: channels without a value or with a constant value, channels with many values missing,
  /// outliers far from all other values, and failed sensors (RepeatWatch::warnings). Fails with bad_file if a model
  /// would be trained with invalid data: an axis without a value, a temperature that sensors send instead of a reading
  /// ("-127") however often, or a temperature more than 40 K from all but a few others.
  [[nodiscard]] Result<void> judge(const std::string& file, const std::vector<MissingTexts>& missing,
                                   Notes& notes) const;

 private:
  enum class Kind { temperature, rate, increment, value };
  static constexpr std::size_t kExtremes = 9;
  /// The most extreme distinct numbers, in order, with the count of each.
  struct Extremes {
    std::array<double, kExtremes> numbers{};
    std::array<std::size_t, kExtremes> counts{};
    std::size_t size{};
    void push(double number, double sign);
  };
  struct Column {
    Kind kind{};
    ChannelSummary summary{};
    double scale = 1, offset = 0;
    std::optional<ValidRange> valid{};
    double last = 0;  ///< value
    Extremes least{}, greatest{};
    /// For increments with counting times: the column of these times, and the extreme rates in °/h.
    std::optional<std::size_t> interval{};
    Extremes least_rate{}, greatest_rate{};
  };
  static void push_extremes(double value, Extremes& least, Extremes& greatest);
  void add(Kind kind, std::string name, const ColumnName& column, std::string unit, double scale, double offset);
  /// Returns whether the column probably has more values like this one: it has had few values, or the last one was
  /// near.
  [[nodiscard]] static bool is_like_others(const Column& column, double value);
  [[nodiscard]] Fault impossible_value_fault(const Column& column, double number) const;
  [[nodiscard]] Result<void> check_isolated(const Column& column, const std::string& file, Notes& notes) const;
  /// Returns whether sensors or loggers send this value for an error.
  [[nodiscard]] static bool is_error_value(const Column& column, double value);
  [[nodiscard]] std::string remedy(const Column& column, double number) const;

  bool is_text_, is_log_;
  /// Rows are combined, so that most cells of a column may be empty.
  bool is_combined_;
  bool refuses_impossible_ = false;
  std::vector<Column> columns_{};
  RepeatWatch watch_{};
  std::vector<double> values_{};  ///< the row's values
};

}  // namespace gyrotherm::exchange
