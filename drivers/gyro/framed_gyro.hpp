/// A gyro that sends frames which a FrameFormat describes.
#pragma once

#include <memory>

#include "drivers/gyro/frame_format.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

/// `within`: how long one read may wait.
///
/// Pulses are counts of the frame's field; for a rate or a real number, 1e-6 arcsec each (arcsec_per_count in
/// frame_sum.hpp). Interval: between the frame that ended the last read and the newest one, by the device's clock; by
/// `expected` itself if the format has none. A read that saw less than `expected` returns what it saw with its exact
/// interval; the first read may see a single frame, and then returns no pulses over no time. Lost frames make the read
/// fail with corrupted: a jump of the sequence; without one, of the device's time at the nominal rate; without both, or
/// where a lock stands in for a sync, bytes that are no frame. Frames that the gyro marks as bad make it fail with
/// out_of_range; the next read counts from the newest frame. After a timeout or a broken line the next read is a first
/// read again.
[[nodiscard]] std::unique_ptr<Gyro> make_framed_gyro(FrameFormat format, std::unique_ptr<ByteStream> line,
                                                     Duration within);

}  // namespace gyrotherm
