#include "acquisition/record/record_status.hpp"

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_rows.hpp"
#include "acquisition/record/run_info_rows.hpp"
#include "acquisition/record/schema.hpp"

namespace gyrotherm {
namespace {

Result<std::optional<FrameCount>> stored_frames(Database& database) {
  const auto known = has_table(database, "frames");
  if (!known) return failure(known.error());
  if (!*known) return std::nullopt;
  auto query = database.prepare("SELECT seen, lost, bad FROM frames");
  if (!query) return failure(query.error());
  const auto more = query->step();
  if (!more) return failure(more.error());
  if (!*more) return FrameCount{};
  return FrameCount{.seen = static_cast<std::uint64_t>(query->integer(0)),
                    .lost = static_cast<std::uint64_t>(query->integer(1)),
                    .bad = static_cast<std::uint64_t>(query->integer(2))};
}

/// The last event, if it is of the kinds that say why a run does not go on.
Result<std::string> last_word(Database& database) {
  auto query = database.prepare("SELECT kind, text FROM event ORDER BY id DESC LIMIT 1");
  if (!query) return failure(query.error());
  const auto row = query->step();
  if (!row) return failure(row.error());
  if (!*row) return std::string();
  switch (event_kind_named(query->text(0))) {
    case EventKind::interlock:
    case EventKind::interrupted:
    case EventKind::finished:
    case EventKind::state: return std::string(query->text(1));
    default: return std::string();
  }
}

}  // namespace

RunStatus first_status(const std::string& path, const RunInfo& info) {
  RunStatus status;
  status.path = path;
  status.id = info.id;
  status.simulated = info.simulated;
  status.segment_count = static_cast<int>(info.segments.size());
  for (const Channel& channel : info.thermometers) status.thermometers.push_back({channel.name, std::nullopt});
  return status;
}

void show_progress(RunStatus& status, const RunInfo& info, const ProfilePosition& progress) {
  status.phase = progress.phase;
  status.segment_index = progress.segment;
  const auto segment = static_cast<std::size_t>(progress.segment);
  status.segment = segment < info.segments.size() ? info.segments[segment].name : std::string();
  status.set_point = known(progress.set_point.value);
}

void show_outlook(RunStatus& status, const Outlook& outlook) {
  status.state = outlook.state;
  status.cause = outlook.cause;
  status.time_left_s = to_seconds(outlook.time_left);
  status.behind_plan_s = to_seconds(outlook.behind_plan);
  status.missed_set_points = outlook.missed_set_points;
  status.faults_now = outlook.faults;
}

Result<RunStatus> stored_status(Database& database, const std::string& path) {
  const auto info = read_run_info(database);
  if (!info) return failure(info.error());
  RunStatus status = first_status(path, *info);
  const auto finished = is_finished(database);
  if (!finished) return failure(finished.error());
  status.finished = *finished;
  const auto faults = database.ask_integer("SELECT count(*) FROM fault", 0);
  if (!faults) return failure(faults.error());
  status.faults = *faults;
  const auto frames = stored_frames(database);
  if (!frames) return failure(frames.error());
  status.frames = *frames;
  const auto acknowledged = last_slot(database);
  if (!acknowledged) return failure(acknowledged.error());
  status.acknowledged = *acknowledged;
  auto ended_by = last_word(database);
  if (!ended_by) return failure(ended_by.error());
  status.ended_by = std::move(*ended_by);
  const auto row = last_row(database, *info);
  if (!row) return failure(row.error());
  if (!*row) return status;

  status.slot = (*row)->slot;
  show_progress(status, *info, (*row)->progress);
  status.state = (*row)->state;
  status.chamber_air = known((*row)->chamber_air_c);
  for (std::size_t i = 0; i < status.thermometers.size(); ++i)
    status.thermometers[i].reading = known((*row)->thermometers_c[i]);
  return status;
}

}  // namespace gyrotherm
