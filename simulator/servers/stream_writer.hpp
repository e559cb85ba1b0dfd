/// The frames that a described gyro sends, made from an accumulated angle: what drivers/gyro/frame_sum.hpp adds up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm {

/// A format at one frame a second: what the virtual gyro sends in a dry run, and what its driver then expects.
[[nodiscard]] FrameFormat at_one_frame_a_second(FrameFormat format);

/// Writes one frame after the other. Increments and rates are what brings the sum of all that has been sent, rounded as
/// the frames round it, to the angle: nothing is lost between frames, whatever the field's resolution.
class StreamWriter {
 public:
  /// `arcsec_per_pulse`: what a pulse of the world is, for fields in an angle's unit.
  StreamWriter(FrameFormat format, double arcsec_per_pulse);

  /// What has come before the stream's first frame on a line that has just been opened: an end of line, or as many
  /// frames without motion as must fit before one is believed.
  [[nodiscard]] std::vector<std::byte> lead_in() const;
  /// The next frame, where `pulses` have been counted and the gyro's clock is at `device_time_us`, both since the start
  /// (fractions of a pulse lie within frames), and `seconds` have passed since the last frame.
  [[nodiscard]] std::vector<std::byte> next(double pulses, std::int64_t device_time_us, double seconds);
  /// The same, but the frame goes to nobody: increments count from here.
  void skip(double pulses);

 private:
  [[nodiscard]] std::uint32_t sequence(std::int64_t number) const;
  [[nodiscard]] GyroFrame frame(std::int64_t number, std::int64_t device_time_us) const;
  void put_counts(double pulses, GyroFrame& frame);
  void put_angle(double pulses, double seconds, GyroFrame& frame);

  FrameFormat format_;
  double arcsec_per_pulse_;
  std::int64_t number_{};       ///< of the next frame
  std::int64_t sent_counts_{};  ///< sum of all increments
  double sent_{};               ///< the same of real numbers and rates, in the field's unit of angle
};

}  // namespace gyrotherm
