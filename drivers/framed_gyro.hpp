/// A gyro that sends frames which a FrameFormat describes.
#pragma once

#include <memory>

#include "drivers/frame_format.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

/// `within`: how long one read may wait.
///
/// Interval: between the frame that ended the last read and the newest one, by the device's timestamps; by `expected`
/// itself if the format has none. A read that saw less than `expected` returns what it saw with its exact interval; the
/// first read may see a single frame, and then returns no pulses over no time. Lost frames (a jump of the sequence;
/// without one, bytes that are no frame) make the read fail with corrupted, frames that the gyro marks as bad with
/// out_of_range; the next read counts from the newest frame. After a timeout or a broken line the next read is a first
/// read again.
[[nodiscard]] std::unique_ptr<Gyro> make_framed_gyro(FrameFormat format, std::unique_ptr<ByteStream> line,
                                                     Duration within);

}  // namespace gyrotherm
