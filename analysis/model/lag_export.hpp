// SPDX-License-Identifier: Apache-2.0
/// The lags of an exported model: what its C program keeps for them.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/model/model.hpp"

namespace gyrotherm::model {

/// What stands for the words of a C text.
using CWords = std::map<std::string, std::string, std::less<>>;

/// The places of the C texts where lags are spoken of: parameters, a ring of what each lag has followed (as SlidingLags
/// keeps it), and the function that moves it on. All are empty for a model without lags.
[[nodiscard]] CWords lag_words(const Model& model, std::string_view name, const std::vector<std::string>& thermometers);

}  // namespace gyrotherm::model
