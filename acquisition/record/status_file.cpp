// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/status_file.hpp"

#include <fmt/format.h>

#include "acquisition/record/row.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/json.hpp"

namespace gyrotherm::record {

void describe(auto& form, Like<RunStatus> auto& status) {
  form.derived("schema", kStatusSchema);
  form("path", status.path);
  form("id", status.id);
  form("pid", status.pid);
  form("being_written", status.being_written);
  form("finished", status.finished);
  form("simulated", status.simulated);
  form("slot", status.slot);
  form("acknowledged", status.acknowledged);
  form("segment", status.segment);
  form("segment_index", status.segment_index);
  form("segment_count", status.segment_count);
  form("phase", one_of(status.phase, kPhases));
  form("set_point_c", status.set_point);
  form("chamber_air_c", status.chamber_air);
  form("thermometers_c", named_values(status.thermometers));
  form("faults", status.faults);
  form("frames", status.frames);
  describe(form, status.overview);
  form("ended_by", status.ended_by);
  form("backlog_s", status.backlog_s);
  form("storage_trouble", status.storage_trouble);
  form("record_damage", status.record_damage);
  const bool from_a_file = !status.written_in_boot.empty();
  form.derived("written", from_a_file ? std::optional(civil_time(status.written_utc)) : std::nullopt);
  form("written_utc_ns", status.written_utc);
  form("written_since_boot_ns", status.written_since_boot);
  form("written_in_boot", status.written_in_boot);
  form("parts", status.parts);
  // Older versions do not write the members below.
  form.if_present("live_copy_trouble", true, status.live_copy_trouble);
  form.if_present("alarms", true, status.alarms);
  form.if_present("gyro_rates", true, status.gyro_rates);
  form.if_present("decision", true, status.decision);
  form.if_present("unreleased", true, status.unreleased);
  form.if_present("virtual_instruments", true, status.virtual_instruments);
  form.if_present("faults_while_off", true, status.faults_while_off);
  form.if_present("chamber_set_point_c", true, status.chamber_set_point);
  form.if_present("slot_since_boot_ns", true, status.slot_since_boot);
  form.if_present("slot_in_boot", true, status.slot_in_boot);
}

bool is_in_virtual_time(const RunStatus& status) { return status.simulated && status.virtual_instruments.empty(); }

std::string describe(RunState state, const std::string& cause) {
  if (cause.empty()) return name(state);
  if (cause.starts_with(name(state))) return cause;
  return fmt::format("{}: {}", name(state), cause);
}

std::string status_path(const std::string& record_path) { return record_path + ".status"; }

std::string to_json(const RunStatus& status) { return json_text(make_json(status)); }

Result<RunStatus> parse_status(const std::string& text, const std::string& where) {
  const auto root = JsonNode::parse(text, where);
  if (!root) return failure(root.error());
  const JsonNode schema = (*root)["schema"];
  if (schema.text() != kStatusSchema) schema.note_error(std::string("another schema, expected ") + kStatusSchema);
  RunStatus status;
  read_json(*root, status);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  if (!is_possible_time(status.written_utc) || !is_possible_time(status.written_since_boot)) {
    status.written_utc = status.written_since_boot = {};
    status.written_in_boot.clear();
  }
  if (!is_possible_time(status.slot_since_boot)) status.slot_in_boot.clear();
  if (!root->has("slot_in_boot")) {
    status.slot_since_boot = status.written_since_boot;
    status.slot_in_boot = status.written_in_boot;
  }
  return status;
}

/// Writes the status file without waiting for a sync. Readers need the file during the run. It must show that the disk
/// hangs even if a sync does not return.
Result<void> write_status(const RunStatus& status) {
  static const std::string boot = boot_id();
  auto now = status;
  now.written_utc = SteadyClock().now().utc;
  now.written_since_boot = since_boot();
  now.written_in_boot = boot;
  return replace_own_file(status_path(status.path), to_json(now) + '\n', Syncing::not_awaited);
}

std::optional<Duration> status_age(const RunStatus& status) {
  if (status.written_in_boot.empty() || status.written_in_boot != boot_id()) return {};
  return since_boot() - status.written_since_boot;
}

Result<RunStatus> read_status_file(const std::string& record_path) {
  const std::string where = status_path(record_path);
  return read_text_file(where).and_then([&](const std::string& text) { return parse_status(text, where); });
}

std::optional<RunStatus> read_status_file_if_any(const std::string& path) {
  const auto file = status_path(path);
  const auto text = read_text_file_if_any(file, kLargestText, Links::refused);
  if (!text || !*text) return std::nullopt;
  auto status = parse_status(**text, file);
  if (!status) return std::nullopt;
  status->path = path;
  return *std::move(status);
}

bool is_fresh(const RunStatus& status) {
  const auto age = status_age(status);
  return !status.finished && age && *age <= kSilentAfter;
}

std::optional<RunStatus> read_fresh_status(const std::string& path) {
  auto status = read_status_file_if_any(path);
  if (!status || !is_fresh(*status)) return std::nullopt;
  status->being_written = true;
  return status;
}

}  // namespace gyrotherm::record
