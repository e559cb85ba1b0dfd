// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/alarms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <tuple>
#include <utility>

#include "core/clock.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::record {
namespace {

constexpr std::string_view kAlarm = "alarm ", kStateSeparator = " to ", kAcknowledged = " acknowledged by ";
constexpr std::string_view kShelvedFor = " shelved for ", kUnshelved = " unshelved", kBy = " by ";
constexpr const char* kWarning = "warn";  ///< reaction
constexpr std::string_view kConsequence = " [consequence of ", kEnd = "]";
constexpr std::size_t kMaxNumbers = 1000;  ///< per row

bool is_alarm(const Event& event) {
  return (event.kind == EventKind::interlock || event.kind == EventKind::fault) && !event.about.interlock.empty();
}

/// Returns whether a row is active or awaits an acknowledgement.
bool needs_attention(const Alarm& alarm) { return alarm.active || !alarm.acknowledged; }

std::string alarm_tag(const EventSubject& about) {
  return about.channel.empty() ? about.interlock : about.interlock + " " + about.channel;
}

/// Removes a number from the front of the text and returns it; 0 if there is none.
std::int64_t take_number(std::string_view& text) {
  std::int64_t number{};
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc()) return 0;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return number;
}

/// Splits "ada (uid 1000): the cable" into author and text.
std::pair<std::string, std::string> split_author(std::string_view text) {
  const auto colon = std::min(text.find(": "), text.size());
  return {std::string(text.substr(0, colon)), std::string(text.substr(std::min(colon + 2, text.size())))};
}

/// The parts of an acknowledgement's text. `first` is 0 if the text is not an acknowledgement.
struct AcknowledgementText {
  std::int64_t first{}, last{};
  std::string author, comment;
};

AcknowledgementText parse_acknowledgement(std::string_view text) {
  if (!text.starts_with(kAlarm)) return {};
  text.remove_prefix(kAlarm.size());
  const auto first = take_number(text);
  auto last = first;
  if (text.starts_with(kStateSeparator)) {
    text.remove_prefix(kStateSeparator.size());
    last = take_number(text);
  }
  if (first <= 0 || last < first || !text.starts_with(kAcknowledged)) return {};
  text.remove_prefix(kAcknowledged.size());
  auto [author, comment] = split_author(text);
  return {.first = first, .last = last, .author = std::move(author), .comment = std::move(comment)};
}

/// The parts of a shelving's text. `time` is 0 if the text does not shelve an alarm.
struct ShelvingText {
  Duration time{};
  std::string author, reason;
};

/// Removes "alarm 12" from the front of the text and returns whether it was there.
bool take_alarm(std::string_view& text) {
  if (!text.starts_with(kAlarm)) return false;
  text.remove_prefix(kAlarm.size());
  return take_number(text) > 0;
}

ShelvingText parse_shelving(std::string_view text) {
  if (!take_alarm(text) || !text.starts_with(kShelvedFor)) return {};
  text.remove_prefix(kShelvedFor.size());
  const auto by = text.find(kBy);
  if (by == std::string_view::npos) return {};
  const auto time = parse_duration(text.substr(0, by));
  auto [author, reason] = split_author(text.substr(by + kBy.size()));
  if (!time || *time > kLongestShelving || author.empty()) return {};
  return {.time = *time, .author = std::move(author), .reason = std::move(reason)};
}

std::string unknown_alarm(std::int64_t number) {
  return fmt::format("there is no alarm {}; \"gyrotherm status\" lists the alarms", number);
}

bool is_unshelving(std::string_view text) { return take_alarm(text) && text.starts_with(kUnshelved); }

Event make_alarm_event(EventKind kind, const Alarm& alarm, const Instant& at, std::optional<int> segment,
                       std::string text) {
  return {.at = at,
          .kind = kind,
          .text = std::move(text),
          .about = {
              .interlock = alarm.interlock, .reaction = alarm.reaction, .segment = segment, .channel = alarm.subject}};
}

void end_shelving(Alarm& alarm) {
  alarm.shelved_by.clear();
  alarm.shelving_reason.clear();
  alarm.shelved_until = alarm.shelved_until_utc = {};
}

/// Splits the text of an alarm into its message and the tag of its root. The tag is empty if the text names no root.
std::pair<std::string, std::string> split_root(const std::string& text) {
  const auto begin = text.rfind(kConsequence);
  if (begin == std::string::npos || !text.ends_with(kEnd)) return {text, ""};
  const auto tag = begin + kConsequence.size();
  return {text.substr(0, begin), text.substr(tag, text.size() - kEnd.size() - tag)};
}

}  // namespace

AlarmPriority priority_for_reaction(std::string_view reaction) {
  if (reaction == "abort") return AlarmPriority::high;
  return reaction == "hold" || reaction == "suspend" ? AlarmPriority::medium : AlarmPriority::low;
}

