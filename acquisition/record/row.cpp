// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/row.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <initializer_list>

#include "acquisition/record/run_parts.hpp"
#include "acquisition/record/schema.hpp"

namespace gyrotherm::record {

namespace {

SampleRow row_of(const Sample& sample) {
  SampleRow row{.slot = sample.slot, .monotonic = sample.at.since_start, .utc = sample.at.utc};
  if (const auto& chamber = sample.chamber.value) {
    row.chamber_air_c = chamber->air.value;
    row.chamber_set_point_c = chamber->set_point.value;
  }
  row.thermometers_c.reserve(sample.thermometers.size());
  for (const auto& reading : sample.thermometers)
    row.thermometers_c.push_back(reading.value.value_or(Celsius{kMissing}).value);
  if (const auto& gyro = sample.gyro.value) {
    row.gyro = static_cast<double>(gyro->pulses);
    row.interval = gyro->interval;
  }
  row.progress = sample.progress;
  row.state = sample.state;
  return row;
}

template <class T>
void add_missing(Entry& entry, const std::string& channel, const Reading<T>& reading) {
  if (!reading.value) entry.missing.push_back({channel, reading.value.error()});
}

}  // namespace

Entry entry_of(const Sample& sample, std::span<const Event> events, const RunInfo& info) {
  Entry entry{.first = sample.slot, .last = sample.slot, .sample = row_of(sample)};
  entry.events.assign(events.begin(), events.end());
  if (!sample.chamber.value) add_missing(entry, "chamber", sample.chamber);
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    add_missing(entry, info.thermometers[i].name, sample.thermometers[i]);
  if (!sample.gyro.value) add_missing(entry, "gyro", sample.gyro);
  return entry;
}

Entry gap_entry(std::int64_t first, std::int64_t last, const std::string& cause) {
  return {.first = first, .last = last, .gap_cause = cause};
}

Entry event_entry(std::int64_t last, const Event& event) {
  return {.first = last + 1, .last = last, .events = {event}};
}

namespace {

constexpr int kReaderPatienceMs = 0;  // a record being written stays so

template <class Kind>
Kind named(std::string_view text, std::initializer_list<Kind> kinds) {
  for (const Kind kind : kinds)
    if (text == name(kind)) return kind;
  return *kinds.begin();
}

Cell cell(std::optional<Duration> time) { return time ? Cell(time->count()) : Cell(); }

template <class Member>
Cell progress_cell(const SampleRow& row, Member member) {
  return row.progress ? Cell(member(*row.progress)) : Cell();
}

ProfilePosition& progress_of(SampleRow& row) {
  if (!row.progress) row.progress = ProfilePosition{.set_point = Celsius{kMissing}};
  return *row.progress;
}

using From = const Statement&;
using Position = const ProfilePosition&;

constexpr std::array kBeforeThermometers{
    Column<SampleRow>{"slot", "INTEGER PRIMARY KEY", [](const SampleRow& row) { return Cell(row.slot); },
                      [](SampleRow& row, From from, int i) { row.slot = from.integer(i); }},
    Column<SampleRow>{"monotonic_ns", "INTEGER NOT NULL", [](const SampleRow& row) { return cell(row.monotonic); },
                      [](SampleRow& row, From from, int i) { row.monotonic = Duration(from.integer(i)); }},
    Column<SampleRow>{"utc_ns", "INTEGER", [](const SampleRow& row) { return cell(row.utc); },
                      [](SampleRow& row, From from, int i) { row.utc = Duration(from.integer(i)); }},
    Column<SampleRow>{
        "set_point_c", "REAL",
        [](const SampleRow& row) { return progress_cell(row, [](Position at) { return at.set_point.value; }); },
        [](SampleRow& row, From from, int i) { progress_of(row).set_point = Celsius{from.real(i)}; }},
    Column<SampleRow>{"chamber_air_c", "REAL", [](const SampleRow& row) { return Cell(row.chamber_air_c); },
                      [](SampleRow& row, From from, int i) { row.chamber_air_c = from.real(i); }, MeasuredBy::chamber,
                      "°C"},
    Column<SampleRow>{"chamber_set_point_c", "REAL", [](const SampleRow& row) { return Cell(row.chamber_set_point_c); },
                      [](SampleRow& row, From from, int i) { row.chamber_set_point_c = from.real(i); },
                      MeasuredBy::chamber, "°C"},
};

constexpr std::array kAfterThermometers{
    // NUMERIC: a foreign record keeps its rate in the place of the pulses.
    Column<SampleRow>{"pulses", "NUMERIC", [](const SampleRow& row) { return Cell(row.gyro); },
                      [](SampleRow& row, From from, int i) { row.gyro = from.real(i); }, MeasuredBy::gyro, ""},
    Column<SampleRow>{"interval_ns", "INTEGER", [](const SampleRow& row) { return cell(row.interval); },
                      [](SampleRow& row, From from, int i) { row.interval = Duration(from.integer(i)); },
                      MeasuredBy::gyro, "ns"},
    Column<SampleRow>{
        "segment", "INTEGER",
        [](const SampleRow& row) { return progress_cell(row, [](Position at) { return std::int64_t{at.segment}; }); },
        [](SampleRow& row, From from, int i) { progress_of(row).segment = static_cast<int>(from.integer(i)); }},
    Column<SampleRow>{
        "cycle", "INTEGER",
        [](const SampleRow& row) { return progress_cell(row, [](Position at) { return std::int64_t{at.cycle}; }); },
        [](SampleRow& row, From from, int i) { progress_of(row).cycle = static_cast<int>(from.integer(i)); }},
    Column<SampleRow>{"phase", "TEXT",
                      [](const SampleRow& row) {
                        return progress_cell(row, [](Position at) { return std::string_view(name(at.phase)); });
                      },
                      [](SampleRow& row, From from, int i) { progress_of(row).phase = phase_named(from.text(i)); }},
    Column<SampleRow>{
        "in_segment_ns", "INTEGER",
        [](const SampleRow& row) { return progress_cell(row, [](Position at) { return at.in_segment.count(); }); },
        [](SampleRow& row, From from, int i) { progress_of(row).in_segment = Duration(from.integer(i)); }},
    Column<SampleRow>{
        "soaked_ns", "INTEGER",
        [](const SampleRow& row) { return progress_cell(row, [](Position at) { return at.soaked.count(); }); },
        [](SampleRow& row, From from, int i) { progress_of(row).soaked = Duration(from.integer(i)); }},
    Column<SampleRow>{
        "state", "TEXT",
        [](const SampleRow& row) { return row.state ? Cell(std::string_view(name(*row.state))) : Cell(); },
        [](SampleRow& row, From from, int i) { row.state = run_state_named(from.text(i)); }},
};

Cell text_cell(const std::string& text) { return text.empty() ? Cell() : Cell(std::string_view(text)); }

using Happened = const RecordedEvent&;

constexpr std::array kEventColumns{
    Column<RecordedEvent>{"slot", "INTEGER NOT NULL", [](Happened row) { return Cell(row.slot); },
                          [](RecordedEvent& row, From from, int i) { row.slot = from.integer(i); }},
    Column<RecordedEvent>{
        "monotonic_ns", "INTEGER NOT NULL", [](Happened row) { return cell(row.event.at.since_start); },
        [](RecordedEvent& row, From from, int i) { row.event.at.since_start = Duration(from.integer(i)); }},
    Column<RecordedEvent>{"utc_ns", "INTEGER NOT NULL", [](Happened row) { return cell(row.event.at.utc); },
                          [](RecordedEvent& row, From from, int i) { row.event.at.utc = Duration(from.integer(i)); }},
    Column<RecordedEvent>{
        "kind", "TEXT NOT NULL", [](Happened row) { return Cell(std::string_view(name(row.event.kind))); },
        [](RecordedEvent& row, From from, int i) { row.event.kind = event_kind_named(from.text(i)); }},
    Column<RecordedEvent>{"interlock", "TEXT", [](Happened row) { return text_cell(row.event.about.interlock); },
                          [](RecordedEvent& row, From from, int i) { row.event.about.interlock = from.text(i); }},
    Column<RecordedEvent>{"reaction", "TEXT", [](Happened row) { return text_cell(row.event.about.reaction); },
                          [](RecordedEvent& row, From from, int i) { row.event.about.reaction = from.text(i); }},
    Column<RecordedEvent>{
        "segment", "INTEGER",
        [](Happened row) { return row.event.about.segment ? Cell(std::int64_t{*row.event.about.segment}) : Cell(); },
        [](RecordedEvent& row, From from, int i) { row.event.about.segment = static_cast<int>(from.integer(i)); }},
    Column<RecordedEvent>{"channel", "TEXT", [](Happened row) { return text_cell(row.event.about.channel); },
                          [](RecordedEvent& row, From from, int i) { row.event.about.channel = from.text(i); }},
    Column<RecordedEvent>{"text", "TEXT NOT NULL", [](Happened row) { return Cell(std::string_view(row.event.text)); },
                          [](RecordedEvent& row, From from, int i) { row.event.text = from.text(i); }},
};

/// Columns in the order of sample_columns().
SampleRow row_in(const Statement& from, const RunInfo& info) {
  SampleRow row{.thermometers_c = std::vector<double>(info.thermometers.size())};
  int i = 0;
  const auto take = [&](const Column<SampleRow>& column) {
    if (!from.null(i)) column.take(row, from, i);
    ++i;
  };
  for (const auto& column : kBeforeThermometers) take(column);
  for (double& reading_c : row.thermometers_c) reading_c = from.real(i++);
  for (const auto& column : kAfterThermometers) take(column);
  return row;
}

bool has_possible_times(const SampleRow& row) {
  const auto& progress = row.progress;
  return is_possible_time(row.monotonic) && (!row.utc || is_possible_time(*row.utc)) &&
         (!progress || (is_possible_time(progress->in_segment) && is_possible_time(progress->soaked)));
}

}  // namespace

std::span<const Column<SampleRow>> columns_before_thermometers() { return kBeforeThermometers; }
std::span<const Column<SampleRow>> columns_after_thermometers() { return kAfterThermometers; }

std::span<const Column<RecordedEvent>> columns_of_events() { return kEventColumns; }

Phase phase_named(std::string_view text) { return named(text, kPhases); }

EventKind event_kind_named(std::string_view text) {
  return named(text, {EventKind::started, EventKind::resumed, EventKind::segment, EventKind::fault,
                      EventKind::recovered, EventKind::interlock, EventKind::note, EventKind::interrupted,
                      EventKind::finished, EventKind::state, EventKind::command});
}

RunState run_state_named(std::string_view text) { return named(text, kRunStates); }

Result<Database> open_record(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status))
    return failure(FaultKind::bad_file, path, "no such file, expected a gyrotherm record");
  if (!std::filesystem::is_regular_file(status))
    return failure(FaultKind::bad_file, path, "is no regular file, expected a gyrotherm record");
  auto database = Database::open(path, Access::read_only, kReaderPatienceMs);
  if (!database) return database;
  if (auto alone = check_no_journal(path, database->path()); !alone) return failure(alone.error());
  if (auto checked = check_schema(*database, path); !checked) return failure(checked.error());
  return database;
}

