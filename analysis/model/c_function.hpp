/// A model's function of its scaled inputs as C.
#pragma once

#include <string>

#include "analysis/methods/function.hpp"

namespace gyrotherm {

/// Tables and "static double function_of(const double z[])".
[[nodiscard]] std::string c_function(const Function& function);

/// Of the terms that the function adds up: how much the rounding of their sum can amount to.
[[nodiscard]] double sum_of_weights(const Function& function);

}  // namespace gyrotherm
