/// The tables of a rig file that say what its interlocks watch and how they react: [limits], [policy], [safe].
/// docs/interlocks.md describes every key.
#pragma once

#include <string>
#include <vector>

#include "core/toml_reader.hpp"
#include "rig/interlocks.hpp"
#include "sequencer/procedure.hpp"
#include "sequencer/profile.hpp"

namespace gyrotherm {

/// Every mistake is noted in the tables. `channels`: the rig's thermometers, in order; `chamber`: what air_fastest
/// follows from where the file does not have it.
[[nodiscard]] InterlockLimits read_limits(const TomlTable& root, const std::vector<std::string>& channels,
                                          const ChamberLimits& chamber);

/// How long the states of a run may last, and how an operator's stop leaves the chamber.
[[nodiscard]] ProcedureLimits read_procedure_limits(const TomlTable& root);

}  // namespace gyrotherm
