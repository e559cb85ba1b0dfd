// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/row.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <concepts>
#include <initializer_list>
#include <type_traits>
#include <utility>

#include "acquisition/record/record.hpp"

namespace gyrotherm::record {

namespace {

/// Returns the row of a unit. Values measured by analogue inputs follow those that the unit sent, which may be missing.
UnitRow make_row(const UnitReading& reading, const UnitInfo& unit) {
  UnitRow row;
  if (const auto& count = reading.count.value) {
    row.rotation.assign(count->pulses.begin(), count->pulses.end());
    if (!count->pulses.empty()) row.interval = count->interval;
    row.values = count->values;
  }
  if (!reading.analogue.empty()) row.values.resize(unit.values.size() - reading.analogue.size(), kMissing);
  for (const auto& analogue : reading.analogue) row.values.push_back(analogue.value.value_or(kMissing));
  for (const auto bias : reading.true_bias) row.true_bias_deg_per_h.push_back(bias.value);
  return row;
}

SampleRow make_row(const Sample& sample, const RunInfo& info) {
  SampleRow row{.slot = sample.slot, .monotonic = sample.at.since_start, .utc = sample.at.utc};
  if (const auto& chamber = sample.chamber.value) {
    row.chamber_air_c = chamber->air.value;
    row.chamber_set_point_c = chamber->set_point.value;
    row.chamber_humidity_percent = chamber->humidity_percent.value_or(kMissing);
    row.chamber_dew_point_c = chamber->dew_point.value_or(Celsius{kMissing}).value;
  }
  row.thermometers_c.reserve(sample.thermometers.size());
  for (const auto& reading : sample.thermometers)
    row.thermometers_c.push_back(reading.value.value_or(Celsius{kMissing}).value);
  row.progress = sample.progress;
  row.state = sample.state;
  for (std::size_t i = 0; i < sample.units.size(); ++i) row.units.push_back(make_row(sample.units[i], info.units[i]));
  return row;
}

template <class T>
void add_missing(Entry& entry, const std::string& channel, const Reading<T>& reading) {
  if (!reading.value) entry.missing.push_back({channel, reading.value.error()});
}

/// Adds the faults of a unit. Each value measured by an analogue input is a channel of its own. These values are the
/// last ones of the unit.
void add_missing(Entry& entry, const UnitInfo& unit, const UnitReading& reading) {
  add_missing(entry, unit.name, reading.count);
  const auto sent = unit.values.size() - reading.analogue.size();
  for (std::size_t i = 0; i < reading.analogue.size(); ++i)
    add_missing(entry, unit.name + "." + unit.values[sent + i].name, reading.analogue[i]);
}

}  // namespace

Entry sample_entry(const Sample& sample, std::span<const Event> events, const RunInfo& info) {
  Entry entry{.first = sample.slot, .last = sample.slot, .sample = make_row(sample, info)};
  entry.events.assign(events.begin(), events.end());
  add_missing(entry, "chamber", sample.chamber);
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    add_missing(entry, info.thermometers[i].name, sample.thermometers[i]);
  for (std::size_t i = 0; i < sample.units.size(); ++i) add_missing(entry, info.units[i], sample.units[i]);
  return entry;
}

Entry gap_entry(std::int64_t first, std::int64_t last, const std::string& cause) {
  return {.first = first, .last = last, .gap_cause = cause};
}

Entry event_entry(std::int64_t last, const Event& event) {
  return {.first = last + 1, .last = last, .events = {event}};
}

namespace {

template <class Kind>
Kind find_kind(std::string_view text, std::initializer_list<Kind> kinds) {
  const auto* found = std::find_if(kinds.begin(), kinds.end(), [&](Kind kind) { return text == name(kind); });
  return found == kinds.end() ? *kinds.begin() : *found;
}

// Conversions of a value to a cell. An empty text becomes NULL.
Cell to_cell(double number) { return number; }
Cell to_cell(Celsius temperature) { return temperature.value; }
Cell to_cell(Duration time) { return time.count(); }
Cell to_cell(const std::string& text) { return text.empty() ? Cell() : Cell(std::string_view(text)); }
Cell to_cell(std::integral auto number) { return std::int64_t{number}; }
template <class Enum>
requires std::is_enum_v<Enum> Cell to_cell(Enum enumerator) { return std::string_view(name(enumerator)); }
template <class T>
Cell to_cell(const std::optional<T>& value) {
  return value ? to_cell(*value) : Cell();
}

// Conversions of a cell to a value.
using From = const Statement&;
void take_value(double& number, From from, int i) { number = from.real(i); }
void take_value(Celsius& temperature, From from, int i) { temperature = Celsius{from.real(i)}; }
void take_value(Duration& time, From from, int i) { time = Duration(from.integer(i)); }
void take_value(std::string& text, From from, int i) { text = from.text(i); }
void take_value(Phase& phase, From from, int i) { phase = find_kind(from.text(i), kPhases); }
void take_value(RunState& state, From from, int i) { state = find_kind(from.text(i), kRunStates); }
void take_value(EventKind& kind, From from, int i) { kind = find_event_kind(from.text(i)); }
template <std::integral T>
void take_value(T& number, From from, int i) {
  number = static_cast<T>(from.integer(i));
}
template <class T>
void take_value(std::optional<T>& value, From from, int i) {
  take_value(value.emplace(), from, i);
}

/// Follows a path of members and returns the cell of the last one; NULL if the row has no progress.
template <auto First, auto... Rest>
Cell cell_at(const auto& of) {
  const auto& member = of.*First;
  if constexpr (sizeof...(Rest) == 0)
    return to_cell(member);
  else if constexpr (requires { member.has_value(); })
    return member ? cell_at<Rest...>(*member) : Cell();
  else
    return cell_at<Rest...>(member);
}
template <auto First, auto... Rest>
void take_at(auto& of, From from, int i) {
  auto& member = of.*First;
  if constexpr (sizeof...(Rest) == 0)
    take_value(member, from, i);
  else if constexpr (requires { member.has_value(); })
    take_at<Rest...>(member ? *member : member.emplace(ProfilePosition{.set_point = Celsius{kMissing}}), from, i);
  else
    take_at<Rest...>(member, from, i);
}
template <class Row, auto... Path>
constexpr Column<Row> column(const char* name, const char* type, Exported exported = {}, const char* unit = "") {
  constexpr auto cell = [](const Row& row) { return cell_at<Path...>(row); };
  constexpr auto take = [](Row& row, From from, int i) { take_at<Path...>(row, from, i); };
  return {name, type, cell, take, exported, unit};
}

template <auto Column>
Cell cell_in_record(const Record& record, std::size_t row) {
  return to_cell((record.*Column)[row]);
}
Cell segment_in_record(const Record& record, std::size_t row) {
  const auto* segment = segment_at(record, row);
  return segment != nullptr ? to_cell(segment->name) : Cell();
}
Cell cycle_in_record(const Record& record, std::size_t row) {
  const auto index = static_cast<std::size_t>(record.progress[row].cycle);
  return index < record.info.cycles.size() ? to_cell(record.info.cycles[index]) : Cell();
}
Cell phase_in_record(const Record& record, std::size_t row) {
  return record.info.imported ? Cell() : to_cell(record.progress[row].phase);
}
constexpr std::array kBeforeChannels{
    column<SampleRow, &SampleRow::slot>("slot", "INTEGER PRIMARY KEY", {"slot", cell_in_record<&Record::slot>}),
    column<SampleRow, &SampleRow::monotonic>("monotonic_ns", "INTEGER NOT NULL",
                                             {"time [s]", cell_in_record<&Record::time_s>}),
    column<SampleRow, &SampleRow::utc>("utc_ns", "INTEGER"),
    column<SampleRow, &SampleRow::progress, &ProfilePosition::set_point>(
        "set_point_c", "REAL", {"set point [°C]", cell_in_record<&Record::set_point_c>}),
    column<SampleRow, &SampleRow::chamber_air_c>("chamber_air_c", "REAL",
                                                 {"chamber air [°C]", cell_in_record<&Record::chamber_air_c>}, "°C"),
    column<SampleRow, &SampleRow::chamber_set_point_c>(
        "chamber_set_point_c", "REAL", {"chamber set point [°C]", cell_in_record<&Record::chamber_set_point_c>}, "°C"),
};
constexpr std::array kAfterChannels{
    column<SampleRow, &SampleRow::progress, &ProfilePosition::segment>("segment", "INTEGER",
                                                                       {"segment", segment_in_record}),
    column<SampleRow, &SampleRow::progress, &ProfilePosition::cycle>("cycle", "INTEGER", {"cycle", cycle_in_record}),
    column<SampleRow, &SampleRow::progress, &ProfilePosition::phase>("phase", "TEXT", {"phase", phase_in_record}),
    column<SampleRow, &SampleRow::progress, &ProfilePosition::in_segment>("in_segment_ns", "INTEGER"),
    column<SampleRow, &SampleRow::progress, &ProfilePosition::soaked>("soaked_ns", "INTEGER"),
    column<SampleRow, &SampleRow::state>("state", "TEXT"),
};

constexpr std::array kEventColumns{
    column<RecordedEvent, &RecordedEvent::slot>("slot", "INTEGER NOT NULL"),
    column<RecordedEvent, &RecordedEvent::event, &Event::at, &Instant::since_start>("monotonic_ns", "INTEGER NOT NULL"),
    column<RecordedEvent, &RecordedEvent::event, &Event::at, &Instant::utc>("utc_ns", "INTEGER NOT NULL"),
    column<RecordedEvent, &RecordedEvent::event, &Event::kind>("kind", "TEXT NOT NULL"),
    column<RecordedEvent, &RecordedEvent::event, &Event::about, &EventSubject::interlock>("interlock", "TEXT"),
    column<RecordedEvent, &RecordedEvent::event, &Event::about, &EventSubject::reaction>("reaction", "TEXT"),
    column<RecordedEvent, &RecordedEvent::event, &Event::about, &EventSubject::segment>("segment", "INTEGER"),
    column<RecordedEvent, &RecordedEvent::event, &Event::about, &EventSubject::channel>("channel", "TEXT"),
    // The column is NOT NULL, so an empty text is stored as an empty text.
    Column<RecordedEvent>{"text", "TEXT NOT NULL",
                          [](const RecordedEvent& row) { return Cell(std::string_view(row.event.text)); },
                          [](RecordedEvent& row, From from, int i) { row.event.text = from.text(i); }},
};

/// Returns the column name with the label of the unit or axis. The single unnamed gyro of a rig file has no label.
std::string label_column(const std::string& label, const char* what) {
  return label == kOnlyUnit ? what : fmt::format("{}.{}", label, what);
}

bool has_possible_times(const SampleRow& row) {
  const auto& progress = row.progress;
  return is_possible_time(row.monotonic) && (!row.utc || is_possible_time(*row.utc)) &&
         (!progress || (is_possible_time(progress->in_segment) && is_possible_time(progress->soaked)));
}

}  // namespace

std::optional<Celsius> celsius_if_known(double celsius) {
  return std::isnan(celsius) ? std::nullopt : std::optional(Celsius{celsius});
}

SampleRow empty_row(const RunInfo& info) {
  SampleRow row{.thermometers_c = std::vector<double>(info.thermometers.size(), kMissing)};
  for (const auto& unit : info.units)
    row.units.push_back({.rotation = std::vector<double>(unit.axes.size(), kMissing),
                         .values = std::vector<double>(unit.values.size(), kMissing),
                         .true_bias_deg_per_h = std::vector<double>(unit.axes.size(), kMissing)});
  return row;
}

std::span<const Column<SampleRow>> columns_before_channels() { return kBeforeChannels; }
std::span<const Column<SampleRow>> columns_after_channels() { return kAfterChannels; }

const char* name(Measures measures) {
  return enumerator_text<Measures::dew_point>(
      {"temperature", "rotation", "interval", "value", "true bias", "humidity", "dew point"}, measures);
}

const char* sql_type(Measures measures) {
  // NUMERIC, because an imported record may store a rate instead of pulses.
  return enumerator_text<Measures::dew_point>({"REAL", "NUMERIC", "INTEGER", "REAL", "REAL", "REAL", "REAL"}, measures);
}

std::vector<ChannelColumn> channel_columns(const RunInfo& info) {
  std::vector<ChannelColumn> columns;
  if (info.has_humidity) columns.push_back({.name = "chamber_humidity_percent", .measures = Measures::humidity});
  if (info.has_dew_point) columns.push_back({.name = "chamber_dew_point_c", .measures = Measures::dew_point});
  for (std::size_t i = 0; i < info.thermometers.size(); ++i)
    columns.push_back({.name = info.thermometers[i].name, .measures = Measures::temperature, .index = i});
  const auto each_axis = [&](std::size_t unit, Measures measures, const char* what) {
    for (std::size_t i = 0; i < info.units[unit].axes.size(); ++i)
      columns.push_back({label_column(axis_label(info.units[unit], i), what), measures, unit, i});
  };
  for (std::size_t unit = 0; unit < info.units.size(); ++unit) {
    const auto& under_test = info.units[unit];
    each_axis(unit, Measures::rotation, "pulses");
    columns.push_back({label_column(under_test.name, "interval_ns"), Measures::interval, unit, 0});
    for (std::size_t i = 0; i < under_test.values.size(); ++i)
      columns.push_back({under_test.name + "." + under_test.values[i].name, Measures::value, unit, i});
  }
  for (std::size_t unit = 0; unit < info.units.size(); ++unit)
    each_axis(unit, Measures::true_bias, "true_bias_deg_per_h");
  return columns;
}

Selection select(const RunInfo& info, const ReadSelection& wanted) {
  const UnitInfo* only = wanted.unit.empty() ? nullptr : find_unit(info, wanted.unit);
  Selection selection{.thermometers = {}, .units = {}, .after = wanted.after};
  for (const Channel& thermometer : info.thermometers)
    selection.thermometers.push_back(only == nullptr || serves(thermometer, *only));
  for (const UnitInfo& one : info.units) selection.units.push_back(only == nullptr || &one == only);
  return selection;
}

SampleColumns::SampleColumns(const RunInfo& info, const Selection& selection) : channels_(channel_columns(info)) {
  std::erase_if(channels_, [&](const ChannelColumn& column) { return !selection.has(column); });
  before_progress_ = static_cast<std::size_t>(
      std::ranges::find(channels_, Measures::true_bias, &ChannelColumn::measures) - channels_.begin());
}

void SampleColumns::each(const std::function<void(std::string_view, std::string_view)>& use) const {
  for (const auto& column : kBeforeChannels) use(column.name, column.type);
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (i == before_progress_)
      for (const auto& column : kAfterChannels) use(column.name, column.type);
    use(channels_[i].name, sql_type(channels_[i].measures));
  }
  if (before_progress_ == channels_.size())
    for (const auto& column : kAfterChannels) use(column.name, column.type);
}

