/// A byte stream over a serial port.
#pragma once

#include <memory>
#include <string>

#include "drivers/line/line_address.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

/// Opens `device` at first use, for this program alone, and again after it was unplugged; a link is followed anew each
/// time. The settings are read back: a port that cannot do `format` is disconnected and says what it does instead.
/// What came before the opening is thrown away. After a second failure in a row the line rests 0.5 s, then longer, up
/// to 10 s; until then every use fails at once. A pseudo-terminal has no settings to make.
[[nodiscard]] std::unique_ptr<ByteStream> make_serial_stream(std::string device, const SerialFormat& format);

}  // namespace gyrotherm
