// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/written_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <random>
#include <string_view>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm::profile {

namespace {

constexpr Celsius kColdest{-273.15};
constexpr Celsius kHottest{1000};
constexpr CelsiusPerMinute kFastest{1000};

Duration whole_seconds(Duration d) { return std::chrono::ceil<std::chrono::seconds>(d); }

bool is_plausible(Celsius t) { return t >= kColdest && t <= kHottest; }
bool is_plausible(CelsiusPerMinute rate) { return rate > CelsiusPerMinute{0} && rate <= kFastest; }

void check(const TomlTable& table, std::string_view key, Celsius t) {
  if (is_plausible(t)) return;
  table.note_error(
      key, fmt::format("\"{}\" is {:g} °C, expected {:g} to {:g} °C", key, t.value, kColdest.value, kHottest.value));
}

void check(const TomlTable& table, std::string_view key, CelsiusPerMinute rate) {
  if (is_plausible(rate)) return;
  table.note_error(key, fmt::format("\"{}\" is {:g} °C/min, expected more than 0, at most {:g} °C/min", key, rate.value,
                                    kFastest.value));
}

void check(const TomlTable& table, std::string_view key, Duration d) {
  if (d <= Duration::zero())
    table.note_error(key, fmt::format("\"{}\" is zero, expected a time longer than zero", key));
}

/// Returns the range of two values. Records an error for any other list and returns the neutral range.
template <class T>
WrittenRange<T> make_range(const TomlTable& table, std::string_view key, const std::vector<T>& values,
                           WrittenRange<T> neutral) {
  if (values.size() != 2 || values[0] > values[1]) {
    table.note_error(key, fmt::format("\"{}\" is not a range, expected [low, high]", key));
    return neutral;
  }
  check(table, key, values[0]);
  check(table, key, values[1]);
  return {values[0], values[1]};
}

/// Reads a time above zero, rounded up to whole seconds.
Duration read_time(const TomlTable& table, std::string_view key) {
  if (!table.has(key)) return table.duration(key);  // records that the key is missing
  const auto time = table.duration(key, kSecond);
  check(table, key, time);
  return whole_seconds(time);
}

std::optional<Duration> read_time_if_any(const TomlTable& table, std::string_view key) {
  return table.has(key) ? std::optional(read_time(table, key)) : std::nullopt;
}

/// Reads a temperature from absolute zero to 1000 °C.
Celsius read_temperature(const TomlTable& table, std::string_view key) {
  const auto t = table.celsius(key);
  check(table, key, t);
  return t;
}

std::optional<Celsius> read_temperature_if_any(const TomlTable& table, std::string_view key) {
  return table.has(key) ? std::optional(read_temperature(table, key)) : std::nullopt;
}

/// Reads a rate above 0, of at most 1000 °C/min.
std::optional<CelsiusPerMinute> read_rate_if_any(const TomlTable& table, std::string_view key) {
  if (!table.has(key)) return std::nullopt;
  const auto rate = table.rate(key, kFastest);
  check(table, key, rate);
  return rate;
}

std::vector<CelsiusPerMinute> read_rates(const TomlTable& table, std::string_view key) {
  auto rates = table.rates(key);
  for (const auto rate : rates) check(table, key, rate);
  return rates;
}

/// Reads an amount above 0 K.
Kelvins read_band(const TomlTable& table, std::string_view key, Kelvins fallback) {
  const auto band = table.kelvins(key, fallback);
  if (band <= Kelvins{0})
    table.note_error(key, fmt::format("\"{}\" is {:g} K, expected more than 0 K", key, band.value));
  return band;
}

/// Reads two rates, the first not above the second.
WrittenRange<CelsiusPerMinute> read_rate_range(const TomlTable& table, std::string_view key) {
  return make_range(table, key, table.rates(key), {kFastest, kFastest});
}

WrittenRange<Duration> read_time_range(const TomlTable& table, std::string_view key) {
  const auto range = make_range(table, key, table.durations(key), {kSecond, kSecond});
  return {whole_seconds(range.low), whole_seconds(range.high)};
}

/// Reads one or more rows of two temperatures, the first not above the second.
std::vector<WrittenRange<Celsius>> read_temperature_ranges(const TomlTable& table, std::string_view key) {
  std::vector<WrittenRange<Celsius>> ranges;
  for (const auto& row : table.number_rows(key)) {
    std::vector<Celsius> ends;
    std::transform(row.begin(), row.end(), std::back_inserter(ends), [](double celsius) { return Celsius{celsius}; });
    ranges.push_back(make_range(table, key, ends, {}));
  }
  if (ranges.empty()) table.note_error(key, fmt::format("\"{}\" is empty, expected rows of [low, high]", key));
  return ranges;
}

constexpr std::size_t kLongestPrompt = 500;  ///< bytes

/// Reads the task for the operator. Records an error if it is not one line of text.
std::string read_prompt(const TomlTable& table) {
  auto prompt = table.text("prompt", "");
  if (table.has("prompt") && prompt.empty())
    table.note_error("prompt", "\"prompt\" is empty, expected a task for the operator");
  if (prompt.size() > kLongestPrompt)
    table.note_error("prompt",
                     fmt::format("\"prompt\" is {} bytes long, expected at most {}", prompt.size(), kLongestPrompt));
  if (plain(prompt) != prompt)
    table.note_error("prompt", "\"prompt\" has control characters, expected one line of text");
  return prompt;
}

/// Reads a choice of two keywords. Returns true for the second, or nothing if the key is absent.
std::optional<bool> read_either(const TomlTable& table, const char* key, const char* usual, const char* other) {
  if (!table.has(key)) return std::nullopt;
  return table.choice(key, {usual, other}) == other;
}

constexpr int kDeepestNesting = 8;

/// The context of a segment.
struct SegmentContext {
  int depth{1};
  bool in_cycle{};
  bool pass_has_rate{};
};

/// Reads the sensor, dwell and slope of a soak. Absent keys leave the rule unchanged.
void read_soak_conditions(const TomlTable& table, SoakRule& rule) {
  rule.sensor = table.text("soak_sensor", rule.sensor);
  if (const auto dwell = read_time_if_any(table, "soak_dwell")) rule.dwell = *dwell;
  if (const auto slope = read_rate_if_any(table, "soak_slope")) rule.slope = *slope;
}

/// Returns the soak keys of a segment without a guaranteed soak, separated by commas.
std::string find_ignored_keys(const TomlTable& table, const SoakRule& rule) {
  std::vector<std::string> keys;
  for (const char* key : {"soak_time", "soak_band", "soak_sensor", "soak_dwell", "soak_slope"})
    if (!rule.guaranteed && table.has(key)) keys.emplace_back(key);
  return fmt::format("{}", fmt::join(keys, ", "));
}

/// Reads segments in the order in which they run, to check that each has a known set point to start from.
class SegmentReader {
 public:
  explicit SegmentReader(const SoakRule& defaults, bool set_point_known = false)
      : defaults_(defaults), set_point_known_(set_point_known) {}

