// SPDX-License-Identifier: Apache-2.0
/// The uncertainty of an exported model's means, as C.
#pragma once

#include <string>
#include <string_view>

#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// What an exported program has of it; all empty for a model that says nothing of its uncertainty.
struct UncertaintyInC {
  std::string declarations;  ///< for the header: NAME_uncertainty
  std::string definitions;   ///< for the source: the budget, source by source, and U
  std::string test;          ///< for the body of NAME_self_test: returns 1 if U does not come out of the budget again
};

/// U of a mean of compensated bias over the model's cluster length, and the contributions that it is made of. Fails
/// with usage if these are not finite.
[[nodiscard]] Result<UncertaintyInC> uncertainty_in_c(const Model& model, std::string_view name);

}  // namespace gyrotherm::model
