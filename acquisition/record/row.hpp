// SPDX-License-Identifier: Apache-2.0
/// The rows of a record: what one call of Store puts in (the rows of a second, of a gap, or of an event that came
/// alone), and how they come out of the file.
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

// What one call of Store puts into the record: the rows of a second, of a gap, or of an event that came alone.

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
/// A temperature as a record has it: NaN is not known.
[[nodiscard]] std::optional<Celsius> unless_nan(double celsius);

/// What a unit under test measured in one second.
struct UnitRow {
  std::vector<double> rotation{};  ///< of each axis: pulses, or a foreign record's number
  std::optional<Duration> interval{};
  std::vector<double> values{};               ///< its housekeeping
  std::vector<double> true_bias_deg_per_h{};  ///< virtual rig, of each axis
};

/// A row of the table `sample`, as written and as read; NaN or nothing is stored as NULL. An imported record has no
/// progress and no state.
struct SampleRow {
  std::int64_t slot{};
  Duration monotonic{};
  std::optional<Duration> utc{};
  double chamber_air_c{kMissing};
  double chamber_set_point_c{kMissing};
  std::vector<double> thermometers_c{};
  std::vector<UnitRow> units{};
  std::optional<ProfilePosition> progress{};
  std::optional<RunState> state{};
};

/// One in which nothing is known yet, with a place for everything that the record has.
[[nodiscard]] SampleRow empty_row(const RunInfo& info);

/// An event and the second that it belongs to.
struct RecordedEvent {
  std::int64_t slot{};
  Event event;
};

struct Entry {
  struct MissingReading {
    std::string channel;
    Fault fault;
  };
  std::int64_t first{};  ///< slots that it accounts for; none if after `last`
  std::int64_t last{};   ///< events belong to this one
  std::optional<SampleRow> sample{};
  std::string gap_cause{};  ///< where there is no sample
  std::vector<MissingReading> missing{};
  std::vector<Event> events{};

  [[nodiscard]] bool is_gap() const { return !sample && first <= last; }
  [[nodiscard]] std::int64_t slots() const { return last - first + 1; }
};

[[nodiscard]] Entry entry_of(const Sample& sample, std::span<const Event> events, const RunInfo& info);
[[nodiscard]] Entry gap_entry(std::int64_t first, std::int64_t last, const std::string& cause);
/// An event after slot `last`.
[[nodiscard]] Entry event_entry(std::int64_t last, const Event& event);

// The rows of a record as they come out of the file.

struct Record;

/// What of the samples is wanted.
struct Wanted {
  std::string unit{};       ///< what was measured of the rig and of this unit; empty: everything
  std::int64_t after = -1;  ///< … behind this second
};

/// A column of the samples as a text table has it. Without a title it has none.
struct Exported {
  const char* title = nullptr;
  Cell (*cell)(const Record& record, std::size_t row) = nullptr;
};

/// One column of a table: the one place where it is named. Schema, insert, hash chain, reading and export follow it.
template <class Row>
struct Column {
  const char* name;
  const char* type;
  Cell (*cell)(const Row& row);
  /// Puts a value that is not NULL into a row.
  void (*take)(Row& row, const Statement& from, int column);
  Exported exported{};
  const char* unit = "";  ///< of a channel that the chamber measures; empty: it is none
};
/// The columns of `sample` that every record has: before those of its channels, and after them.
[[nodiscard]] std::span<const Column<SampleRow>> columns_before_channels();
[[nodiscard]] std::span<const Column<SampleRow>> columns_after_channels();

/// What a channel measures that is not the chamber's.
enum class Measures { temperature, rotation, interval, value, true_bias };
[[nodiscard]] const char* name(Measures measures);
/// The type of the column of such a channel.
[[nodiscard]] const char* type_of(Measures measures);

/// A column of `sample` that the record's own channels make.
struct ChannelColumn {
  std::string name;
  Measures measures{};
  std::size_t unit{};   ///< under test; of a temperature none
  std::size_t index{};  ///< of the thermometer, or among the axes or values of the unit
};
/// In the order of the table: thermometers, then what each unit measured, and, behind the columns after them, the true
/// biases. A thermometer's column is named as it is; a unit's have its label before them, but for the one gyro of a rig
/// file that names none: "pulses", "u1.x.pulses".
[[nodiscard]] std::vector<ChannelColumn> channel_columns(const RunInfo& info);

/// … of one record.
struct Selection {
  std::vector<bool> thermometers, units;  ///< of each, whether
  std::int64_t after{};
  [[nodiscard]] bool has(const ChannelColumn& column) const {
    return column.measures == Measures::temperature ? thermometers[column.index] : units[column.unit];
  }
};
[[nodiscard]] Selection select(const RunInfo& info, const Wanted& wanted);

/// Columns of `sample` but its link of the chain, of one record: all, or those of the channels that are selected.
class SampleColumns {
 public:
  explicit SampleColumns(const RunInfo& info) : SampleColumns(info, select(info, {})) {}
  SampleColumns(const RunInfo& info, const Selection& selection);

  [[nodiscard]] std::span<const ChannelColumn> channels() const { return channels_; }
  /// Each in order, with its type.
  void each(const std::function<void(std::string_view name, std::string_view type)>& use) const;
  /// Quoted where they need it, joined by commas.
  [[nodiscard]] std::string names() const;
  [[nodiscard]] std::size_t count() const;
  /// What a row has in each, into as many cells; units and thermometers of the row as many as the record's.
  void read_cells(const SampleRow& row, std::span<Cell> cells) const;
  /// Puts the row that stands in the first columns of a statement which asked for names() into one of the record,
  /// whose channels that are not selected stay as they are.
  void read(SampleRow& row, const Statement& from) const;

 private:
  std::vector<ChannelColumn> channels_;
  std::size_t before_progress_{};  ///< channels
};

/// The columns of `event` between its id and its link of the chain.
[[nodiscard]] std::span<const Column<RecordedEvent>> columns_of_events();

/// The columns of a table of that list, joined by commas.
template <class Row>
[[nodiscard]] std::string names_of(std::span<const Column<Row>> columns) {
  std::string names;
  for (const auto& column : columns) names += (names.empty() ? "" : ", ") + std::string(column.name);
  return names;
}

/// Takes the values of those columns into a row in which nothing is known yet; the first stands at column `i` of the
/// statement, which is counted on.
template <class Row>
void take(Row& row, std::span<const Column<Row>> columns, const Statement& from, int& i) {
  for (const auto& column : columns) {
    if (!from.null(i)) column.take(row, from, i);
    ++i;
  }
}

/// Calls `use` with what is selected of each sample, in order of slots; the row is overwritten by the next.
[[nodiscard]] Result<void> each_sample(Database& database, const RunInfo& info, const Selection& selection,
                                       const std::function<void(const SampleRow&)>& use);

/// Whether a run's clock, or the wall's, could show it, until 2116: differences of such times do not overflow.
[[nodiscard]] constexpr bool is_possible_time(Duration time) {
  return time >= Duration{} && time <= Duration(std::int64_t{1} << 62);
}

/// The last sample, if there is one.
[[nodiscard]] Result<std::optional<SampleRow>> last_row(Database& database, const RunInfo& info);

/// The last slot that has a sample or lies in a gap; −1 if none.
[[nodiscard]] Result<std::int64_t> last_slot(Database& database);

/// The reverse of name(…); an unknown name gives the first of them.
[[nodiscard]] EventKind event_kind_named(std::string_view text);

}  // namespace gyrotherm::record
