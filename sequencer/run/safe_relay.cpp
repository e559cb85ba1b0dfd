// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/safe_relay.hpp"

#include <mutex>
#include <thread>
#include <utility>

namespace gyrotherm::run {
namespace {

constexpr Duration kRelayRetryInterval = std::chrono::seconds(10);

}  // namespace

/// One attempt, shared with its thread.
struct SafeRelay::Work {
  std::mutex mutex;
  std::optional<Result<void>> result;
};

SafeRelay::SafeRelay(std::optional<drivers::RelaySettings> settings, Open open)
    : settings_(std::move(settings)), open_(std::move(open)) {}

std::optional<std::string> SafeRelay::advance(watchdog::RelayDue due, Duration at) {
  using watchdog::RelayDue;
  if (!settings_) return std::nullopt;
  if (!began_ || due == RelayDue::never) began_ = at;
  if (work_) return take_result();
  const bool is_early = due == RelayDue::in_time && at - *began_ < settings_->after;
  const bool is_resting = tried_ && at - *tried_ < kRelayRetryInterval;
  if (is_open_ || due == RelayDue::never || is_early || is_resting) return std::nullopt;
  tried_ = at;
  work_ = std::make_shared<Work>();
  std::thread([work = work_, open = open_, settings = *settings_] {
    auto result = open(settings);
    const std::lock_guard lock(work->mutex);
    work->result = std::move(result);
  }).detach();
  return std::nullopt;
}

std::optional<std::string> SafeRelay::take_result() {
  std::optional<Result<void>> result;
  {
    const std::lock_guard lock(work_->mutex);
    result = work_->result;
  }
  if (!result) return std::nullopt;
  work_.reset();
  is_open_ = result->has_value();
  auto words = watchdog::describe_relay(*result);
  if (words == words_) return std::nullopt;
  return words_ = std::move(words);
}

}  // namespace gyrotherm::run
