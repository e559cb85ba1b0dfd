// SPDX-License-Identifier: Apache-2.0
/// The rows of a record, for Store, which writes them, and for readers. Each call of Store writes one entry: the rows
/// of one second, of a gap, or of a separate event.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

// The entries that Store writes.

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
/// Returns a temperature from a record; nothing if it is NaN.
[[nodiscard]] std::optional<Celsius> celsius_if_known(double celsius);

/// The measurements of a unit under test in one second.
struct UnitRow {
  /// The pulses of each axis in the second, or the number that an imported record stores for it.
  std::vector<double> rotation{};
  std::optional<Duration> interval{};
  /// The values that the unit and analogue inputs measured.
  std::vector<double> values{};
  /// The true bias of each axis of a virtual unit.
  std::vector<double> true_bias_deg_per_h{};
};

/// A row of the table `sample`. NaN and empty optionals are stored as NULL. An imported record has neither progress nor
/// state.
struct SampleRow {
  std::int64_t slot{};
  Duration monotonic{};
  std::optional<Duration> utc{};
  double chamber_air_c{kMissing};
  double chamber_set_point_c{kMissing};
  /// The row of a record without these channels does not contain them.
  double chamber_humidity_percent{kMissing};
  double chamber_dew_point_c{kMissing};
  std::vector<double> thermometers_c{};
  std::vector<UnitRow> units{};
  std::optional<ProfilePosition> progress{};
  std::optional<RunState> state{};
};

/// Returns a row without values, sized for all channels of the record.
[[nodiscard]] SampleRow empty_row(const RunInfo& info);

/// An event and its second.
struct RecordedEvent {
  std::int64_t slot{};
  Event event;
};

/// The rows that one call of Store writes, for a second, a gap or a separate event.
struct Entry {
  struct MissingReading {
    std::string channel;
    Fault fault;
  };
  /// The slots of the entry; none if `first` is after `last`. The events of the entry belong to slot `last`.
  std::int64_t first{};
  std::int64_t last{};
  std::optional<SampleRow> sample{};
  /// The cause of the gap for an entry without a sample.
  std::string gap_cause{};
  std::vector<MissingReading> missing{};
  std::vector<Event> events{};
  /// The segments that the event, a decision, adds to the profile.
  std::vector<RunInfo::SegmentInfo> segments{};

  [[nodiscard]] bool is_gap() const { return !sample && first <= last; }
  [[nodiscard]] std::int64_t slots() const { return last - first + 1; }
};

/// Returns the entry of one second.
[[nodiscard]] Entry sample_entry(const Sample& sample, std::span<const Event> events, const RunInfo& info);
/// Returns the entry of a gap.
[[nodiscard]] Entry gap_entry(std::int64_t first, std::int64_t last, const std::string& cause);
/// Returns the entry of an event after slot `last`.
[[nodiscard]] Entry event_entry(std::int64_t last, const Event& event);

// The columns of the tables, and the reading of rows.

struct Record;

/// Selects the seconds and the measurements to read.
struct ReadSelection {
  /// The unit whose measurements are read, in addition to those of the rig. Empty selects all units.
  std::string unit{};
  /// Only the seconds after this one are read.
  std::int64_t after = -1;
};

/// A column of the text export. A column without a title is not exported.
struct Exported {
  const char* title = nullptr;
  Cell (*cell)(const Record& record, std::size_t row) = nullptr;
};

/// One column of a table. Schema, insert statement, hash chain, reader and export all use this single definition.
template <class Row>
struct Column {
  const char* name;
  const char* type;
  Cell (*cell)(const Row& row);
  /// Copies a non-NULL value from the statement to the row.
  void (*take)(Row& row, const Statement& from, int column);
  Exported exported{};
  /// The unit of measurement, if the chamber measures the column; otherwise empty.
  const char* unit = "";
};
/// Return the columns of `sample` that every record has, before and after the columns of its channels.
[[nodiscard]] std::span<const Column<SampleRow>> columns_before_channels();
[[nodiscard]] std::span<const Column<SampleRow>> columns_after_channels();

/// The quantity that a channel measures, for channels that not every record has. Humidity and dew point are the
/// chamber's.
enum class Measures { temperature, rotation, interval, value, true_bias, humidity, dew_point };
[[nodiscard]] const char* name(Measures measures);
[[nodiscard]] constexpr bool is_of_chamber(Measures measures) {
  return measures == Measures::humidity || measures == Measures::dew_point;
}
[[nodiscard]] constexpr bool is_of_unit(Measures measures) {
  return measures != Measures::temperature && !is_of_chamber(measures);
}
/// Returns the SQL type of the column of such a channel.
[[nodiscard]] const char* sql_type(Measures measures);

