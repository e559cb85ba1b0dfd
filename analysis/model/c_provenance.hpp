/// What is known of a model, in words for the head of an exported file.
#pragma once

#include <string>

#include "analysis/model/model.hpp"

namespace gyrotherm {

/// Lines of a block comment, each begun with a space and ended: what it computes, from what it was trained and whether
/// that was simulated, its figures, and the trained range of each input.
[[nodiscard]] std::string c_provenance(const Model& model);

}  // namespace gyrotherm
