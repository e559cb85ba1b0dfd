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
struct AlarmSeen {
  std::int64_t number{};
  std::string text;
};

/// The properties of a run that rules use.
struct RunSeen {
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
  std::vector<AlarmSeen> alarms;
  /// Free space at the record of an active run; empty if unknown.
  std::optional<std::uint64_t> free_bytes;
  /// The run was active when it was last seen and can no longer be seen.
  bool missing{};
};

/// The situation to which the rules apply.
struct Situation {
  /// Readable runs.
  std::vector<RunSeen> runs;
  /// Whether each watched monitor answers, by URL.
  std::map<std::string, bool> monitors_answer;
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
struct ToldMatter {
  /// Number of addresses of the rule that were notified or given up.
  std::int64_t steps{};
  /// Time of the last message, UTC.
  Duration at{};
  /// Beginning of the matter, UTC.
  Duration since{};
  /// Failed deliveries to the next address.
  std::int64_t failures{};
  bool operator==(const ToldMatter&) const = default;
};

/// Data of a run that was active when it was last seen, for messages after it has disappeared.
struct RunGoingOn {
  std::string name;
  std::string record;
  std::string rig;
  bool simulated{};
  bool operator==(const RunGoingOn&) const = default;
};

class ToldMemory {
 public:
  [[nodiscard]] static Result<ToldMemory> parse(std::string_view text, const std::string& file);
  [[nodiscard]] std::string to_text() const;

  /// Records that the message was delivered, or that a delivery failed. After kMostTries failures the next address
  /// follows.
  void told(const DueMessage& message, Duration now);
  void failed(const DueMessage& message, Duration now);

  friend std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc, ToldMemory& memory);
  bool operator==(const ToldMemory&) const = default;

 private:
  friend void describe(auto& form, Like<ToldMemory> auto& memory);
  /// By key.
  std::vector<std::pair<std::string, ToldMatter>> matters_;
  /// Ids of runs that have been seen active, except those not seen for a day.
  std::vector<std::string> running_;
  /// Data of those runs in `running_` that were active when last seen, by id.
  std::vector<std::pair<std::string, RunGoingOn>> going_on_;
  /// Time since when each run in `running_` cannot be seen, UTC. Lost in a restart.
  std::map<std::string, Duration> gone_;

  void see(const Situation& now);
  [[nodiscard]] std::vector<RunSeen> missing(const Situation& now) const;
  void let_nothing_be_later_than(Duration utc);
  void forget(const Situation& now, Duration utc, const std::set<std::string>& standing);

  [[nodiscard]] ToldMatter& matter(const std::string& key, Duration now);
};

/// Failed deliveries to an address after which the next address is notified.
inline constexpr int kMostTries = 3;

/// Returns the messages that are due at `utc`. Runs that had ended when first seen, and their alarms, cause no
/// messages. Ended matters are removed from the memory; matters of a run that cannot be seen are removed after a day.
/// An active run that disappears is treated as silent. If the clock was set back, waiting times start at the new time.
[[nodiscard]] std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc,
                                                   ToldMemory& memory);

}  // namespace gyrotherm::monitor