  std::vector<WrittenSegment> read_all(const TomlTable& parent, const SegmentContext& context) {
    const auto tables = parent.tables("segment");
    if (tables.empty()) parent.note_error("segment", "no segment, expected at least one");
    std::vector<WrittenSegment> segments;
    for (const auto& table : tables) read(table, context, segments);
    return segments;
  }

 private:
  void read(const TomlTable& table, const SegmentContext& context, std::vector<WrittenSegment>& into) {
    const auto kind = table.choice("kind", {"hold", "ramp", "repeat", "random"});
    if (kind.empty() || table.text("kind") != kind) {
      // The kind decides which keys are valid. Without a known kind, no key is reported as unknown.
      (void)table.keys();
      set_point_known_ = true;
      return;
    }
    WrittenSegment segment{table, table.text("name", ""), {}};
    if (kind == "hold") segment.what = read_hold(table);
    if (kind == "ramp") segment.what = read_ramp(table, context);
    if (kind == "repeat") segment.what = read_repeat(table, context);
    if (kind == "random") segment.what = read_random(table);
    into.push_back(std::move(segment));
  }

  WrittenHold read_hold(const TomlTable& table) {
    WrittenHold hold{.at = read_temperature_if_any(table, "at"),
                     .time = read_time(table, "time"),
                     .soak = defaults_,
                     .deadline = read_time_if_any(table, "deadline")};
    if (hold.at) set_point_known_ = true;
    if (!set_point_known_) table.note_error("", "missing key \"at\", expected a temperature in the first hold");
    set_point_known_ = true;
    hold.soak.guaranteed = table.boolean("guaranteed_soak", defaults_.guaranteed);
    hold.soak.band = read_band(table, "soak_band", defaults_.band);
    read_soak_conditions(table, hold.soak);
    if (const auto time = read_time_if_any(table, "soak_time")) hold.soak.time = time;
    hold.soak.ignored_keys = find_ignored_keys(table, hold.soak);
    hold.prompt = read_prompt(table);
    hold.off = read_either(table, "power", "on", "off");
    hold.turned = read_either(table, "axis", "as mounted", "turned");
    hold.opens_door = read_either(table, "door", "closed", "opened");
    if (hold.opens_door.value_or(false) && hold.prompt.empty() && !hold.turned)
      table.note_error("door", "the door is opened without a prompt, expected \"prompt\" or \"axis\" with it");
    return hold;
  }

