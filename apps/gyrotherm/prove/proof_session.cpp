// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/prove/proof_session.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <thread>

#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/machine_checks.hpp"
#include "apps/gyrotherm/prove/operator_answer.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "drivers/supply/safety_relay.hpp"
#include "drivers/virtual_identity.hpp"
#include "sequencer/prove/chamber_snapshot.hpp"
#include "sequencer/prove/driven_child.hpp"
#include "sequencer/prove/interlock_proof.hpp"
#include "sequencer/prove/limiter_proof.hpp"
#include "sequencer/prove/make_safe_proof.hpp"
#include "sequencer/run/chamber_ownership.hpp"

namespace gyrotherm::app {
namespace {

using prove::ProofResult;
using prove::ProofTest;
using prove::ProofVerdict;

constexpr Duration kHeartbeatEvery = std::chrono::milliseconds(200);
constexpr Duration kLongestSync = std::chrono::seconds(1);
constexpr int kSyncs = 20;

class ProofSession {
 public:
  ProofSession(Console& console, const ProofOrder& order)
      : console_(console), order_(order), rig_(order.rig), environment_(make_environment()) {}

  Result<prove::Proof> carry_out() {
    proof_ = {.rig = rig_.name,
              .title = rig_.title,
              .rig_file = rig_.file,
              .rig_sha256 = sha256(rig_.text),
              .simulated = rig_.simulated,
              .version = GYROTHERM_VERSION,
              .operator_name = order_.operator_name,
              .began = civil_time(clock_.now().utc)};
    const auto before = prove::find_proofs(rig_);
    if (const auto* newest = prove::find_newest(before)) {
      proof_.previous = newest->folder;
      proof_.previous_sha256 = newest->sha256;
    }
    const bool moves = std::ranges::any_of(order_.tests, prove::moves_chamber);
    if (moves)
      if (auto begun = begin_with_chamber(); !begun) return failure(begun.error());
    for (const auto test : order_.tests) {
      if (interrupted()) break;
      console_.print_message(fmt::format("proof test {}", name(test)));
      proof_.results.push_back(carry_out(test));
      const auto& result = proof_.results.back();
      console_.print_message(fmt::format("proof test {}: {}{}{}", name(test), name(result.verdict),
                                         result.cause.empty() ? "" : ": ", result.cause));
      if (ownership_ && ownership_->is_armed()) break;  // the guard has to make the chamber safe
    }
    if (moves) restore();
    proof_.ended = civil_time(clock_.now().utc);
    return proof_;
  }

 private:
  prove::DrillEnvironment make_environment() {
    return {.clock = clock_,
            .wait = [this](Duration time) { wait(time); },
            .is_interrupted = [] { return interrupted(); },
            .ask = [this](const std::string& question) { return ask(question); },
            .say = [this](const std::string& words) { console_.print_message("  " + words); },
            .connect = [this] { return prove::connect_chamber(rig_); }};
  }

  void wait(Duration time) {
    for (Duration left = time; left > Duration::zero(); left -= kHeartbeatEvery) {
      std::this_thread::sleep_for(std::min(left, kHeartbeatEvery));
      if (ownership_) ownership_->heartbeat({});
    }
  }

  /// Asks for a step by hand. Only an empty line that follows the question confirms it.
  bool ask(const std::string& question) {
    discard_typed_input(STDIN_FILENO);
    console_.print_message(question + ". Press Enter when done, or type stop:");
    pollfd waiting[] = {{STDIN_FILENO, POLLIN, 0}, {interrupt_descriptor(), POLLIN, 0}};
    while (!interrupted() && waiting[0].revents == 0) ::poll(waiting, 2, -1);
    if (interrupted()) return false;
    return read_confirmation(STDIN_FILENO);
  }

