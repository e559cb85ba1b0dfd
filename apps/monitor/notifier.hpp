// SPDX-License-Identifier: Apache-2.0
/// Sends notifications: checks the runs periodically, delivers due messages, and adds a note to the record of each run
/// that is concerned.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "apps/monitor/due_messages.hpp"
#include "apps/monitor/run_catalogue.hpp"
#include "core/clock.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// The notifier, used by one thread.
class Notifier {
 public:
  /// Creates a notifier. `memory_file` stores the sent messages. Calls `complain` for addresses that cannot be reached.
  Notifier(Site site, std::string memory_file, const RunCatalogue& catalogue, const Clock& clock,
           std::function<void(const Fault&)> report_fault);
  /// Loads the memory. Fails with bad_file.
  [[nodiscard]] Result<void> load();
  /// Checks once. May take half a minute for each address that does not answer.
  void check();

 private:
  [[nodiscard]] Situation situation();
  void send_message(const DueMessage& message);
  void save();

  Site site_;
  std::string memory_file_;
  const RunCatalogue& catalogue_;
  const Clock& clock_;
  std::function<void(const Fault&)> report_fault_;
  NotificationMemory memory_;
  std::string saved_;
  /// Whether the other monitors answered at the time `asked_`, by URL.
  std::map<std::string, bool> answers_;
  Duration asked_{-std::chrono::hours(1)};
};

}  // namespace gyrotherm::monitor
