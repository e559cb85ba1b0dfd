// SPDX-License-Identifier: Apache-2.0
/// One field of a gyro's frame: where its bits lie, and what they mean.
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

/// The last four are words of a line of text.
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
  pulse_count,       ///< accumulated up–down counter, wraps at its width
  increment,         ///< pulses, or angle, since the last frame
  rate,              ///< mean rate since the last frame
  integrated_angle,  ///< accumulated angle, wraps at `wraps_at`
  sequence,          ///< frame counter
  timestamp,         ///< device time
  status,            ///< must equal `good` under `mask`, and obey the field's rules
  temperature,       ///< °C after scaling
  value,             ///< of no part in the bias; housekeeping if it has a unit: an acceleration, a current
  other_axis,        ///< of the gyro, but not asked for; no word of a file
};

/// An exact factor: numerator / denominator * 2^power_of_two.
struct ExactScale {
  std::int64_t numerator = 1;
  std::int64_t denominator = 1;
  int power_of_two = 0;
  [[nodiscard]] double of(double raw) const;
};

/// What a status means that differs from `good` under `mask`.
enum class StatusMeaning {
  invalid,   ///< gyro value is unusable
  warning,   ///< frame is flagged
  reject,    ///< bytes are another frame
  mismatch,  ///< unit has another setting
};
struct StatusRule {
  std::uint32_t mask{};
  std::uint32_t good{};
  StatusMeaning verdict{};
  std::string meaning{};
  std::vector<std::uint32_t> also_good{};  ///< what else is, under the mask
};

struct FrameField {
  std::string name{};  ///< by default the role's
  FieldRole role{};
  FieldType type{};
  std::ptrdiff_t offset{};     ///< bytes from the frame's start, or (negative) from its end; number of a line's word
  std::size_t bytes{};         ///< on the wire
  unsigned bits_per_byte = 8;  ///< 7: the top bit of each byte is not part of the value
  unsigned low_bit{};          ///< of the slice, 0 the least significant of the whole
  unsigned bits{};             ///< of the slice
  bool big_endian{};
  std::string axis{};                ///< of a gyro's field
  std::vector<std::uint32_t> ids{};  ///< the messages that have this field; empty: all
  std::uint32_t every = 1;           ///< present when sequence modulo `every` is `turn`
  std::uint32_t turn = 0;
  std::uint64_t when_mask{};  ///< present when the integer, of which the field is a slice, has `when_value` under this
  std::uint64_t when_value{};
  std::size_t slot{};  ///< of a gyro's field its axis, of housekeeping its value, as FrameFormat counts them

  ExactScale scale{};  ///< value = raw * scale + zero, in `unit`
  double zero{};
  std::string unit{};      ///< empty: pulses, or counts
  double wraps_at{};       ///< integrated_angle, in `unit`
  double unit_s = 1e-6;    ///< timestamp: seconds per count; a timestamp of floating point is counted in nanoseconds
  std::uint64_t range{};   ///< sequence, timestamp, pulse_count: values before it wraps; 0 stands for 2^64
  std::uint64_t step = 1;  ///< sequence: from one frame to the next
  std::uint32_t mask = 0;  ///< status
  std::uint32_t good = 0;  ///< status
  std::vector<StatusRule> rules{};
};

/// Bits as they stand in the frame: an integer, sign-extended to 64 bits, or a real number.
struct RawValue {
  std::int64_t whole{};
  double real{};
  bool is_real{};
  [[nodiscard]] double number(bool is_signed) const;
};

[[nodiscard]] std::size_t byte_count(FieldType type);  ///< 0 for a word of a line
[[nodiscard]] bool is_signed(FieldType type);
[[nodiscard]] bool is_real(FieldType type);
[[nodiscard]] bool is_word(FieldType type);
[[nodiscard]] bool is_gyro(FieldRole role);  ///< pulse_count, increment, rate, integrated_angle
/// What a gyro tells of itself and the record keeps: a temperature, or a value with a unit.
[[nodiscard]] bool is_housekeeping(const FrameField& field);

/// What the status holds under the rule's mask is good.
[[nodiscard]] bool keeps(const StatusRule& rule, std::uint32_t status);

/// Counts are exact: an integer that wraps where its bits end.
[[nodiscard]] bool is_counted(const FrameField& field);

/// The messages named by the field hold `id`; a field that names none is in all.
[[nodiscard]] bool is_in_message(const FrameField& field, std::optional<std::uint32_t> id);
/// Where in a frame of `length` bytes the field begins; nothing if it does not fit.
[[nodiscard]] std::optional<std::size_t> place_of(const FrameField& field, std::size_t length);
/// An unsigned number of up to 8 bytes, the lower `bits_per_byte` bits of each.
[[nodiscard]] std::uint64_t load_bits(std::span<const std::byte> bytes, bool big_endian, unsigned bits_per_byte = 8);
/// The inverse; of each byte only the lower `bits_per_byte` bits are written.
void store_bits(std::span<std::byte> bytes, bool big_endian, std::uint64_t value, unsigned bits_per_byte = 8);

/// Nothing if the frame is too short for the field, or does not have under `when_mask` what it must.
[[nodiscard]] std::optional<RawValue> read_raw(const FrameField& field, std::span<const std::byte> frame);
/// Writes the slice, and what `when_mask` covers, no bit beside them; integers wrap at the slice's width.
void write_raw(const FrameField& field, std::span<std::byte> frame, const RawValue& raw);
/// A whole word must be a number of the field's type, and fit in 64 bits.
[[nodiscard]] std::optional<RawValue> parse_word(const FrameField& field, std::string_view word);
[[nodiscard]] std::string print_word(const FrameField& field, const RawValue& raw);
/// `whole`, an integer of which the field is a slice, with the slice written as write_raw does.
[[nodiscard]] std::uint64_t with_slice(const FrameField& field, std::uint64_t whole, const RawValue& raw);

/// raw * scale + zero.
[[nodiscard]] double scaled(const FrameField& field, const RawValue& raw);
/// The raw value nearest to `value`, which must be finite; a slice may be narrower than it.
[[nodiscard]] RawValue unscaled(const FrameField& field, double value);
/// Arc seconds per unit of an angle ("rad", "deg", "arcsec"), or per second and unit of a rate ("rad/s", "deg/s",
/// "deg/h": 1 °/h is 1 arcsec/s exactly); nothing for another unit.
[[nodiscard]] std::optional<double> arcsec_per(std::string_view unit, FieldRole role);

}  // namespace gyrotherm::drivers