  /// Identifies the chamber and keeps its registers. Nothing is written.
  Result<void> begin_with_chamber() {
    if (auto locked = lock_chamber("the start"); !locked) return locked;
    if (const auto why = prove::relay_refusal_reason(rig_, rig_.file); !why.empty())
      return failure(FaultKind::refused, rig_.file, why);
    const auto [registers, chamber] = prove::connect_with_registers(rig_);
    const auto identity = chamber->identify();
    if (!identity) return failure(identity.error());
    proof_.chamber = *identity;
    proof_.simulated = proof_.simulated || drivers::is_virtual_identity(*identity);
    auto found = prove::ChamberSnapshot::take(rig_.chamber_map, *registers, *chamber);
    if (!found) return failure(found.error());
    if (const auto why = prove::refusal_reason(found->state()); !why.empty())
      return failure(FaultKind::refused, "chamber", why);
    settings_ = chamber->settings();
    found_.emplace(std::move(*found));
    return {};
  }

  [[nodiscard]] std::string record(const char* test) const { return fmt::format("{}/{}.db", order_.folder, test); }

  /// Takes the chamber's lock, so no run begins meanwhile.
  Result<void> lock_chamber(const char* test) {
    ownership_.reset();
    auto taken = run::ChamberOwnership::take(rig_, record(test));
    if (!taken) return failure(taken.error());
    ownership_.emplace(std::move(*taken));
    return {};
  }

  ProofResult carry_out(ProofTest test) {
    switch (test) {
      case ProofTest::limiter: return carry_out_limiter();
      case ProofTest::make_safe: ownership_.reset(); return prove_make_safe(rig_, record("make-safe"), environment_);
      case ProofTest::line: return carry_out_locked(test);
      case ProofTest::relay: return carry_out_locked(test);
      case ProofTest::interlocks: return prove_interlocks(rig_, environment_);
      case ProofTest::clock: return carry_out_clock();
      case ProofTest::disk: return carry_out_disk();
    }
    return {};
  }

  ProofResult not_tested(ProofTest test, const std::string& cause) {
    return prove::DrillLog(test, environment_).end(ProofVerdict::not_tested, cause);
  }

  ProofResult carry_out_limiter() {
    const auto state = environment_.connect()->inspect();
    if (!state) return not_tested(ProofTest::limiter, text(state.error()));
    const auto plan = prove::plan_limiter_proof(rig_, state->air);
    if (!plan) return not_tested(ProofTest::limiter, text(plan.error()));
    const prove::GuardedHeating guarded{.begin = [this]() -> Result<void> {
                                          if (auto locked = lock_chamber("limiter"); !locked) return locked;
                                          auto armed = ownership_->arm(proof_.chamber, settings_);
                                          has_heated_ = has_heated_ || armed.has_value();
                                          return armed;
                                        },
                                        .end = [this] { ownership_->release(); }};
    return prove::prove_limiter(*plan, guarded, environment_);
  }

  ProofResult carry_out_locked(ProofTest test) {
    if (auto locked = lock_chamber(name(test)); !locked) return not_tested(test, text(locked.error()));
    return test == ProofTest::line ? prove_line(rig_, record("line"), environment_) : prove_relay(rig_, environment_);
  }

  ProofResult carry_out_clock() {
    prove::DrillLog log(ProofTest::clock, environment_);
    log.limit("clock", "synchronised with UTC, as the kernel reports");
    const auto finding = check_clock();
    log.read("clock", finding.found);
    return log.end(finding.state == FindingState::ok ? ProofVerdict::passed : ProofVerdict::failed,
                   finding.state == FindingState::ok ? "" : finding.found);
  }

  ProofResult carry_out_disk() {
    prove::DrillLog log(ProofTest::disk, environment_);
    log.limit("free space and file system", "suitable for records");
    log.limit("longest of 20 syncs", format_duration(kLongestSync));
    std::string cause;
    for (const auto& finding : check_disk(order_.folder)) {
      log.read(finding.what, finding.found);
      if (finding.state == FindingState::fault) cause += (cause.empty() ? "" : "; ") + finding.found;
    }
    const auto longest = time_syncs();
    if (!longest) return log.end(ProofVerdict::failed, text(longest.error()));
    log.read("longest sync", fmt::format("{:.1f} ms", to_seconds(*longest) * 1e3));
    if (*longest > kLongestSync) cause += (cause.empty() ? "" : "; ") + std::string("a sync takes too long");
    return log.end(cause.empty() ? ProofVerdict::passed : ProofVerdict::failed, cause);
  }

