#include "sequencer/profile/random_program.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace gyrotherm {
namespace {

constexpr int kMostRedraws = 1000;

/// The top 53 bits as a fraction of [0, 1): std::uniform_real_distribution differs between standard libraries, this
/// does not.
double fraction(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

}  // namespace

double RandomProgram::draw(double low, double high, double per_unit) {
  const double drawn = low + (high - low) * fraction(engine_);
  return std::clamp(std::round(drawn * per_unit) / per_unit, low, high);
}

std::optional<Celsius> RandomProgram::draw_target(Celsius from) {
  const auto& row = program_.targets[row_++ % program_.targets.size()];
  for (int i = 0; i < kMostRedraws; ++i) {
    const Celsius to{draw(row.low.value, row.high.value, 10)};
    if (abs(to - from) >= program_.least_step) return to;
  }
  return std::nullopt;
}

std::optional<RandomStep> RandomProgram::next(Celsius from) {
  const auto to = draw_target(from);
  if (!to) return std::nullopt;
  const CelsiusPerMinute rate{draw(program_.rates.low.value, program_.rates.high.value, 100)};
  const double hold_s = draw(to_seconds(program_.hold.low), to_seconds(program_.hold.high), 1);
  return RandomStep{*to, rate, std::chrono::seconds(static_cast<std::int64_t>(hold_s))};
}

}  // namespace gyrotherm
