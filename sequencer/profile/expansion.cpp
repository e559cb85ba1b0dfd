// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/expansion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>
#include <random>
#include <string>
#include <utility>

namespace gyrotherm::profile {
namespace {

constexpr int kMostRedraws = 1000;

/// The top 53 bits as a fraction of [0, 1): std::uniform_real_distribution differs between standard libraries, this
/// does not.
double fraction(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

/// A ramp to a target, and the hold there.
struct RandomStep {
  Celsius to;
  CelsiusPerMinute rate;
  Duration hold{};
};

/// Targets are drawn uniformly from the rows in turn, in steps of 0.1 °C; rates in steps of 0.01 °C/min; holds in whole
/// seconds.
class RandomProgram {
 public:
  explicit RandomProgram(const WrittenRandom& program) : program_(program), engine_(program.seed) {}

  /// The next step from a set point. Nothing if the next row has no target that is `least_step` away from it.
  [[nodiscard]] std::optional<RandomStep> next(Celsius from);

 private:
  /// Uniform over [low, high], rounded to `per_unit` values in one unit.
  double draw(double low, double high, double per_unit);
  std::optional<Celsius> draw_target(Celsius from);

  const WrittenRandom& program_;
  std::mt19937_64 engine_;
  std::size_t row_ = 0;
};

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

/// The pass of a repeat that a segment is expanded in.
struct Pass {
  std::optional<CelsiusPerMinute> rate;
  int cycle{-1};
};

class Expansion {
 public:
  explicit Expansion(Profile& profile) : profile_(profile) {}

  void append_all(const std::vector<WrittenSegment>& body, const Pass& pass);

 private:
  void append(const WrittenSegment& written, const WrittenHold& hold, const Pass& pass);
  void append(const WrittenSegment& written, const WrittenRamp& ramp, const Pass& pass);
  void append(const WrittenSegment& written, const WrittenRepeat& repeat, const Pass& pass);
  void append(const WrittenSegment& written, const WrittenRandom& random, const Pass& pass);
  void add(const WrittenSegment& written, Segment segment, const Pass& pass);

  [[nodiscard]] Celsius set_point() const { return profile_.segments.back().target; }
  [[nodiscard]] int begin_cycle(const WrittenSegment& written, const std::string& pass_name);

  Profile& profile_;
  Duration total_{};
  bool at_limit_ = false;
};

/// A hold as its soak rule makes it; `deadline` absent: the rule's own.
Segment hold_at(Celsius target, Duration time, const SoakRule& soak, std::optional<Duration> deadline) {
  Segment segment{.kind = SegmentKind::hold,
                  .name = fmt::format("hold {:g} °C", target.value),
                  .target = target,
                  .duration = time,
                  .guaranteed_soak = soak.guaranteed,
                  .soak_band = soak.band,
                  .soak_sensor = soak.sensor,
                  .soak_dwell = soak.dwell,
                  .soak_slope = soak.slope,
                  .soak_time = soak.time.value_or(time)};
  const auto at_least = shortest(segment);
  segment.deadline = deadline.value_or(soak.guaranteed ? 3 * at_least + soak.margin : at_least);
  return segment;
}

Segment ramp_to(Celsius target, CelsiusPerMinute rate, Duration time, std::optional<Duration> deadline) {
  return {.kind = SegmentKind::ramp,
          .name = fmt::format("ramp to {:g} °C", target.value),
          .target = target,
          .rate = rate,
          .duration = time,
          .deadline = deadline.value_or(time)};
}

/// Whole seconds, rounded up, at least one; nothing if longer than any profile.
std::optional<Duration> ramp_time(Kelvins distance, CelsiusPerMinute rate) {
  if (60.0 * distance.value / rate.value > to_seconds(kLongestProfile)) return std::nullopt;
  return std::max(kSecond, Duration(std::chrono::ceil<std::chrono::seconds>(distance / rate)));
}

void Expansion::append_all(const std::vector<WrittenSegment>& body, const Pass& pass) {
  for (const auto& written : body)
    if (!at_limit_) std::visit([&](const auto& what) { append(written, what, pass); }, written.what);
}

void Expansion::append(const WrittenSegment& written, const WrittenHold& hold, const Pass& pass) {
  add(written, hold_at(hold.at ? *hold.at : set_point(), hold.time, hold.soak, hold.deadline), pass);
}

void Expansion::append(const WrittenSegment& written, const WrittenRamp& ramp, const Pass& pass) {
  const auto distance = abs(ramp.to - set_point());
  if (ramp.time) {
    const CelsiusPerMinute rate{60.0 * distance.value / to_seconds(*ramp.time)};
    return add(written, ramp_to(ramp.to, rate, *ramp.time, ramp.deadline), pass);
  }
  const auto rate = ramp.rate ? *ramp.rate : *pass.rate;
  const auto time = ramp_time(distance, rate);
  if (distance == Kelvins{0})
    written.table.mistake("to", fmt::format("the ramp goes nowhere: the set point is {:g} °C already", ramp.to.value));
  if (!time)
    written.table.mistake("", fmt::format("a ramp over {:g} K at {:g} °C/min takes more than {:.0f} s, the limit",
                                          distance.value, rate.value, to_seconds(kLongestProfile)));
  add(written, ramp_to(ramp.to, rate, time.value_or(kSecond), ramp.deadline), pass);
}

void Expansion::append(const WrittenSegment& written, const WrittenRepeat& repeat, const Pass& pass) {
  for (std::int64_t i = 0; i < repeat.count && !at_limit_; ++i) {
    Pass inner = pass;
    if (!repeat.rates.empty()) inner.rate = repeat.rates[static_cast<std::size_t>(i)];
    if (repeat.cycle)
      inner.cycle = begin_cycle(written, repeat.rates.empty() ? fmt::format("pass {}", i + 1)
                                                              : fmt::format("{:g} °C/min", inner.rate->value));
    append_all(repeat.body, inner);
  }
}

/// The last ramp or hold is cut where the program's duration ends; a cut ramp ends where its set point stands by then.
void Expansion::append(const WrittenSegment& written, const WrittenRandom& random, const Pass& pass) {
  RandomProgram program(random);
  for (auto left = random.duration; left > Duration::zero() && !at_limit_;) {
    const auto from = set_point();
    const auto step = program.next(from);
    if (!step) {
      written.table.mistake("least_step", fmt::format("no target is {:g} K away from {:g} °C, expected a smaller step",
                                                      random.least_step.value, from.value));
      return;
    }
    const auto distance = step->to - from;
    const auto whole = ramp_time(abs(distance), step->rate).value_or(kLongestProfile);
    const auto time = std::min(whole, left);
    const auto way = step->rate * time;
    const auto to = time == whole ? step->to : from + (distance < Kelvins{0} ? -way : way);
    add(written, ramp_to(to, step->rate, time, {}), pass);
    left -= time;
    if (left == Duration::zero()) return;
    const auto hold = std::min(step->hold, left);
    add(written, hold_at(to, hold, random.soak, {}), pass);
    left -= hold;
  }
}

int Expansion::begin_cycle(const WrittenSegment& written, const std::string& pass_name) {
  profile_.cycles.push_back(written.name.empty() ? pass_name : fmt::format("{}, {}", written.name, pass_name));
  return static_cast<int>(profile_.cycles.size()) - 1;
}

void Expansion::add(const WrittenSegment& written, Segment segment, const Pass& pass) {
  if (at_limit_) return;
  total_ += shortest(segment);
  at_limit_ = profile_.segments.size() == kMostSegments || total_ > kLongestProfile;
  if (at_limit_) {
    written.table.mistake("", fmt::format("the profile grows beyond {} segments or {:.0f} s here", kMostSegments,
                                          to_seconds(kLongestProfile)));
    return;
  }
  if (!written.name.empty()) segment.name = written.name;
  segment.cycle = pass.cycle;
  segment.place = written.table.place();
  profile_.segments.push_back(std::move(segment));
}

}  // namespace

void expand(const std::vector<WrittenSegment>& written, Profile& profile) {
  Expansion(profile).append_all(written, {});
}

}  // namespace gyrotherm::profile
