// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/toml_reader.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/profile/written_profile.hpp"

namespace gyrotherm::profile {

namespace {

constexpr const char* kSchema = "gyrotherm-profile/1";

/// Reads `prefix.key = number` at any depth: both "a.b" = 1 and a.b = 1 are the path a.b.
/// Reads an upper limit of a magnitude.
double read_accepted(const TomlTable& table, const std::string& key) {
  const double limit = table.number(key);
  if (limit < 0) table.note_error(key, fmt::format("\"{}\" is {}, expected 0 or more", key, limit));
  return limit;
}

void read_accept(const TomlTable& table, const std::string& prefix, std::vector<AcceptLimit>& limits) {
  for (const auto& key : table.keys()) {
    if (table.is_table(key))
      read_accept(table.table(key), prefix + key + ".", limits);
    else
      limits.push_back({prefix + key, read_accepted(table, key)});
  }
}

/// Reads [condensation]. Returns true if the run may add warm-ups.
bool read_condensation(const TomlTable& table) { return table.boolean("warm_up", true); }

constexpr CelsiusPerMinute kRounding{1e-9};

constexpr std::size_t kMostErrors = 100;  ///< reported for one profile

/// The errors found so far. Each is listed once, even if several passes of a repeat have it.
class ErrorList {
 public:
  void note(const Segment& segment, std::string what) {
    if (found_.size() == kMostErrors) return;
    std::pair mistake{segment.place, std::move(what)};
    if (std::find(found_.begin(), found_.end(), mistake) == found_.end()) found_.push_back(std::move(mistake));
  }

  [[nodiscard]] Result<void> verdict() const {
    if (found_.empty()) return {};
    std::string what = found_.front().second;
    for (std::size_t i = 1; i < found_.size(); ++i) what += fmt::format("\n{}: {}", found_[i].first, found_[i].second);
    if (found_.size() == kMostErrors) what += fmt::format("\nonly the first {} errors are reported", kMostErrors);
    return failure(FaultKind::bad_file, found_.front().first, std::move(what));
  }

 private:
  std::vector<std::pair<std::string, std::string>> found_;
};

void check_temperature(const Segment& segment, const ChamberLimits& limits, ErrorList& errors) {
  if (segment.target >= limits.lowest && segment.target <= limits.highest) return;
  errors.note(segment, fmt::format("{:g} °C is outside the chamber's range, expected {:g} to {:g} °C",
                                   segment.target.value, limits.lowest.value, limits.highest.value));
}

void check_rate(const Segment& segment, Celsius from, const ChamberLimits& limits, ErrorList& errors) {
  const bool heating = segment.target > from;
  const auto fastest = heating ? limits.fastest_heating : limits.fastest_cooling;
  if (segment.rate.value <= fastest.value + kRounding.value) return;
  errors.note(segment, fmt::format("{:g} °C/min is faster than the chamber {}, expected at most {:g} °C/min",
                                   segment.rate.value, heating ? "heats" : "cools", fastest.value));
}

void check_deadline(const Segment& segment, ErrorList& errors) {
  if (segment.deadline >= shortest(segment)) return;
  errors.note(segment,
              fmt::format("deadline too short: {:.0f} s, expected at least the {:.0f} s that the segment takes",
                          to_seconds(segment.deadline), to_seconds(shortest(segment))));
}

/// Finds a hold whose time would run while the set point is still on its way: no ramp leads to it, and it does not
/// wait.
void check_step(const Segment& segment, Celsius from, ErrorList& errors) {
  if (segment.kind == SegmentKind::ramp || segment.guaranteed_soak || segment.target == from) return;
  errors.note(segment,
              fmt::format("the set point is {:g} °C before this hold at {:g} °C, so the hold's time would begin before "
                          "the set point arrives; expected a ramp before it, or guaranteed_soak = true",
                          from.value, segment.target.value));
}

void check_soak_keys(const Segment& segment, ErrorList& errors) {
  if (segment.ignored_keys.empty()) return;
  errors.note(segment,
              fmt::format("{} has no effect without a guaranteed soak, expected guaranteed_soak = true with it",
                          segment.ignored_keys));
}

}  // namespace

Duration shortest(const Segment& segment) {
  return segment.guaranteed_soak ? std::max(segment.duration, segment.soak_time + segment.soak_dwell)
                                 : segment.duration;
}

Celsius set_point_before(const Profile& profile, std::size_t segment) {
  return profile.segments[segment == 0 ? 0 : segment - 1].target;
}

Result<Profile> parse_profile(std::string_view text, const std::string& file) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  root->expect("schema", kSchema);
  Profile profile;
  profile.text = text;
  profile.name = root->text("name");
  if (profile.name.empty() && root->is_text("name")) root->note_error("name", "\"name\" is empty, expected a name");
  profile.title = root->text("title", profile.name);
  const auto metadata = root->table("metadata");
  for (const auto& key : metadata.keys()) profile.metadata[key] = metadata.text(key);
  read_accept(root->table("accept"), "", profile.accept);
  profile.warms_up = read_condensation(root->table("condensation"));
  const auto defaults = read_defaults(root->table("defaults"));
  const auto written = read_segments(*root, defaults);
  const auto until = root->has("until") ? std::optional(read_until(root->table("until"), defaults)) : std::nullopt;
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  expand(written, profile);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  if (until) expand_until(*until, profile);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return profile;
}