Result<void> each_sample(Database& database, const RunInfo& info, const std::function<void(const SampleRow&)>& use) {
  auto query = database.prepare(fmt::format("SELECT {} FROM sample ORDER BY slot", sample_columns(info.thermometers)));
  if (!query) return failure(query.error());
  for (;;) {
    const auto more = query->step();
    if (!more) return failure(more.error());
    if (!*more) return {};
    const SampleRow row = row_in(*query, info);
    if (!has_possible_times(row))
      return failure(FaultKind::bad_file, database.path(), fmt::format("second {} has impossible times", row.slot));
    use(row);
  }
}

Result<std::optional<SampleRow>> last_row(Database& database, const RunInfo& info) {
  auto query = database.prepare(
      fmt::format("SELECT {} FROM sample ORDER BY slot DESC LIMIT 1", sample_columns(info.thermometers)));
  if (!query) return failure(query.error());
  const auto more = query->step();
  if (!more) return failure(more.error());
  if (!*more) return std::nullopt;
  return row_in(*query, info);
}

Result<std::int64_t> last_slot(Database& database) {
  return database.ask_integer(
      "SELECT max(coalesce((SELECT max(slot) FROM sample), -1), coalesce((SELECT max(last) FROM gap), -1))", -1);
}

}  // namespace gyrotherm::record
