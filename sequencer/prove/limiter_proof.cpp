// SPDX-License-Identifier: Apache-2.0
#include "sequencer/prove/limiter_proof.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gyrotherm::prove {
namespace {

constexpr Kelvins kLimiterAboveAir{10};
/// Fall of the air, or rise after the trip, that is taken for the work of the limiter.
constexpr double kSeenFallK = 1, kSeenRiseK = 1.5;
constexpr int kSafeTries = 10, kLostReadings = 5, kResetReadings = 60;

enum class HeatingEnd { tripped, too_hot, timed_out, lost, interrupted };

class LimiterDrill {
 public:
  LimiterDrill(const LimiterPlan& plan, const GuardedHeating& guarded, const DrillEnvironment& environment)
      : plan_(plan), guarded_(guarded), environment_(environment), log_(ProofTest::limiter, environment) {
    log_.limit("setting of the limiter", celsius_text(plan.at));
    log_.limit("set point", celsius_text(plan.set_point));
    log_.limit("trip", fmt::format("{} ± {:g} K", celsius_text(plan.at), plan.band.value));
    log_.limit("heating ends at", celsius_text(highest()));
    log_.limit("stays tripped for", format_duration(plan.hold));
  }

  ProofResult carry_out() {
    if (!environment_.ask(
            fmt::format("Set the over-temperature limiter of the chamber to {:g} °C by hand", plan_.at.value)))
      return log_.end(ProofVerdict::interrupted, "the operator did not set the limiter");
    if (const auto began = guarded_.begin(); !began) return log_.end(ProofVerdict::not_tested, text(began.error()));
    chamber_ = environment_.connect();
    heat();
    if (make_safe()) {
      guarded_.end();
      ask_for_reset();
    } else {
      fail("the chamber does not show its safe set point");
    }
    return log_.end(has_failed_       ? ProofVerdict::failed
                    : causes_.empty() ? ProofVerdict::passed
                                      : ProofVerdict::interrupted,
                    fmt::format("{}", fmt::join(causes_, "; ")));
  }

 private:
  [[nodiscard]] Celsius highest() const { return plan_.at + plan_.band * 2; }

  /// Notes an observed failure. An interruption before or after it does not undo it.
  void fail(std::string cause) {
    has_failed_ = true;
    causes_.push_back(std::move(cause));
  }
  void note_interruption(std::string cause) { causes_.push_back(std::move(cause)); }

  /// Reads the chamber; nothing after several failures in a row.
  std::optional<ChamberState> read() {
    for (int i = 0; i < kLostReadings; ++i) {
      if (auto state = chamber_->inspect()) return *state;
      environment_.wait(kSecond);
    }
    return std::nullopt;
  }

  /// Heats until the limiter has tripped and stayed tripped. Notes each failure.
  void heat() {
    auto sent = chamber_->send_set_point(plan_.set_point);
    if (sent) sent = chamber_->start();
    if (!sent) return fail("the chamber did not take the set point: " + text(sent.error()));
    log_.read("set point sent", celsius_text(plan_.set_point));
    switch (wait_for_trip()) {
      case HeatingEnd::too_hot: return fail(describe_missing_trip());
      case HeatingEnd::timed_out: return fail(describe_timeout());
      case HeatingEnd::lost: return fail("the chamber did not answer while it heated");
      case HeatingEnd::interrupted: return note_interruption("the operator stopped the test");
      case HeatingEnd::tripped: break;
    }
    if (trip_ > plan_.at + plan_.band)
      fail(fmt::format("the limiter tripped late: at {}, {:.1f} K above its setting", celsius_text(trip_),
                       (trip_ - plan_.at).value));
    if (trip_ < plan_.at - plan_.band)
      fail(fmt::format("the limiter tripped early: at {}, {:.1f} K below its setting", celsius_text(trip_),
                       (plan_.at - trip_).value));
    watch_trip();
  }

  [[nodiscard]] std::string describe_missing_trip() const {
    return fmt::format("the limiter did not trip: it was set to {:g} °C and the air reached {}", plan_.at.value,
                       celsius_text(peak_));
  }
  /// Describes air that did not heat enough for a trip, or that settled above the setting without a trip.
  [[nodiscard]] std::string describe_timeout() const {
    if (peak_ > plan_.at + plan_.band) return describe_missing_trip();
    if (peak_ < plan_.at)
      return fmt::format("the air did not reach the limiter's setting of {:g} °C in {}: {}", plan_.at.value,
                         format_duration(plan_.within), celsius_text(peak_));
    return fmt::format("the air did not exceed the limiter's setting of {:g} °C by {:g} K in {}: {}", plan_.at.value,
                       plan_.band.value, format_duration(plan_.within), celsius_text(peak_));
  }

