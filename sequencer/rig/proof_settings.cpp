// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/proof_settings.hpp"

#include <array>
#include <string_view>

namespace gyrotherm::rig {
namespace {

constexpr Duration kDay = std::chrono::hours(24);
constexpr double kMostDays = 3660;
constexpr std::array<std::string_view, 2> kDays{"days", "day"};

/// Reads an interval such as "180 days".
Duration read_days(const TomlTable& table, const char* key) {
  const auto text = table.text(key);
  const auto days = parse_quantity(text, kDays);
  if (days && *days > 0 && *days <= kMostDays) return from_seconds(*days * to_seconds(kDay));
  table.note_error(key, fmt::format("\"{}\" is \"{}\", expected more than 0 and at most {} days, such as \"180 days\"",
                                    key, text, kMostDays));
  return kDay;
}

Kelvins read_span(const TomlTable& table, const char* key, Kelvins fallback, double most) {
  const auto span = table.kelvins(key, fallback);
  if (span.value >= 1 && span.value <= most) return span;
  table.note_error(key, fmt::format("\"{}\" is {:g} K, expected 1 to {:g} K", key, span.value, most));
  return fallback;
}

Duration read_limit(const TomlTable& table, const char* key, Duration fallback) {
  constexpr Duration kShortest = std::chrono::seconds(10), kLongest = std::chrono::hours(4);
  const auto time = table.duration(key, fallback);
  if (time >= kShortest && time <= kLongest) return time;
  table.note_error(key, fmt::format("\"{}\" is out of range, expected 10 s to 4 h", key));
  return fallback;
}

}  // namespace

ProofSettings read_proof_settings(const TomlTable& root) {
  ProofSettings settings;
  const auto table = root.table("prove");
  if (table.has("every")) settings.every = read_days(table, "every");
  settings.folder = table.text("folder", settings.folder);
  if (table.has("limiter_at")) settings.limiter_at = table.celsius("limiter_at");
  settings.limiter_over = read_span(table, "limiter_over", settings.limiter_over, 50);
  settings.limiter_band = read_span(table, "limiter_band", settings.limiter_band, 20);
  if (settings.limiter_over < settings.limiter_band * 2)
    table.note_error("limiter_over", "expected at least twice limiter_band: a late trip must be seen");
  settings.limiter_within = read_limit(table, "limiter_within", settings.limiter_within);
  settings.limiter_hold = read_limit(table, "limiter_hold", settings.limiter_hold);
  const auto policy = root.table("policy");
  settings.refuses_runs = policy.choice("proof", {"warn", "refuse"}, "warn") == "refuse";
  if (settings.refuses_runs && !settings.every)
    policy.note_error("proof", "\"refuse\" needs the interval of the proof tests, [prove] every");
  return settings;
}

}  // namespace gyrotherm::rig
