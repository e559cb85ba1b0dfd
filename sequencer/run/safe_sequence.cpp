// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/safe_sequence.hpp"

#include <fmt/format.h>

#include <cmath>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::run {
namespace {

constexpr Duration kEachSecondFor = std::chrono::seconds(10);
constexpr Duration kThenEvery = std::chrono::seconds(10);
constexpr Duration kTellEvery = std::chrono::seconds(60);

bool is_due(const std::optional<Duration>& last, Duration at, Duration every) { return !last || at - *last >= every; }

}  // namespace

SafeSequence::SafeSequence(const rig::RigFile& rig)
    : target_(rig.safe_set_point),
      off_(rig.safe_off),
      tolerance_(set_point_tolerance(rig.chamber_map)),
      ends_programs_(rig.chamber_map.sequences.contains("stop_program")) {}

Result<void> SafeSequence::carry_out(io::InstrumentIo& io, bool at_once) {
  if (!taken_) {
    if (auto sent = at_once ? io.insist(target_) : io.command(target_); !sent) return sent;
    taken_ = true;
  }
  if (off_ && !switched_) {
    if (auto switched = io.switch_on(false); !switched) return switched;
    switched_ = true;
  }
  return {};
}

std::optional<std::string> SafeSequence::attempt(io::InstrumentIo& io, Duration at) {
  if (!began_) began_ = at;
  const bool at_once = at - *began_ < kEachSecondFor || is_due(insisted_, at, kThenEvery);
  if (at_once) insisted_ = at;
  const auto done = carry_out(io, at_once);
  trouble_ = done ? "" : text(done.error());
  if (done || !is_due(told_, at, kTellEvery)) return std::nullopt;
  told_ = at;
  return describe() + "; it is tried until it can";
}

void SafeSequence::see(const Reading<ChamberState>& chamber) {
  if (!began_ || !chamber.value) return;
  const auto shown = chamber.value->set_point;
  const bool overruled = ends_programs_ && carries_out_program(chamber.value->activity);
  const bool holds = abs(shown - target_) <= tolerance_ && !overruled;
  if (holds) taken_ = true;  // though nobody may have acknowledged it
  if (!taken_ || (off_ && !switched_)) return;
  confirmed_ = holds || (std::isnan(shown.value) && !overruled);
  if (!confirmed_) taken_ = switched_ = false;
}

std::string SafeSequence::describe() const {
  const auto what = fmt::format("sent to {:g} °C{}", target_.value, off_ ? " and switched off" : "");
  if (confirmed_) return "the chamber was " + what;
  return fmt::format("the chamber could NOT be {} ({})", what, trouble_.empty() ? "it has not confirmed it" : trouble_);
}

}  // namespace gyrotherm::run