std::string Alarm::tag() const { return subject.empty() ? interlock : interlock + " " + subject; }

std::string describe_alarm_state(const Alarm& alarm) {
  const auto* handled = alarm.is_shelved() ? ", shelved" : alarm.acknowledged ? ", acknowledged" : "";
  return fmt::format("{}{}", alarm.active ? "active" : "returned", handled);
}

std::string describe_shelving(const Alarm& alarm) {
  return fmt::format("shelved until {} by {}: {}", civil_time(alarm.shelved_until_utc), alarm.shelved_by,
                     alarm.shelving_reason);
}

std::size_t count_unacknowledged(std::span<const Alarm> alarms) {
  return static_cast<std::size_t>(std::ranges::count_if(alarms, &Alarm::awaits_acknowledgement));
}

std::string consequence_suffix(std::string_view root_tag) {
  return fmt::format("{}{}{}", kConsequence, root_tag, kEnd);
}

const Alarms::Row* Alarms::find(std::string_view tag) const {
  const auto found = std::ranges::find_if(rows_, [&](const Row& row) { return row.alarm.tag() == tag; });
  return found == rows_.end() ? nullptr : &*found;
}

bool Alarms::is_listed(const Row& row) const {
  return is_listed(row, row.alarm.suppressed_by.empty() ? nullptr : find(row.alarm.suppressed_by));
}

bool Alarms::is_listed(const Row& row, const Row* root) {
  const auto& alarm = row.alarm;
  if (alarm.suppressed_by.empty()) return needs_attention(alarm) || alarm.is_shelved();
  return alarm.active || (root && root->alarm.suppressed_by.empty() && is_listed(*root, nullptr));
}

AlarmPriority Alarms::priority_of_group(const Row& row) const {
  auto most = row.alarm.priority;
  for (const auto& other : rows_)
    if (other.alarm.suppressed_by == row.alarm.tag()) most = std::max(most, other.alarm.priority);
  return most;
}

bool Alarms::is_suppressed_by(const Row* root, const Alarm& alarm) const {
  if (!root || !root->alarm.suppressed_by.empty() || root->alarm.tag() == alarm.tag()) return false;
  if (root->alarm.is_shelved() || alarm.is_shelved()) return false;
  if (alarm.reaction == "hold" || alarm.reaction == "abort") return false;
  if (!root->alarm.acknowledged) return true;
  return root->alarm.active && alarm.priority <= priority_of_group(*root);
}

std::int64_t Alarms::take_removed_count(const std::string& tag) {
  const auto removed = removed_counts_.extract(tag);
  return removed ? removed.mapped() : 0;
}

void Alarms::raise(const RecordedEvent& recorded) {
  const auto& event = recorded.event;
  auto row = std::ranges::find_if(rows_, [&](const Row& one) { return one.alarm.tag() == alarm_tag(event.about); });
  if (row == rows_.end()) {
    rows_.push_back({.alarm = {.first_utc = event.at.utc,
                               .interlock = event.about.interlock,
                               .subject = event.about.channel,
                               .count = take_removed_count(alarm_tag(event.about)),
                               .acknowledged = true},
                     .unacknowledged = {}});
    row = std::prev(rows_.end());
  }
  auto& alarm = row->alarm;
  auto [text, root] = split_root(event.text);
  alarm.slot = recorded.slot;
  alarm.utc = event.at.utc;
  alarm.reaction = event.about.reaction;
  alarm.priority = priority_for_reaction(alarm.reaction);
  alarm.text = std::move(text);
  ++alarm.count;
  alarm.active = true;
  alarm.last_number = event.number;
  if (alarm.is_shelved() && alarm.reaction == kWarning) {
    shelved_numbers_.push_back(event.number);
    return;
  }
  end_shelving(alarm);
  alarm.suppressed_by = is_suppressed_by(find(root), alarm) ? root : std::string();
  alarm.acknowledged = false;
  if (row->unacknowledged.size() >= kMaxNumbers) row->unacknowledged.erase(row->unacknowledged.begin() + 1);
  row->unacknowledged.push_back(event.number);
  alarm.number = row->unacknowledged.front();
  make_room();
}

void Alarms::clear(const Event& event) {
  const auto tag = alarm_tag(event.about);
  for (auto& row : rows_) {
    if (row.alarm.tag() == tag && row.alarm.active) {
      row.alarm.active = false;
      row.alarm.returned_utc = event.at.utc;
    }
    if (row.alarm.suppressed_by == tag && row.alarm.active) row.alarm.suppressed_by.clear();
  }
}

