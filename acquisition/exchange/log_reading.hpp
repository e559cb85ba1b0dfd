// SPDX-License-Identifier: Apache-2.0
/// What readers of autopilots' logs have in common: which fields of which messages are wanted, and rows made of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/log_column.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

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