Result<void> check_profile(const Profile& profile, const ChamberLimits& limits) {
  ErrorList errors;
  each_released(profile, [&](const Segment& segment, Celsius before) {
    check_temperature(segment, limits, errors);
    if (segment.kind == SegmentKind::ramp) check_rate(segment, before, limits, errors);
    check_step(segment, before, errors);
    check_deadline(segment, errors);
    check_soak_keys(segment, errors);
  });
  return errors.verdict();
}

Result<void> check_run_limits(const Profile& profile, const char* which, Celsius lowest, Celsius highest) {
  ErrorList errors;
  each_released(profile, [&](const Segment& segment, Celsius) {
    if (segment.target < lowest || segment.target > highest)
      errors.note(segment, fmt::format("{:g} °C is outside the rig's {} limits, at which a run ends, expected "
                                       "{:g} to {:g} °C",
                                       segment.target.value, which, lowest.value, highest.value));
  });
  return errors.verdict();
}

Result<void> check_sensors(const Profile& profile, const std::vector<std::string>& channels) {
  ErrorList errors;
  each_released(profile, [&](const Segment& segment, Celsius) {
    if (segment.kind == SegmentKind::hold && !segment.is_warm_up && segment.soak_sensor != "air" &&
        std::find(channels.begin(), channels.end(), segment.soak_sensor) == channels.end())
      errors.note(segment, fmt::format("soak_sensor is \"{}\", expected \"air\" or a channel of the rig: {}",
                                       segment.soak_sensor, fmt::join(channels, ", ")));
  });
  return errors.verdict();
}

Result<void> check_turns(const Profile& profile, bool can_turn) {
  ErrorList errors;
  for (const auto& segment : profile.segments)
    if (segment.unit.turned && !can_turn)
      errors.note(segment, "the unit is turned here, expected a rig with \"can_be_turned\" in [gyro]");
  return errors.verdict();
}

