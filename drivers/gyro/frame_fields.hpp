// SPDX-License-Identifier: Apache-2.0
/// One field of a gyro's frame: the position of its bits and their meaning.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::drivers {

inline constexpr std::int64_t kLongestFrame = 4096;  ///< bytes

/// Encoding of a field. The last four are tokens in a line of text.
enum class FieldType {
  u8,
  u16,
  u24,
  u32,
  u64,
  i8,
  i16,
  i24,
  i32,
  i64,
  f32,
  f64,
  hexadecimal,
  signed_hexadecimal,
  integer,
  decimal
};
enum class FieldRole {
  /// Accumulated up–down counter, which wraps at its width.
  pulse_count,
  /// Pulses or angle since the previous frame.
  increment,
  /// Mean rate since the previous frame.
  rate,
  /// Accumulated angle, which wraps at `wraps_at`.
  integrated_angle,
  /// Frame counter.
  sequence,
  /// Device time.
  timestamp,
  /// Status bits. The frame is good if they equal `good` under `mask` and satisfy the field's rules.
  status,
  /// Temperature, in °C after scaling.
  temperature,
  /// Any other value, such as an acceleration; recorded as housekeeping if it has a unit.
  value,
  /// Field of an axis that is not in use; not a keyword in files.
  other_axis,
};

/// An exact factor: numerator / denominator · 2^power_of_two.
struct ExactScale {
  std::int64_t numerator = 1;
  std::int64_t denominator = 1;
  int power_of_two = 0;
  [[nodiscard]] double of(double raw) const;
};

/// Consequence of a status that breaks a rule.
enum class StatusMeaning {
  /// The gyro's value is unusable, and the frame is flagged.
  invalid,
  /// The frame is flagged.
  warning,
  /// The bytes are not a frame and are rejected.
  reject,
  /// A setting of the gyro differs from the description.
  mismatch,
};
struct StatusRule {
  std::uint32_t mask{};
  std::uint32_t good{};
  StatusMeaning verdict{};
  std::string meaning{};
  /// Further good values under the mask.
  std::vector<std::uint32_t> also_good{};
};

struct FrameField {
  std::string name{};
  FieldRole role{};
  FieldType type{};
  /// Bytes from the start of the frame, or from its end if negative. In a line of text, the index of the token.
  std::ptrdiff_t offset{};
  std::size_t bytes{};  ///< bytes on the wire
  /// 8, or 7 if the top bit of each byte is not part of the value.
  unsigned bits_per_byte = 8;
  /// Position and width of the slice of the integer that is the field; bit 0 is the least significant.
  unsigned low_bit{};
  unsigned bits{};
  bool big_endian{};
  /// Axis of a gyro field.
  std::string axis{};
  /// Messages that contain this field; all if empty.
  std::vector<std::uint32_t> ids{};
  /// The field is present if sequence modulo `every` is `turn`.
  std::uint32_t every = 1;
  std::uint32_t turn = 0;
  /// The field is present if the integer that contains it equals `when_value` under `when_mask`.
  std::uint64_t when_mask{};
  std::uint64_t when_value{};
  /// Index into FrameFormat::axes or FrameFormat::values().
  std::size_t slot{};

  /// The scaled value, in `unit`, is raw · scale + zero.
  ExactScale scale{};
  double zero{};
  std::string unit{};  ///< empty: pulses or counts
  /// Angle at which an integrated angle wraps around, in `unit`.
  double wraps_at{};
  /// Seconds per count of a timestamp; 1e-9 for a floating-point timestamp, which is converted to nanoseconds.
  double unit_s = 1e-6;
  /// Number of values of a sequence, timestamp or pulse count before it wraps; 0 means 2^64.
  std::uint64_t range{};
  /// Increase of a sequence from one frame to the next.
  std::uint64_t step = 1;
  /// A good status equals `good` under `mask`.
  std::uint32_t mask = 0;
  std::uint32_t good = 0;
  std::vector<StatusRule> rules{};
};

/// Unscaled value of a field: an integer, sign-extended to 64 bits if its type is signed, or a real number.
struct RawValue {
  std::int64_t whole{};
  double real{};
  bool is_real{};
  [[nodiscard]] double number(bool is_signed) const;
};

/// Returns the bytes of a type; 0 for a token.
[[nodiscard]] std::size_t byte_count(FieldType type);
[[nodiscard]] bool is_signed(FieldType type);
[[nodiscard]] bool is_real(FieldType type);
[[nodiscard]] bool is_word(FieldType type);
/// Returns true for pulse_count, increment, rate and integrated_angle.
[[nodiscard]] bool is_gyro(FieldRole role);
/// Returns whether a field is housekeeping that is recorded: a temperature, or a value with a unit.
[[nodiscard]] bool is_housekeeping(const FrameField& field);

/// Returns whether the status has a good value under the rule's mask.
[[nodiscard]] bool is_satisfied(const StatusRule& rule, std::uint32_t status);

/// Returns whether the field counts pulses exactly: an integer pulse count or increment with `zero` = 0.
[[nodiscard]] bool is_counted(const FrameField& field);

/// Returns whether message `id` contains the field. A field without ids belongs to every message.
[[nodiscard]] bool is_in_message(const FrameField& field, std::optional<std::uint32_t> id);
/// Returns the position of the field in a frame of `length` bytes, or nothing if it does not fit.
[[nodiscard]] std::optional<std::size_t> find_field_position(const FrameField& field, std::size_t length);
/// Reads an unsigned number from up to 8 bytes, using the lower `bits_per_byte` bits of each.
[[nodiscard]] std::uint64_t load_bits(std::span<const std::byte> bytes, bool big_endian, unsigned bits_per_byte = 8);
/// Writes a number as load_bits() reads it. Only the lower `bits_per_byte` bits of each byte are changed.
void store_bits(std::span<std::byte> bytes, bool big_endian, std::uint64_t value, unsigned bits_per_byte = 8);

/// Reads a field. Returns nothing if the frame is too short or the `when` condition does not hold.
[[nodiscard]] std::optional<RawValue> read_raw(const FrameField& field, std::span<const std::byte> frame);
/// Writes only the bits of the slice and of `when_mask`. Integers wrap at the width of the slice.
void write_raw(const FrameField& field, std::span<std::byte> frame, const RawValue& raw);
/// Parses a token. Returns nothing unless the whole token is a number of the field's type that fits in 64 bits.
[[nodiscard]] std::optional<RawValue> parse_token(const FrameField& field, std::string_view word);
[[nodiscard]] std::string print_token(const FrameField& field, const RawValue& raw);
/// Returns the sequence of a frame without a sign, whatever the type of its field.
[[nodiscard]] std::uint32_t sequence_number(const FrameField& field, const RawValue& raw);
/// Returns the integer `whole` with the slice and the bits of `when_mask` replaced, as in write_raw().
[[nodiscard]] std::uint64_t replace_slice(const FrameField& field, std::uint64_t whole, const RawValue& raw);

/// Returns raw · scale + zero.
[[nodiscard]] double apply_scale(const FrameField& field, const RawValue& raw);
/// Returns the raw value nearest to `value`, which must be finite. It may exceed the width of a slice.
[[nodiscard]] RawValue invert_scale(const FrameField& field, double value);
/// Returns the arc seconds per unit of an angle ("rad", "deg", "arcsec"), or the arc seconds per second per unit of a
/// rate ("rad/s", "deg/s", "deg/h"; 1 °/h is exactly 1 arcsec/s). Returns nothing for other units.
[[nodiscard]] std::optional<double> arcsec_per(std::string_view unit, FieldRole role);

}  // namespace gyrotherm::drivers
