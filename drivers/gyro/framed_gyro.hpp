// SPDX-License-Identifier: Apache-2.0
/// A gyro's whole description: a TOML file under profiles/gyro-streams, with the port's settings, what to send before
/// and after, and the frames.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/gyro/frame_format.hpp"
#include "drivers/gyro/start_command.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

struct GyroStream {
  std::string name;
  std::string vendor;
  std::string source;      ///< where its facts come from
  std::string confidence;  ///< "verified" (against published frames), "manual", "secondary" (someone's driver)
  SerialFormat port;
  std::vector<GyroCommand> start;  ///< makes it send; in order
  std::vector<GyroCommand> stop;
  std::optional<GyroQuestion> identity{};
  FrameFormat frame;
  std::vector<StreamSetting> settings{};  ///< on which the frames depend
  /// Bias that a good unit may have, °/h; nothing if the file does not state it.
  std::optional<double> largest_bias_deg_per_h{};
  std::string text;  ///< the file, as read
};

/// Fails with bad_file, every mistake with its place. `axes`, `rate_hz`: as read_frame_format has them.
[[nodiscard]] Result<GyroStream> parse_gyro_stream(std::string_view text, const std::string& file,
                                                   const std::vector<std::string>& axes = {},
                                                   std::optional<double> rate_hz = {});

// A line that is read all the time by a thread of its own, so that nothing that a gyro sends between two readings
// overflows the system's buffers (a serial port's holds a tenth of a second of a thousand frames).

/// Reads and writes as `line` does, from the first use on, for one caller at a time. What is not read for so long that
/// 1 MiB waits is dropped, and the next read fails with corrupted. A fault of the line is told by the first read that
/// finds nothing before it; the line is tried again after that. It knows when bytes came, however late they are read.
[[nodiscard]] std::unique_ptr<ByteStream> make_pumped(std::unique_ptr<ByteStream> line);

// A gyro that sends frames which a FrameFormat describes.

/// What is sent to a gyro before its frames are read, and when it is left.
struct GyroCommands {
  std::vector<GyroCommand> start{}, stop{};
  std::optional<GyroQuestion> identity{};
};

/// `within`: how long one read may wait. `clock`: of a line with a time of its own, which outlives the gyro; without
/// one the steady clock counts. That clock is the host's.
///
/// The commands of `commands.start` are sent when the gyro is opened (by the first read, if not before), and again
/// before the read that follows a silence or a broken line; each takes its wait, during which the line is read, or less
/// if its answer comes (send_command). An answer that does not come, or refuses, fails the read: nothing is counted of
/// a gyro that did not confirm its settings. A message that shows other settings than the description makes every read
/// fail with mismatch until one agrees. The commands of `commands.stop` are sent to an open
/// gyro when it goes.
///
/// Pulses, in the order of FrameFormat::axes, are counts of the axis's field; for a rate or a real number, 1e-6 arcsec
/// each (arcsec_per_count in frame_sum.hpp). Where it takes several messages to bring every axis, they count in whole
/// rounds of them. Interval: between the frame that ended the last read and the newest one, by the device's clock; if
/// the format has none, by the instants at which they came, smoothed where it has a nominal rate (HostInterval).
/// Values, in the order of housekeeping_of(), are of the frames of this read, of a first read of those behind its
/// origin.
///
/// identify() asks `commands.identity`, if there is one; what came meanwhile is not counted. A gyro that never answered
/// has no identity; one that did, and is silent now, is a timeout. If the count of frames began anew or the time
/// jumped, the gyro may have restarted or been exchanged: breaks() counts that, and the start commands are sent again.
///
/// If bytes came and no frame, the read fails with corrupted, reports how many bytes came and the first of them, and
/// the next read sends the start commands again.
///
/// A read that saw less than `expected` returns what it
/// saw with its exact interval; one that saw a single frame, and none before it to count from, fails with corrupted,
/// but where that frame is what take_origin() waits for. So does, without a clock of the device's, one that saw several
/// and none before them: when the first of them came is not known. Lost frames make the read fail with corrupted: a
/// jump of the sequence; without one, of the device's time at the nominal rate; without both, or where a lock stands in
/// for a sync, bytes that are no frame; without a clock of the device's, frames that do not fit the host's time, upon
/// which the count begins anew. A frame that comes twice, a sequence that goes back and a time of the device's that
/// jumps (by more than a second beyond the host's) make it fail with corrupted too, and are no lost frames. Frames that
/// the gyro marks as bad make it fail with out_of_range; the next read counts from the newest frame. After a timeout or
/// a broken line there is no frame to count from. Each read fails with mismatch if the sequence is the clock and frames
/// come at another rate than the nominal one (FramePace), if the steps of the sequence or of the device's time are
/// steady and not the described ones (StepWatch), or if the device's time passes twice as fast as the host's, or half
/// as fast.
[[nodiscard]] std::unique_ptr<Gyro> make_framed_gyro(FrameFormat format, std::unique_ptr<ByteStream> line,
                                                     Duration within, GyroCommands commands = {},
                                                     const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
