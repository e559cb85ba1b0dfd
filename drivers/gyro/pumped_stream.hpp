/// A line that is read all the time by a thread of its own, so that nothing that a gyro sends between two readings
/// overflows the system's buffers (a serial port's holds a tenth of a second of a thousand frames).
#pragma once

#include <memory>

#include "drivers/wires.hpp"

namespace gyrotherm {

/// Reads and writes as `line` does, from the first use on, for one caller at a time. What is not read for so long that
/// 1 MiB waits is dropped, and the next read fails with corrupted. A fault of the line is told by the first read that
/// finds nothing before it; the line is tried again after that.
[[nodiscard]] std::unique_ptr<ByteStream> make_pumped(std::unique_ptr<ByteStream> line);

}  // namespace gyrotherm
