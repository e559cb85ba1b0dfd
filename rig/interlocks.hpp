/// The conditions under which a run may go on. Pure: limits and what was seen in, a verdict out; it outranks the
/// profile.
#pragma once

#include <string>

#include "core/sample.hpp"

namespace gyrotherm {

/// From the rig file's [limits]. A silent instrument suspends the profile (the clock stops, recording goes on) and,
/// when it has been silent for its limit, ends the run.
struct InterlockLimits {
  Celsius air_lowest{-60};  ///< of the chamber's own sensor
  Celsius air_highest{100};
  Celsius thermometers_lowest{-60};  ///< of each thermometer on the article
  Celsius thermometers_highest{100};
  int confirming_samples = 2;                        ///< consecutive samples beyond a limit before it counts
  Duration suspend_after = std::chrono::seconds(5);  ///< of silence
  Duration chamber_lost = std::chrono::minutes(10);  ///< silence that ends the run
  Duration thermometers_lost = std::chrono::minutes(10);
  Duration gyro_lost = std::chrono::minutes(60);
};

/// What the interlocks remember from second to second.
struct InterlockMemory {
  Duration chamber_silent{};
  Duration thermometers_silent{};
  Duration gyro_silent{};
  int beyond_limit{};
};

enum class Reaction { go_on, suspend, abort };

struct Verdict {
  Reaction reaction = Reaction::go_on;
  std::string cause;  ///< empty when nothing is wrong
};

struct Judgement {
  Verdict verdict;
  InterlockMemory memory;
};

/// Judges one sample that covers `elapsed`; what the chamber says of its own state and alarms counts at once. The most
/// severe reaction wins.
[[nodiscard]] Judgement judge(const InterlockLimits& limits, const InterlockMemory& memory, const Sample& sample,
                              Duration elapsed);

}  // namespace gyrotherm
