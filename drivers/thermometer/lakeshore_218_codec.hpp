// SPDX-License-Identifier: Apache-2.0
/// Lake Shore 218 temperature monitor: text ↔ values, both ends of the line (user's manual pp. 6-10 to 6-29).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::drivers {

inline constexpr std::size_t kLakeshore218Inputs = 8;

/// "+295.123,+296.124,…" (CR LF already taken off) → eight readings of `CRDG? 0`. The number of decimals varies, the
/// sign is always there. Fails with corrupted if the line is not eight numbers; a reading the instrument cannot have is
/// a fault in its place.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_crdg(std::string_view line);

/// The instrument's side. Readings are rounded to `decimals`.
[[nodiscard]] std::string encode_crdg(std::span<const double> celsius, int decimals);

}  // namespace gyrotherm::drivers
