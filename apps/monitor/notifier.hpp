// SPDX-License-Identifier: Apache-2.0
/// Tells people: looks at the runs now and then, gives away what is due, and has each run's record say who was told.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "apps/monitor/due_messages.hpp"
#include "apps/monitor/run_catalogue.hpp"
#include "core/clock.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// One thread.
class Notifier {
 public:
  /// What was told stands in `memory_file`. `complain` is told of addresses that cannot be reached.
  Notifier(Site site, std::string memory_file, const RunCatalogue& catalogue, const Clock& clock,
           std::function<void(const Fault&)> complain);
  /// Fails with bad_file.
  [[nodiscard]] Result<void> load();
  /// One look; may take half a minute for each address that does not answer.
  void look();

 private:
  [[nodiscard]] Situation situation();
  void give_away(const DueMessage& message);
  void save();

  Site site_;
  std::string memory_file_;
  const RunCatalogue& catalogue_;
  const Clock& clock_;
  std::function<void(const Fault&)> complain_;
  ToldMemory memory_;
  std::string saved_;
  std::map<std::string, bool> answers_;  ///< of other monitors, as of `asked_`
  Duration asked_{-std::chrono::hours(1)};
};

}  // namespace gyrotherm::monitor