/// A column of `sample` that depends on the record's channels.
struct ChannelColumn {
  std::string name;
  Measures measures{};
  std::size_t unit{};  ///< unused for a temperature or a channel of the chamber
  /// The index of the thermometer, or the index among the axes or values of the unit.
  std::size_t index{};
};
/// Returns the columns that depend on the channels, in the order of the table: humidity and dew point of the
/// chamber, if it measures them, thermometers, then the measurements of each unit, then, after
/// columns_after_channels(), the true biases. The column of a thermometer has the name of the thermometer. The columns
/// of a unit start with its label ("u1.x.pulses"), except in a rig file with a single unnamed gyro ("pulses").
[[nodiscard]] std::vector<ChannelColumn> channel_columns(const RunInfo& info);

/// The selected thermometers, units and seconds of one record.
struct Selection {
  /// True if selected: one flag per thermometer, one per unit.
  std::vector<bool> thermometers, units;
  std::int64_t after{};
  [[nodiscard]] bool has(const ChannelColumn& column) const {
    if (is_of_chamber(column.measures)) return true;
    return column.measures == Measures::temperature ? thermometers[column.index] : units[column.unit];
  }
};
[[nodiscard]] Selection select(const RunInfo& info, const ReadSelection& wanted);

/// The columns of `sample` in one record, for all channels or only the selected ones. The column `chain` is not
/// included.
class SampleColumns {
 public:
  explicit SampleColumns(const RunInfo& info) : SampleColumns(info, select(info, {})) {}
  SampleColumns(const RunInfo& info, const Selection& selection);

  [[nodiscard]] std::span<const ChannelColumn> channels() const { return channels_; }
  /// Calls `use` with the name and the type of each column, in order.
  void each(const std::function<void(std::string_view name, std::string_view type)>& use) const;
  /// Returns the column names in quotes, joined by commas.
  [[nodiscard]] std::string names() const;
  [[nodiscard]] std::size_t count() const;
  /// Writes the values of a row to `cells`, one per column. The row must have all units and thermometers of the record.
  void read_cells(const SampleRow& row, std::span<Cell> cells) const;
  /// Reads a row from the first columns of a statement that selected names(). Leaves channels that are not selected
  /// unchanged.
  void read(SampleRow& row, const Statement& from) const;

 private:
  std::vector<ChannelColumn> channels_;
  /// The number of channels before columns_after_channels().
  std::size_t before_progress_{};
};

/// Returns the columns of `event`, except the first, its id, and the last, `chain`.
[[nodiscard]] std::span<const Column<RecordedEvent>> event_columns();

/// Returns the names of the columns, joined by commas.
template <class Row>
[[nodiscard]] std::string column_names(std::span<const Column<Row>> columns) {
  std::string names;
  for (const auto& column : columns) names += (names.empty() ? "" : ", ") + std::string(column.name);
  return names;
}

/// Reads the values of the columns into an empty row. The values start at column `i` of the statement. Advances `i`
/// past them.
template <class Row>
void take(Row& row, std::span<const Column<Row>> columns, const Statement& from, int& i) {
  for (const auto& column : columns) {
    if (!from.null(i)) column.take(row, from, i);
    ++i;
  }
}

/// Calls `use` with the selected part of each sample, in order of slots. A row is valid only during the call.
[[nodiscard]] Result<void> each_sample(Database& database, const RunInfo& info, const Selection& selection,
                                       const std::function<void(const SampleRow&)>& use);

/// Returns whether a time is between 0 and 2^62 ns, which as UTC is 1970 to 2116. Differences of such times do not
/// overflow.
[[nodiscard]] constexpr bool is_possible_time(Duration time) {
  return time >= Duration{} && time <= Duration(std::int64_t{1} << 62);
}

/// Returns the last sample; nothing if there is none.
[[nodiscard]] Result<std::optional<SampleRow>> last_row(Database& database, const RunInfo& info);

/// Returns the last slot with a sample or in a gap; −1 if there is none.
[[nodiscard]] Result<std::int64_t> last_slot(Database& database);

/// Returns the event kind with this name, or EventKind::started if the name is unknown.
[[nodiscard]] EventKind find_event_kind(std::string_view text);

}  // namespace gyrotherm::record
