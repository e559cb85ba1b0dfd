// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/block_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sequencer/profile/released_blocks.hpp"

namespace gyrotherm::run {
namespace {

/// Rounds to the nearest number with this many significant digits, as it is printed and read back.
double round_to_digits(double value, int digits) {
  const auto text = fmt::format("{:.{}g}", value, digits);
  double rounded{};
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

std::optional<double> rounded_u(double u_deg_per_h) {
  return std::isfinite(u_deg_per_h) ? std::optional(round_to_digits(u_deg_per_h, 3)) : std::nullopt;
}

/// Returns hours, rounded to hundredths.
double rounded_hours(Duration time) { return std::round(to_seconds(time) / 36) / 100; }

/// Returns the time that a block takes from the end of the profile, and the closing segments after it; nothing if it
/// is not released there.
struct BlockTimes {
  Duration block{};
  Duration closing{};
};
std::optional<BlockTimes> block_times(const profile::Profile& profile, const profile::ReleasedBlock& block) {
  const auto* expanded = find_expansion(block, profile.segments.back().target);
  if (expanded == nullptr || expanded->segments.empty()) return std::nullopt;
  const auto* closing = find_expansion(profile.until->closing, expanded->segments.back().target);
  if (closing == nullptr) return std::nullopt;
  const bool is_too_long =
      profile.segments.size() + expanded->segments.size() + closing->segments.size() > profile::kMaxSegments;
  if (is_too_long) return std::nullopt;
  return BlockTimes{.block = profile::total_time(expanded->segments),
                    .closing = profile::total_time(closing->segments)};
}

/// Returns the rank of a block: its gain per hour, or 0 if it does not lower U. While U is unknown, a lower U has a
/// higher rank; if the record is too short for a model, a block with an unknown U has the lowest rank above 0.
double rank_block(const DecisionInputs& inputs, std::size_t block, double hours) {
  const double u_now = inputs.u_now_deg_per_h, u_after = inputs.u_after_deg_per_h[block];
  const bool is_known = std::isfinite(u_now);
  if (!std::isfinite(u_after)) return inputs.is_record_short && !is_known ? std::numeric_limits<double>::min() : 0;
  if (!is_known) return 1 / u_after;
  const double gain = inputs.gains.empty() ? 1 - u_after / u_now : inputs.gains[block];
  return gain > kLeastGain ? gain / hours : 0;
}

}  // namespace

record::Decision decide(const profile::Profile& profile, const DecisionInputs& inputs) {
  assert(is_open(profile) && inputs.u_after_deg_per_h.size() == profile.until->blocks.size());
  assert(inputs.gains.empty() || inputs.gains.size() == inputs.u_after_deg_per_h.size());
  const auto& until = *profile.until;
  const auto left = until.longest - inputs.used;
  record::Decision decision{.number = inputs.number,
                            .target_deg_per_h = inputs.target_deg_per_h,
                            .u_now_deg_per_h = rounded_u(inputs.u_now_deg_per_h),
                            .hours_used = rounded_hours(inputs.used),
                            .hours_left = rounded_hours(std::max(left, Duration{}))};
  std::vector<double> ranks;  // 0 for a block that does not fit
  bool any_fits = false, another_lowers = false;
  for (std::size_t i = 0; i < until.blocks.size(); ++i) {
    const auto times = block_times(profile, until.blocks[i]);
    auto& block = decision.blocks.emplace_back(record::BlockNumbers{.block = until.blocks[i].name});
    block.u_after_deg_per_h = rounded_u(inputs.u_after_deg_per_h[i]);
    block.fits = times && inputs.hold_left + times->block + times->closing <= left;
    if (times) block.hours = rounded_hours(times->block);
    const auto rank = rank_block(inputs, i, times ? to_seconds(times->block) / kSecondsPerHour : 1);
    any_fits = any_fits || block.fits;
    another_lowers = another_lowers || (rank > 0 && !block.fits);
    ranks.push_back(block.fits ? rank : 0);
  }
  const auto best = *std::ranges::max_element(ranks);
  const auto chosen = std::ranges::find_if(ranks, [&](double rank) { return rank >= kEqualShare * best; });
  if (decision.u_now_deg_per_h && *decision.u_now_deg_per_h <= inputs.target_deg_per_h) {
    decision.end = kMet;
  } else if (best > 0) {
    const auto& block = decision.blocks[static_cast<std::size_t>(chosen - ranks.begin())];
    decision.block = block.block;
    decision.u_expected_deg_per_h = block.u_after_deg_per_h;
  } else {
    decision.end = another_lowers || !any_fits ? kTimeIsUp : kCannotBeMet;
  }
  return decision;
}

}  // namespace gyrotherm::run
