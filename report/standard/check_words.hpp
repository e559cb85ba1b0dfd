// SPDX-License-Identifier: Apache-2.0
/// Texts of the views of check runs, in English and German.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "report/plot/language.hpp"

namespace gyrotherm::standard {

/// Returns the text of a key; asserts that the table has it.
[[nodiscard]] std::string_view check_word(plot::Language language, std::string_view key);

/// Returns the text of a key with each {} replaced by a value.
template <class... Values>
[[nodiscard]] std::string check_sentence(plot::Language language, std::string_view key, const Values&... values) {
  return fmt::vformat(fmt::string_view(check_word(language, key)), fmt::make_format_args(values...));
}

}  // namespace gyrotherm::standard
