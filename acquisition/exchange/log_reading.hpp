// SPDX-License-Identifier: Apache-2.0
/// Columns of autopilots' logs, which are numbers in messages of many kinds, and the rows that are made of them. The
/// readers of ULog and DataFlash share this file.
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

/// A field of a message. A log may have several series of a message, one for each sensor.
struct LogColumn {
  std::string message;
  unsigned instance{};
  std::string field;
};

/// Parses "sensor_gyro.x" or "sensor_gyro[1].x". Returns nothing for any other name.
[[nodiscard]] std::optional<LogColumn> parse_log_column(std::string_view name);
/// Returns "sensor_gyro" for instance 0, "sensor_gyro[1]" for instance 1.
[[nodiscard]] std::string name_of_series(std::string_view message, unsigned instance);

/// The type of a number in a message. The least significant byte comes first.
enum class NumberType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float16, float32, float64 };
[[nodiscard]] std::size_t size_of(NumberType type);
/// Returns the number at a byte of a message, which must hold all its bytes. Returns NaN for an infinite number.
[[nodiscard]] double number_at(std::string_view message, std::size_t place, NumberType type);
[[nodiscard]] std::uint64_t whole_number_at(std::string_view message, std::size_t place, std::size_t bytes);

/// Describes the columns that a log does not have, with the alternatives: the fields of their messages, or else the
/// messages.
[[nodiscard]] std::string describe_missing_log_columns(const std::vector<LogColumn>& missing,
                                                       const std::vector<LogColumn>& there);

/// A number of a message, as its format says.
struct LogField {
  std::string name;
  std::size_t place{};  ///< bytes from the message's beginning
  NumberType type{};
  double scale = 1;  ///< of the number as it is stored
};

/// A series of messages of one kind and sensor.
struct LogSeries {
  std::string message;
  unsigned instance{};
  LogField time{};                 ///< in microseconds, by its scale
  std::vector<LogField> fields{};  ///< all that are numbers
  std::size_t size{};              ///< bytes of a message
};

/// Picks the wanted columns out of the messages.
class LogReading {
 public:
  /// Without a map nothing is wanted, and what there is can be listed. Names that are no columns of logs are never
  /// found.
  explicit LogReading(const ImportMap* map = nullptr, const TakeRow* take = nullptr);

  /// Makes a series known; the number that stands for it. Fails with bad_file where there are more than a log has.
  [[nodiscard]] Result<std::size_t> add(LogSeries series, const std::string& file);
  /// Hands on a message of a series, if something is wanted of it. One that is too short for its format counts as
  /// damaged. `where` says its place in faults.
  [[nodiscard]] Result<void> take(std::size_t series, std::string_view message, const std::string& file,
                                  std::uint64_t at);
  /// Fails with bad_file if a wanted column never came up, or none of its messages.
  [[nodiscard]] Result<void> finish(const std::string& file) const;

  /// Whether a column of such messages is wanted.
  [[nodiscard]] bool wants(std::string_view message) const;
  [[nodiscard]] const std::vector<LogColumn>& there() const { return there_; }
  /// Those of them of whose series at least one message has come.
  [[nodiscard]] std::vector<LogColumn> published() const;
  [[nodiscard]] std::size_t damaged() const { return damaged_; }

 private:
  struct Wanted {
    std::size_t column{};  ///< of the map
    LogField field{};
  };
  struct Known {
    LogField time{};
    std::size_t size{};
    std::vector<Wanted> wanted{};
    std::size_t first_column{}, columns{};  ///< of those that are there
    std::size_t messages{};
  };
  [[nodiscard]] Result<void> check_alone(std::size_t series, const std::string& file) const;

  const ImportMap* map_;
  const TakeRow* take_;
  std::vector<LogColumn> columns_{};  ///< that are wanted
  std::vector<bool> found_{};
  std::vector<Known> series_{};
  std::vector<LogColumn> there_{};
  std::vector<double> numbers_{};
  std::size_t rows_{}, damaged_{};
  std::size_t only_{};  ///< the series of the first row
  bool counts_since_1970_ = false;
  double origin_us_{};  ///< where it does: the first message
};

}  // namespace gyrotherm::exchange
