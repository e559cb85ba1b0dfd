// SPDX-License-Identifier: Apache-2.0
/// The disk of a simulated run, and the record on it. Where the schedule has injected faults of the disk, the record is
/// a file on one that breaks on command, and the real store's work for it is done second by second; else it is the
/// store that writes inside its calls.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"
#include "tests/sequencer/faults/schedule.hpp"
#include "tests/support/failing_vfs.hpp"

namespace gyrotherm::faults {

[[nodiscard]] bool is_of_disk(InjectedFaultKind kind);
[[nodiscard]] bool has_faults_of_disk(const Schedule& schedule);

class Disk {
 public:
  /// `most_rows`: how many a store keeps in memory.
  Disk(bool breaks, std::string path, std::int64_t most_rows);
  ~Disk();
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;

  [[nodiscard]] Result<std::unique_ptr<record::Store>> create(const record::RunInfo& info);
  [[nodiscard]] Result<std::unique_ptr<record::Store>> reopen();
  /// As the injected faults that stand now say.
  void inject(const std::vector<InjectedFault>& standing);
  void fail_once(std::int64_t operation);
  void heal();
  /// Another program does something to the file that the record is being written to, or to its log. Of one that it
  /// destroys, the bytes are gone. False where there is nothing to be done: no file, or no byte of it to cut off.
  [[nodiscard]] bool attack(const InjectedFault& fault, int part);
  /// What it does for the store in this second.
  void attend(std::int64_t second);
  /// A program dies, and its store with it: its disk does nothing more for it. In a power cut a part of what was not
  /// synced is lost, by chance.
  void leave(bool power_cut, unsigned seed, const std::function<void()>& die);

  [[nodiscard]] bool breaks() const { return vfs_.has_value(); }
  /// What is asked of it now may fail.
  [[nodiscard]] bool is_sick() const;
  [[nodiscard]] bool hangs() const { return hangs_; }

 private:
  [[nodiscard]] Result<std::unique_ptr<record::Store>> attended(record::RunFile file, record::RunStatus status,
                                                                record::Alarms alarms, int part,
                                                                std::int64_t last_event);

  std::string path_;
  std::int64_t most_rows_;
  std::optional<tests::FailingVfs> vfs_;
  std::function<void()> attend_;
  Schedule standing_;  ///< of the disk
  bool takes_nothing_ = false, hangs_ = false, fails_once_ = false;
  std::int64_t every_ = 1;  ///< seconds, a transaction
};

}  // namespace gyrotherm::faults
