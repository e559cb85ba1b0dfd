// SPDX-License-Identifier: Apache-2.0
/// Who is to be told of what now: rules against what is the case and what was told already. Pure, but for the memory,
/// which outlives the monitor in a file of its own, so that nothing is told twice and an escalation goes on.
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

/// An alarm of a run that awaits an acknowledgement.
struct AlarmSeen {
  std::int64_t number{};
  std::string text;
};

/// What rules look at, of one run.
struct RunSeen {
  std::string id;
  std::string name;
  std::string record;  ///< its path
  std::string rig;
  bool simulated{};
  bool running{};       ///< a program carries it out, silent or not
  bool silent{};        ///< … and does not answer; or it was left unfinished
  std::string outcome;  ///< of a run that is not running: "complete", "aborted: …"
  std::vector<AlarmSeen> alarms;
  std::optional<std::uint64_t> free_bytes;  ///< where it is recorded, as long as it runs; nothing: unknown now
  bool missing{};                           ///< it ran when it was last seen, and cannot be seen any more
};

/// What is the case.
struct Situation {
  std::vector<RunSeen> runs;                    ///< that are there and can be read
  std::map<std::string, bool> monitors_answer;  ///< by URL
};

/// Something to be told to one address.
struct DueMessage {
  std::string key;  ///< of the memory
  std::string rule;
  std::string address;
  std::string subject;
  std::string text;
  std::string record;  ///< of the run that it is about; empty: of none
  std::optional<std::int64_t> alarm;
};

/// How far a matter has been told.
struct ToldMatter {
  std::int64_t steps{};     ///< addresses of the rule that were told, or could not be reached in time
  Duration at{};            ///< the last of them, UTC
  Duration since{};         ///< when the matter began, UTC
  std::int64_t failures{};  ///< of the address that is next
  bool operator==(const ToldMatter&) const = default;
};

/// A run that a program carried out when it was last seen: what is to be said of it once it cannot be.
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

  /// The message was given away; or could not be, `so many` times since: then it is the next address's turn.
  void told(const DueMessage& message, Duration now);
  void failed(const DueMessage& message, Duration now);

  friend std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc, ToldMemory& memory);
  bool operator==(const ToldMemory&) const = default;

 private:
  friend void describe(auto& form, Like<ToldMemory> auto& memory);
  std::vector<std::pair<std::string, ToldMatter>> matters_;  ///< by key
  std::vector<std::string> running_;  ///< ids of runs that were seen running and not seen to have ended
  std::vector<std::pair<std::string, RunGoingOn>> going_on_;  ///< … those of them that ran when last seen, by id
  std::map<std::string, Duration> gone_;  ///< since when those are not seen, UTC; not kept over a restart

  void see(const Situation& now);
  [[nodiscard]] std::vector<RunSeen> missing(const Situation& now) const;
  void let_nothing_be_later_than(Duration utc);
  void forget(const Situation& now, Duration utc, const std::set<std::string>& standing);

  [[nodiscard]] ToldMatter& matter(const std::string& key, Duration now);
};

inline constexpr int kMostTries = 3;  ///< of one address; then it is the next one's turn

/// What is to be told at `utc`. A run that was over when it was first seen is not told of, nor are its alarms. Matters
/// that are over leave the memory; those of a run that cannot be seen do once it was not for a day. A run that was
/// going on and cannot be seen is silent. Where the clock was set back, what waits does so from now on.
[[nodiscard]] std::vector<DueMessage> due_messages(const Site& site, const Situation& now, Duration utc,
                                                   ToldMemory& memory);

}  // namespace gyrotherm::monitor
