/// A model as C99 for a navigation computer: no allocation, no state of its own, nothing but <math.h>.
#pragma once

#include <string>
#include <string_view>

#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm {

struct CProgram {
  std::string header, source;
};

/// NAME.h and NAME.c. Names begin with NAME_; the header says what is there, which thermometers in which order, what
/// the model was trained on and how good it was. It has
///   NAME_predict  from the thermometers' means of the last cluster length and those of the one before (for rates), as
///                 `predict` does it, in double, inputs outside the trained range clamped to it as in
///                 trained_range.hpp;
///   NAME_push     the same from a reading a second, in a struct of fixed size, as CompensationStream does it;
///   NAME_self_test  0 if the values that this program predicted for a few means come out again.
/// Each tells in its return value what was outside or missing. Agrees with `predict` to c_tolerance_deg_per_h. Fails
/// with usage if `name` cannot begin the names of a C program.
[[nodiscard]] Result<CProgram> to_c(const Model& model, std::string_view name);

/// 1e-12 of the target's STD; where the weights of the function add up to more than 1000, so much more of it, since the
/// rounding of their sum then shows.
[[nodiscard]] double c_tolerance_deg_per_h(const Model& model);

/// The nearest name that can begin the names of a C program: "7-B" becomes "m7_B".
[[nodiscard]] std::string c_name(std::string_view text);

}  // namespace gyrotherm
