// SPDX-License-Identifier: Apache-2.0
/// The alarms of a run: what an interlock did stands until somebody has acknowledged it, whether its cause is over or
/// not. The list is made of the record's events alone, so that it outlives every program. Values; one thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/row.hpp"
#include "core/form.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

/// An event of an interlock that reacted.
struct Alarm {
  std::int64_t number{};  ///< of the event, in the record's table of events
  std::int64_t slot{};
  Duration utc{};
  std::string interlock;
  std::string reaction;
  std::string text;
  bool operator==(const Alarm&) const = default;
};

void describe(auto& form, Like<Alarm> auto& alarm) {
  form("number", alarm.number);
  form("slot", alarm.slot);
  form.derived("utc", civil_time(alarm.utc));
  form("utc_ns", alarm.utc);
  form("interlock", alarm.interlock);
  form("reaction", alarm.reaction);
  form("text", alarm.text);
}

class Alarms {
 public:
  /// So many stand at most; of more the oldest that only warn leave the list, and where none does the oldest of all.
  static constexpr std::size_t kMost = 256;

  /// Takes the next event of the run; one that neither is an alarm nor acknowledges one changes nothing.
  void see(const RecordedEvent& event);
  /// What belongs to that slot or to a later one is told again by the part of the record that follows.
  void forget_from(std::int64_t slot);

  /// The oldest first.
  [[nodiscard]] const std::vector<Alarm>& standing() const { return standing_; }
  /// Why that alarm cannot be acknowledged; empty: it can.
  [[nodiscard]] std::string objection(std::int64_t number) const;

 private:
  std::vector<Alarm> standing_;
  std::vector<std::int64_t> acknowledged_, crowded_out_;  ///< numbers
};

/// The event that acknowledges an alarm: its text begins with the number, which see() reads, "alarm 12 acknowledged by
/// ada (uid 1000): …". `at` and `segment` are those of now.
[[nodiscard]] Event acknowledgement_of(const Alarm& alarm, const Instant& at, std::optional<int> segment,
                                       std::string_view who, std::string_view comment);

/// As the record has them, of all the files that it consists of. Fails like read_record().
[[nodiscard]] Result<Alarms> alarms_of(const std::string& record_path);

/// The highest number that an event has in any file of the record; 0: there is none. Fails like read_record().
[[nodiscard]] Result<std::int64_t> last_event_of(const std::string& record_path);

}  // namespace gyrotherm::record
