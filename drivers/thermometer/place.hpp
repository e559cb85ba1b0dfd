/// An instrument's own place in front of its faults.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// "thermometer 2 input 3": the place of the instrument, then that within it.
[[nodiscard]] Fault at_instrument(const std::string& place, Fault fault);

/// The readings with their faults so placed; if there is no answer, its fault for each of the `inputs`.
[[nodiscard]] std::vector<Result<Celsius>> readings_at(const std::string& place, std::size_t inputs,
                                                       Result<std::vector<Result<Celsius>>> answer);

}  // namespace gyrotherm
