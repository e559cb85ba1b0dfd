// SPDX-License-Identifier: Apache-2.0
/// Code shared by the readers of ULog and DataFlash. A column of an autopilot's log is a number in messages of one
/// kind. This code converts messages of several kinds to rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// A field of a message. A log may have several series of the same message, one per sensor (`instance`).
struct LogColumn {
  std::string message;
  unsigned instance{};
  std::string field;
};

/// Parses "sensor_gyro.x" or "sensor_gyro[1].x". Returns nothing for any other name.
[[nodiscard]] std::optional<LogColumn> parse_log_column(std::string_view name);
/// Returns "sensor_gyro" for instance 0, "sensor_gyro[1]" for instance 1.
[[nodiscard]] std::string series_name(std::string_view message, unsigned instance);

/// The type of a number in a message. The least significant byte comes first.
enum class NumberType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float16, float32, float64 };
[[nodiscard]] std::size_t number_size(NumberType type);
/// Returns the number at byte `offset` of a message, which must contain all bytes of the number. Returns NaN for an
/// infinite number.
[[nodiscard]] double number_at(std::string_view message, std::size_t offset, NumberType type);
[[nodiscard]] std::uint64_t whole_number_at(std::string_view message, std::size_t offset, std::size_t bytes);

/// Describes columns that a log does not have, and the alternatives: the fields of the same messages or, if there are
/// none, the names of all messages.
[[nodiscard]] std::string describe_missing_log_columns(const std::vector<LogColumn>& missing,
                                                       const std::vector<LogColumn>& available);

/// The position and type of a number in a message.
struct LogField {
  std::string name;
  std::size_t offset{};  ///< bytes from the message's start
  NumberType type{};
  double scale = 1;  ///< for the stored number
};

/// A series of messages of one kind and sensor.
struct LogSeries {
  std::string message;
  unsigned instance{};
  /// The time; its scale converts it to microseconds.
  LogField time{};
  /// All numeric fields.
  std::vector<LogField> fields{};
  /// The size of a message in bytes.
  std::size_t size{};
};

/// Extracts the columns of a map from messages.
class LogReading {
 public:
  /// Creates a reader for a map. Without a map, it extracts nothing and only lists the columns of the log. A column
  /// name in the map that is not of the form MESSAGE.FIELD matches nothing, and finish() reports it as missing.
  explicit LogReading(const ImportMap* map = nullptr, const TakeRow* take = nullptr);

  /// Adds a series and returns its index. Fails with bad_file if there are more series or fields than a log can have.
  [[nodiscard]] Result<std::size_t> add(const LogSeries& series, const std::string& file);
  /// Passes on a message of a series if the map has a column of it. Counts a message that is shorter than its format or
  /// has an impossible time as damaged. `at` is its position in faults. Fails with bad_file if the columns come from
  /// several messages and the map does not combine them, and as TakeRow does.
  [[nodiscard]] Result<void> take(std::size_t series, std::string_view message, const std::string& file,
                                  std::uint64_t at);
  /// Fails with bad_file if the log lacks a column of the map, has no usable message with such columns, or has more
  /// damaged ones than usable ones.
  [[nodiscard]] Result<void> finish(const std::string& file) const;

  /// Returns whether the map has a column of messages with this name.
  [[nodiscard]] bool selects_message(std::string_view message) const;
  /// Returns the columns of series with at least one message.
  [[nodiscard]] std::vector<LogColumn> published_columns() const;
  [[nodiscard]] std::size_t damaged_messages() const { return damaged_; }

 private:
  struct SelectedField {
    std::size_t column{};  ///< index in the map
    LogField field{};
  };
  struct KnownSeries {
    LogField time{};
    std::size_t size{};
    std::vector<SelectedField> wanted{};
    std::size_t first_column{}, columns{};  ///< range in `there_`
    std::size_t messages{};
  };
  [[nodiscard]] Result<void> check_single_series(std::size_t series, const std::string& file) const;

  const ImportMap* map_;
  const TakeRow* take_;
  std::vector<LogColumn> columns_{};  ///< columns of the map
  std::vector<bool> found_{};
  std::vector<KnownSeries> series_{};
  std::vector<LogColumn> there_{};
  std::vector<double> numbers_{};
  std::size_t rows_{}, damaged_{};
  std::size_t only_{};  ///< series of the first row
  bool counts_since_1970_ = false;
  /// The instant of the first message, if `counts_since_1970_`.
  double origin_us_{};
};

}  // namespace gyrotherm::exchange
