// SPDX-License-Identifier: Apache-2.0
/// Stream of lines "S,RATE,WORD". A test adds the fields of the last word.
#pragma once

#include <stdexcept>
#include <string>

#include "drivers/gyro/framed_gyro.hpp"

namespace gyrotherm::drivers {

/// Returns the format of the lines with these tables [[frame.field]].
inline FrameFormat decimal_lines(const std::string& fields) {
  const auto stream = parse_gyro_stream(R"(schema = "gyrotherm-gyro-stream/1"
name = "lines"
vendor = "v"
source = "s"
confidence = "secondary"
[port]
baud = 38400
[frame]
name = "lines"
rate_hz = 100
[frame.line]
starts_with = "S"
terminator = "\n"
separators = ","
merges = false
words = 3
longest = 60
[[frame.field]]
role = "rate"
type = "decimal"
word = 1
unit = "deg/s"
)" + fields,
                                        "lines.toml");
  if (!stream) throw std::runtime_error(text(stream.error()));
  return stream->frame;
}

}  // namespace gyrotherm::drivers
