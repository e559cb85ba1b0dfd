// SPDX-License-Identifier: Apache-2.0
/// Judges markup that the report wrote.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm::tests {

/// "" if every element is closed, in order, every attribute is quoted and no bare '&' or '<' is left; else what is
/// wrong. Raw style sheets, the doctype and void HTML elements written "<x/>" are understood.
[[nodiscard]] std::string markup_mistake(std::string_view markup);

[[nodiscard]] int count_of(std::string_view text, std::string_view word);

}  // namespace gyrotherm::tests
