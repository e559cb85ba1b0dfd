/// The likeliest meaning of a misspelt word.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace gyrotherm {

/// The word of `known` with the least edit distance to `word`, or "" if none is near (distance over a third of its
/// length, at least 2).
[[nodiscard]] std::string nearest(std::string_view word, std::span<const std::string> known);

}  // namespace gyrotherm
