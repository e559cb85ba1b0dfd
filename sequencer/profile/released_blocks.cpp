// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/released_blocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm::profile {
namespace {

constexpr std::size_t kLongestBlockName = 60, kMaxBlocks = 50;

void check_block_name(const TomlTable& table, const std::string& name) {
  if (!table.has("name")) return;
  if (name.empty() || name.size() > kLongestBlockName || plain(name) != name || name.find('"') != std::string::npos)
    table.note_error("name", fmt::format("\"name\" is not valid, expected 1 to {} bytes without quotation marks",
                                         kLongestBlockName));
}

std::vector<WrittenUntil::Block> read_blocks(const TomlTable& until, const SoakRule& defaults) {
  std::vector<WrittenUntil::Block> blocks;
  const auto tables = until.tables("block");
  if (tables.empty()) until.note_error("", "no block, expected at least one [[until.block]]");
  if (tables.size() > kMaxBlocks)
    until.note_error("block", fmt::format("{} blocks, expected at most {}", tables.size(), kMaxBlocks));
  for (const auto& table : tables) {
    const auto name = table.text("name");
    check_block_name(table, name);
    if (std::ranges::count(blocks, name, &WrittenUntil::Block::name) > 0)
      table.note_error("name", fmt::format("a block \"{}\" exists already, expected another name", name));
    blocks.push_back({table, name, read_block(table, defaults)});
  }
  return blocks;
}

/// Records an error if the unit is not switched on and as mounted after the segments, or if they do not end with a hold
/// that leaves time for a decision.
void check_end(const TomlTable& table, const std::vector<Segment>& segments, const char* what) {
  const auto last = segments.empty() ? Segment{} : segments.back();
  if (last.kind != SegmentKind::hold || last.duration < kShortestLastHold)
    table.note_error("", fmt::format("{} does not end with a hold of at least {:.0f} min, in which the next block is "
                                     "chosen",
                                     what, to_seconds(kShortestLastHold) / 60));
  if (last.unit.off || last.unit.turned)
    table.note_error("", fmt::format("{} leaves the unit {}, expected it switched on and as mounted", what,
                                     last.unit.off ? "switched off" : "turned around"));
}

/// Returns the set points at which a block can begin: those at which the opening and the blocks end.
std::vector<Celsius> possible_starts(const WrittenUntil& written, const Profile& profile) {
  std::vector<Celsius> starts{profile.segments.back().target};
  for (const auto& block : written.blocks) {
    const auto segments = expand_block(block.segments, starts.front());
    if (!segments.empty() && std::ranges::count(starts, segments.back().target) == 0)
      starts.push_back(segments.back().target);
  }
  return starts;
}

ReleasedBlock expand_at(const WrittenUntil::Block& block, const std::vector<Celsius>& starts) {
  ReleasedBlock released{.name = block.name, .place = block.table.location(), .expanded = {}};
  for (const auto from : starts) released.expanded.push_back({from, expand_block(block.segments, from)});
  return released;
}

Duration longest_time(const ReleasedBlock& block) {
  Duration longest{};
  for (const auto& expanded : block.expanded) longest = std::max(longest, total_time(expanded.segments));
  return longest;
}

Duration shortest_time(const ReleasedBlock& block) {
  auto least = longest_time(block);
  for (const auto& expanded : block.expanded) least = std::min(least, total_time(expanded.segments));
  return least;
}

/// Records an error if the opening and the closing segments exceed the longest duration, or if a block never fits.
void check_longest(const WrittenUntil& written, const Profile& profile) {
  const auto& until = *profile.until;
  const auto fixed = total_time(profile.segments) + longest_time(until.closing);
  if (until.longest > kLongestProfile)
    written.table.note_error("longest", fmt::format("\"longest\" is {:.0f} s, expected at most {:.0f} s",
                                                    to_seconds(until.longest), to_seconds(kLongestProfile)));
  if (until.longest < fixed)
    return written.table.note_error(
        "longest", fmt::format("\"longest\" is {:.0f} s, expected at least the {:.0f} s of opening and closing",
                               to_seconds(until.longest), to_seconds(fixed)));
  for (std::size_t i = 0; i < until.blocks.size(); ++i)
    if (const auto time = shortest_time(until.blocks[i]); fixed + time > until.longest)
      written.blocks[i].table.note_error(
          "", fmt::format("this block of {:.0f} s never fits between opening and closing into the longest duration",
                          to_seconds(time)));
}

tl::unexpected<Fault> block_mismatch(std::string what) {
  return failure(FaultKind::mismatch, "blocks of the profile", std::move(what));
}

}  // namespace

