// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/operator_mark.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <mutex>
#include <system_error>
#include <thread>

#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::app {

/// The mark, shared with the threads that change it.
struct OperatorMark::Shared {
  std::mutex mutex;
  std::string path;
  std::atomic<bool> is_wanted = false;

  /// Creates or removes the file, as required last.
  void apply() {
    const std::lock_guard lock(mutex);
    if (!is_wanted) {
      ::unlink(path.c_str());
      return;
    }
    constexpr mode_t kMode = 0640;
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, kMode);
    if (file >= 0) ::close(file);
  }
};

OperatorMark::OperatorMark(const std::string& record) : shared_(std::make_shared<Shared>()) {
  shared_->path = operator_mark_path(record);
}

void OperatorMark::follow(RunState state) {
  const bool is_wanted = state == RunState::held || state == RunState::aborting || state == RunState::aborted;
  if (last_ == is_wanted) return;
  last_ = is_wanted;
  shared_->is_wanted = is_wanted;
  std::thread([shared = shared_] { shared->apply(); }).detach();
}

std::string operator_mark_path(const std::string& record) { return record + ".ask-operator"; }

bool has_operator_mark(const std::string& record) {
  std::error_code error;
  return std::filesystem::exists(operator_mark_path(record), error);
}

bool has_lost_end(const std::string& record, bool is_end_recorded) {
  return has_operator_mark(record) || (!is_end_recorded && watchdog::was_released(record));
}

void remove_operator_mark(const std::string& record) {
  std::error_code error;
  std::filesystem::remove(operator_mark_path(record), error);
}

}  // namespace gyrotherm::app