std::string SampleColumns::names() const {
  std::string names;
  each([&](std::string_view name, std::string_view) {
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", name);
  });
  return names;
}

namespace {

/// Returns a reference to the value of a channel in a row that has it.
double& number_at(const ChannelColumn& column, SampleRow& row) {
  switch (column.measures) {
    case Measures::rotation: return row.units[column.unit].rotation[column.index];
    case Measures::value: return row.units[column.unit].values[column.index];
    case Measures::true_bias: return row.units[column.unit].true_bias_deg_per_h[column.index];
    case Measures::humidity: return row.chamber_humidity_percent;
    case Measures::dew_point: return row.chamber_dew_point_c;
    case Measures::temperature:
    case Measures::interval: break;
  }
  return row.thermometers_c[column.index];
}

/// Returns a value, or NaN if the unit sent none.
double number_or_missing(const std::vector<double>& numbers, std::size_t index) {
  return index < numbers.size() ? numbers[index] : kMissing;
}

Cell cell_in(const ChannelColumn& column, const SampleRow& row) {
  switch (column.measures) {
    case Measures::rotation: return number_or_missing(row.units[column.unit].rotation, column.index);
    case Measures::interval: return to_cell(row.units[column.unit].interval);
    case Measures::value: return number_or_missing(row.units[column.unit].values, column.index);
    case Measures::true_bias: return number_or_missing(row.units[column.unit].true_bias_deg_per_h, column.index);
    case Measures::humidity: return row.chamber_humidity_percent;
    case Measures::dew_point: return row.chamber_dew_point_c;
    case Measures::temperature: break;
  }
  return number_or_missing(row.thermometers_c, column.index);
}

}  // namespace