WrittenUntil read_until(const TomlTable& until, const SoakRule& defaults) {
  WrittenUntil written{.table = until,
                       .u_deg_per_h = until.number("u_deg_per_h"),
                       .mission = until.text("mission"),
                       .prior = until.text("prior", ""),
                       .longest = until.duration("longest"),
                       .blocks = read_blocks(until, defaults),
                       .closing = {}};
  if (until.has("u_deg_per_h") && !(written.u_deg_per_h > 0 && std::isfinite(written.u_deg_per_h)))
    until.note_error("u_deg_per_h",
                     fmt::format("\"u_deg_per_h\" is {:g} °/h, expected more than 0 °/h", written.u_deg_per_h));
  if (until.has("mission") && written.mission.empty())
    until.note_error("mission", "\"mission\" is empty, expected a profile");
  if (until.has("closing")) {
    const auto closing = until.table("closing");
    written.closing.push_back({closing, "", read_block(closing, defaults)});
  }
  return written;
}

void expand_until(const WrittenUntil& written, Profile& profile) {
  check_end(written.table, profile.segments, "the opening");
  const auto starts = possible_starts(written, profile);
  Until until{.u_deg_per_h = written.u_deg_per_h,
              .mission = written.mission,
              .prior = written.prior,
              .longest = written.longest,
              .place = written.table.location(),
              .blocks = {},
              .closing = {.name = "", .place = written.table.location(), .expanded = {}}};
  for (const auto& block : written.blocks) {
    until.blocks.push_back(expand_at(block, starts));
    for (const auto& expanded : until.blocks.back().expanded) check_end(block.table, expanded.segments, "the block");
  }
  for (const auto from : starts) until.closing.expanded.push_back({from, {}});
  if (!written.closing.empty()) until.closing = expand_at(written.closing.front(), starts);
  profile.until = std::move(until);
  check_longest(written, profile);
}

void each_expansion(Profile& profile, const std::function<void(ReleasedBlock::Expanded&)>& use) {
  if (!profile.until) return;
  for (auto& block : profile.until->blocks) std::ranges::for_each(block.expanded, use);
  std::ranges::for_each(profile.until->closing.expanded, use);
}

void each_released(const Profile& profile, const std::function<void(const Segment&, Celsius before)>& use) {
  for (std::size_t i = 0; i < profile.segments.size(); ++i) use(profile.segments[i], set_point_before(profile, i));
  const auto use_all = [&](const ReleasedBlock& block) {
    for (const auto& [from, segments] : block.expanded) {
      auto before = from;
      for (const auto& segment : segments) use(segment, std::exchange(before, segment.target));
    }
  };
  if (!profile.until) return;
  std::ranges::for_each(profile.until->blocks, use_all);
  use_all(profile.until->closing);
}

const ReleasedBlock::Expanded* find_expansion(const ReleasedBlock& block, Celsius from) {
  const auto found = std::ranges::find(block.expanded, from, &ReleasedBlock::Expanded::from);
  return found == block.expanded.end() ? nullptr : &*found;
}

Duration total_time(std::span<const Segment> segments) {
  Duration total{};
  for (const auto& segment : segments) total += shortest(segment);
  return total;
}

bool is_open(const Profile& profile) {
  return profile.until && (profile.added_blocks.empty() || !profile.added_blocks.back().empty());
}

Result<std::vector<Segment>> add_block(Profile& profile, const std::string& block) {
  if (!is_open(profile)) return block_mismatch(fmt::format("\"{}\" cannot be added to a profile that ends", block));
  const auto& blocks = profile.until->blocks;
  const auto named = std::ranges::find(blocks, block, &ReleasedBlock::name);
  if (!block.empty() && named == blocks.end()) return block_mismatch(fmt::format("no block \"{}\"", block));
  const auto from = profile.segments.back().target;
  const auto* expanded = find_expansion(block.empty() ? profile.until->closing : *named, from);
  if (expanded == nullptr)
    return block_mismatch(fmt::format("\"{}\" is not released for a start at {:g} °C", block, from.value));
  if (profile.segments.size() + expanded->segments.size() > kMaxSegments)
    return block_mismatch(fmt::format("the run would have more than {} segments", kMaxSegments));
  auto segments = expanded->segments;
  profile.segments.insert(profile.segments.end(), segments.begin(), segments.end());
  profile.added_blocks.push_back(block);
  return segments;
}

Result<void> add_blocks(Profile& profile, std::span<const std::string> blocks) {
  for (const auto& block : blocks)
    if (auto added = add_block(profile, block); !added) return failure(added.error());
  return {};
}

}  // namespace gyrotherm::profile
