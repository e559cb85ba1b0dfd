// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/pauses.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace gyrotherm::drivers {

namespace {

/// Begin of the part of a message that a layer above may have received from the line below.
constexpr std::string_view kNextTry = "; next try in ";

}  // namespace

void Backoff::note_failure(std::string_view cause) {
  constexpr Duration kFirstRest = std::chrono::milliseconds(500), kLongestRest = std::chrono::seconds(10);
  cause_ = cause.substr(0, cause.find(kNextTry));
  if (++failures_ < 2) return;
  rest_ = std::clamp(2 * rest_, kFirstRest, kLongestRest);
  next_ = Deadline(rest_, clock_);
}

std::string Backoff::message() const {
  constexpr double kResolution = 0.1;
  return fmt::format("{}{}{:.1f} s", cause_, kNextTry, std::max(kResolution, to_seconds(left())));
}

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

class RealPauses final : public Pauses {
 public:
  Duration now() const override { return steady_clock::now().time_since_epoch(); }
  void rest(Duration time) override {
    const auto end = now() + time;
    for (auto left = time; left > Duration{}; left = end - now())
      poll(nullptr, 0, static_cast<int>(std::max<std::int64_t>(std::chrono::ceil<milliseconds>(left).count(), 1)));
  }
};

class VirtualPauses final : public Pauses {
 public:
  Duration now() const override { return now_; }
  void rest(Duration time) override { now_ += time; }

 private:
  Duration now_{};
};

constexpr Duration kNoteInterval = std::chrono::milliseconds(500);

class NotingRegisters final : public Registers {
 public:
  NotingRegisters(std::unique_ptr<Registers> registers, std::shared_ptr<LineActivity> activity)
      : registers_(std::move(registers)), activity_(std::move(activity)) {}

  Result<std::vector<std::uint16_t>> read(ReadFunction function, std::uint16_t address, std::uint16_t count) override {
    auto words = registers_->read(function, address, count);
    activity_->note();
    return words;
  }
  Result<void> write(WriteFunction function, std::uint16_t address, std::span<const std::uint16_t> words) override {
    auto done = registers_->write(function, address, words);
    activity_->note();
    return done;
  }
  Result<void> write_unconfirmed(WriteFunction function, std::uint16_t address,
                                 std::span<const std::uint16_t> words) override {
    auto done = registers_->write_unconfirmed(function, address, words);
    activity_->note();
    return done;
  }
  void end_rest() override { registers_->end_rest(); }
  std::uint64_t breaks() const override { return registers_->breaks(); }

 private:
  std::unique_ptr<Registers> registers_;
  std::shared_ptr<LineActivity> activity_;
};

class NotingPauses final : public Pauses {
 public:
  NotingPauses(std::unique_ptr<Pauses> pauses, std::shared_ptr<LineActivity> activity)
      : pauses_(std::move(pauses)), activity_(std::move(activity)) {}

  Duration now() const override { return pauses_->now(); }
  void rest(Duration time) override {
    for (; time > Duration{}; time -= kNoteInterval) {
      pauses_->rest(std::min(time, kNoteInterval));
      activity_->note();
    }
  }

 private:
  std::unique_ptr<Pauses> pauses_;
  std::shared_ptr<LineActivity> activity_;
};

}  // namespace

std::unique_ptr<Pauses> make_real_pauses() { return std::make_unique<RealPauses>(); }
std::unique_ptr<Pauses> make_virtual_pauses() { return std::make_unique<VirtualPauses>(); }

std::unique_ptr<Registers> record_activity(std::unique_ptr<Registers> registers,
                                           std::shared_ptr<LineActivity> activity) {
  return std::make_unique<NotingRegisters>(std::move(registers), std::move(activity));
}

std::unique_ptr<Pauses> record_activity(std::unique_ptr<Pauses> pauses, std::shared_ptr<LineActivity> activity) {
  return std::make_unique<NotingPauses>(std::move(pauses), std::move(activity));
}

}  // namespace gyrotherm::drivers