std::size_t SampleColumns::count() const {
  return std::size(kBeforeChannels) + channels_.size() + std::size(kAfterChannels);
}

void SampleColumns::read_cells(const SampleRow& row, std::span<Cell> cells) const {
  assert(cells.size() == count());
  auto cell = cells.begin();
  const auto channels = std::span(channels_);
  for (const auto& column : kBeforeChannels) *cell++ = column.cell(row);
  for (const auto& column : channels.first(before_progress_)) *cell++ = cell_in(column, row);
  for (const auto& column : kAfterChannels) *cell++ = column.cell(row);
  for (const auto& column : channels.subspan(before_progress_)) *cell++ = cell_in(column, row);
}

void SampleColumns::read(SampleRow& row, const Statement& from) const {
  row = SampleRow{.thermometers_c = std::move(row.thermometers_c), .units = std::move(row.units)};
  int i = 0;
  const auto take_channels = [&](std::span<const ChannelColumn> channels) {
    for (const auto& column : channels) {
      if (column.measures == Measures::interval) {
        auto& interval = row.units[column.unit].interval;
        interval.reset();
        if (!from.null(i)) take_value(interval, from, i);
      } else {
        number_at(column, row) = from.real(i);
      }
      ++i;
    }
  };
  const auto channels = std::span<const ChannelColumn>(channels_);
  take(row, columns_before_channels(), from, i);
  take_channels(channels.first(before_progress_));
  take(row, columns_after_channels(), from, i);
  take_channels(channels.subspan(before_progress_));
}

