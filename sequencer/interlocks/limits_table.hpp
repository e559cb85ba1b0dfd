/// The tables of a rig file that say what its interlocks watch and how they react: [limits], [policy], [safe].
/// docs/interlocks.md describes every key.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "core/toml_reader.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm {

/// How an operator's stop leaves the chamber. An abort always makes it safe.
enum class OnStop { hold, safe };

/// What a run does whose terminal is closed.
enum class OnHangup { go_on, safe };

struct RunLimits {
  Duration longest_suspended = std::chrono::hours(2);  ///< then the run is aborted
  Duration longest_held = std::chrono::hours(12);      ///< likewise
  Duration longest_return = std::chrono::hours(4);     ///< likewise
  Duration resume_delay = std::chrono::seconds(10);    ///< how long a cause is gone before the run goes on
  OnStop on_stop = OnStop::safe;
  OnHangup on_hangup = OnHangup::go_on;
};

/// Every mistake is noted in the tables. `channels`: the rig's thermometers, in order; `chamber`: what air_fastest
/// follows from where the file does not have it.
[[nodiscard]] InterlockLimits read_limits(const TomlTable& root, const std::vector<std::string>& channels,
                                          const ChamberLimits& chamber);

/// How long the states of a run may last, and how an operator's stop leaves the chamber.
[[nodiscard]] RunLimits read_run_limits(const TomlTable& root);

}  // namespace gyrotherm
