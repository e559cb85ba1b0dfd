// SPDX-License-Identifier: Apache-2.0
/// Counts the values of an imported file per channel and judges whether they fit the map.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// One channel of a record that was imported, with what its column had.
struct ChannelSummary {
  std::string name{};    ///< in the record: "T1", "gyro", "imu.x"
  std::string column{};  ///< in words
  std::string unit{};    ///< unit of least and greatest
  std::size_t values{}, missing{};
  MissingTexts missing_texts{};
  std::size_t outside{};  ///< missing: outside the valid range
  double least = std::numeric_limits<double>::quiet_NaN(), greatest = std::numeric_limits<double>::quiet_NaN();
};

/// "T1: 1080 values, 19.98 to 40.3 °C, 2 missing ("---" 2)".
[[nodiscard]] std::string in_words(const ChannelSummary& channel);

/// Looks at each number of a file.
class ChannelTally {
 public:
  explicit ChannelTally(const ImportMap& map);
  /// Makes push() fail at a number that its channel cannot have.
  void refuse_impossible() { refuses_impossible_ = true; }

  /// Takes the numbers of a row; those outside of the map's valid ranges become NaN. Fails with bad_file and no place
  /// at a number that is infinite by the map's scale or, where it was told to, that the channel cannot have: a
  /// temperature below absolute zero or above 5000 °C, a rate beyond 10⁸ °/h, or one of 10³⁰ and more, by which
  /// instruments report an overload.
  [[nodiscard]] Result<void> push(std::span<double> numbers);

  /// The channels so far, with the texts that the reader took for missing.
  [[nodiscard]] std::vector<ChannelSummary> channels(const std::vector<MissingTexts>& missing) const;

  /// Puts what people should look at into the notes: a channel without a value, one that never changes, one of whose
  /// values most are missing, and values that lie apart from all others. Fails with bad_file where a model would learn
  /// from what was never measured: an axis without a value; a temperature that a sensor sends when it has none ("-127")
  /// or that lies more than 40 K from all but a few of the others.
  [[nodiscard]] Result<void> judge(const std::string& file, const std::vector<MissingTexts>& missing,
                                   Notes& notes) const;

 private:
  enum class Kind { temperature, rate, increment, value };
  static constexpr std::size_t kExtremes = 9;
  /// The most extreme of the different numbers, in order, and how often each came.
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
    Extremes least{}, greatest{};
  };
  void add(Kind kind, std::string name, const ColumnName& column, std::string unit, double scale, double offset);
  [[nodiscard]] Fault impossible(const Column& column, double number) const;
  [[nodiscard]] Result<void> judge_isolated(const Column& column, const std::string& file, Notes& notes) const;
  [[nodiscard]] std::string way_out(const Column& column, double number) const;

  bool is_text_, is_log_;
  bool refuses_impossible_ = false;
  std::vector<Column> columns_{};
};

}  // namespace gyrotherm::exchange