std::span<const Column<RecordedEvent>> event_columns() { return kEventColumns; }

EventKind find_event_kind(std::string_view text) {
  return find_kind(
      text, {EventKind::started, EventKind::resumed, EventKind::segment, EventKind::fault, EventKind::recovered,
             EventKind::interlock, EventKind::note, EventKind::interrupted, EventKind::finished, EventKind::state,
             EventKind::command, EventKind::dropped, EventKind::returned, EventKind::acknowledged, EventKind::told});
}

Result<void> each_sample(Database& database, const RunInfo& info, const Selection& selection,
                         const std::function<void(const SampleRow&)>& use) {
  const SampleColumns columns(info, selection);
  SampleRow row = empty_row(info);
  const auto sql = fmt::format("SELECT {} FROM sample WHERE slot > {} ORDER BY slot", columns.names(), selection.after);
  return database.each_row(sql, [&](const Statement& from) -> Result<void> {
    columns.read(row, from);
    if (!has_possible_times(row))
      return failure(FaultKind::bad_file, database.path(), fmt::format("second {} has impossible times", row.slot));
    use(row);
    return {};
  });
}

Result<std::optional<SampleRow>> last_row(Database& database, const RunInfo& info) {
  const SampleColumns columns(info);
  const auto last =
      database.first_row(fmt::format("SELECT {} FROM sample ORDER BY slot DESC LIMIT 1", columns.names()));
  if (!last) return failure(last.error());
  if (!*last) return std::nullopt;
  SampleRow row = empty_row(info);
  columns.read(row, **last);
  return row;
}

Result<std::int64_t> last_slot(Database& database) {
  return database.query_integer(
      "SELECT max(coalesce((SELECT max(slot) FROM sample), -1), coalesce((SELECT max(last) FROM gap), -1))", -1);
}

}  // namespace gyrotherm::record
