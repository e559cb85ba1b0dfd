// SPDX-License-Identifier: Apache-2.0
/// The disk of a simulated run, and its record. If the schedule has faults of the disk, the record is a file on a disk
/// that breaks on command, and the store's worker advances second by second. Otherwise the store writes inside its
/// calls.
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

[[nodiscard]] bool is_disk_fault(InjectedFaultKind kind);
[[nodiscard]] bool has_faults_of_disk(const Schedule& schedule);

class Disk {
 public:
  /// `most_rows`: the number of rows that a store keeps in memory.
  Disk(bool breaks, std::string path, std::int64_t most_rows);
  ~Disk();
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;

  [[nodiscard]] Result<std::unique_ptr<record::Store>> create(const record::RunInfo& info);
  [[nodiscard]] Result<std::unique_ptr<record::Store>> reopen();
  /// Applies the active faults of the disk.
  void inject(const std::vector<InjectedFault>& active);
  void fail_once(std::int64_t operation);
  void heal();
  /// Lets another program change the file to which the record is being written, or its log. A destroyed file loses its
  /// bytes. Returns false if there is no file, or no byte to cut off.
  [[nodiscard]] bool attack(const InjectedFault& fault, int part);
  /// Carries out one second of the store's work.
  void advance(std::int64_t second);
  /// Lets the program and its store die: the disk does no more work for them. A power cut loses a random part of the
  /// data that was not synced.
  void leave(bool power_cut, unsigned seed, const std::function<void()>& die);

  [[nodiscard]] bool breaks() const { return vfs_.has_value(); }
  /// Returns true if an operation may fail now.
  [[nodiscard]] bool is_failing() const;
  [[nodiscard]] bool hangs() const { return hangs_; }

 private:
  [[nodiscard]] Result<std::unique_ptr<record::Store>> open_store(record::RunFile file, record::RunStatus status,
                                                                  record::Alarms alarms, int part,
                                                                  std::int64_t last_event);

  std::string path_;
  std::int64_t most_rows_;
  std::optional<tests::FailingVfs> vfs_;
  std::function<void()> attend_;
  /// Active faults of the disk.
  Schedule active_;
  bool takes_nothing_ = false, hangs_ = false, fails_once_ = false;
  std::int64_t every_ = 1;  ///< seconds per transaction
};

}  // namespace gyrotherm::faults
