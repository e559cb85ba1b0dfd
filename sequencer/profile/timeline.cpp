// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/timeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace gyrotherm::profile {
namespace {

constexpr Duration kCluster = std::chrono::seconds(100);

void count(const Segment& segment, CycleTotal& total) {
  (segment.kind == SegmentKind::ramp ? total.ramps : total.holds) += shortest(segment);
  total.clusters = (total.ramps + total.holds) / kCluster;
}

/// "2:00:00": hours, minutes, seconds.
std::string hms(Duration d) {
  const auto s = std::chrono::round<std::chrono::seconds>(d).count();
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string soak_of(const Segment& segment) {
  if (!segment.guaranteed_soak) return "";
  return fmt::format("{} within ±{:g} K, at most {}", hms(segment.soak_time), segment.soak_band.value,
                     hms(segment.deadline));
}

/// Columns that are as wide as their widest cell: `<` to the left, `>` to the right.
class Table {
 public:
  explicit Table(std::string alignment) : alignment_(std::move(alignment)) {}

  void add(std::vector<std::string> row) {
    widths_.resize(row.size());
    for (std::size_t c = 0; c < row.size(); ++c) widths_[c] = std::max(widths_[c], columns_of(row[c]));
    rows_.push_back(std::move(row));
  }

  [[nodiscard]] std::string text() const {
    std::string all;
    for (const auto& row : rows_) {
      std::string line;
      for (std::size_t c = 0; c < row.size(); ++c) line += "  " + padded(row[c], c);
      all += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return all;
  }

 private:
  [[nodiscard]] std::string padded(const std::string& cell, std::size_t column) const {
    const std::string space(widths_[column] - columns_of(cell), ' ');
    return alignment_[column] == '>' ? space + cell : cell + space;
  }

  /// The columns that UTF-8 text takes: one for each byte that begins a character.
  [[nodiscard]] static std::size_t columns_of(const std::string& text) {
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
    table.add({std::to_string(i + 1), segment.name, hms(planned.start), hms(planned.duration),
               fmt::format("{:g}", planned.from.value), fmt::format("{:g}", planned.to.value),
               ramp ? fmt::format("{:g}", segment.rate.value) : "",
               segment.cycle < 0 ? "" : profile.cycles[static_cast<std::size_t>(segment.cycle)], soak_of(segment)});
  }
  return table.text();
}

std::string totals_table(const Timeline& timeline) {
  Table table("<>>>>");
  table.add({"cycle", "ramps", "holds", "total", "clusters"});
  auto totals = timeline.cycles;
  totals.push_back(timeline.all);
  for (const auto& total : totals)
    table.add({total.name, hms(total.ramps), hms(total.holds), hms(total.ramps + total.holds),
               std::to_string(total.clusters)});
  return table.text();
}

}  // namespace

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
  return fmt::format("{}: {}\n\n{}\n{}", profile.name, profile.title, segments_table(profile, timeline),
                     totals_table(timeline));
}

}  // namespace gyrotherm::profile