void Alarms::acknowledge(const Event& event) {
  const auto parsed = parse_acknowledgement(event.text);
  for (auto& row : rows_) {
    const auto is_covered = [&](std::int64_t number) { return number >= parsed.first && number <= parsed.last; };
    if (std::ranges::find(row.unacknowledged, parsed.first) == row.unacknowledged.end()) continue;
    std::ranges::copy_if(row.unacknowledged, std::back_inserter(acknowledged_), is_covered);
    std::erase_if(row.unacknowledged, is_covered);
    row.alarm.acknowledged = row.unacknowledged.empty();
    if (!row.unacknowledged.empty()) row.alarm.number = row.unacknowledged.front();
    row.alarm.acknowledged_by = parsed.author;
    row.alarm.comment = parsed.comment;
  }
}

/// Moves the occurrences so far to the shelved ones: they need no acknowledgement.
void Alarms::shelve(Row& row, const Event& event) {
  auto parsed = parse_shelving(event.text);
  auto& alarm = row.alarm;
  if (parsed.time <= Duration{} || alarm.is_shelved() || alarm.reaction != kWarning) return;
  shelved_numbers_.insert(shelved_numbers_.end(), row.unacknowledged.begin(), row.unacknowledged.end());
  row.unacknowledged.clear();
  alarm.acknowledged = true;
  alarm.shelved_by = std::move(parsed.author);
  alarm.shelving_reason = std::move(parsed.reason);
  alarm.shelved_until = event.at.since_start + parsed.time;
  alarm.shelved_until_utc = event.at.utc + parsed.time;
}

void Alarms::unshelve(Row& row, const Event& event) {
  end_shelving(row.alarm);
  if (!row.alarm.active) return;
  row.unacknowledged = {event.number};
  row.alarm.number = event.number;
  row.alarm.acknowledged = false;
}

void Alarms::change_shelving(const Event& event) {
  const auto tag = alarm_tag(event.about);
  const auto row = std::ranges::find_if(rows_, [&](const Row& one) { return one.alarm.tag() == tag; });
  if (row == rows_.end()) return;
  if (is_unshelving(event.text) && row->alarm.is_shelved()) return unshelve(*row, event);
  shelve(*row, event);
}

void Alarms::make_room() {
  if (rows_.size() <= kMaxRows) return;
  struct Group {
    const Row* root{};
    AlarmPriority priority{};
    bool has_consequences{};
  };
  std::map<std::string, Group> groups;
  for (const auto& row : rows_) groups[row.alarm.tag()] = {&row, row.alarm.priority, false};
  for (const auto& row : rows_) {
    if (row.alarm.suppressed_by.empty()) continue;
    auto& group = groups[row.alarm.suppressed_by];
    group.priority = std::max(group.priority, row.alarm.priority);
    group.has_consequences = group.has_consequences || needs_attention(row.alarm);
  }
  const auto rank = [&](const Row& row) {
    const auto& own = groups.at(row.alarm.tag());
    const auto* root = row.alarm.suppressed_by.empty() ? nullptr : groups.at(row.alarm.suppressed_by).root;
    return std::tuple(is_listed(row, root), own.priority, own.has_consequences);
  };
  const auto newest = std::prev(rows_.end());
  const auto least = std::ranges::min_element(rows_.begin(), newest, {}, rank);
  removed_numbers_.insert(removed_numbers_.end(), least->unacknowledged.begin(), least->unacknowledged.end());
  const auto tag = least->alarm.tag();
  removed_counts_[tag] = least->alarm.count;
  rows_.erase(least);
  for (auto& row : rows_)
    if (row.alarm.suppressed_by == tag) row.alarm.suppressed_by.clear();
}

void Alarms::update(const RecordedEvent& recorded) {
  const auto& event = recorded.event;
  if (is_alarm(event)) return raise(recorded);
  if (event.kind == EventKind::acknowledged) return acknowledge(event);
  if (event.kind == EventKind::recovered && !event.about.interlock.empty()) return clear(event);
  if (event.kind == EventKind::command && !event.about.interlock.empty()) return change_shelving(event);
  if (event.kind != EventKind::resumed) return;
  for (auto& row : rows_) row.alarm.active = false;
}

std::vector<Alarm> Alarms::list() const {
  std::vector<Alarm> roots, all;
  for (const auto& row : rows_)
    if (is_listed(row) && row.alarm.suppressed_by.empty()) {
      roots.push_back(row.alarm);
      roots.back().priority = priority_of_group(row);
    }
  std::ranges::stable_sort(roots, std::ranges::greater{},
                           [](const Alarm& alarm) { return std::pair(!alarm.is_shelved(), alarm.last_number); });
  for (auto& root : roots) {
    const auto tag = root.tag();
    all.push_back(std::move(root));
    for (const auto& row : rows_)
      if (row.alarm.suppressed_by == tag) all.push_back(row.alarm);
  }
  return all;
}

