// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <tuple>
#include <utility>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/status_file.hpp"

namespace gyrotherm::record {
namespace {

/// Calls `use` with each selected column of numbers. The order is the same for all records of one run.
void each_number(Record& record, const Selection& selection, const std::function<void(std::vector<double>&)>& use) {
  for (auto* column : {&record.time_s, &record.set_point_c, &record.chamber_air_c, &record.chamber_set_point_c})
    use(*column);
  if (record.info.has_humidity) use(record.chamber_humidity_percent);
  if (record.info.has_dew_point) use(record.chamber_dew_point_c);
  for (std::size_t i = 0; i < record.thermometers_c.size(); ++i)
    if (selection.thermometers[i]) use(record.thermometers_c[i]);
  for (std::size_t i = 0; i < record.units.size(); ++i) {
    if (!selection.units[i]) continue;
    auto& unit = record.units[i];
    use(unit.interval_s);
    for (auto* columns : {&unit.rotation, &unit.values, &unit.true_bias_deg_per_h})
      std::ranges::for_each(*columns, use);
  }
}

void prepare_columns(Record& record, std::size_t rows, const Selection& selection) {
  record.slot.reserve(rows);
  record.thermometers_c.resize(record.info.thermometers.size());
  record.units.clear();
  for (const auto& unit : record.info.units) {
    auto& columns = record.units.emplace_back();
    columns.rotation.resize(unit.axes.size());
    columns.values.resize(unit.values.size());
    columns.true_bias_deg_per_h.resize(unit.axes.size());
  }
  each_number(record, selection, [rows](std::vector<double>& column) { column.reserve(rows); });
  record.progress.reserve(rows);
  record.state.reserve(rows);
}

/// Appends a number to each column. A second without a reading may have fewer numbers.
void add_to(std::vector<std::vector<double>>& columns, const std::vector<double>& numbers) {
  for (std::size_t i = 0; i < columns.size(); ++i) columns[i].push_back(i < numbers.size() ? numbers[i] : kMissing);
}

void add(UnitColumns& unit, const UnitRow& row) {
  add_to(unit.rotation, row.rotation);
  unit.interval_s.push_back(row.interval ? static_cast<double>(row.interval->count()) * 1e-9 : kMissing);
  add_to(unit.values, row.values);
  add_to(unit.true_bias_deg_per_h, row.true_bias_deg_per_h);
}

void add(Record& record, const SampleRow& row, const Selection& selection) {
  record.slot.push_back(row.slot);
  record.time_s.push_back(to_seconds(row.monotonic));
  const auto progress = row.progress.value_or(ProfilePosition{.set_point = Celsius{kMissing}});
  record.set_point_c.push_back(progress.set_point.value);
  record.chamber_air_c.push_back(row.chamber_air_c);
  record.chamber_set_point_c.push_back(row.chamber_set_point_c);
  if (record.info.has_humidity) record.chamber_humidity_percent.push_back(row.chamber_humidity_percent);
  if (record.info.has_dew_point) record.chamber_dew_point_c.push_back(row.chamber_dew_point_c);
  for (std::size_t i = 0; i < record.thermometers_c.size(); ++i)
    if (selection.thermometers[i]) record.thermometers_c[i].push_back(row.thermometers_c[i]);
  for (std::size_t i = 0; i < record.units.size(); ++i)
    if (selection.units[i]) add(record.units[i], row.units[i]);
  record.progress.push_back(progress);
  record.state.push_back(row.state.value_or(RunState::execute));
  record.last_utc = row.utc;
}

Result<void> read_samples(Database& database, Record& record, const ReadSelection& wanted) {
  const auto rows = database.query_integer(fmt::format("SELECT count(*) FROM sample WHERE slot > {}", wanted.after), 0);
  if (!rows) return failure(rows.error());
  const auto selection = select(record.info, wanted);
  prepare_columns(record, static_cast<std::size_t>(*rows), selection);
  return each_sample(database, record.info, selection, [&](const SampleRow& row) { add(record, row, selection); });
}

Result<void> read_gaps(Database& database, Record& record) {
  return database.each_row("SELECT first, last, cause FROM gap ORDER BY first", [&](const Statement& row) {
    record.gaps.push_back({row.integer(0), row.integer(1), std::string(row.text(2))});
  });
}

Result<void> read_events(Database& database, Record& record) {
  const auto sql = fmt::format("SELECT {} FROM event ORDER BY id", column_names(event_columns()));
  return database.each_row(sql, [&](const Statement& row) -> Result<void> {
    RecordedEvent& recorded = record.events.emplace_back();
    int i = 0;
    take(recorded, event_columns(), row, i);
    const Instant& at = recorded.event.at;
    if (is_possible_time(at.since_start) && is_possible_time(at.utc)) return {};
    return failure(FaultKind::bad_file, database.path(), "an event has impossible times");
  });
}

/// Takes the segments that decisions have added from the description in a later file.
void take_growth(RunInfo& info, RunInfo later) {
  if (!info.goal) return;
  info.segments = std::move(later.segments);
  info.added_blocks = std::move(later.added_blocks);
}

Gap lost_gap(const Continuation& continuation, std::int64_t first) {
  return {first, continuation.from - 1, fmt::format("lost with {}: {}", continuation.before, continuation.cause)};
}

/// Returns whether two parts of a run have the same columns of numbers.
bool have_same_columns(const RunInfo& left, const RunInfo& right) {
  const auto describe_column = [](const ChannelColumn& column) {
    return std::tuple(column.name, column.measures, column.unit, column.index);
  };
  const auto count_columns = [](const UnitInfo& unit) { return std::pair(unit.axes.size(), unit.values.size()); };
  return left.thermometers.size() == right.thermometers.size() &&
         std::ranges::equal(left.units, right.units, {}, count_columns, count_columns) &&
         std::ranges::equal(channel_columns(left), channel_columns(right), {}, describe_column, describe_column);
}

/// Appends a part to the record. The part must have the columns of the record. The rows of the part replace the
/// record's rows from the first slot of the part on. Slots between the record and the part become a gap.
void append_part(Record& record, Record part, const Continuation& continuation, const Selection& selection) {
  const auto kept = static_cast<std::size_t>(
      std::lower_bound(record.slot.begin(), record.slot.end(), continuation.from) - record.slot.begin());
  const auto extend = [&](auto& column, const auto& by) {
    column.resize(kept);
    column.insert(column.end(), by.begin(), by.end());
  };
  std::erase_if(record.gaps, [&](const Gap& gap) { return gap.first >= continuation.from; });
  std::erase_if(record.events, [&](const RecordedEvent& event) { return event.slot >= continuation.from; });
  const auto last = std::max(kept > 0 ? record.slot[kept - 1] : -1, record.gaps.empty() ? -1 : record.gaps.back().last);
  if (last + 1 < continuation.from) record.gaps.push_back(lost_gap(continuation, last + 1));
  extend(record.slot, part.slot);
  std::vector<const std::vector<double>*> more;
  each_number(part, selection, [&](std::vector<double>& column) { more.push_back(&column); });
  each_number(record, selection,
              [&, next = more.begin()](std::vector<double>& column) mutable { extend(column, **next++); });
  take_growth(record.info, std::move(part.info));
  extend(record.progress, part.progress);
  extend(record.state, part.state);
  record.gaps.insert(record.gaps.end(), part.gaps.begin(), part.gaps.end());
  record.events.insert(record.events.end(), part.events.begin(), part.events.end());
  record.finished = part.finished;
  if (part.last_utc) record.last_utc = part.last_utc;
}

/// Reads one file. If `proves`, verifies its chain.
Result<Record> read_part(const Part& part, bool proves, const std::string& unit) {
  auto database = open_part(part);
  if (!database) return failure(database.error());
  if (proves)
    if (const auto chain = check_chain(*database, part.path); !chain) return failure(chain.error());
  return read_open_record(*database, {.unit = unit});
}

/// Reads all parts. Skips a part that was changed. Its slots are in the parts after it, or become a gap.
Result<Record> read_all(const RecordFiles& files, const std::string& unit, bool proves_last) {
  std::optional<Record> record;
  for (const auto& part : files.parts) {
    const bool is_last = &part == &files.parts.back();
    auto more = read_part(part, proves_last || !is_last, unit);
    if (!more && !is_last && !is_locked(more.error())) continue;
    if (!more) return more;
    if (record) {
      if (!have_same_columns(record->info, more->info))
        return failure(FaultKind::bad_file, part.path, "has other channels than the parts before it");
      append_part(*record, std::move(*more), part.continuation, select(record->info, {.unit = unit}));
    } else {
      record = std::move(*more);
      if (part.continuation.from > 0) record->gaps.insert(record->gaps.begin(), lost_gap(part.continuation, 0));
    }
  }
  return std::move(*record);
}

}  // namespace

void append_sample(Record& record, const Sample& sample) {
  const auto selection = select(record.info, {});
  if (record.slot.empty()) prepare_columns(record, 0, selection);
  const auto last =
      std::max(record.slot.empty() ? -1 : record.slot.back(), record.gaps.empty() ? -1 : record.gaps.back().last);
  if (sample.slot > last + 1) record.gaps.push_back({last + 1, sample.slot - 1, {}});
  add(record, *sample_entry(sample, {}, record.info).sample, selection);
}

const RunInfo::SegmentInfo* segment_at(const Record& record, std::size_t row) {
  if (row >= record.progress.size()) return nullptr;
  const auto index = static_cast<std::size_t>(record.progress[row].segment);
  return index < record.info.segments.size() ? &record.info.segments[index] : nullptr;
}

std::vector<bool> find_rows_away(const Record& record) {
  std::vector<bool> away(record.state.size());
  bool is_away = false;
  for (std::size_t i = 0; i < away.size(); ++i)
    away[i] = is_away = has_left_profile(record.state[i]) || (is_away && record.state[i] == RunState::suspended);
  return away;
}

bool has_operator_actions(const RunInfo& info) {
  return std::ranges::any_of(info.segments, [](const RunInfo::SegmentInfo& segment) {
    return segment.unit.turned || !segment.prompt.empty();
  });
}

double turned_at(const Record& record, std::size_t row) {
  const auto* segment = segment_at(record, row);
  if (segment == nullptr) return 0;
  const bool is_being_handled = !segment->prompt.empty() && record.progress[row].in_segment == Duration{};
  return is_being_handled ? kMissing : segment->unit.turned ? 1 : 0;
}

Result<Record> read_open_record(Database& database, const ReadSelection& wanted) {
  Record record;
  const auto read = assign_result(record.info, read_run_info(database))
                        .and_then([&] { return assign_result(record.finished, is_finished(database)); })
                        .and_then([&] { return read_samples(database, record, wanted); })
                        .and_then([&] { return read_gaps(database, record); })
                        .and_then([&] { return read_events(database, record); });
  if (!read) return failure(read.error());
  return record;
}

Fault explain_read_fault(Fault fault, const std::string& path) {
  if (!is_locked(fault)) {
    fault.kind = FaultKind::bad_file;
    return fault;
  }
  if (const auto status = read_status_file(path); status && status->pid != 0)
    fault.what = fmt::format("{} (process {})", fault.what, status->pid);
  return fault;
}

Result<RunInfo> read_info(const RecordFiles& files) {
  std::optional<Fault> first;
  std::optional<RunInfo> found;
  for (const auto& part : files.parts) {
    if (found && !found->goal) break;
    auto database = open_part(part);
    auto info = database ? read_run_info(*database) : failure(database.error());
    if (info && found)
      take_growth(*found, std::move(*info));
    else if (info)
      found = std::move(*info);
    else if (!first)
      first = info.error();
  }
  if (found) return std::move(*found);
  return failure(explain_read_fault(*first, files.path));
}

Result<Record> read_record(const RecordFiles& files, const std::string& unit) {
  return read_all(files, unit, false).map_error([&](const Fault& fault) {
    return explain_read_fault(fault, files.path);
  });
}

Result<Record> read_verified_record(const RecordFiles& files) {
  return read_all(files, {}, true).map_error([&](const Fault& fault) { return explain_read_fault(fault, files.path); });
}

Result<RecordFiles> find_files_to_read(const std::string& path) {
  return find_record_files(path).map_error([&](const Fault& fault) { return explain_read_fault(fault, path); });
}

Result<RunInfo> read_info(const std::string& path) {
  return find_files_to_read(path).and_then([](const RecordFiles& files) { return read_info(files); });
}

Result<Record> read_record(const std::string& path, const std::string& unit) {
  return find_files_to_read(path).and_then([&](const RecordFiles& files) { return read_record(files, unit); });
}

}  // namespace gyrotherm::record
