// SPDX-License-Identifier: Apache-2.0
/// The alarms of a run, modelled after ISA-18.2 and IEC 62682: one row per alarm tag, which is an interlock and its
/// subject. A row counts its occurrences; it is active or returned to normal, and acknowledged or not. An alarm that is
/// a consequence of another alarm is suppressed and listed under that alarm. The list is computed only from the
/// record's events, so it survives the end of any program. An operator may shelve a warning for a time: it stays in the
/// record and is not announced. The types are values. Only one thread may use an object.
#pragma once

#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/row.hpp"
#include "core/form.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

/// The urgency of the operator's response, in increasing order.
enum class AlarmPriority { low, medium, high };
inline constexpr std::initializer_list<AlarmPriority> kAlarmPriorities = {AlarmPriority::low, AlarmPriority::medium,
                                                                          AlarmPriority::high};
[[nodiscard]] inline const char* name(AlarmPriority priority) {
  return enumerator_text<AlarmPriority::high>({"low", "medium", "high"}, priority);
}
/// Returns the priority of a reaction: abort is high, hold and suspend are medium, all others are low.
[[nodiscard]] AlarmPriority priority_for_reaction(std::string_view reaction);

/// The longest time for which an alarm can be shelved.
inline constexpr Duration kLongestShelving = std::chrono::hours(24);

/// One row of the list.
struct Alarm {
  std::int64_t number{};  ///< oldest unacknowledged event number
  /// The newest occurrence: its number, second and time.
  std::int64_t last_number{};
  std::int64_t slot{};
  Duration utc{};
  /// The first occurrence and the last return to normal; a return of 0 means none.
  Duration first_utc{};
  Duration returned_utc{};
  std::string interlock{};
  std::string subject{};  ///< channel, unit or line; empty: none
  /// The reaction and the message of the newest occurrence.
  std::string reaction{};
  std::string text{};
  AlarmPriority priority{};
  std::int64_t count{1};        ///< occurrences in this run
  bool active{true};            ///< false: returned to normal
  bool acknowledged{};          ///< every occurrence was acknowledged
  std::string suppressed_by{};  ///< tag of the root alarm
  /// The comment and the author of the last acknowledgement.
  std::string comment{};
  std::string acknowledged_by{};
  /// The user who shelved the alarm, and the reason. Both are empty if the alarm is not shelved. The row of a shelved
  /// alarm is `acknowledged`, so no program announces it.
  std::string shelved_by{};
  std::string shelving_reason{};
  /// The end of the shelving: since the start of the run, and UTC by the clock of the rig when it was shelved.
  Duration shelved_until{};
  Duration shelved_until_utc{};
  bool operator==(const Alarm&) const = default;

  /// Returns "door", "channel_lost A": the interlock, then the subject if there is one.
  [[nodiscard]] std::string tag() const;
  /// Returns true if an operator must acknowledge the alarm. A suppressed alarm is acknowledged with its root.
  [[nodiscard]] bool awaits_acknowledgement() const { return !acknowledged && suppressed_by.empty(); }
  [[nodiscard]] bool is_shelved() const { return !shelved_by.empty(); }
};

/// Totals of a run, with the rows that were removed because the list was full.
struct AlarmCount {
  std::int64_t occurrences{};
  std::int64_t tags{};
  std::int64_t unacknowledged{};  ///< rows that await an acknowledgement
};

/// Returns the state of a row: "active", "active, acknowledged", "returned" or "returned, acknowledged". A shelved row
/// is "active, shelved" or "returned, shelved".
[[nodiscard]] std::string describe_alarm_state(const Alarm& alarm);

/// Counts the rows that await an acknowledgement.
[[nodiscard]] std::size_t count_unacknowledged(std::span<const Alarm> alarms);

/// Describes a shelving: "shelved until 2026-01-05T14:20:00Z by ada (uid 1000): the fan is being replaced".
[[nodiscard]] std::string describe_shelving(const Alarm& alarm);

void describe(auto& form, Like<Alarm> auto& alarm) {
  form("number", alarm.number);
  form("slot", alarm.slot);
  form.derived("utc", civil_time(alarm.utc));
  form("utc_ns", alarm.utc);
  form("interlock", alarm.interlock);
  form("reaction", alarm.reaction);
  form("text", alarm.text);
  // Version 0.1.0 does not write the members below.
  form.if_present("last_number", true, alarm.last_number);
  form.if_present("subject", true, alarm.subject);
  form.if_present("priority", true, one_of(alarm.priority, kAlarmPriorities));
  form.if_present("count", true, alarm.count);
  form.if_present("first_utc_ns", true, alarm.first_utc);
  form.if_present("returned_utc_ns", true, alarm.returned_utc);
  form.if_present("active", true, alarm.active);
  form.if_present("acknowledged", true, alarm.acknowledged);
  form.if_present("suppressed_by", true, alarm.suppressed_by);
  form.if_present("acknowledged_by", true, alarm.acknowledged_by);
  form.if_present("comment", true, alarm.comment);
  form.if_present("shelved_by", alarm.is_shelved(), alarm.shelved_by);
  form.if_present("shelving_reason", alarm.is_shelved(), alarm.shelving_reason);
  form.if_present("shelved_until_ns", alarm.is_shelved(), alarm.shelved_until);
  form.if_present("shelved_until_utc_ns", alarm.is_shelved(), alarm.shelved_until_utc);
}

