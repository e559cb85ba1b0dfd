/// A gyro that sends frames which a FrameFormat describes.
#pragma once

#include <memory>
#include <vector>

#include "core/clock.hpp"
#include "drivers/gyro/frame_stream.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

/// What is sent to a gyro before its frames are read, and when it is left.
struct GyroCommands {
  std::vector<GyroCommand> start{}, stop{};
};

/// `within`: how long one read may wait. `clock`: of a line with a time of its own, which outlives the gyro; without
/// one the steady clock counts.
///
/// The commands of `commands.start` are sent when the gyro is opened (by the first read, if not before), and again
/// before the read that follows a silence or a broken line; each takes its wait, during which the line is read, or less
/// if its reply comes. A reply that does not come is a timeout. The commands of `commands.stop` are sent to an open
/// gyro when it goes.
///
/// Pulses are counts of the frame's field; for a rate or a real number, 1e-6 arcsec each (arcsec_per_count in
/// frame_sum.hpp). Interval: between the frame that ended the last read and the newest one, by the device's clock; by
/// `expected` itself if the format has none. A read that saw less than `expected` returns what it saw with its exact
/// interval; one that saw a single frame, and none before it to count from, fails with corrupted, but where that frame
/// is what take_origin() waits for. Lost frames make the read
/// fail with corrupted: a jump of the sequence; without one, of the device's time at the nominal rate; without both, or
/// where a lock stands in for a sync, bytes that are no frame. Frames that the gyro marks as bad make it fail with
/// out_of_range; the next read counts from the newest frame. After a timeout or a broken line there is no frame to
/// count from.
[[nodiscard]] std::unique_ptr<Gyro> make_framed_gyro(FrameFormat format, std::unique_ptr<ByteStream> line,
                                                     Duration within, GyroCommands commands = {},
                                                     const Clock* clock = nullptr);

}  // namespace gyrotherm
