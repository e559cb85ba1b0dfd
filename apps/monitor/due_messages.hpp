// SPDX-License-Identifier: Apache-2.0
/// Determines the notifications that are due, from the rules, the observed runs and the earlier notifications. Does no
/// input or output. The caller stores the memory in a file, so after a restart no message is sent twice, and
/// escalations continue.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/monitor/site_file.hpp"
#include "core/form.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// An unacknowledged alarm of a run.
struct ObservedAlarm {
  std::int64_t number{};
  std::string text;
};

/// The properties of a run that rules use.
struct ObservedRun {
  std::string id;
  std::string name;
  /// Path of the record.
  std::string record;
  std::string rig;
  /// The run is marked as SIMULATED.
  bool simulated{};
  /// All instruments of the run are virtual, and so is its time.
  bool virtual_rig{};
  /// A program executes the run. It may be silent.
  bool running{};
  /// The program does not respond, or it ended without finishing the run.
  bool silent{};
  /// Outcome of a run that has ended, such as "complete" or "aborted: …".
  std::string outcome;
  std::vector<ObservedAlarm> alarms;
  /// Free space at the record of an active run; empty if unknown.
  std::optional<std::uint64_t> free_bytes;
  /// The run was active when it was last seen, and its record can no longer be found.
  bool missing{};
};

/// The observations to which the rules are applied.
struct Situation {
  /// Readable runs.
  std::vector<ObservedRun> runs;
  /// Whether each monitor named in a rule responds, by URL.
  std::map<std::string, bool> responding_monitors;
};

/// A message to one address.
struct DueMessage {
  /// Key in the memory.
  std::string key;
  std::string rule;
  std::string address;
  std::string subject;
  std::string text;
  /// Path of the run's record; empty if the message does not concern a run.
  std::string record;
  std::optional<std::int64_t> alarm;
};

/// Progress of the messages about an incident: an alarm or another event to which a rule applies.
struct NotificationProgress {
  /// Number of addresses that were notified, or skipped after failed deliveries.
  std::int64_t steps{};
  /// Time of the last delivery or failure, UTC.
  Duration last_attempt{};
  /// Time when the incident began, UTC.
  Duration began{};
  /// Number of failed deliveries to the current address.
  std::int64_t failures{};
  bool operator==(const NotificationProgress&) const = default;
};

/// Data of an active run, for messages after its record has disappeared.
struct LastSeenRun {
  std::string name;
  std::string record;
  std::string rig;
  bool simulated{};
  bool virtual_rig{};
  bool operator==(const LastSeenRun&) const = default;
};

class NotificationMemory {
 public:
  /// Parses the text of a memory file. Fails with bad_file.
  [[nodiscard]] static Result<NotificationMemory> parse(std::string_view text, const std::string& file);
  [[nodiscard]] std::string to_text() const;

  /// Record that a message was delivered, or that its delivery failed. After kMaxAttempts failures, the next address is
  /// notified.
  void record_delivery(const DueMessage& message, Duration now);
  void record_failure(const DueMessage& message, Duration now);

  friend std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc,
                                              NotificationMemory& memory);
  bool operator==(const NotificationMemory&) const = default;

 private:
  friend void describe(auto& form, Like<NotificationMemory> auto& memory);
  /// Progress of each incident, by key.
  std::vector<std::pair<std::string, NotificationProgress>> incidents_;
  /// Ids of the runs that this monitor has seen active. A run that has been missing for a day is removed.
  std::vector<std::string> seen_active_;
  /// Data of the runs that were active when last seen, by id.
  std::vector<std::pair<std::string, LastSeenRun>> last_seen_;
  /// Time when each run of `seen_active_` was first found missing, UTC. Not stored in the file.
  std::map<std::string, Duration> missing_since_;

  void update_runs(const Situation& now);
  [[nodiscard]] std::vector<ObservedRun> missing_runs(const Situation& now) const;
  void clamp_times(Duration utc);
  void remove_ended(const Situation& now, Duration utc, const std::set<std::string>& current);

  /// Returns the progress of an incident. Adds one that begins `now` if there is none.
  [[nodiscard]] NotificationProgress& find_or_add_progress(const std::string& key, Duration now);
};

/// Number of deliveries that are tried to an address before the next address is notified.
inline constexpr int kMaxAttempts = 3;

/// Returns the messages that are due at `utc`, and updates the memory. A run that had ended when it was first seen
/// causes no messages. An active run that disappears is treated as silent. Incidents are removed from the memory when
/// they end, or after a day if their run is missing. If the clock was set back, waiting times start at the new time.
[[nodiscard]] std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc,
                                                   NotificationMemory& memory);

}  // namespace gyrotherm::monitor