  /// Writes and syncs a small file several times. Returns the longest time.
  Result<Duration> time_syncs() {
    const auto path = order_.folder + "/sync-test";
    const Descriptor file(::open(path.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0640));
    Duration longest{};
    const std::string page(4096, 'x');
    bool good = file.is_open();
    for (int i = 0; i < kSyncs && good; ++i) {
      const auto began = clock_.now().since_start;
      good = write_all(file.number(), page) && ::fsync(file.number()) == 0;
      longest = std::max(longest, clock_.now().since_start - began);
    }
    ::unlink(path.c_str());
    if (!good) return failure(FaultKind::storage, path, "the file could not be written and synced");
    return longest;
  }

  /// Returns whether a test has sent a set point.
  [[nodiscard]] bool has_commanded() const {
    return std::ranges::any_of(proof_.results, [this](const ProofResult& result) {
      if (result.test == ProofTest::limiter) return has_heated_;
      return moves_chamber(result.test) && result.test != ProofTest::relay &&
             result.verdict != ProofVerdict::not_tested;
    });
  }

  /// Returns the chamber to the state in which it was found. After a failed test, sends the safe set point first.
  void restore() {
    const auto give_up = [&](const std::string& why) {
      proof_.is_as_found = false;
      proof_.restoration = why;
      console_.print_message("WARNING: the chamber was not left as it was found: " + why);
    };
    // A watchdog that is still armed makes the chamber safe when this program ends; it is not disturbed.
    if (ownership_ && ownership_->is_armed()) return give_up("the guard makes the chamber safe");
    if (auto locked = lock_chamber("restoration"); !locked) return give_up(text(locked.error()));
    const auto [registers, chamber] = prove::connect_with_registers(rig_);
    const auto lost = has_commanded() ? found_->describe_lost_state(rig_.safe_set_point) : "";
    const bool failed = overall_verdict(proof_) == ProofVerdict::failed;
    if (failed || !lost.empty())
      if (const auto sent = chamber->send_set_point_immediately(rig_.safe_set_point); !sent)
        return give_up(text(sent.error()));
    if (const auto restored = found_->restore(*registers, *chamber); !restored) return give_up(text(restored.error()));
    auto compared = found_->compare(*registers);
    if (!compared) return give_up(text(compared.error()));
    proof_.registers = std::move(*compared);
    for (const auto& one : proof_.registers)
      if (one.before != one.after) return give_up(fmt::format("{} is {}, was {}", one.item, one.after, one.before));
    if (const auto why = prove::relay_refusal_reason(rig_, rig_.file); !why.empty()) return give_up(why);
    proof_.is_restorable = lost.empty();
    if (!lost.empty()) give_up(lost);
  }

  Console& console_;
  const ProofOrder& order_;
  const rig::RigFile& rig_;
  SteadyClock clock_;
  prove::DrillEnvironment environment_;
  prove::Proof proof_;
  std::optional<prove::ChamberSnapshot> found_;
  drivers::ControllerSettings settings_;
  std::optional<run::ChamberOwnership> ownership_;
  /// The test of the limiter has begun to drive the chamber.
  bool has_heated_ = false;
};

}  // namespace

Result<prove::Proof> carry_out_proofs(Console& console, const ProofOrder& order) {
  return ProofSession(console, order).carry_out();
}

Result<void> close_relay_by_person(Console& console, const rig::RigFile& rig) {
  if (!rig.safe_also) return failure(FaultKind::usage, "--close-relay", "the rig file has no [safe.also]");
  const auto relay = make_safety_relay(*rig.safe_also);
  const auto shown = relay->read();
  if (!shown) return failure(shown.error());
  if (*shown == drivers::RelayPosition::closed) {
    console.print_message("the relay is closed already");
    return {};
  }
  if (!console.can_ask()) return failure(FaultKind::usage, "--close-relay", "a person must confirm it at a terminal");
  const auto answer = console.ask(
      "The relay is open: the chamber could not be made safe. Check the chamber. Close the relay? Type close to "
      "confirm:");
  if (answer != "close") return failure(FaultKind::interrupted, "--close-relay", "not confirmed; the relay stays open");
  return switch_relay(*relay, drivers::RelayPosition::closed, [](Duration time) { std::this_thread::sleep_for(time); });
}

}  // namespace gyrotherm::app
