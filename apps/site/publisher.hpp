// SPDX-License-Identifier: Apache-2.0
/// Sends the runs of a rig to the store: finished ones whole, running ones second by second from their live copies, and
/// the documents beside them. It only reads, never a record that is being written, and keeps nothing of its own: where
/// it was, it asks the store. So it may be killed at any time, and two of it for one run do no harm.
///
/// What the store refuses is told once and set aside until its files change; everything else that goes wrong is tried
/// again, after waits that grow. One thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/run_source.hpp"
#include "acquisition/record/status_file.hpp"
#include "apps/site/run_text.hpp"
#include "apps/site/site_file.hpp"
#include "apps/site/store.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/random.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// How far one run is, here and in the store.
struct RunLag {
  std::string name;
  std::string state{};        ///< of the run, as it is here
  std::int64_t here{-1};      ///< its last slot
  std::int64_t in_store{-1};  ///< …, as the store has it
  bool finished_in_store{};
  std::string trouble{};  ///< why it does not go on; empty: it does

  [[nodiscard]] std::int64_t seconds() const { return here - in_store; }
};

/// Computes how long to wait before a failed attempt is repeated: twice as long each time, up to a longest wait. A part
/// of each wait is random, so that a hundred rigs that lost their store together do not all return in the same second.
class Backoff {
 public:
  explicit Backoff(Duration longest, std::uint64_t seed) : longest_(longest), generator_(seed) {}

  /// Returns a random time between half of the present wait and all of it. Doubles the next wait.
  [[nodiscard]] Duration next() {
    const auto whole = std::min(wait_, longest_);
    wait_ = std::min(wait_ * 2, longest_);
    return std::chrono::duration_cast<Duration>(whole * (0.5 + 0.5 * uniform(generator_)));
  }
  /// Makes the next wait a short one again, after a success.
  void reset() { wait_ = kFirst; }

 private:
  static constexpr Duration kFirst = std::chrono::milliseconds(250);
  Duration longest_;
  Duration wait_ = kFirst;
  std::mt19937_64 generator_;
};

class Publisher {
 public:
  /// `say` is told each change of state in a line, `complain` each trouble, once. The program ends what it does once
  /// `stop` is readable.
  Publisher(SiteSettings settings, int stop, std::function<void(const std::string&)> say,
            std::function<void(const Fault&)> complain);

  /// Looks and sends until `stop` is readable. Fails with bad_file or usage where no waiting helps before it could ever
  /// connect.
  [[nodiscard]] Result<void> serve();
  /// Sends all that is there now. Fails with the first fault that keeps something from being sent.
  [[nodiscard]] Result<void> once();
  /// Asks the store how far each run is; sends nothing.
  [[nodiscard]] Result<std::vector<RunLag>> lags();

 private:
  struct Run {
    FileState file;  ///< which one the rest was read from
    record::RunInfo info;
    std::vector<FileState> states{};  ///< of its files, when they were last seen to be this run's
    std::vector<StoredChannel> channels{};
    std::optional<RunPosition> position{};  ///< as the store says; asked anew over a new connection
  };
  /// What a run's files look like; a run that was sent whole is looked at again when this changes.
  struct Stamp {
    FileState record, status, live_copy;
    bool operator==(const Stamp&) const = default;
  };
  struct Watched {
    std::optional<Run> run;
    std::optional<Stamp> settled;
    std::optional<Deadline> rests;  ///< until then, after the store has refused it
    std::string trouble;            ///< that was told
  };
  /// Whether rows are left that can be sent at once: a long run interrupts its sending for the others.
  enum class Backlog { none, some };

  [[nodiscard]] Result<void> connect();
  void disconnect(const Fault& why);
  void look();
  /// Sends a turn of each run that was found, and the new documents. Returns whether a run has a backlog.
  [[nodiscard]] Result<Backlog> round();
  /// Sends a turn of one run, unless its files have not changed since it was sent whole, or the store has refused it a
  /// short time ago.
  [[nodiscard]] Result<Backlog> send_run(const std::string& path, Watched& watched);
  /// Makes `watched` hold the run that the files hold, and reads it if it is another one than before. Returns false if
  /// that run is being prepared and has not begun; `is_written`: a program writes its record.
  [[nodiscard]] static Result<bool> open_run(const record::RecordFiles& files, bool is_written, Watched& watched);
  /// Sends the rows of a turn and, if these are all, the events and gaps. Sends nothing to a run that is closed.
  [[nodiscard]] Result<Backlog> send_recorded(const record::RecordFiles& files, Run& run);
  [[nodiscard]] Result<void> ask_position(Run& run);
  [[nodiscard]] Result<Backlog> send_rows(const record::RecordFiles& files, Run& run);
  [[nodiscard]] Result<void> send_events_and_gaps(const record::RecordFiles& files, Run& run);
  /// Sends state, cause and alarms from a status file, if it is this run's.
  [[nodiscard]] Result<void> send_live_state(const std::optional<record::RunStatus>& status, Run& run);
  /// Sends state, cause and alarms if one of them differs from what was sent last.
  [[nodiscard]] Result<void> send_state(Run& run, const RunNow& now);
  /// Archives the files of a finished run and closes it in the store; sends the last state of one that was interrupted.
  [[nodiscard]] Result<void> end_run(const record::RecordFiles& files, Run& run);
  [[nodiscard]] Result<void> send_document(const std::string& path);
  /// Whether what failed concerns this file alone; then it is told once.
  [[nodiscard]] bool set_aside(const Fault& fault, const std::string& path, std::string& told);

  SiteSettings settings_;
  Patience patience_;
  std::function<void(const std::string&)> say_;
  std::function<void(const Fault&)> complain_;
  std::optional<Store> store_;
  bool has_sent_ = false;                       ///< a whole round
  std::string store_trouble_;                   ///< that was told
  std::map<std::string, Watched> runs_;         ///< by path of the record
  std::map<std::string, FileState> documents_;  ///< that were sent, or are none
  std::set<std::string> found_documents_;
  std::optional<Fault> first_trouble_;  ///< of this round, of one file
};

}  // namespace gyrotherm::site