  WrittenRamp read_ramp(const TomlTable& table, const SegmentContext& context) {
    expect_set_point(table, "ramp");
    const WrittenRamp ramp{.to = read_temperature(table, "to"),
                           .rate = read_rate_if_any(table, "rate"),
                           .time = read_time_if_any(table, "time"),
                           .deadline = read_time_if_any(table, "deadline")};
    if (ramp.rate && ramp.time) table.note_error("time", "\"rate\" and \"time\" are both given, expected one of them");
    if (!ramp.rate && !ramp.time && !context.pass_has_rate)
      table.note_error("", "neither \"rate\" nor \"time\" is given, expected one of them");
    return ramp;
  }

  WrittenRepeat read_repeat(const TomlTable& table, const SegmentContext& context) {
    WrittenRepeat repeat;
    repeat.rates = read_rates(table, "rates");
    repeat.cycle = table.boolean("cycle", false);
    const bool counted = table.has("count");
    if (counted == table.has("rates"))
      table.note_error("", "a repeat has either \"count\" or \"rates\", expected one of them");
    repeat.count = counted ? table.integer("count", 1) : static_cast<std::int64_t>(repeat.rates.size());
    if (counted && repeat.count <= 0)
      table.note_error("count", fmt::format("\"count\" is {}, expected 1 or more", repeat.count));
    if (!counted && table.has("rates") && repeat.rates.empty())
      table.note_error("rates", "\"rates\" is empty, expected one for each pass");
    if (repeat.cycle && context.in_cycle)
      table.note_error("cycle", "a cycle inside a cycle, expected one level of cycles");
    if (context.depth >= kDeepestNesting) {
      table.note_error("", fmt::format("repeats are nested deeper than {} levels", kDeepestNesting));
      table.ignore("segment");
      return repeat;
    }
    repeat.body = read_all(table, {.depth = context.depth + 1,
                                   .in_cycle = context.in_cycle || repeat.cycle,
                                   .pass_has_rate = context.pass_has_rate || !repeat.rates.empty()});
    return repeat;
  }

  WrittenRandom read_random(const TomlTable& table) {
    expect_set_point(table, "random program");
    WrittenRandom random{.duration = read_time(table, "duration"),
                         .targets = read_temperature_ranges(table, "targets"),
                         .rates = read_rate_range(table, "rates"),
                         .hold = read_time_range(table, "hold"),
                         .least_step = read_band(table, "least_step", Kelvins{1}),
                         .soak = defaults_};
    const auto seed = table.integer("seed");
    if (seed < 0) table.note_error("seed", fmt::format("\"seed\" is {}, expected 0 or more", seed));
    random.seed = static_cast<std::uint64_t>(seed);
    // The soak time of a drawn hold is its whole duration.
    random.soak.time.reset();
    random.soak.guaranteed = table.boolean("guaranteed_soak", defaults_.guaranteed);
    random.soak.band = read_band(table, "soak_band", defaults_.band);
    read_soak_conditions(table, random.soak);
    random.soak.ignored_keys = find_ignored_keys(table, random.soak);
    return random;
  }

