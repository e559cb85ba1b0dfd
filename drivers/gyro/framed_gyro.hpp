// SPDX-License-Identifier: Apache-2.0
/// Description of a gyro, a TOML file under profiles/gyro-streams, and the driver for gyros with such a description.
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
  std::string source;  ///< origin of the facts
  /// "verified" (with published frames), "manual", or "secondary" (another driver).
  std::string confidence;
  SerialFormat port;
  /// Commands that make the gyro send, in order.
  std::vector<GyroCommand> start;
  std::vector<GyroCommand> stop;
  std::optional<IdentityQuery> identity{};
  FrameFormat frame;
  /// Settings that the frames depend on.
  std::vector<StreamSetting> settings{};
  /// Maximum bias of a good unit, °/h; empty if the file does not specify it.
  std::optional<double> largest_bias_deg_per_h{};
  std::string text;  ///< text of the file
};

/// Parses a description. Fails with bad_file and lists every error with its position. `axes` and `rate_hz` are as in
/// read_frame_format().
[[nodiscard]] Result<GyroStream> parse_gyro_stream(std::string_view text, const std::string& file,
                                                   const std::vector<std::string>& axes = {},
                                                   std::optional<double> rate_hz = {});

/// Returns a stream that reads `line` continuously in a thread of its own, which starts at the first use. Without it,
/// the bytes that a gyro sends between two reads would overflow the buffers of the operating system: at a thousand
/// frames per second, the buffer of a serial port is full after a tenth of a second.
///
/// Only one thread may use the stream at a time. If more than 1 MiB is unread, all of it is discarded and the next read
/// fails with corrupted. A fault of the line is reported after all earlier bytes were read; the line is not read again
/// before. arrival_time() returns the time at which the bytes arrived, not the time of the read.
[[nodiscard]] std::unique_ptr<ByteStream> make_buffered_stream(std::unique_ptr<ByteStream> line);

/// Commands that are sent to a gyro before its frames are read, and at the end.
struct GyroCommands {
  std::vector<GyroCommand> start{}, stop{};
  std::optional<IdentityQuery> identity{};
};

/// Returns the driver for a gyro whose frames are described by `format`. `within` limits one read. `clock` is the
/// host's clock; null means the steady clock. It must outlive the gyro, and the line must use the same clock.
///
/// Start commands: `commands.start` is sent when the gyro is opened, by the first read at the latest, and again before
/// the read that follows a silence or a broken line. One silent read after them is not yet a silence, because the next
/// frame of a slow gyro may arrive later. The driver waits for the answer to each command (send_command()).
/// If an answer is missing or refuses the command, the read fails: the frames of a gyro that did not confirm its
/// settings are not counted. If a message shows settings that differ from the description, every read fails with
/// mismatch until a later message agrees. The destructor sends `commands.stop` to an open gyro.
///
/// Count: the pulses are in the order of FrameFormat::axes, in counts of the axis's field; for a rate or a real number,
/// one count is 1e-6 arcsec (arcsec_per_count() in frame_sum.hpp). If several messages are needed for all axes, only
/// whole rounds of them are counted.
///
/// Interval: it extends from the last frame of the previous read to the newest frame, measured by the device's clock.
/// If there is no such clock, it is computed from the arrival times, which are smoothed if there is a nominal rate
/// (HostInterval). A read that covers less than `expected` returns its pulses with their exact interval.
///
/// Housekeeping: the values, in the order of list_housekeeping(), are averaged over the frames of this read; in the
/// first read, over the frames after the origin.
///
/// Identity: identify() sends `commands.identity` if there is one. Frames that arrive meanwhile are not counted. If the
/// gyro has never answered, its identity is empty; if it answered before and does not answer now, identify() fails with
/// timeout. If the frame counter restarted or the device's time jumped, the gyro may have been restarted or exchanged:
/// breaks() increases, and the start commands are sent again.
///
/// Faults of read():
///
/// - corrupted, if bytes arrived but no frame. The fault contains the number of bytes and the first of them, and the
///   next read sends the start commands again.
/// - corrupted, if there is only one frame and none before it, except in wait_for_origin(). Without a device clock,
/// also
///   if there are several frames and none before them, because the arrival time of the first one is unknown.
/// - corrupted, if frames were lost. A loss is detected by a jump of the sequence; without a sequence, by a jump of the
///   device's time, from the nominal rate; without both, or if `lock_frames` replaces a sync, by bytes that are not a
///   frame. Without a device clock, frames that do not fit the host's time are also a loss, and the count starts again.
/// - corrupted, without lost frames, if a frame arrived twice, the sequence went backwards, or the device's time jumped
///   by more than a second ahead of the host's.
/// - out_of_range, if the gyro marked frames as bad. The next read counts from the newest frame. If that frame is bad
///   and contains a count or an angle, the next read has no frame to count from.
/// - mismatch, if the sequence is the clock and the frame rate differs from the nominal one (FramePace), if the steps
/// of
///   the sequence or of the device's time are constant but differ from the described ones (StepWatch), or if the
///   device's time passes at least twice as fast as the host's, or at most half as fast.
/// - timeout and disconnected, as the line reports them. The next read has no frame to count from.
[[nodiscard]] std::unique_ptr<Gyro> make_framed_gyro(FrameFormat format, std::unique_ptr<ByteStream> line,
                                                     Duration within, GyroCommands commands = {},
                                                     const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
