// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/due_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/clock.hpp"
#include "core/json.hpp"

namespace gyrotherm::monitor {

inline constexpr const char* kMemorySchema = "gyrotherm-monitor-told/1";

void describe(auto& form, Like<NotificationProgress> auto& incident) {
  form("steps", incident.steps);
  form("at_utc_ns", incident.last_attempt);
  form("since_utc_ns", incident.began);
  form("failures", incident.failures);
}
void describe(auto& form, Like<LastSeenRun> auto& run) {
  form("name", run.name);
  form("record", run.record);
  form("rig", run.rig);
  form("simulated", run.simulated);
  form.if_present("virtual_rig", run.virtual_rig, run.virtual_rig);  // since 0.2.0
}
void describe(auto& form, Like<NotificationMemory> auto& memory) {
  form.derived("schema", kMemorySchema);
  form("running", memory.seen_active_);
  // Missing in files of older versions.
  form.if_present("going_on", !memory.last_seen_.empty(), named_values(memory.last_seen_));
  form("matters", named_values(memory.incidents_));
}

Result<NotificationMemory> NotificationMemory::parse(std::string_view text, const std::string& file) {
  const auto root = JsonNode::parse(text, file);
  if (!root) return failure(root.error());
  if (const auto schema = (*root)["schema"]; schema.text() != kMemorySchema)
    schema.note_error(std::string("unknown schema, expected ") + kMemorySchema);
  NotificationMemory memory;
  read_json(*root, memory);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return memory;
}

std::string NotificationMemory::to_text() const { return json_text(make_json(*this), 1) + "\n"; }

NotificationProgress& NotificationMemory::find_or_add_progress(const std::string& key, Duration now) {
  const auto found = std::ranges::find_if(incidents_, [&](const auto& known) { return known.first == key; });
  if (found != incidents_.end()) return found->second;
  return incidents_.emplace_back(key, NotificationProgress{.last_attempt = now, .began = now}).second;
}

void NotificationMemory::record_delivery(const DueMessage& message, Duration now) {
  auto& known = find_or_add_progress(message.key, now);
  ++known.steps;
  known.last_attempt = now;
  known.failures = 0;
}

void NotificationMemory::record_failure(const DueMessage& message, Duration now) {
  auto& known = find_or_add_progress(message.key, now);
  known.last_attempt = now;
  if (++known.failures < kMaxAttempts) return;
  ++known.steps;
  known.failures = 0;
}

void NotificationMemory::update_runs(const Situation& now) {
  for (const auto& run : now.runs) {
    if (run.running && std::ranges::find(seen_active_, run.id) == seen_active_.end()) seen_active_.push_back(run.id);
    std::erase_if(last_seen_, [&](const auto& known) { return known.first == run.id; });
    if (run.running)
      last_seen_.emplace_back(run.id, LastSeenRun{.name = run.name,
                                                  .record = run.record,
                                                  .rig = run.rig,
                                                  .simulated = run.simulated,
                                                  .virtual_rig = run.virtual_rig});
  }
}

std::vector<ObservedRun> NotificationMemory::missing_runs(const Situation& now) const {
  std::vector<ObservedRun> missing;
  for (const auto& [id, run] : last_seen_)
    if (std::ranges::find(now.runs, id, &ObservedRun::id) == now.runs.end())
      missing.push_back({.id = id,
                         .name = run.name,
                         .record = run.record,
                         .rig = run.rig,
                         .simulated = run.simulated,
                         .virtual_rig = run.virtual_rig,
                         .running = true,
                         .silent = true,
                         .outcome = {},
                         .alarms = {},
                         .free_bytes = {},
                         .missing = true});
  return missing;
}

void NotificationMemory::clamp_times(Duration utc) {
  for (auto& [key, progress] : incidents_) {
    progress.last_attempt = std::min(progress.last_attempt, utc);
    progress.began = std::min(progress.began, utc);
  }
  for (auto& [id, since] : missing_since_) since = std::min(since, utc);
}

/// Removes incidents that have ended. If a run cannot be read, for example because its folder is unmounted for a
/// moment, its incidents are kept for a day.
void NotificationMemory::remove_ended(const Situation& now, Duration utc, const std::set<std::string>& current) {
  constexpr Duration kForgetAfter = std::chrono::hours(24);
  std::set<std::string> seen;
  for (const auto& run : now.runs)
    if (!run.running || run.free_bytes) seen.insert(run.id);
  for (const auto& id : seen_active_)
    if (!seen.contains(id)) missing_since_.try_emplace(id, utc);
  std::erase_if(missing_since_, [&](const auto& run) { return seen.contains(run.first); });
  std::erase_if(seen_active_, [&](const std::string& id) {
    const auto missing = missing_since_.find(id);
    return missing != missing_since_.end() && utc - missing->second > kForgetAfter;
  });
  const auto is_forgotten = [&](const auto& run) {
    return std::ranges::find(seen_active_, run.first) == seen_active_.end();
  };
  std::erase_if(missing_since_, is_forgotten);
  std::erase_if(last_seen_, is_forgotten);
  std::erase_if(incidents_, [&](const auto& incident) {
    const auto concerns = [&](const auto& run) {
      return incident.first.find("|" + run.first + "|") != std::string::npos;
    };
    return !current.contains(incident.first) && std::ranges::none_of(missing_since_, concerns);
  });
}

namespace {

constexpr Duration kRetryAfter = std::chrono::minutes(1);

/// An alarm or another event to which a rule applies now.
struct Incident {
  std::string key;
  std::string subject;
  std::string text;
  std::string record;
  std::optional<std::int64_t> alarm;
  /// Waiting time before the first address is notified.
  Duration wait{};
  /// If true, one address after another is notified, at the interval of the rule. Otherwise all are notified together.
  bool escalates{};
};

std::string describe_run(const Site& site, const ObservedRun& run) {
  return fmt::format("{}{}{} on {}", site.name.empty() ? "" : site.name + ": ", run.simulated ? "SIMULATED " : "",
                     run.name, run.rig);
}

void find_run_incidents(const Site& site, const NotifyRule& rule, const ObservedRun& run, bool was_running,
                        std::vector<Incident>& found) {
  const auto key = [&](const std::string& what) { return fmt::format("{}|{}|{}", rule.name, run.id, what); };
  switch (rule.trigger) {
    case RuleTrigger::alarm:
      for (const auto& alarm : run.alarms)
        found.push_back({.key = key(fmt::format("alarm {}", alarm.number)),
                         .subject = "Alarm: " + describe_run(site, run),
                         .text = alarm.text,
                         .record = run.record,
                         .alarm = alarm.number,
                         .escalates = true});
      break;
    case RuleTrigger::ended:
      if (was_running && !run.running && !run.silent)
        found.push_back({.key = key("ended"),
                         .subject = "Ended: " + describe_run(site, run),
                         .text = run.outcome,
                         .record = run.record,
                         .alarm = {}});
      break;
    case RuleTrigger::disk_low:
      if (run.running && run.free_bytes && *run.free_bytes < rule.free_bytes)
        found.push_back({.key = key("disk"),
                         .subject = "Disk low: " + describe_run(site, run),
                         .text = fmt::format("{:.1f} GB free on the disk of {}",
                                             static_cast<double>(*run.free_bytes) / 1e9, run.record),
                         .record = run.record,
                         .alarm = {}});
      break;
    case RuleTrigger::silent:
      if (rule.monitor.empty() && run.silent)
        found.push_back({.key = key("silent"),
                         .subject = "Silent: " + describe_run(site, run),
                         .text = run.missing
                                     ? fmt::format("{} is missing, and the end of the run was not observed; the folder "
                                                   "may be unmounted, or the record was moved or deleted",
                                                   run.record)
                                     : fmt::format("the program that executes {} does not respond", run.record),
                         .record = run.record,
                         .alarm = {},
                         .wait = rule.after});
      break;
  }
}

std::vector<Incident> find_incidents(const Site& site, const NotifyRule& rule, const Situation& now,
                                     const std::vector<ObservedRun>& missing, const std::set<std::string>& known) {
  std::vector<Incident> found;
  for (const auto* runs : {&now.runs, &missing})
    for (const auto& run : *runs)
      if (known.contains(run.id) && (rule.simulated || !run.virtual_rig))
        find_run_incidents(site, rule, run, true, found);
  const auto answers = now.responding_monitors.find(rule.monitor);
  if (rule.trigger == RuleTrigger::silent && answers != now.responding_monitors.end() && !answers->second)
    found.push_back(
        {.key = fmt::format("{}|{}", rule.name, rule.monitor),
         .subject = fmt::format("{}{} does not respond", site.name.empty() ? "" : site.name + ": ", rule.monitor),
         .text = fmt::format("{} has not responded for {}; its machine or the network may be down", rule.monitor,
                             format_duration(rule.after)),
         .record = {},
         .alarm = {},
         .wait = rule.after});
  return found;
}

/// Returns the address to notify now, if any. For an incident that does not escalate, the next call returns the next
/// address.
std::vector<std::string> due_addresses(const NotifyRule& rule, const Incident& incident,
                                       const NotificationProgress& progress, Duration utc) {
  const auto steps = static_cast<std::size_t>(progress.steps);
  if (steps >= rule.addresses.size()) return {};
  if (progress.failures > 0 && utc - progress.last_attempt < kRetryAfter) return {};
  if (utc - progress.began < incident.wait) return {};
  const bool must_wait =
      incident.escalates && steps > 0 && progress.failures == 0 && utc - progress.last_attempt < rule.after;
  return must_wait ? std::vector<std::string>{} : std::vector{rule.addresses[steps]};
}

}  // namespace

std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc, NotificationMemory& memory) {
  memory.clamp_times(utc);
  memory.update_runs(now);
  const auto missing = memory.missing_runs(now);
  const std::set<std::string> known(memory.seen_active_.begin(), memory.seen_active_.end());
  std::vector<DueMessage> due;
  std::set<std::string> current;
  for (const auto& rule : site.rules)
    for (const auto& found : find_incidents(site, rule, now, missing, known)) {
      current.insert(found.key);
      for (const auto& address : due_addresses(rule, found, memory.find_or_add_progress(found.key, utc), utc))
        due.push_back({.key = found.key,
                       .rule = rule.name,
                       .address = address,
                       .subject = found.subject,
                       .text = found.text,
                       .record = found.record,
                       .alarm = found.alarm});
    }
  memory.remove_ended(now, utc, current);
  return due;
}

}  // namespace gyrotherm::monitor