  /// Records an error if no set point is known before this segment; reports only the first such segment.
  void expect_set_point(const TomlTable& table, std::string_view kind) {
    if (!set_point_known_)
      table.note_error("", fmt::format("the start of this {} is unknown, expected a hold with \"at\" before it", kind));
    set_point_known_ = true;
  }

  const SoakRule& defaults_;
  bool set_point_known_;
};

/// Records an error for each segment of a block that needs a person at the chamber or begins a cycle.
void check_block(const std::vector<WrittenSegment>& written) {
  for (const auto& segment : written) {
    if (const auto* hold = std::get_if<WrittenHold>(&segment.what)) {
      if (hold->turned) segment.table.note_error("axis", "a block cannot turn the unit; expected it in the opening");
      if (hold->opens_door)
        segment.table.note_error("door", "a block cannot open the door; expected it in the opening");
    }
    if (const auto* repeat = std::get_if<WrittenRepeat>(&segment.what)) {
      if (repeat->cycle) segment.table.note_error("cycle", "a block has no cycles; expected cycles in the opening");
      check_block(repeat->body);
    }
  }
}

}  // namespace

SoakRule read_defaults(const TomlTable& defaults) {
  SoakRule rule;
  rule.guaranteed = defaults.boolean("guaranteed_soak", rule.guaranteed);
  rule.band = read_band(defaults, "soak_band", rule.band);
  read_soak_conditions(defaults, rule);
  rule.time = read_time_if_any(defaults, "soak_time");
  rule.margin = defaults.duration("deadline_margin", rule.margin);
  return rule;
}

std::vector<WrittenSegment> read_segments(const TomlTable& root, const SoakRule& defaults) {
  return SegmentReader(defaults).read_all(root, {});
}

std::vector<WrittenSegment> read_block(const TomlTable& block, const SoakRule& defaults) {
  auto written = SegmentReader(defaults, true).read_all(block, {});
  if (!written.empty() && !std::holds_alternative<WrittenRamp>(written.front().what))
    written.front().table.note_error("kind", "the first segment of a block is not a ramp, expected one");
  check_block(written);
  return written;
}

