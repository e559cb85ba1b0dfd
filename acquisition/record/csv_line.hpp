/// One line of a text table, cut into fields.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

inline constexpr std::size_t kLongestLine = 65536;  ///< bytes of a line of any table
inline constexpr std::size_t kMostFields = 4096;    ///< … and its fields

struct Field {
  std::string_view text;  ///< trimmed of blanks, without its quotes
  std::size_t column{};   ///< where it begins, in bytes from 1
};

/// Cuts at `separator`; fields may stand in double quotes. With a blank as separator any run of blanks is one, and
/// blanks at either end are none. Fails with bad_file (`where` is the column alone) if a quote is not closed or
/// followed by text, or where there are more than kMostFields.
[[nodiscard]] Result<void> cut(std::string_view line, char separator, std::vector<Field>& fields);

[[nodiscard]] std::string_view trimmed(std::string_view text);

/// The finite number that the whole text is, with a decimal point; a sign may stand before it.
[[nodiscard]] std::optional<double> number_in(std::string_view text);

}  // namespace gyrotherm
