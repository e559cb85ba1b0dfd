// SPDX-License-Identifier: Apache-2.0
/// The profile as it is written, a tree of segments, and its expansion to the flat list of holds and ramps that runs.
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

/// What makes a soak: of a hold, or the `[defaults]` that it falls back to.
struct SoakRule {
  bool guaranteed{};
  Kelvins band{2};
  std::string sensor = "air";
  Duration dwell{};
  CelsiusPerMinute slope{};                 ///< 0: none
  std::optional<Duration> time;             ///< absent: the hold's own time
  Duration margin = std::chrono::hours(2);  ///< a guaranteed soak may take 3 times as long as it must, plus this
  std::string unheeded{};                   ///< its keys that stand on a segment without a guaranteed soak, in words
};

struct WrittenHold {
  std::optional<Celsius> at;  ///< absent: where the segment before left the set point
  Duration time{};
  SoakRule soak;
  std::optional<Duration> deadline;
  std::string prompt{};          ///< empty: none of its own
  std::optional<bool> off{};     ///< the unit's power; absent: as in the segment before
  std::optional<bool> turned{};  ///< its axis; absent: as in the segment before
};

/// With neither rate nor time, the ramp takes the rate of the pass that it is repeated in.
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

/// Ramps to drawn targets and holds of drawn lengths, until `duration` is filled exactly.
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

/// Either `count` passes, or one for each of `rates`.
struct WrittenRepeat {
  std::int64_t count{};
  std::vector<CelsiusPerMinute> rates;
  bool cycle{};
  std::vector<WrittenSegment> body;
};

struct WrittenSegment {
  TomlTable table;  ///< for the places of mistakes found later
  std::string name;
  std::variant<WrittenHold, WrittenRamp, WrittenRepeat, WrittenRandom> what;
};

/// Reads `[defaults]`. Mistakes are noted in the table.
[[nodiscard]] SoakRule read_defaults(const TomlTable& defaults);

/// Reads every `[[segment]]` of a file's root. Mistakes are noted in the tables; a segment that could not be understood
/// is left out.
[[nodiscard]] std::vector<WrittenSegment> read_segments(const TomlTable& root, const SoakRule& defaults);

inline constexpr int kMostSegments = 20'000;
inline constexpr Duration kLongestProfile = std::chrono::seconds(100'000'000);

/// Appends the segments of `written` to the profile, and the cycles they make; a random program is drawn on the way,
/// the same one from the same seed on every machine. Mistakes that only the expansion shows (a ramp that goes nowhere,
/// a profile beyond the limits above) are noted in the tables; expansion ends at a limit.
void expand(const std::vector<WrittenSegment>& written, Profile& profile);

}  // namespace gyrotherm::profile