namespace {

constexpr int kMaxRedraws = 1000;

/// Returns the top 53 bits as a fraction in [0, 1). std::uniform_real_distribution would differ between standard
/// libraries.
double fraction(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

/// A ramp to a target and the hold there.
struct RandomStep {
  Celsius to;
  CelsiusPerMinute rate;
  Duration hold{};
};

/// Draws targets uniformly from the rows in turn, in steps of 0.1 °C; rates in steps of 0.01 °C/min; holds in whole
/// seconds.
class RandomProgram {
 public:
  explicit RandomProgram(const WrittenRandom& program) : program_(program), engine_(program.seed) {}

  /// Returns the next step from a set point, or nothing if the next row has no target that is `least_step` away from
  /// it.
  [[nodiscard]] std::optional<RandomStep> next(Celsius from) {
    const auto to = draw_target(from);
    if (!to) return std::nullopt;
    const CelsiusPerMinute rate{draw(program_.rates.low.value, program_.rates.high.value, 100)};
    const double hold_s = draw(to_seconds(program_.hold.low), to_seconds(program_.hold.high), 1);
    return RandomStep{*to, rate, std::chrono::seconds(static_cast<std::int64_t>(hold_s))};
  }

 private:
  /// Draws uniformly from [low, high] and rounds to `per_unit` values in one unit.
  double draw(double low, double high, double per_unit) {
    const double drawn = low + (high - low) * fraction(engine_);
    return std::clamp(std::round(drawn * per_unit) / per_unit, low, high);
  }

  std::optional<Celsius> draw_target(Celsius from) {
    const auto& row = program_.targets[row_++ % program_.targets.size()];
    for (int i = 0; i < kMaxRedraws; ++i) {
      const Celsius to{draw(row.low.value, row.high.value, 10)};
      if (abs(to - from) >= program_.least_step) return to;
    }
    return std::nullopt;
  }

  const WrittenRandom& program_;
  std::mt19937_64 engine_;
  std::size_t row_ = 0;
};

/// Returns the segment of a hold. Without `deadline`, the default of the soak rule applies.
Segment make_hold(Celsius target, Duration time, const SoakRule& soak, std::optional<Duration> deadline) {
  Segment segment{.kind = SegmentKind::hold,
                  .name = fmt::format("hold {:g} °C", target.value),
                  .target = target,
                  .duration = time,
                  .guaranteed_soak = soak.guaranteed,
                  .soak_band = soak.band,
                  .soak_sensor = soak.sensor,
                  .soak_dwell = soak.dwell,
                  .soak_slope = soak.slope,
                  .soak_time = soak.time.value_or(time),
                  .ignored_keys = soak.ignored_keys};
  const auto at_least = shortest(segment);
  segment.deadline = deadline.value_or(soak.guaranteed ? 3 * at_least + soak.margin : at_least);
  return segment;
}

Segment make_ramp(Celsius target, CelsiusPerMinute rate, Duration time, std::optional<Duration> deadline) {
  return {.kind = SegmentKind::ramp,
          .name = fmt::format("ramp to {:g} °C", target.value),
          .target = target,
          .rate = rate,
          .duration = time,
          .deadline = deadline.value_or(time)};
}

/// Returns the duration of a ramp in whole seconds, rounded up, at least one; nothing if it is longer than any profile.
std::optional<Duration> ramp_time(Kelvins distance, CelsiusPerMinute rate) {
  if (60.0 * distance.value / rate.value > to_seconds(kLongestProfile)) return std::nullopt;
  return std::max(kSecond, Duration(std::chrono::ceil<std::chrono::seconds>(distance / rate)));
}

/// The pass of a repeat in which a segment is expanded.
struct Pass {
  std::optional<CelsiusPerMinute> rate;
  int cycle{-1};
};

class Expansion {
 public:
  explicit Expansion(Profile& profile) : profile_(profile) {}

  void append_all(const std::vector<WrittenSegment>& body, const Pass& pass) {
    for (const auto& written : body)
      if (!at_limit_) std::visit([&](const auto& what) { append(written, what, pass); }, written.what);
  }

 private:
  void append(const WrittenSegment& written, const WrittenHold& hold, const Pass& pass) {
    auto segment = make_hold(hold.at ? *hold.at : set_point(), hold.time, hold.soak, hold.deadline);
    const auto before = std::exchange(unit_, {hold.off.value_or(unit_.off), hold.turned.value_or(unit_.turned)});
    segment.has_own_prompt = !hold.prompt.empty();
    segment.prompt = segment.has_own_prompt ? hold.prompt : describe_change(before, unit_);
    segment.opens_door = hold.opens_door.value_or(before.turned != unit_.turned);
    add(written, std::move(segment), pass);
  }

  void append(const WrittenSegment& written, const WrittenRamp& ramp, const Pass& pass) {
    const auto distance = abs(ramp.to - set_point());
    if (ramp.time) {
      const CelsiusPerMinute rate{60.0 * distance.value / to_seconds(*ramp.time)};
      return add(written, make_ramp(ramp.to, rate, *ramp.time, ramp.deadline), pass);
    }
    const auto rate = ramp.rate ? *ramp.rate : *pass.rate;
    const auto time = ramp_time(distance, rate);
    if (distance == Kelvins{0})
      written.table.note_error(
          "to", fmt::format("the ramp changes nothing: the set point is {:g} °C already", ramp.to.value));
    if (!time)
      written.table.note_error("", fmt::format("a ramp over {:g} K at {:g} °C/min takes more than {:.0f} s, the limit",
                                               distance.value, rate.value, to_seconds(kLongestProfile)));
    add(written, make_ramp(ramp.to, rate, time.value_or(kSecond), ramp.deadline), pass);
  }

  void append(const WrittenSegment& written, const WrittenRepeat& repeat, const Pass& pass) {
    for (std::int64_t i = 0; i < repeat.count && !at_limit_; ++i) {
      Pass inner = pass;
      if (!repeat.rates.empty()) inner.rate = repeat.rates[static_cast<std::size_t>(i)];
      if (repeat.cycle)
        inner.cycle = begin_cycle(written, repeat.rates.empty() ? fmt::format("pass {}", i + 1)
                                                                : fmt::format("{:g} °C/min", inner.rate->value));
      append_all(repeat.body, inner);
    }
  }

  /// Cuts the last ramp or hold at the end of the program's duration. A cut ramp ends at the set point that it has
  /// reached.
  void append(const WrittenSegment& written, const WrittenRandom& random, const Pass& pass) {
    RandomProgram program(random);
    for (auto left = random.duration; left > Duration::zero() && !at_limit_;) {
      const auto from = set_point();
      const auto step = program.next(from);
      if (!step) {
        written.table.note_error("least_step",
                                 fmt::format("no target is {:g} K away from {:g} °C, expected a smaller step",
                                             random.least_step.value, from.value));
        return;
      }
      const auto distance = step->to - from;
      const auto whole = ramp_time(abs(distance), step->rate).value_or(kLongestProfile);
      const auto time = std::min(whole, left);
      const auto way = step->rate * time;
      const auto to = time == whole ? step->to : from + (distance < Kelvins{0} ? -way : way);
      add(written, make_ramp(to, step->rate, time, {}), pass);
      left -= time;
      if (left == Duration::zero()) return;
      const auto hold = std::min(step->hold, left);
      add(written, make_hold(to, hold, random.soak, {}), pass);
      left -= hold;
    }
  }

  void add(const WrittenSegment& written, Segment segment, const Pass& pass) {
    if (at_limit_) return;
    total_ += shortest(segment);
    at_limit_ = profile_.segments.size() == kMaxSegments || total_ > kLongestProfile;
    if (at_limit_) {
      written.table.note_error("", fmt::format("the profile exceeds {} segments or {:.0f} s here", kMaxSegments,
                                               to_seconds(kLongestProfile)));
      return;
    }
    if (!written.name.empty()) segment.name = written.name;
    segment.cycle = pass.cycle;
    segment.unit = unit_;
    segment.place = written.table.location();
    profile_.segments.push_back(std::move(segment));
  }

  [[nodiscard]] Celsius set_point() const { return profile_.segments.back().target; }
  [[nodiscard]] int begin_cycle(const WrittenSegment& written, const std::string& pass_name) {
    profile_.cycles.push_back(written.name.empty() ? pass_name : fmt::format("{}, {}", written.name, pass_name));
    return static_cast<int>(profile_.cycles.size()) - 1;
  }

  Profile& profile_;
  Duration total_{};
  UnitState unit_;
  bool at_limit_ = false;
};

}  // namespace

void expand(const std::vector<WrittenSegment>& written, Profile& profile) {
  Expansion(profile).append_all(written, {});
}

std::vector<Segment> expand_block(const std::vector<WrittenSegment>& written, Celsius from) {
  Profile scratch;
  scratch.segments.push_back({.kind = SegmentKind::hold, .name = {}, .target = from});
  const auto* ramp = written.empty() ? nullptr : std::get_if<WrittenRamp>(&written.front().what);
  const bool is_there = ramp != nullptr && ramp->to == from;
  expand({written.begin() + (is_there ? 1 : 0), written.end()}, scratch);
  scratch.segments.erase(scratch.segments.begin());
  return std::move(scratch.segments);
}

}  // namespace gyrotherm::profile
