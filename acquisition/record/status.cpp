#include "acquisition/record/status.hpp"

#include <fmt/format.h>

#include "acquisition/record/record.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/run_parts.hpp"
#include "acquisition/record/schema.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/json.hpp"

namespace gyrotherm {

namespace {

Json to_value(const std::optional<FrameCount>& frames) {
  return frames ? Json{{"seen", frames->seen}, {"lost", frames->lost}, {"bad", frames->bad}} : Json(nullptr);
}

Json to_value(const std::optional<Celsius>& reading) { return reading ? Json(reading->value) : Json(nullptr); }

Json to_value(const std::optional<double>& number) { return number ? Json(*number) : Json(nullptr); }

void read_outlook(const Json& json, RunStatus& status) {
  status.state = run_state_named(json.at("state").get<std::string>());
  json.at("cause").get_to(status.cause);
  const auto seconds = [&](const char* key) {
    return json.at(key).is_null() ? std::nullopt : std::optional(json.at(key).get<double>());
  };
  status.time_left_s = seconds("time_left_s");
  status.behind_plan_s = seconds("behind_plan_s");
  json.at("missed_set_points").get_to(status.missed_set_points);
  json.at("faults_now").get_to(status.faults_now);
  json.at("ended_by").get_to(status.ended_by);
  json.at("backlog_s").get_to(status.backlog_s);
  json.at("storage_trouble").get_to(status.storage_trouble);
  json.at("record_damage").get_to(status.record_damage);
  json.at("parts").get_to(status.parts);
  const Duration utc(json.at("written_utc_ns").get<std::int64_t>());
  const Duration since_boot(json.at("written_since_boot_ns").get<std::int64_t>());
  if (!is_possible_time(utc) || !is_possible_time(since_boot)) return;
  status.written_utc = utc;
  status.written_since_boot = since_boot;
  json.at("written_in_boot").get_to(status.written_in_boot);
}

std::optional<Celsius> to_reading(const Json& value) {
  if (value.is_null()) return std::nullopt;
  return Celsius{value.get<double>()};
}

RunStatus from_json(const Json& json) {
  RunStatus status;
  json.at("path").get_to(status.path);
  json.at("id").get_to(status.id);
  json.at("pid").get_to(status.pid);
  json.at("being_written").get_to(status.being_written);
  json.at("finished").get_to(status.finished);
  json.at("simulated").get_to(status.simulated);
  json.at("slot").get_to(status.slot);
  json.at("acknowledged").get_to(status.acknowledged);
  json.at("segment").get_to(status.segment);
  json.at("segment_index").get_to(status.segment_index);
  json.at("segment_count").get_to(status.segment_count);
  status.phase = phase_named(json.at("phase").get<std::string>());
  status.set_point = to_reading(json.at("set_point_c"));
  status.chamber_air = to_reading(json.at("chamber_air_c"));
  for (const auto& [channel, value] : json.at("thermometers_c").items())
    status.thermometers.push_back({channel, to_reading(value)});
  json.at("faults").get_to(status.faults);
  if (const auto frames = json.find("frames"); frames != json.end() && !frames->is_null())
    status.frames = FrameCount{.seen = frames->at("seen").get<std::uint64_t>(),
                               .lost = frames->at("lost").get<std::uint64_t>(),
                               .bad = frames->at("bad").get<std::uint64_t>()};
  read_outlook(json, status);
  return status;
}

Result<RunStatus> read_status_file(const std::string& path) {
  const std::string where = status_path(path);
  return read_text_file(where).and_then([&](const std::string& text) { return parse_status(text, where); });
}

Result<RunStatus> status_of_file(const std::string& path) {
  return open_record(path).and_then([&](Database database) { return stored_status(database, path); });
}

/// Of its last file, which goes on from the others.
Result<RunStatus> status_of_record(const std::string& path) {
  const auto files = files_of_record(path);
  if (!files) return failure(files.error());
  auto status = status_of_file(files->parts.back().path);
  if (!status) return status;
  status->path = path;
  if (files->lost) status->record_damage = text(*files->lost);
  for (const auto& part : files->parts)
    if (part.path != path) status->parts.push_back(part.path);
  return status;
}

}  // namespace

std::string status_path(const std::string& record_path) { return record_path + ".status"; }

std::string to_json(const RunStatus& status) {
  Json thermometers = Json::object();
  for (const auto& thermometer : status.thermometers) thermometers[thermometer.channel] = to_value(thermometer.reading);
  const Json json{{"schema", kStatusSchema},
                  {"path", status.path},
                  {"id", status.id},
                  {"pid", status.pid},
                  {"being_written", status.being_written},
                  {"finished", status.finished},
                  {"simulated", status.simulated},
                  {"slot", status.slot},
                  {"acknowledged", status.acknowledged},
                  {"segment", status.segment},
                  {"segment_index", status.segment_index},
                  {"segment_count", status.segment_count},
                  {"phase", name(status.phase)},
                  {"set_point_c", to_value(status.set_point)},
                  {"chamber_air_c", to_value(status.chamber_air)},
                  {"thermometers_c", thermometers},
                  {"faults", status.faults},
                  {"frames", to_value(status.frames)},
                  {"state", name(status.state)},
                  {"cause", status.cause},
                  {"time_left_s", to_value(status.time_left_s)},
                  {"behind_plan_s", to_value(status.behind_plan_s)},
                  {"missed_set_points", status.missed_set_points},
                  {"faults_now", status.faults_now},
                  {"ended_by", status.ended_by},
                  {"backlog_s", status.backlog_s},
                  {"storage_trouble", status.storage_trouble},
                  {"record_damage", status.record_damage},
                  {"written", status.written_in_boot.empty() ? Json(nullptr) : Json(civil_time(status.written_utc))},
                  {"written_utc_ns", status.written_utc.count()},
                  {"written_since_boot_ns", status.written_since_boot.count()},
                  {"written_in_boot", status.written_in_boot},
                  {"parts", status.parts}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<RunStatus> parse_status(const std::string& text, const std::string& where) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != kStatusSchema)
      return failure(FaultKind::bad_file, where, std::string("another schema, expected ") + kStatusSchema);
    return from_json(json);
  } catch (const Json::exception& error) {
    return failure(FaultKind::bad_file, where, std::string("not a status: ") + error.what());
  }
}

