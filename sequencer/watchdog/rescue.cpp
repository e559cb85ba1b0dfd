#include "sequencer/watchdog/rescue.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <thread>

#include "core/clock.hpp"
#include "drivers/chamber/chamber_lock.hpp"

namespace gyrotherm {
namespace {

constexpr Duration kForTheRest = std::chrono::seconds(15);

/// The file that a process runs; "" where this user may not know.
std::string program_of(std::int64_t pid) {
  std::error_code error;
  return std::filesystem::read_symlink(fmt::format("/proc/{}/exe", pid), error).filename().string();
}

constexpr std::string_view kMakesSafe = "gyrotherm-make-safe";

/// Whether who holds the chamber has it rightly: a program of this user or of root, and not the one that has gone.
/// One that was stopped drives nothing and makes nothing safe.
bool is_successor(const ChamberHolder& holder, const std::string& program, const SafeState& safe_state) {
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

Rescued attempt_once(const SafeState& safe_state, const SafeStateChamber& chamber, Voice& voice) {
  const auto lock = ChamberLock::take(chamber.place, safe_state.record + " (made safe)");
  if (!lock && lock.error().kind == FaultKind::refused) {
    const auto holder = ChamberLock::holder(chamber.place);
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

}  // namespace gyrotherm
