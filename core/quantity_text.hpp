/// Quantities as people write them: "2 h", "-40 °C".
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// "2 h", "90 s", "1 h 30 min", "250 ms" → a duration; fails with bad_file naming the text.
[[nodiscard]] Result<Duration> parse_duration(std::string_view text);

/// The number before one of `units`; nothing if the text is anything else.
[[nodiscard]] std::optional<double> quantity_in(std::string_view text, std::span<const std::string_view> units);

}  // namespace gyrotherm
