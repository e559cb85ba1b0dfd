// SPDX-License-Identifier: Apache-2.0
/// Checks the HTML and SVG of the reports.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm::tests {

/// Returns the first error, or an empty string. Requires that elements are closed in order and attributes are quoted,
/// and rejects a bare '&' or '<'. Accepts the doctype, raw style sheets and void elements written "<x/>".
[[nodiscard]] std::string markup_error(std::string_view markup);

/// Counts the occurrences of a word in a text. They do not overlap.
[[nodiscard]] int count_occurrences(std::string_view text, std::string_view word);

}  // namespace gyrotherm::tests
