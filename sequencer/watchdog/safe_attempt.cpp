// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/safe_attempt.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <thread>

#include "drivers/chamber/chamber_lock.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::watchdog {
namespace {

constexpr Duration kBetweenTries = std::chrono::milliseconds(300);
constexpr Duration kLastTryBefore = std::chrono::seconds(8);
constexpr int kTriesOfTheRest = 3;
constexpr int kMostQuestions = 3;

class Attempt {
 public:
  Attempt(const SafeGoal& goal, const AttemptMeans& means)
      : goal_(goal), means_(means), began_(means.clock.now().since_start), chamber_(means.connect()) {}

  SafeAttempt carry_out() {
    if (!send_set_point()) return done_;
    for (int i = 0; i < kTriesOfTheRest && done_.reached != SafeStage::all; ++i) leave_as_wanted();
    return done_;
  }

 private:
  void told(SafeStage reached, std::string details) {
    done_.reached = std::max(done_.reached, reached);
    done_.details = std::move(details);
    means_.told(done_);
  }

  /// A connection that broke is made anew, for it may still bring an answer to what was asked on it.
  void try_later(const Fault& fault) {
    told(done_.reached, text(fault));
    means_.wait(kBetweenTries);
    if (fault.kind == FaultKind::disconnected) chamber_ = means_.connect();
    if (fault.kind == FaultKind::disconnected) is_recognised_ = false;
  }

  /// Fails with mismatch where another instrument answers: nothing is sent to it. One that does not answer this
  /// question is sent the set point all the same, for the run compared it before.
  [[nodiscard]] Result<void> recognise_chamber() {
    if (is_recognised_) return {};
    const auto who = chamber_->recognise();
    const bool is_other = who ? !goal_.identity.starts_with(*who) && !goal_.identity.empty()
                              : who.error().kind == FaultKind::mismatch || who.error().kind == FaultKind::refused;
    if (is_other)
      return failure(FaultKind::mismatch, "chamber",
                     fmt::format("nothing is sent to another instrument: {}; the run began with: {}",
                                 who ? *who : text(who.error()), goal_.identity.empty() ? "its map" : goal_.identity));
    is_recognised_ = who.has_value();
    const bool is_asked_again = !who && ++unrecognised_ < kMostQuestions;
    return is_asked_again ? failure(who.error()) : Result<void>{};
  }

  [[nodiscard]] Result<void> send_once() {
    if (auto known = recognise_chamber(); !known) return known;
    if (!goal_.by_program) return chamber_->insist(goal_.set_point);
    chamber_->end_rest();
    const auto ended = chamber_->end_program();
    return chamber_->insist(goal_.set_point).and_then([&] { return ended; });
  }

  [[nodiscard]] bool send_set_point() {
    while (means_.clock.now().since_start - began_ < kLastTryBefore) {
      ++done_.tries;
      const auto sent = send_once();
      if (sent) {
        told(SafeStage::set_point, "set point read back");
        return true;
      }
      try_later(sent.error());
    }
    return false;
  }

  /// The chamber's own word, once nothing overrules the set point any more.
  [[nodiscard]] Result<std::string> settle() {
    chamber_->end_rest();
    if (auto known = recognise_chamber(); !known) return failure(known.error());
    if (auto ended = chamber_->end_program(); !ended) return failure(ended.error());
    if (auto sent = chamber_->insist(goal_.set_point); !sent) return failure(sent.error());
    if (goal_.switch_off)
      if (auto off = chamber_->stop(); !off) return failure(off.error());
    const auto state = chamber_->inspect();
    if (!state) return failure(state.error());
    if (!std::isnan(state->set_point.value) && abs(state->set_point - goal_.set_point) > goal_.tolerance)
      return failure(FaultKind::mismatch, "chamber set point",
                     fmt::format("reads {:g} after {:g} was written", state->set_point.value, goal_.set_point.value));
    return fmt::format("set point read back, air {:.2f} °C{}", state->air.value,
                       goal_.switch_off ? ", conditioning switched off" : "");
  }

  void leave_as_wanted() {
    const auto settled = settle();
    if (settled) return told(SafeStage::all, *settled);
    try_later({settled.error().kind, "", "set point read back, but " + text(settled.error())});
  }

