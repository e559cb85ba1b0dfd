// SPDX-License-Identifier: Apache-2.0
/// Checks markup that the report wrote.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm::tests {

/// Returns an empty string if every element is closed in order, every attribute is quoted and no bare '&' or '<'
/// exists; otherwise the error. Accepts raw style sheets, the doctype and void HTML elements written "<x/>".
[[nodiscard]] std::string markup_error(std::string_view markup);

[[nodiscard]] int count_of(std::string_view text, std::string_view word);

}  // namespace gyrotherm::tests
