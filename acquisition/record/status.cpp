// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/status.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

#include "acquisition/record/row.hpp"
#include "acquisition/record/schema.hpp"

namespace gyrotherm::record {

namespace {

Result<RunStatus> read_part_status(const Part& part) {
  return open_part(part).and_then([&](Database database) { return read_stored_status(database, part.path); });
}

/// Returns the state of a run at its end. Early records do not store it with each row, so the state of a finished one
/// is read as execute.
RunState end_state(const RunStatus& status) {
  const auto state = status.overview.state;
  if (!status.finished || state != RunState::execute) return state;
  return status.ended_by.starts_with(name(RunState::stopped)) ? RunState::stopped : RunState::complete;
}

/// Copies the position of the run from the status of an earlier file that has a sample.
void copy_position(RunStatus& status, const RunStatus& before) {
  status.slot = before.slot;
  status.segment = before.segment;
  status.segment_index = before.segment_index;
  status.phase = before.phase;
  status.set_point = before.set_point;
  status.chamber_air = before.chamber_air;
  status.chamber_set_point = before.chamber_set_point;
  status.thermometers = before.thermometers;
  status.overview = before.overview;
  status.overview.state = end_state(status);
}

/// The numbers of faults of a file.
struct FaultCounts {
  std::int64_t all{};
  /// Faults of units in segments that switch the units off.
  std::int64_t while_off{};
};

/// Counts the faults before a slot.
Result<FaultCounts> count_faults(Database& database, std::int64_t end) {
  FaultCounts counts;
  return assign_result(counts.all,
                       database.query_integer(fmt::format("SELECT count(*) FROM fault WHERE slot < {}", end), 0))
      .and_then([&] {
        return assign_result(
            counts.while_off,
            database.query_integer(
                fmt::format("SELECT count(*) FROM fault JOIN sample ON sample.slot = fault.slot "
                            "JOIN segment ON segment.position = sample.segment JOIN unit ON unit.name = fault.channel "
                            "WHERE segment.unit_off AND fault.slot < {}",
                            end),
                0));
      })
      .map([&] { return counts; });
}

/// Counts the faults in the files before the last one. Does not count rows that a later file repeats, and ignores
/// damaged files.
Result<FaultCounts> faults_before_last(const RecordFiles& files) {
  FaultCounts sum;
  auto end = files.parts.back().continuation.from;
  for (auto part = std::next(files.parts.rbegin()); part != files.parts.rend(); ++part) {
    const auto faults = open_part(*part).and_then([end](Database database) { return count_faults(database, end); });
    if (!faults && is_locked(faults.error())) return failure(faults.error());
    sum.all += faults ? faults->all : 0;
    sum.while_off += faults ? faults->while_off : 0;
    end = std::min(end, part->continuation.from);
  }
  return sum;
}

Result<std::vector<RecordedEvent>> read_alarm_events(Database& database) {
  const auto sql = fmt::format(
      "SELECT id, {} FROM event WHERE kind IN ('{}', '{}', '{}', '{}', '{}', '{}') ORDER BY id",
      column_names(event_columns()), name(EventKind::interlock), name(EventKind::fault), name(EventKind::acknowledged),
      name(EventKind::recovered), name(EventKind::resumed), name(EventKind::command));
  std::vector<RecordedEvent> events;
  const auto read = database.each_row(sql, [&](const Statement& row) {
    RecordedEvent recorded;
    int i = 1;
    take(recorded, event_columns(), row, i);
    recorded.event.number = row.integer(0);
    events.push_back(std::move(recorded));
  });
  return read.map([&] { return std::move(events); });
}

}  // namespace

Result<Alarms> read_record_alarms(const RecordFiles& files) {
  std::vector<RecordedEvent> events;  // later parts repeat earlier seconds
  for (const auto& part : files.parts) {
    const bool is_last = &part == &files.parts.back();
    auto database = open_part(part);
    if (!database && !is_last && !is_locked(database.error())) continue;
    if (!database) return failure(database.error());
    std::erase_if(events, [&](const RecordedEvent& event) { return event.slot >= part.continuation.from; });
    const auto more = read_alarm_events(*database);
    if (!more && is_last) return failure(more.error());
    if (more) events.insert(events.end(), more->begin(), more->end());
  }
  Alarms alarms;
  for (const auto& event : events) alarms.update(event);
  return alarms;
}

Result<std::int64_t> read_last_event_number(const RecordFiles& files) {
  std::int64_t highest = 0;
  for (const auto& part : files.parts) {
    const auto number = open_part(part).and_then(
        [](Database database) { return database.query_integer("SELECT max(id) FROM event", 0); });
    const bool is_needed = &part == &files.parts.back();
    if (!number && (is_needed || is_locked(number.error()))) return failure(number.error());
    if (number) highest = std::max(highest, *number);
  }
  return highest;
}

namespace {

/// Returns the status of the last file. Adds the faults of the files before it, and their last position if the last
/// file has no sample yet.
Result<RunStatus> read_record_status(const RecordFiles& files) {
  auto status = read_part_status(files.parts.back());
  if (!status) return status;
  for (auto part = files.parts.rbegin() + 1; status->slot < 0 && part != files.parts.rend(); ++part)
    if (const auto before = read_part_status(*part); before && before->slot >= 0) copy_position(*status, *before);
  const auto faults = faults_before_last(files);
  if (!faults) return failure(faults.error());
  status->faults += faults->all;
  status->faults_while_off += faults->while_off;
  status->path = files.path;
  if (files.lost) status->record_damage = text(*files.lost);
  for (const auto& part : files.parts)
    if (part.path != files.path) status->parts.push_back(part.path);
  for (auto part = files.parts.rbegin() + 1; !status->decision && part != files.parts.rend(); ++part)
    if (const auto before = read_part_status(*part)) status->decision = before->decision;
  const auto alarms = read_record_alarms(files);
  if (!alarms) return failure(alarms.error());
  status->alarms = alarms->list();
  return status;
}

}  // namespace

namespace {

/// If the fault is that the record is being written, returns the status in its status file instead, provided that file
/// can be read.
Result<RunStatus> fall_back_to_status_file(Result<RunStatus> status, const std::string& path) {
  if (status || !is_locked(status.error())) return status;
  auto from_file = read_status_file(path);
  if (!from_file) return status;
  from_file->being_written = true;
  return from_file;
}

}  // namespace

Result<RunStatus> read_status(const RecordFiles& files) {
  return fall_back_to_status_file(read_record_status(files), files.path);
}

Result<RunStatus> read_status(const std::string& path) {
  return fall_back_to_status_file(find_record_files(path).and_then(read_record_status), path);
}

std::string describe(const LostEnd& lost) {
  return fmt::format("ends at second {}, but second {} was acknowledged: its end is lost", lost.last,
                     lost.acknowledged);
}

Result<std::optional<LostEnd>> lost_end(const RecordFiles& files) {
  const auto held = read_record_status(files);
  if (!held) return failure(held.error());
  if (held->finished) return std::nullopt;
  const auto from_file = read_status_file(files.path);
  if (!from_file || from_file->id != held->id || from_file->acknowledged <= held->acknowledged) return std::nullopt;
  return LostEnd{.last = held->acknowledged, .acknowledged = from_file->acknowledged};
}

namespace {

/// Returns whether the last writer of an unfinished file closed it, so that its log was copied into it. A writer that
/// ends in order notes this in its last event; it notes the start of a run in its first second.
Result<bool> was_closed_in_order(Database& database, const RunStatus& held) {
  if (held.overview.state == RunState::aborted) return true;
  const auto row = database.first_row(fmt::format(
      "SELECT kind FROM event WHERE kind IN ('{}', '{}', '{}', '{}') ORDER BY id DESC LIMIT 1",
      name(EventKind::started), name(EventKind::resumed), name(EventKind::interrupted), name(EventKind::finished)));
  if (!row) return failure(row.error());
  if (!*row) return held.slot >= 0;  // rows of another program
  const auto kind = find_event_kind((*row)->text(0));
  return kind == EventKind::interrupted || kind == EventKind::finished;
}

}  // namespace

Result<std::vector<std::string>> missing_files(const RecordFiles& files) {
  std::vector<std::string> missing;
  const auto& last = files.parts.back();
  if (last.is_live_copy) return missing;
  const auto held = read_record_status(files);
  if (!held) return failure(held.error());
  if (held->finished) return missing;
  auto database = open_part(last);
  if (!database) return failure(database.error());
  const auto log = database->path() + "-wal";  // beside the target of a link
  if (path_exists(log)) return missing;
  const auto status = read_status_file(files.path);
  if (status && status->id == held->id) {
    if (status->acknowledged > held->acknowledged) missing.push_back(name_in_folder(log));
    return missing;
  }
  const auto closed = was_closed_in_order(*database, *held);
  if (!closed) return failure(closed.error());
  if (!*closed) missing = {name_in_folder(log), name_in_folder(status_path(files.path))};
  return missing;
}

std::string describe_missing(const std::vector<std::string>& names) {
  return fmt::format("{} {} missing; move all files of a record together", fmt::join(names, " and "),
                     names.size() == 1 ? "is" : "are");
}

namespace {

Result<FrameCount> stored_frames(Database& database) {
  FrameCount frames;
  const auto read = database.each_row("SELECT seen, lost, bad FROM frames", [&](const Statement& row) {
    frames = {.seen = static_cast<std::uint64_t>(row.integer(0)),
              .lost = static_cast<std::uint64_t>(row.integer(1)),
              .bad = static_cast<std::uint64_t>(row.integer(2))};
  });
  return read.map([&] { return frames; });
}

/// Returns true if an event with this text states how the program of the run ended. After a suspension or a warning,
/// the program continues, so such an event does not explain an end.
bool explains_end(std::optional<EventKind> kind, std::string_view reaction, std::string_view text) {
  constexpr std::array kEnds = {RunState::aborting, RunState::aborted, RunState::stopped, RunState::complete};
  switch (kind.value_or(EventKind::note)) {
    case EventKind::interrupted:
    case EventKind::finished: return true;
    // Early records contain no reactions; they end with the interlock.
    case EventKind::interlock: return reaction.empty() || reaction == "abort";
    case EventKind::state:
      return std::ranges::any_of(kEnds, [&](RunState state) { return text.starts_with(name(state)); });
    default: return false;
  }
}

/// Returns the text of the event that states how the program of the run ended, if no later event shows that the run
/// went on. Notes, warnings and acknowledgements may follow it.
Result<std::string> end_cause(Database& database) {
  const auto row = database.first_row(fmt::format(
      "SELECT kind, reaction, text FROM event WHERE kind IN ('{}', '{}', '{}', '{}', '{}') OR (kind = '{}' AND "
      "ifnull(reaction, '') IN ('', 'abort')) ORDER BY id DESC LIMIT 1",
      name(EventKind::started), name(EventKind::resumed), name(EventKind::state), name(EventKind::interrupted),
      name(EventKind::finished), name(EventKind::interlock)));
  if (!row) return failure(row.error());
  if (!*row) return std::string();
  const auto text = (*row)->text(2);
  return std::string(explains_end(find_event_kind((*row)->text(0)), (*row)->text(1), text) ? text : "");
}

/// Returns the last decision of the run; nothing if it has none.
Result<std::optional<Decision>> last_decision(Database& database) {
  const auto row =
      database.first_row(fmt::format("SELECT text FROM event WHERE {} ORDER BY id DESC LIMIT 1", kIsDecision));
  if (!row) return failure(row.error());
  return *row ? parse_decision((*row)->text(0)) : std::nullopt;
}

}  // namespace

RunStatus make_first_status(const std::string& path, const RunInfo& info) {
  RunStatus status;
  status.path = path;
  status.id = info.id;
  status.simulated = is_simulated(info);
  status.virtual_instruments = info.virtual_instruments;
  for (const ProgramRelease& release : info.releases)
    if (!release.unreleased.empty()) status.unreleased.push_back(release.title);
  status.segment_count = static_cast<int>(info.segments.size());
  for (const Channel& channel : info.thermometers) status.thermometers.emplace_back(channel.name, std::nullopt);
  return status;
}

void set_progress(RunStatus& status, const RunInfo& info, const ProfilePosition& progress) {
  status.phase = progress.phase;
  status.segment_index = progress.segment;
  const auto segment = static_cast<std::size_t>(progress.segment);
  status.segment = segment < info.segments.size() ? info.segments[segment].name : std::string();
  status.set_point = celsius_if_known(progress.set_point.value);
}

Result<RunStatus> read_stored_status(Database& database, const std::string& path) {
  const auto info = read_run_info(database);
  if (!info) return failure(info.error());
  RunStatus status = make_first_status(path, *info);
  std::optional<Continuation> continuation;
  std::optional<SampleRow> row;
  const auto read = assign_result(status.finished, is_finished(database))
                        .and_then([&] {
                          return count_faults(database, kMaxSlots + 1).map([&](const FaultCounts& counts) {
                            status.faults = counts.all;
                            status.faults_while_off = counts.while_off;
                          });
                        })
                        .and_then([&] { return assign_result(status.frames, stored_frames(database)); })
                        .and_then([&] { return assign_result(status.acknowledged, last_slot(database)); })
                        .and_then([&] { return assign_result(status.ended_by, end_cause(database)); })
                        .and_then([&] { return assign_result(status.decision, last_decision(database)); })
                        .and_then([&] { return assign_result(continuation, read_continuation(database)); })
                        .and_then([&] { return assign_result(row, last_row(database, *info)); });
  if (!read) return failure(read.error());
  if (continuation) status.acknowledged = std::max(status.acknowledged, continuation->from - 1);
  if (!row) {
    status.overview.state = end_state(status);
    return status;
  }
  status.slot = row->slot;
  set_progress(status, *info, row->progress.value_or(ProfilePosition{.set_point = Celsius{kMissing}}));
  status.overview.state = row->state.value_or(RunState::execute);
  status.overview.state = end_state(status);
  status.chamber_air = celsius_if_known(row->chamber_air_c);
  status.chamber_set_point = celsius_if_known(row->chamber_set_point_c);
  for (std::size_t i = 0; i < status.thermometers.size(); ++i)
    status.thermometers[i].second = celsius_if_known(row->thermometers_c[i]);
  return status;
}

}  // namespace gyrotherm::record
