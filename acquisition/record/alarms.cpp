// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/alarms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "acquisition/record/run_parts.hpp"
#include "acquisition/record/sqlite.hpp"

namespace gyrotherm::record {
namespace {

constexpr std::string_view kAlarm = "alarm ", kAcknowledged = " acknowledged by ";
constexpr std::string_view kMildest = "warn";  ///< of the reactions

bool is_alarm(const Event& event) {
  return (event.kind == EventKind::interlock || event.kind == EventKind::fault) && !event.about.interlock.empty();
}

/// The number in the text of an acknowledgement; 0 where there is none.
std::int64_t acknowledged_in(std::string_view text) {
  if (!text.starts_with(kAlarm)) return 0;
  text.remove_prefix(kAlarm.size());
  std::int64_t number{};
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc()) return 0;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return text.starts_with(kAcknowledged) ? number : 0;
}

Result<void> see_events(Alarms& alarms, Database& database) {
  const auto sql = fmt::format("SELECT id, {} FROM event WHERE kind IN ('{}', '{}', '{}') ORDER BY id",
                               names_of(columns_of_events()), name(EventKind::interlock), name(EventKind::fault),
                               name(EventKind::acknowledged));
  return database.each_row(sql, [&](const Statement& row) {
    RecordedEvent recorded;
    int i = 1;
    take(recorded, columns_of_events(), row, i);
    recorded.event.number = row.integer(0);
    alarms.see(recorded);
  });
}

}  // namespace

void Alarms::see(const RecordedEvent& recorded) {
  const auto& [slot, event] = recorded;
  if (is_alarm(event)) {
    standing_.push_back({event.number, slot, event.at.utc, event.about.interlock, event.about.reaction, event.text});
    if (standing_.size() <= kMost) return;
    const auto mild = std::ranges::find(standing_, kMildest, &Alarm::reaction);
    const auto least = mild != standing_.end() ? mild : standing_.begin();
    crowded_out_.push_back(least->number);
    standing_.erase(least);
  }
  if (event.kind != EventKind::acknowledged) return;
  const auto number = acknowledged_in(event.text);
  if (std::erase_if(standing_, [&](const Alarm& alarm) { return alarm.number == number; }) > 0)
    acknowledged_.push_back(number);
}

void Alarms::forget_from(std::int64_t slot) {
  std::erase_if(standing_, [&](const Alarm& alarm) { return alarm.slot >= slot; });
}

std::string Alarms::objection(std::int64_t number) const {
  if (std::ranges::find(standing_, number, &Alarm::number) != standing_.end()) return {};
  if (std::ranges::find(acknowledged_, number) != acknowledged_.end())
    return fmt::format("alarm {} is acknowledged already", number);
  if (std::ranges::find(crowded_out_, number) != crowded_out_.end())
    return fmt::format("alarm {} left the list, which holds {}, for later ones", number, kMost);
  return fmt::format("there is no alarm {}; \"gyrotherm status\" shows those that stand", number);
}

Event acknowledgement_of(const Alarm& alarm, const Instant& at, std::optional<int> segment, std::string_view who,
                         std::string_view comment) {
  return {.at = at,
          .kind = EventKind::acknowledged,
          .text = fmt::format("{}{}{}{}: {}", kAlarm, alarm.number, kAcknowledged, who, comment),
          .about = {.interlock = alarm.interlock, .reaction = alarm.reaction, .segment = segment}};
}

Result<Alarms> alarms_of(const std::string& record_path) {
  const auto files = files_of_record(record_path);
  if (!files) return failure(files.error());
  Alarms alarms;
  for (const auto& part : files->parts) {
    const bool is_last = &part == &files->parts.back();
    auto database = open_record(part.path);
    if (!database && !is_last && !is_locked(database.error())) continue;
    if (!database) return failure(database.error());
    alarms.forget_from(part.continuation.from);
    const auto seen = see_events(alarms, *database);
    if (!seen && is_last) return failure(seen.error());
  }
  return alarms;
}

Result<std::int64_t> last_event_of(const std::string& record_path) {
  const auto files = files_of_record(record_path);
  if (!files) return failure(files.error());
  std::int64_t highest = 0;
  for (const auto& part : files->parts) {
    const auto number = open_record(part.path).and_then(
        [](Database database) { return database.ask_integer("SELECT max(id) FROM event", 0); });
    const bool is_needed = &part == &files->parts.back();
    if (!number && (is_needed || is_locked(number.error()))) return failure(number.error());
    if (number) highest = std::max(highest, *number);
  }
  return highest;
}

}  // namespace gyrotherm::record
