// SPDX-License-Identifier: Apache-2.0
/// Profiles of runs that end by themselves: the table `[until]`, its released blocks, and the growth of the profile by
/// these blocks. Everything is expanded and checked when the profile is read. A run can therefore carry out only what
/// was released. Pure; any thread.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/profile/written_profile.hpp"

namespace gyrotherm::profile {

/// Shortest hold at the end of the opening and of each block. The next block is chosen during its last minutes.
inline constexpr Duration kShortestLastHold = std::chrono::minutes(10);

/// The table `[until]` as written. Copies of the tables record later errors.
struct WrittenUntil {
  TomlTable table;
  double u_deg_per_h{};
  std::string mission;
  std::string prior{};
  Duration longest{};
  struct Block {
    TomlTable table;
    std::string name;
    std::vector<WrittenSegment> segments;
  };
  std::vector<Block> blocks;
  /// Empty if the profile has no closing segments.
  std::vector<Block> closing;
};

/// Reads the table `[until]`. Records errors in the tables.
[[nodiscard]] WrittenUntil read_until(const TomlTable& until, const SoakRule& defaults);

/// Expands the blocks for each set point at which they can begin, and stores them in the profile, whose segments must
/// have been expanded. Records errors in the tables: a block that does not end with a sufficiently long hold or leaves
/// the unit switched off, and a longest duration that does not suffice.
void expand_until(const WrittenUntil& written, Profile& profile);

/// Calls `use` with each expansion of the blocks and of the closing segments.
void each_expansion(Profile& profile, const std::function<void(ReleasedBlock::Expanded&)>& use);

/// Calls `use` with each segment of the profile and of every expansion, and with the set point before it.
void each_released(const Profile& profile, const std::function<void(const Segment&, Celsius before)>& use);

/// Returns the expansion of a block that begins at a set point; null if there is none.
[[nodiscard]] const ReleasedBlock::Expanded* find_expansion(const ReleasedBlock& block, Celsius from);

/// Returns the duration of segments without waiting.
[[nodiscard]] Duration total_time(std::span<const Segment> segments);

/// Returns whether the run of the profile has not been decided to end, so that its last segment is not its end.
[[nodiscard]] bool is_open(const Profile& profile);

/// Appends a released block, or the closing segments if `block` is empty. Returns the appended segments. Fails with
/// mismatch, and changes nothing, if the profile has no such block or is not open.
[[nodiscard]] Result<std::vector<Segment>> add_block(Profile& profile, const std::string& block);

/// Rebuilds the profile of a recorded run: appends the blocks that its decisions have chosen, in order. Fails as
/// add_block() does.
[[nodiscard]] Result<void> add_blocks(Profile& profile, std::span<const std::string> blocks);

}  // namespace gyrotherm::profile
