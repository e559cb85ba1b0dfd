// SPDX-License-Identifier: Apache-2.0
/// Lake Shore 218, eight thermometers on one line: the encoding for host and instrument (user's manual pp. 6-10 to
/// 6-29), and the driver.
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

/// Decodes "+295.123,+296.124,…", the answer to `CRDG? 0` without its CR LF, to eight readings. Every number has a sign
/// and any number of decimals. Fails with corrupted if the line is not eight numbers. An impossible reading becomes a
/// fault of its input.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_crdg(std::string_view line);

/// Instrument: encodes readings, rounded to `decimals`.
[[nodiscard]] std::string encode_crdg(std::span<const double> celsius, int decimals);

/// Timing of the exchange. The user's manual (chapter 6) requires 50 ms between communications. A reply of 73
/// characters takes 77 ms at 9600 baud; an unknown command is not answered. A whole exchange ends within three times
/// `within`.
struct Lakeshore218Timing {
  /// Time limit for a complete reply.
  Duration within = std::chrono::milliseconds(500);
  /// Required silence before a query; 0 for the virtual instrument.
  Duration pause = std::chrono::milliseconds(50);
  /// Clock of the line; null means the steady clock.
  const Clock* clock = nullptr;
};

/// Returns the driver. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_lakeshore_218(std::unique_ptr<ByteStream> line, std::string place,
                                                              Lakeshore218Timing timing = {});

}  // namespace gyrotherm::drivers
