// SPDX-License-Identifier: Apache-2.0
/// Sends notifications: observes the runs, delivers the due messages, and adds a note to the record of the run that a
/// message concerns.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "apps/monitor/due_messages.hpp"
#include "apps/monitor/run_catalogue.hpp"
#include "core/clock.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// The notifier. Used by one thread.
class Notifier {
 public:
  /// Creates a notifier. `memory_file` is the path of the memory. Calls `report_fault` for each failed delivery.
  Notifier(Site site, std::string memory_file, const RunCatalogue& catalogue, const Clock& clock,
           std::function<void(const Fault&)> report_fault);
  /// Loads the memory from its file, if that exists. Fails with bad_file.
  [[nodiscard]] Result<void> load();
  /// Sends the messages that are due now. May take half a minute for each address that does not respond.
  void notify_due();

 private:
  [[nodiscard]] Situation observe_situation();
  void send_message(const DueMessage& message);
  void save();

  Site site_;
  std::string memory_file_;
  const RunCatalogue& catalogue_;
  const Clock& clock_;
  std::function<void(const Fault&)> report_fault_;
  NotificationMemory memory_;
  /// Text of the memory when it was last saved.
  std::string saved_text_;
  /// True if the last attempt to save the memory failed. The fault is reported once; the attempts continue.
  bool has_save_failed_ = false;
  /// Whether each of the other monitors responded at the time `monitors_checked_at_`, by URL.
  std::map<std::string, bool> responding_monitors_;
  Duration monitors_checked_at_{-std::chrono::hours(1)};
};

}  // namespace gyrotherm::monitor