/// Returns the suffix of an alarm event's text that names its root alarm: " [consequence of host_late]".
[[nodiscard]] std::string consequence_suffix(std::string_view root_tag);

/// The state machine of the list. Transitions of a row:
/// - An occurrence makes the row active and unacknowledged, even if earlier occurrences were acknowledged.
/// - A return to normal makes the row inactive. If the row is acknowledged, it is also removed from the list.
/// - An acknowledgement covers all occurrences so far. An active row stays in the list until it returns to normal.
/// - An occurrence that names a root in the list is suppressed, with two exceptions: its reaction is hold or abort, or
///   the root is already acknowledged and has returned to normal or has a lower priority. If the root returns to normal
///   while a consequence is active, the consequence becomes a row of its own.
/// - A resumed run evaluates every condition again: no row is active until its interlock acts again.
/// - A shelved row is acknowledged, and its further warnings only count. It suppresses no consequences and is not
///   suppressed. The shelving ends with an unshelving event, or when the row occurs with another reaction than `warn`.
///   A row that is active when it is unshelved must be acknowledged, under the number of the unshelving event.
class Alarms {
 public:
  /// The maximum number of rows kept. Adding another row removes an old one: a row that is no longer in the list if
  /// there is one, otherwise the oldest row of the lowest priority. A root has the highest priority of its consequences
  /// and is removed after them; consequences whose root is removed become rows of their own.
  static constexpr std::size_t kMaxRows = 256;

  /// Updates the rows with the next event of the run. Ignores events that do not concern alarms.
  void update(const RecordedEvent& event);

  /// Returns the rows that are active, unacknowledged or shelved: the newest first, each followed by its consequences,
  /// and the shelved ones last.
  [[nodiscard]] std::vector<Alarm> list() const;
  /// Returns the row with the unacknowledged occurrence `number`, and the unacknowledged consequences of the row.
  [[nodiscard]] std::vector<Alarm> rows_for(std::int64_t number) const;
  /// Returns every row of the list with an unacknowledged occurrence, suppressed ones too.
  [[nodiscard]] std::vector<Alarm> unacknowledged() const;
  [[nodiscard]] AlarmCount count() const;
  /// Returns the reason why the occurrence `number` cannot be acknowledged; empty if it can.
  [[nodiscard]] std::string refusal_reason(std::int64_t number) const;

  /// Returns the row that an operator means by a number: that of the row, or of its newest occurrence.
  [[nodiscard]] std::optional<Alarm> find_row(std::int64_t number) const;
  [[nodiscard]] std::vector<Alarm> shelved() const;
  /// Return the reason why the row with this number cannot be shelved or unshelved, and the remedy; empty if it can.
  [[nodiscard]] std::string shelving_refusal_reason(std::int64_t number) const;
  [[nodiscard]] std::string unshelving_refusal_reason(std::int64_t number) const;

 private:
  struct Row {
    Alarm alarm;
    std::vector<std::int64_t> unacknowledged;  ///< numbers of occurrences, ascending
  };
  void raise(const RecordedEvent& event);
  void clear(const Event& event);
  void acknowledge(const Event& event);
  void shelve(Row& row, const Event& event);
  void unshelve(Row& row, const Event& event);
  void change_shelving(const Event& event);
  [[nodiscard]] bool has_consequences(const Alarm& alarm) const;
  void make_room();
  /// Returns the number of occurrences in a removed row, and forgets it.
  [[nodiscard]] std::int64_t take_removed_count(const std::string& tag);
  [[nodiscard]] bool is_listed(const Row& row) const;
  /// Returns whether a row is in the list. `root` is the row that suppresses it; null if there is none.
  [[nodiscard]] static bool is_listed(const Row& row, const Row* root);
  [[nodiscard]] const Row* find(std::string_view tag) const;
  [[nodiscard]] bool is_suppressed_by(const Row* root, const Alarm& alarm) const;
  [[nodiscard]] AlarmPriority priority_of_group(const Row& row) const;

  std::vector<Row> rows_;  ///< ordered by first occurrence
  /// Numbers of occurrences.
  std::vector<std::int64_t> acknowledged_, removed_numbers_, shelved_numbers_;
  /// Occurrences in the rows that were removed, by tag.
  std::map<std::string, std::int64_t> removed_counts_;
};

/// Returns the event that acknowledges a row: "alarm 12 acknowledged by ada (uid 1000): …", or "alarm 12 to 40
/// acknowledged by …" for several occurrences. Alarms::update() parses the numbers. `at` and `segment` are the present
/// instant and segment.
[[nodiscard]] Event acknowledgement_event(const Alarm& alarm, const Instant& at, std::optional<int> segment,
                                          std::string_view author, std::string_view comment);

/// Returns the event that shelves a row: "alarm 12 shelved for 2 h 00 min 00 s by ada (uid 1000): …". It is a command
/// that names the interlock. Alarms::update() parses the text.
[[nodiscard]] Event shelving_event(const Alarm& alarm, const Instant& at, std::optional<int> segment, Duration time,
                                   std::string_view author, std::string_view reason);
/// Returns the event that ends a shelving: "alarm 12 unshelved by ada (uid 1000)", or "alarm 12 unshelved: the time is
/// over". `cause` is the text after "unshelved".
[[nodiscard]] Event unshelving_event(const Alarm& alarm, const Instant& at, std::optional<int> segment,
                                     std::string_view cause);

}  // namespace gyrotherm::record