namespace {

constexpr Duration kCluster = std::chrono::seconds(100);

void count(const Segment& segment, CycleTotal& total) {
  (segment.kind == SegmentKind::ramp ? total.ramps : total.holds) += shortest(segment);
  total.clusters = (total.ramps + total.holds) / kCluster;
}

/// Returns hours, minutes and seconds as "2:00:00".
std::string format_hms(Duration d) {
  const auto s = std::chrono::round<std::chrono::seconds>(d).count();
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string describe_soak(const Segment& segment) {
  if (!segment.guaranteed_soak) return "";
  if (segment.is_warm_up)
    return fmt::format("coldest thermometer at {:g} °C or more, at most {}", (segment.target - segment.soak_band).value,
                       format_hms(segment.deadline));
  return fmt::format("{} within ±{:g} K, at most {}", format_hms(segment.soak_time), segment.soak_band.value,
                     format_hms(segment.deadline));
}

/// A text table. Each column is as wide as its widest cell; `<` aligns it to the left, `>` to the right.
class Table {
 public:
  explicit Table(std::string alignment) : alignment_(std::move(alignment)) {}

  void add(std::vector<std::string> row) {
    widths_.resize(row.size());
    for (std::size_t c = 0; c < row.size(); ++c) widths_[c] = std::max(widths_[c], count_columns(row[c]));
    rows_.push_back(std::move(row));
  }

  [[nodiscard]] std::string text() const {
    std::string all;
    for (const auto& row : rows_) {
      std::string line;
      for (std::size_t c = 0; c < row.size(); ++c) line += "  " + pad(row[c], c);
      all += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return all;
  }

 private:
  [[nodiscard]] std::string pad(const std::string& cell, std::size_t column) const {
    const std::string space(widths_[column] - count_columns(cell), ' ');
    return alignment_[column] == '>' ? space + cell : cell + space;
  }

  /// Counts the columns of UTF-8 text: one for each byte that begins a character.
  [[nodiscard]] static std::size_t count_columns(const std::string& text) {
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
  }

  std::string alignment_;
  std::vector<std::size_t> widths_;
  std::vector<std::vector<std::string>> rows_;
};

std::string segments_table(const Profile& profile, const Timeline& timeline) {
  Table table("><>>>>><<");
  table.add({"#", "segment", "start", "time", "from °C", "to °C", "°C/min", "cycle", "guaranteed soak"});
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    const auto& segment = profile.segments[i];
    const auto& planned = timeline.segments[i];
    const bool ramp = segment.kind == SegmentKind::ramp;
    table.add({std::to_string(i + 1), segment.name, format_hms(planned.start), format_hms(planned.duration),
               fmt::format("{:g}", planned.from.value), fmt::format("{:g}", planned.to.value),
               ramp ? fmt::format("{:g}", segment.rate.value) : "",
               segment.cycle < 0 ? "" : profile.cycles[static_cast<std::size_t>(segment.cycle)],
               describe_soak(segment)});
  }
  return table.text();
}

std::string totals_table(const Timeline& timeline) {
  Table table("<>>>>");
  table.add({"cycle", "ramps", "holds", "total", "clusters"});
  auto totals = timeline.cycles;
  totals.push_back(timeline.all);
  for (const auto& total : totals)
    table.add({total.name, format_hms(total.ramps), format_hms(total.holds), format_hms(total.ramps + total.holds),
               std::to_string(total.clusters)});
  return table.text();
}

/// Describes the segments that wait for an operator, and those at which supplies switch the units.
std::string describe_prompts(const Profile& profile) {
  std::string lines;
  bool was_off = false;
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    const auto& segment = profile.segments[i];
    const bool is_off = segment.unit.off;
    if (!segment.prompt.empty())
      lines += fmt::format("\n  segment {} waits for the operator: {}", i + 1, segment.prompt);
    else if (is_off != was_off)
      lines += fmt::format("\n  segment {} switches the unit {} by its supply", i + 1, is_off ? "off" : "on");
    was_off = is_off;
  }
  return lines.empty() ? lines : lines + "\n";
}

/// Returns the table of a released block that begins at the end of the opening.
std::string describe_block(const Profile& profile, const ReleasedBlock& block) {
  const auto title = block.name.empty() ? std::string("closing") : fmt::format("block \"{}\"", block.name);
  const auto from = profile.segments.back().target;
  const auto* expanded = find_expansion(block, from);
  if (expanded == nullptr || expanded->segments.empty()) return fmt::format("\n{}: nothing\n", title);
  Profile path;
  path.segments.push_back({.kind = SegmentKind::hold, .name = {}, .target = from});
  path.segments.insert(path.segments.end(), expanded->segments.begin(), expanded->segments.end());
  for (auto& segment : path.segments) segment.cycle = -1;
  auto timeline = plan(path);
  path.segments.erase(path.segments.begin());
  timeline.segments.erase(timeline.segments.begin());
  return fmt::format("\n{}, {}:\n{}{}", title, format_hms(timeline.all.ramps + timeline.all.holds),
                     segments_table(path, timeline), describe_prompts(path));
}

/// Returns the goal and the released blocks of a run that ends by itself, as they follow the opening.
std::string describe_until(const Profile& profile) {
  if (!profile.until) return "";
  const auto& until = *profile.until;
  auto text = fmt::format("\nuntil U = {:g} °/h on {}, at most {}{}; the segments above are the opening\n",
                          until.u_deg_per_h, until.mission, format_hms(until.longest),
                          until.prior.empty() ? "" : ", with the prior " + until.prior);
  for (const auto& block : until.blocks) text += describe_block(profile, block);
  return text + describe_block(profile, until.closing);
}

}  // namespace

std::string describe_change(const UnitState& from, const UnitState& to, const std::vector<std::string>& units) {
  std::string words;
  const auto which = units.empty() ? std::string("the unit") : fmt::format("{}", fmt::join(units, ", "));
  if (from.off != to.off) words = fmt::format("switch {} {}", which, to.off ? "off" : "on");
  if (from.turned != to.turned) {
    if (!words.empty()) words += " and ";
    words += to.turned ? "turn the unit around: its input axis points the other way" : "turn the unit back, as mounted";
  }
  return words;
}

Profile switch_by_supplies(Profile profile, const std::vector<std::string>& unfed) {
  const auto switch_all = [&](std::vector<Segment>& segments) {
    UnitState before;
    for (auto& segment : segments) {
      const auto from = std::exchange(before, segment.unit);
      const UnitState seen{.off = unfed.empty() ? segment.unit.off : from.off, .turned = from.turned};
      if (!segment.has_own_prompt) segment.prompt = describe_change(seen, segment.unit, unfed);
    }
  };
  switch_all(profile.segments);
  each_expansion(profile, [&](ReleasedBlock::Expanded& expanded) { switch_all(expanded.segments); });
  return profile;
}

Timeline plan(const Profile& profile) {
  Timeline timeline;
  timeline.all.name = "all";
  for (const auto& name : profile.cycles) timeline.cycles.push_back({.name = name});
  Duration start{};
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    const auto& segment = profile.segments[i];
    const auto from = segment.kind == SegmentKind::ramp ? set_point_before(profile, i) : segment.target;
    timeline.segments.push_back({start, shortest(segment), from, segment.target});
    start += shortest(segment);
    count(segment, timeline.all);
    if (segment.cycle >= 0) count(segment, timeline.cycles[static_cast<std::size_t>(segment.cycle)]);
  }
  return timeline;
}

std::string describe(const Profile& profile, const Timeline& timeline) {
  return fmt::format("{}: {}\n\n{}\n{}{}{}", profile.name, profile.title, segments_table(profile, timeline),
                     totals_table(timeline), describe_prompts(profile), describe_until(profile));
}

}  // namespace gyrotherm::profile