  const SafeGoal& goal_;
  const AttemptMeans& means_;
  Duration began_;
  std::unique_ptr<drivers::Chamber> chamber_;
  bool is_recognised_ = false;
  int unrecognised_ = 0;  ///< questions that were not answered
  SafeAttempt done_;
};

constexpr Duration kForTheRest = std::chrono::seconds(15);

/// The file that a process runs; "" where this user may not know.
std::string program_of(std::int64_t pid) {
  std::error_code error;
  return std::filesystem::read_symlink(fmt::format("/proc/{}/exe", pid), error).filename().string();
}

constexpr std::string_view kMakesSafe = "gyrotherm-make-safe";

/// Whether who holds the chamber has it rightly: a program of this user or of root, and not the one that has gone.
/// One that was stopped drives nothing and makes nothing safe.
bool is_successor(const drivers::ChamberHolder& holder, const std::string& program, const SafeState& safe_state) {
  if (holder.pid == 0 || holder.pid == safe_state.written_by.pid || holder.pid == ::getpid()) return false;
  if (holder.uid != 0 && holder.uid != ::geteuid()) return false;
  if (is_stopped(holder.pid)) return false;
  constexpr std::array<std::string_view, 2> kOwn{"gyrotherm", kMakesSafe};
  return program.empty() || std::ranges::count(kOwn, program) > 0;
}

std::string line_of(const SafeAttempt& attempt) {
  auto details = attempt.details;
  std::replace(details.begin(), details.end(), '\n', ' ');
  return fmt::format("{} {}", static_cast<int>(attempt.reached), details);
}

void take(const std::string& line, Rescued& rescued) {
  int stage = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), stage);
  if (error != std::errc() || stage < 0 || stage > static_cast<int>(SafeStage::all)) return;
  rescued.reached = static_cast<SafeStage>(stage);
  rescued.details = line.substr(std::min<std::size_t>(static_cast<std::size_t>(end - line.data()) + 1, line.size()));
}

void carry_out(const SafeStateChamber& chamber, const ChildWork::Tell& tell) {
  const SteadyClock clock;
  (void)attempt_safe(chamber.goal, {.connect = chamber.connect,
                                    .wait = [](Duration time) { std::this_thread::sleep_for(time); },
                                    .told = [&](const SafeAttempt& attempt) { tell(line_of(attempt)); },
                                    .clock = clock});
}

}  // namespace

SafeAttempt attempt_safe(const SafeGoal& goal, const AttemptMeans& means) { return Attempt(goal, means).carry_out(); }

Result<SafeStateChamber> chamber_of(const SafeState& safe_state) {
  const auto where = safe_state_path(safe_state.record);
  const auto line = drivers::parse_line(safe_state.line);
  if (!line || !drivers::carries_bytes(*line))
    return failure(FaultKind::bad_file, where, "its line leads to no chamber");
  auto map = parse_register_map(safe_state.map_text, where + " (register map)", safe_state.word_order);
  if (!map) return failure(map.error());
  const auto linked = on_link(std::move(*map), safe_state.link).and_then([&](drivers::RegisterMap used) {
    return with_power_switch(std::move(used), safe_state.power);
  });
  if (!linked) return failure(FaultKind::bad_file, where, linked.error().what);
  return SafeStateChamber{.place = drivers::chamber_place(*line, linked->link.modbus.port, linked->link.modbus.unit),
                          .goal = {safe_state.safe_set_point, set_point_tolerance(*linked), safe_state.switch_off,
                                   safe_state.by_program, safe_state.identity},
                          .connect = [map = *linked, line = *line] {
                            return make_modbus_chamber(map, make_modbus(line, map.link.modbus));
                          }};
}

Rescued attempt_once(const SafeState& safe_state, const SafeStateChamber& chamber, Voice& voice) {
  const auto lock = drivers::ChamberLock::take(chamber.place, safe_state.record + " (made safe)");
  if (!lock && lock.error().kind == FaultKind::refused) {
    const auto holder = drivers::ChamberLock::holder(chamber.place);
    const auto program = holder ? program_of(holder->pid) : "";
    if (holder && is_successor(*holder, program, safe_state)) {
      voice.say("another program has the chamber: " + holder->words);
      return {.reached = {}, .details = {}, .in_use = true, .is_driven = program != kMakesSafe};
    }
  }
  Rescued rescued{.reached = {}, .details = "nothing came back", .in_use = false, .is_driven = false};
  ChildWork work([&](const auto& tell) { carry_out(chamber, tell); });
  const SteadyClock clock;
  for (Duration longest = kSafeWithin; !work.has_ended();) {
    const auto line = work.next(longest - clock.now().since_start);
    if (!line) break;
    take(*line, rescued);
    if (rescued.reached != SafeStage::nothing) longest = kSafeWithin + kForTheRest;
  }
  if (!work.has_ended()) rescued.details += "; the attempt did not come to its end in time";
  return rescued;
}

}  // namespace gyrotherm::watchdog