  HeatingEnd wait_for_trip() {
    double minute = 0;
    for (const double began = log_.passed_s();; environment_.wait(kSecond)) {
      const auto state = read();
      if (!state) return environment_.is_interrupted() ? HeatingEnd::interrupted : HeatingEnd::lost;
      peak_ = std::max(peak_, state->air);
      if (has_alarm(*state)) {
        trip_ = state->air;
        shows_alarm_ = true;
        log_.read("trip, seen by the alarm",
                  fmt::format("{}, {}", celsius_text(trip_), state->alarms.empty() ? "alarm" : state->alarms.front()));
        return HeatingEnd::tripped;
      }
      if (state->air > highest()) return HeatingEnd::too_hot;
      if ((peak_ - state->air).value >= kSeenFallK) {
        trip_ = peak_;
        log_.read("trip, seen by air that falls below the set point", celsius_text(trip_));
        return HeatingEnd::tripped;
      }
      if (environment_.is_interrupted()) return HeatingEnd::interrupted;
      const double passed = log_.passed_s() - began;
      if (passed >= minute) log_.read("air", celsius_text(state->air)), minute += kSecondsPerMinute;
      if (passed > to_seconds(plan_.within)) return HeatingEnd::timed_out;
    }
  }

  /// Watches that the limiter stays tripped with the set point above the air.
  void watch_trip() {
    Celsius lowest = peak_;
    for (const double began = log_.passed_s(); log_.passed_s() - began < to_seconds(plan_.hold);) {
      environment_.wait(kSecond);
      const auto state = read();
      if (!state && !environment_.is_interrupted()) return fail("the chamber did not answer after the trip");
      if (!state) return note_interruption("the operator stopped the test");
      lowest = std::min(lowest, state->air);
      const bool heats = (state->air - lowest).value >= kSeenRiseK;
      if ((shows_alarm_ && !has_alarm(*state)) || heats) {
        log_.read("reset without a person", celsius_text(state->air));
        return fail(fmt::format("the limiter reset itself {:.0f} s after the trip: {}", log_.passed_s() - began,
                                heats ? "the air rises again" : "the alarm has gone"));
      }
      if (environment_.is_interrupted()) return note_interruption("the operator stopped the test");
    }
    log_.read("still tripped; lowest air", celsius_text(lowest));
  }

  /// Sends the safe set point until it is read back.
  bool make_safe() {
    for (int i = 0; i < kSafeTries; ++i) {
      if (const auto sent = chamber_->send_set_point_immediately(plan_.safe)) {
        log_.read("safe set point read back", celsius_text(plan_.safe));
        return true;
      }
      environment_.wait(kSecond);
      chamber_ = environment_.connect();
    }
    return false;
  }

  /// Has the limiter set back and reset, and waits until its alarm goes.
  void ask_for_reset() {
    chamber_.reset();
    if (!environment_.ask(fmt::format("Set the limiter back to its setting for runs ({}) and reset it", plan_.usual)))
      return note_interruption("the operator did not confirm that the limiter was set back and reset");
    chamber_ = environment_.connect();
    for (int i = 0; i < kResetReadings; ++i, environment_.wait(kSecond)) {
      const auto state = read();
      if (!state) return fail("the chamber did not answer after the reset");
      if (has_alarm(*state)) continue;
      log_.read("limiter reset; air", celsius_text(state->air));
      return;
    }
    fail("the alarm remains after the operator reset the limiter");
  }

  const LimiterPlan& plan_;
  const GuardedHeating& guarded_;
  const DrillEnvironment& environment_;
  DrillLog log_;
  std::unique_ptr<drivers::Chamber> chamber_;
  Celsius peak_{-300}, trip_{-300};
  bool shows_alarm_ = false, has_failed_ = false;
  std::vector<std::string> causes_;  ///< reasons for the verdict, in order
};

}  // namespace

Result<LimiterPlan> plan_limiter_proof(const rig::RigFile& rig, Celsius air) {
  const auto& settings = rig.proof;
  const auto start = std::max(air, rig.safe_set_point) + kLimiterAboveAir;
  LimiterPlan plan{.at = settings.limiter_at.value_or(Celsius{std::ceil(start.value)}),
                   .set_point = {},
                   .safe = rig.safe_set_point,
                   .band = settings.limiter_band,
                   .within = settings.limiter_within,
                   .hold = settings.limiter_hold,
                   .usual = rig.limiter ? describe(*rig.limiter) : "as it was before the test"};
  plan.set_point = plan.at + settings.limiter_over;
  const auto refused = [&](const std::string& why) { return failure(FaultKind::usage, "limiter", why); };
  if (plan.set_point > rig.chamber_limits.highest)
    return refused(fmt::format("the set point of the test, {:g} °C, is above the chamber's limit of {:g} °C",
                               plan.set_point.value, rig.chamber_limits.highest.value));
  if (plan.at + plan.band * 2 > rig.limits.air_highest)
    return refused(fmt::format("the test may heat the air to {:g} °C, above the air limit of {:g} °C",
                               (plan.at + plan.band * 2).value, rig.limits.air_highest.value));
  if (plan.at < air + plan.band * 2)
    return refused(fmt::format("the setting of {:g} °C is too near to the air, {:.1f} °C", plan.at.value, air.value));
  return plan;
}

ProofResult prove_limiter(const LimiterPlan& plan, const GuardedHeating& guarded, const DrillEnvironment& environment) {
  return LimiterDrill(plan, guarded, environment).carry_out();
}

}  // namespace gyrotherm::prove
