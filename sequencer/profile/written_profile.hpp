// SPDX-License-Identifier: Apache-2.0
/// The tree of segments in a profile file, and its expansion to the flat list of holds and ramps that runs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm::profile {

/// The soak keys of a hold, or of `[defaults]`, which a hold inherits.
struct SoakRule {
  bool guaranteed{};
  Kelvins band{2};
  std::string sensor = "air";
  Duration dwell{};
  CelsiusPerMinute slope{};  ///< 0: no limit
  /// Absent: the hold's own time.
  std::optional<Duration> time;
  /// Added to three times the shortest duration to give the default deadline of a guaranteed soak.
  Duration margin = std::chrono::hours(2);
  /// Soak keys of a segment without a guaranteed soak, as text.
  std::string ignored_keys{};
};

struct WrittenHold {
  /// Absent: the set point that the previous segment ended at.
  std::optional<Celsius> at;
  Duration time{};
  SoakRule soak;
  std::optional<Duration> deadline;
  std::string prompt{};  ///< empty: none
  /// Absent: power as in the previous segment.
  std::optional<bool> off{};
  /// Absent: axis as in the previous segment.
  std::optional<bool> turned{};
  /// Absent: the door is opened if the axis changes.
  std::optional<bool> opens_door{};
};

/// A ramp. If neither rate nor time is given, the rate of the repeat's current pass applies.
struct WrittenRamp {
  Celsius to;
  std::optional<CelsiusPerMinute> rate;
  std::optional<Duration> time;
  std::optional<Duration> deadline;
};

template <class T>
struct WrittenRange {
  T low{};
  T high{};
};

/// A random program: ramps to drawn targets and holds of drawn lengths, until `duration` is filled exactly.
struct WrittenRandom {
  std::uint64_t seed{};
  Duration duration{};
  std::vector<WrittenRange<Celsius>> targets;  ///< used in turn
  WrittenRange<CelsiusPerMinute> rates;
  WrittenRange<Duration> hold;
  Kelvins least_step;
  SoakRule soak;
};

struct WrittenSegment;

/// A repeat: `count` passes, or one pass for each of `rates`.
struct WrittenRepeat {
  std::int64_t count{};
  std::vector<CelsiusPerMinute> rates;
  bool cycle{};
  std::vector<WrittenSegment> body;
};

struct WrittenSegment {
  /// Source of the position in errors that are found later.
  TomlTable table;
  std::string name;
  std::variant<WrittenHold, WrittenRamp, WrittenRepeat, WrittenRandom> what;
};

/// Reads `[defaults]`. Records errors in the table.
[[nodiscard]] SoakRule read_defaults(const TomlTable& defaults);

/// Reads every `[[segment]]` of a file's root. Records errors in the tables and leaves out segments of an unknown kind.
[[nodiscard]] std::vector<WrittenSegment> read_segments(const TomlTable& root, const SoakRule& defaults);

/// Reads the `[[segment]]`s of a released block, which begins at the set point where the run is. Records errors as
/// read_segments() does, and also if the first segment is not a ramp or if a segment needs a person at the chamber.
[[nodiscard]] std::vector<WrittenSegment> read_block(const TomlTable& block, const SoakRule& defaults);

/// Expands a block that begins at a set point. Omits the first ramp if it ends at this set point. Records errors as
/// expand() does.
[[nodiscard]] std::vector<Segment> expand_block(const std::vector<WrittenSegment>& written, Celsius from);

inline constexpr int kMaxSegments = 20'000;
inline constexpr Duration kLongestProfile = std::chrono::seconds(100'000'000);

/// Appends the segments of `written`, and their cycles, to the profile. Draws the random programs; the same seed draws
/// the same program on every machine. Records the errors that only the expansion reveals (a ramp to its own start, a
/// profile above the limits) in the tables, and stops at a limit.
void expand(const std::vector<WrittenSegment>& written, Profile& profile);

}  // namespace gyrotherm::profile
