// SPDX-License-Identifier: Apache-2.0
/// Determines the messages that are due: compares the rules with the situation and with earlier messages. Pure except
/// for the memory. The memory is stored in a file: after a restart no message is sent twice, and escalations continue.
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
  bool simulated{};
  /// A program executes the run, even if it is silent.
  bool running{};
  /// The program does not answer, or the run was left unfinished.
  bool silent{};
  /// Outcome of a run that has ended: "complete", "aborted: …".
  std::string outcome;
  std::vector<ObservedAlarm> alarms;
  /// Free space at the record of an active run; empty if unknown.
  std::optional<std::uint64_t> free_bytes;
  /// The run was active when it was last seen and can no longer be seen.
  bool missing{};
};

/// The situation to which the rules apply.
struct Situation {
  /// Readable runs.
  std::vector<ObservedRun> runs;
  /// Whether each watched monitor answers, by URL.
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
  /// Record of the run; empty if the message concerns no run.
  std::string record;
  std::optional<std::int64_t> alarm;
};

/// Progress of the messages about a matter: an alarm or another event that a rule reports.
struct NotificationProgress {
  /// Number of addresses of the rule that were notified or given up.
  std::int64_t steps{};
  /// Time of the last message, UTC.
  Duration at{};
  /// Beginning of the matter, UTC.
  Duration since{};
  /// Failed deliveries to the next address.
  std::int64_t failures{};
  bool operator==(const NotificationProgress&) const = default;
};

/// Data of a run that was active when it was last seen, for messages after it has disappeared.
struct LastSeenRun {
  std::string name;
  std::string record;
  std::string rig;
  bool simulated{};
  bool operator==(const LastSeenRun&) const = default;
};

class NotificationMemory {
 public:
  [[nodiscard]] static Result<NotificationMemory> parse(std::string_view text, const std::string& file);
  [[nodiscard]] std::string to_text() const;

  /// Records that the message was delivered, or that a delivery failed. After kMaxAttempts failures the next address
  /// follows.
  void record_delivery(const DueMessage& message, Duration now);
  void record_failure(const DueMessage& message, Duration now);

  friend std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc,
                                              NotificationMemory& memory);
  bool operator==(const NotificationMemory&) const = default;

 private:
  friend void describe(auto& form, Like<NotificationMemory> auto& memory);
  /// By key.
  std::vector<std::pair<std::string, NotificationProgress>> incidents_;
  /// Ids of runs that have been seen active, except those not seen for a day.
  std::vector<std::string> seen_active_;
  /// Data of those runs in `seen_active_` that were active when last seen, by id.
  std::vector<std::pair<std::string, LastSeenRun>> last_seen_;
  /// Time since when each run in `seen_active_` cannot be seen, UTC. Lost in a restart.
  std::map<std::string, Duration> missing_since_;

  void update_runs(const Situation& now);
  [[nodiscard]] std::vector<ObservedRun> missing_runs(const Situation& now) const;
  void clamp_times(Duration utc);
  void remove_ended(const Situation& now, Duration utc, const std::set<std::string>& current);

  [[nodiscard]] NotificationProgress& find_or_add(const std::string& key, Duration now);
};

/// Failed deliveries to an address after which the next address is notified.
inline constexpr int kMaxAttempts = 3;

/// Returns the messages that are due at `utc`. Runs that had ended when first seen, and their alarms, cause no
/// messages. Ended matters are removed from the memory; matters of a run that cannot be seen are removed after a day.
/// An active run that disappears is treated as silent. If the clock was set back, waiting times start at the new time.
[[nodiscard]] std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc,
                                                   NotificationMemory& memory);

}  // namespace gyrotherm::monitor