std::vector<Alarm> Alarms::rows_for(std::int64_t number) const {
  std::vector<Alarm> found;
  for (const auto& row : rows_) {
    if (std::ranges::find(row.unacknowledged, number) == row.unacknowledged.end()) continue;
    found.push_back(row.alarm);
    for (const auto& other : rows_)
      if (other.alarm.suppressed_by == row.alarm.tag() && !other.alarm.acknowledged) found.push_back(other.alarm);
  }
  return found;
}

std::vector<Alarm> Alarms::unacknowledged() const {
  std::vector<Alarm> found;
  for (const auto& row : rows_)
    if (!row.alarm.acknowledged && is_listed(row)) found.push_back(row.alarm);
  return found;
}

AlarmCount Alarms::count() const {
  AlarmCount count{.tags = static_cast<std::int64_t>(rows_.size() + removed_counts_.size())};
  for (const auto& [tag, occurrences] : removed_counts_) count.occurrences += occurrences;
  for (const auto& row : rows_) {
    count.occurrences += row.alarm.count;
    count.unacknowledged += row.alarm.awaits_acknowledgement() ? 1 : 0;
  }
  return count;
}

std::string Alarms::refusal_reason(std::int64_t number) const {
  const auto has_number = [&](const Row& row) {
    return std::ranges::find(row.unacknowledged, number) != row.unacknowledged.end();
  };
  if (std::ranges::any_of(rows_, has_number)) return {};
  if (std::ranges::find(shelved_numbers_, number) != shelved_numbers_.end())
    return fmt::format("alarm {} was shelved and needs no acknowledgement", number);
  if (std::ranges::find(acknowledged_, number) != acknowledged_.end())
    return fmt::format("alarm {} is acknowledged already", number);
  if (std::ranges::find(removed_numbers_, number) != removed_numbers_.end())
    return fmt::format("alarm {} is no longer in the list, which has {} rows at most", number, kMaxRows);
  return unknown_alarm(number);
}

bool Alarms::has_consequences(const Alarm& alarm) const {
  return std::ranges::any_of(
      rows_, [&](const Row& row) { return row.alarm.suppressed_by == alarm.tag() && needs_attention(row.alarm); });
}

std::optional<Alarm> Alarms::find_row(std::int64_t number) const {
  for (const auto& row : rows_)
    if (row.alarm.number == number || row.alarm.last_number == number) return row.alarm;
  return std::nullopt;
}

std::vector<Alarm> Alarms::shelved() const {
  std::vector<Alarm> found;
  for (const auto& row : rows_)
    if (row.alarm.is_shelved()) found.push_back(row.alarm);
  return found;
}

std::string Alarms::shelving_refusal_reason(std::int64_t number) const {
  const auto row = find_row(number);
  if (!row) return unknown_alarm(number);
  if (row->is_shelved())
    return fmt::format("alarm {} is {}; unshelve it before you shelve it again", number, describe_shelving(*row));
  if (row->reaction != kWarning)
    return fmt::format(
        "alarm {} has the reaction {}, and only a warning can be shelved; acknowledge it and remove its "
        "cause",
        number, row->reaction);
  if (!row->suppressed_by.empty())
    return fmt::format("alarm {} is a consequence of {} and is not announced; acknowledge that alarm", number,
                       row->suppressed_by);
  if (has_consequences(*row))
    return fmt::format("alarm {} suppresses its consequences, which shelving would hide; acknowledge it", number);
  return {};
}

std::string Alarms::unshelving_refusal_reason(std::int64_t number) const {
  const auto row = find_row(number);
  if (!row) return unknown_alarm(number);
  return row->is_shelved() ? std::string() : fmt::format("alarm {} is not shelved", number);
}

Event acknowledgement_event(const Alarm& alarm, const Instant& at, std::optional<int> segment, std::string_view author,
                            std::string_view comment) {
  const auto last = alarm.last_number > alarm.number ? fmt::format("{}{}", kStateSeparator, alarm.last_number) : "";
  return make_alarm_event(EventKind::acknowledged, alarm, at, segment,
                          fmt::format("{}{}{}{}{}: {}", kAlarm, alarm.number, last, kAcknowledged, author, comment));
}

Event shelving_event(const Alarm& alarm, const Instant& at, std::optional<int> segment, Duration time,
                     std::string_view author, std::string_view reason) {
  return make_alarm_event(
      EventKind::command, alarm, at, segment,
      fmt::format("{}{}{}{}{}{}: {}", kAlarm, alarm.number, kShelvedFor, format_duration(time), kBy, author, reason));
}

Event unshelving_event(const Alarm& alarm, const Instant& at, std::optional<int> segment, std::string_view cause) {
  return make_alarm_event(EventKind::command, alarm, at, segment,
                          fmt::format("{}{}{}{}", kAlarm, alarm.number, kUnshelved, cause));
}

}  // namespace gyrotherm::record