/// Not synced: it is for those who look while the program lives, and a sync that does not come back must not keep from
/// them that it does not.
Result<void> write_status(const RunStatus& status) {
  static const std::string boot = boot_id();
  auto now = status;
  now.written_utc = SteadyClock().now().utc;
  now.written_since_boot = since_boot();
  now.written_in_boot = boot;
  return replace_own_file(status_path(status.path), to_json(now) + '\n', Syncing::not_awaited);
}

std::optional<Duration> age_of(const RunStatus& status) {
  if (status.written_in_boot.empty() || status.written_in_boot != boot_id()) return {};
  return since_boot() - status.written_since_boot;
}

Result<RunStatus> read_status(const std::string& path) {
  auto status = status_of_record(path);
  if (status || !is_locked(status.error())) return status;
  auto told = read_status_file(path);
  if (!told) return failure(status.error());
  told->being_written = true;
  return told;
}

std::string in_words(const LostEnd& lost) {
  return fmt::format("ends at second {}, but second {} was acknowledged: its end is lost", lost.last,
                     lost.acknowledged);
}

Result<std::optional<LostEnd>> lost_end(const std::string& path) {
  const auto held = status_of_record(path);
  if (!held) return failure(held.error());
  if (held->finished) return std::nullopt;
  const auto told = read_status_file(path);
  if (!told || told->id != held->id || told->acknowledged <= held->acknowledged) return std::nullopt;
  return LostEnd{.last = held->acknowledged, .acknowledged = told->acknowledged};
}

namespace {

Result<FrameCount> stored_frames(Database& database) {
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
  show_progress(status, *info, (*row)->progress.value_or(ProfilePosition{.set_point = Celsius{kMissing}}));
  status.state = (*row)->state.value_or(RunState::execute);
  status.chamber_air = known((*row)->chamber_air_c);
  for (std::size_t i = 0; i < status.thermometers.size(); ++i)
    status.thermometers[i].reading = known((*row)->thermometers_c[i]);
  return status;
}

}  // namespace gyrotherm
