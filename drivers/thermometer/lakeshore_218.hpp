// SPDX-License-Identifier: Apache-2.0
/// Lake Shore 218: eight thermometers on one line. Text ↔ values, both ends of the line (user's manual pp. 6-10 to
/// 6-29), and who asks.
#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

inline constexpr std::size_t kLakeshore218Inputs = 8;

/// "+295.123,+296.124,…" (CR LF already taken off) → eight readings of `CRDG? 0`. The number of decimals varies, the
/// sign is always there. Fails with corrupted if the line is not eight numbers; a reading the instrument cannot have is
/// a fault in its place.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_crdg(std::string_view line);

/// The instrument's side. Readings are rounded to `decimals`.
[[nodiscard]] std::string encode_crdg(std::span<const double> celsius, int decimals);

/// The user's manual (chapter 6) asks for 50 ms between communications. A reply of 73 characters takes 77 ms at 9600
/// baud; the reply to an unknown command never comes. A whole exchange ends within three times `within`.
struct Lakeshore218Timing {
  Duration within = std::chrono::milliseconds(500);  ///< for a whole reply
  Duration pause =
      std::chrono::milliseconds(50);  ///< the line must be silent this long before a query; 0 on the virtual rig
  const Clock* clock = nullptr;       ///< of a line with a time of its own
};

/// `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_lakeshore_218(std::unique_ptr<ByteStream> line, std::string place,
                                                              Lakeshore218Timing timing = {});

}  // namespace gyrotherm::drivers
