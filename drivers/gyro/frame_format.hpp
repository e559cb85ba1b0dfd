// SPDX-License-Identifier: Apache-2.0
/// The framed stream of a gyro, as described by a file: the framing of binary frames or lines of text, their check
/// values, and the decoder. frame_fields.hpp contains the fields.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/checksum.hpp"
#include "drivers/gyro/frame_fields.hpp"

namespace gyrotherm::drivers {

/// Kinds of check values. sum16 adds 16-bit words in the byte order of the check. fletcher8 has two sums modulo 256,
/// fletcher16 has two sums modulo 255. Parity is computed over all covered bits, including the parity bit.
enum class CheckKind { none, sum8, sum16, fletcher8, fletcher16, xor8, crc, odd_parity, even_parity };

/// A check value of a frame. Positions are counted from the start of the frame, or from its end if negative. In a line
/// of text, the check consists of the hexadecimal digits after `LineFormat::mark` and covers the text before the mark;
/// `offset` and `to` are not used.
struct FrameCheck {
  CheckKind kind = CheckKind::none;
  std::ptrdiff_t from{};    ///< first byte covered
  std::ptrdiff_t offset{};  ///< position of the stored check
  /// End of the covered bytes; by default the position of the stored check.
  std::ptrdiff_t to{};
  bool big_endian{};
  Crc model{};  ///< crc only
  /// sum8 only: the check is the negated sum, so that it and the covered bytes add up to 0.
  bool is_negated{};
  /// The check is computed as if zero bytes followed the covered bytes up to a multiple of this number.
  std::size_t padded_to = 1;
  /// Position of the parity bit in the byte at `offset`.
  unsigned bit{};
  std::uint32_t mask = 0xFFFFFFFF;  ///< bits that are compared
};

/// Returns the size of the stored check.
[[nodiscard]] std::size_t byte_count(const FrameCheck& check);
/// Reads a [frame.check] table. The check must fit in frames of `shortest` bytes. `in_line` means a line of text.
[[nodiscard]] FrameCheck read_frame_check(const TomlTable& table, std::size_t shortest, bool in_line);

/// Returns the check value of the covered bytes.
[[nodiscard]] std::uint32_t compute_check_value(const FrameCheck& check, std::span<const std::byte> covered);
[[nodiscard]] bool has_valid_check(const FrameCheck& check, std::span<const std::byte> frame);
/// Writes the correct check value into the frame.
void write_check(const FrameCheck& check, std::span<std::byte> frame);

/// Format of a line of text: tokens between separators, a terminator, and an optional check in hexadecimal digits.
struct LineFormat {
  std::string starts_with;  ///< first token; empty: any
  std::string terminator = "\r\n";
  std::string separators = " ";
  /// Treats consecutive separators as one, and ignores separators at both ends.
  bool merges = true;
  /// Number of tokens in the header, which ends with `header_end` instead of a separator; 0 for no header.
  std::size_t header_words{};
  std::string header_end;
  /// Text before the check's digits; empty for no check.
  std::string mark;
  std::size_t words{};        ///< exact number of tokens
  std::size_t longest = 256;  ///< bytes, including the terminator
};

/// An unsigned integer in the frame's head: the message id or the length.
struct HeadNumber {
  std::size_t offset{};
  std::size_t bytes{};  ///< 1 to 4
  bool big_endian{};
};

/// One message of a stream with several messages.
struct FrameVariant {
  std::uint32_t id{};
  /// Total bytes; 0 if the head contains the length.
  std::size_t length{};
  std::optional<FrameCheck> check{};  ///< replaces the stream's check
};

struct FrameFormat {
  std::string name{};
  std::vector<std::byte> sync{};
  /// Total bytes of every frame or of the first message, or the maximum if the head contains the length.
  std::size_t length{};
  std::vector<FrameField> fields{};
  FrameCheck check{};

  /// Axes in use, in the requested order. A gyro whose fields name no axis has one axis with an empty name.
  std::vector<std::string> axes{};
  /// All axes in the description, in its order.
  std::vector<std::string> all_axes{};
  /// Field of the head that identifies the message.
  std::optional<HeadNumber> id{};
  /// The messages of a stream with an id. Messages with other ids are valid only if the head contains the length.
  std::vector<FrameVariant> variants{};
  /// Field of the head that contains the length of the frame minus `length_plus`.
  std::optional<HeadNumber> length_at{};
  std::size_t length_plus{};
  std::vector<std::byte> tail{};  ///< optional bytes after a frame
  /// Number of consecutive valid frames that must follow a frame before it is accepted, while not synchronised.
  std::size_t lock_frames{};
  /// Set for a stream of text lines.
  std::optional<LineFormat> line{};
  double rate_hz{};  ///< nominal; 0 if unknown
  /// The device's time is computed from the sequence and the nominal rate.
  bool clocked_by_sequence{};

  /// Returns the first field with this role, or null. Fields of axes that are not in use have the role `other_axis`.
  [[nodiscard]] const FrameField* find(FieldRole role) const;
  /// Returns one gyro field for each of `axes`, in their order. If several messages contain an axis, returns its first
  /// field. A format that was read without errors has at least one axis. The pointers refer to `fields`.
  [[nodiscard]] std::vector<const FrameField*> gyros() const;
  /// Returns the first gyro field, or null.
  [[nodiscard]] const FrameField* gyro() const;
  /// Returns the housekeeping fields, one per name, in the order of `fields`: all temperatures, and all values with a
  /// unit.
  [[nodiscard]] std::vector<const FrameField*> values() const;
  /// Returns the number of bytes from the start of a frame to the end of its sync, id and length.
  [[nodiscard]] std::size_t head_size() const;
};

/// Name and unit of a housekeeping value.
struct HousekeepingValue {
  /// Letters, digits and '_'; unique within a format.
  std::string name;
  /// "°C" for a temperature, "1" for a dimensionless value, otherwise the unit of the field.
  std::string unit;
  bool is_temperature{};
};

/// Returns the names and units of GyroCount::values, in their order. They correspond to FrameFormat::values(). If there
/// are any, two more follow: "frames" (the number of averaged frames) and "flagged" (the number of frames whose status
/// was not good or broke a rule).
[[nodiscard]] std::vector<HousekeepingValue> list_housekeeping(const FrameFormat& format);

/// Values of one axis in a frame; both are empty if the frame does not contain the axis.
struct AxisReading {
  /// The unscaled field if it is an integer.
  std::optional<std::int64_t> pulses{};
  std::optional<double> value{};  ///< scaled, in the field's unit
};

/// Fields of one frame. A field is empty if the format or this message does not contain it.
struct GyroFrame {
  std::optional<std::uint32_t> id{};
  std::vector<AxisReading> axes{};  ///< in the order of FrameFormat::axes
  std::optional<std::uint32_t> sequence{};
  std::optional<std::uint64_t> timestamp{};  ///< in counts of unit_s
  bool good = true;
  /// A status is not good, or breaks a rule that only warns.
  bool flagged = false;
  /// Housekeeping, in the order and the units of FrameFormat::values().
  std::vector<std::optional<double>> values{};
};

/// Reads a [frame] table. Notes errors in the table; the caller must call verdict(). profiles/gyro-streams/README.md
/// describes the keys. A minimal table is:
///
///     [frame]
///     name = "…"
///     sync = [0xA5, 0x5A]
///     length = 16                 # bytes in all
///     [[frame.field]]
///     role = "timestamp"          # pulse_count or increment (one of them), sequence, timestamp, status
///     type = "u32"                # u8 … u32, i8 … i32
///     offset = 4
///     endian = "little"           # or "big"
///     unit = "us"                 # of one count of a timestamp: s, ms, us, ns
///     [[frame.field]]
///     role = "status"
///     type = "u8"
///     offset = 12
///     mask = 0xFF                 # good when (status & mask) == good
///     good = 0
///     [frame.check]
///     kind = "crc16"              # none, sum8, fletcher8, xor8, crc16, crc32 …
///     from = 0                    # first byte covered; covers up to the check itself
///     offset = 14
///     polynomial = 0x1021
///     initial = 0xFFFF
///     reflected = false
///     final_xor = 0
///
/// `axes` selects the axes in use, in this order, from FrameFormat::all_axes. If it is empty, the file's key `axis`
/// selects one axis; without this key, the first axis is used. `rate_hz` replaces the nominal rate in the table.
[[nodiscard]] FrameFormat read_frame_format(const TomlTable& table, const std::vector<std::string>& axes = {},
                                            std::optional<double> rate_hz = {});

/// Reads a list of at most `most` bytes, as in `sync`. Returns an empty list if there is no such key. Notes errors in
/// the table.
[[nodiscard]] std::vector<std::byte> read_bytes(const TomlTable& table, const char* key, std::size_t most);

/// Keywords of the roles in files.
inline constexpr auto kFieldRoles = make_vocabulary<FieldRole::pulse_count, FieldRole::value>(
    "pulse_count", "increment", "rate", "integrated_angle", "sequence", "timestamp", "status", "temperature", "value");

/// Assigns axes and slots to the fields of `format`, after all fields were read. `wanted` selects the axes as in
/// read_frame_format(). Notes these errors in `table`, or in the field's table in `fields`: an axis that does not exist
/// or is requested twice; two fields of one frame for the same column of the record; fields with the same axis or name
/// but different meanings; an invalid name of a housekeeping value.
void assign_slots(const TomlTable& table, const std::vector<TomlTable>& fields, const std::vector<std::string>& wanted,
                  FrameFormat& format);

/// Decodes frames from bytes that arrive in pieces. After a false sync it resynchronises at the next byte; in text, at
/// the next line. The first line is rejected because it may be incomplete, unless the format has `starts_with` and a
/// check.
class FrameDecoder {
 public:
  explicit FrameDecoder(FrameFormat format);
  void feed(std::span<const std::byte> bytes);
  /// Returns the next valid frame, or null if more bytes are needed. The frame remains valid until the next call.
  [[nodiscard]] const GyroFrame* take();
  /// Returns the number of bytes so far that were not part of a valid frame.
  [[nodiscard]] std::uint64_t rejected_bytes() const { return rejected_; }
  /// Returns the scaled value of every field of the latest frame, in the format's order. It is empty for a field that
  /// the frame does not contain.
  [[nodiscard]] const std::vector<std::optional<double>>& values() const { return values_; }
  /// Returns the meanings of the status rules that the latest frame breaks.
  [[nodiscard]] std::vector<std::string> broken_rules() const;
  /// Returns the meanings of the `mismatch` rules that the latest frame breaks, or nothing if the frame contains no
  /// field with such a rule.
  [[nodiscard]] std::optional<std::vector<std::string>> differing_settings() const;

 private:
  [[nodiscard]] std::span<const std::byte> unread() const { return std::span(buffer_).subspan(begin_); }
  [[nodiscard]] const GyroFrame* take_line();
  [[nodiscard]] const GyroFrame* take_bytes();
  void reject(std::size_t bytes);

  FrameFormat format_;
  std::vector<std::byte> buffer_;
  std::size_t begin_{};  ///< first unread byte in `buffer_`
  std::uint64_t rejected_{};
  /// The format has a rule with the verdict `mismatch`.
  bool has_settings_{};
  /// The bytes before `begin_` were a valid frame or a complete line.
  bool is_locked_{};
  std::optional<std::uint32_t> sequence_{};
  GyroFrame frame_;  ///< the latest
  std::vector<std::optional<double>> values_;
  /// Lower 32 bits of every status of the latest frame, in the format's order; empty for any other field.
  std::vector<std::optional<std::uint32_t>> statuses_;
};

/// Encodes a frame for the virtual gyro and for tests. Selects the message with the most axes; among those, the one
/// with the most housekeeping. Counts wrap at the width of their fields; housekeeping saturates. A value that `frame`
/// does not contain is encoded as zero in its unit, or omitted if the format permits it. Bytes outside all fields are
/// zero.
[[nodiscard]] std::vector<std::byte> encode_frame(const FrameFormat& format, const GyroFrame& frame);
/// Encodes message `id` with the settings that the description requires. If `differs`, each setting breaks its
/// `mismatch` rules instead.
[[nodiscard]] std::vector<std::byte> encode_settings(const FrameFormat& format, std::uint32_t id, bool differs);

}  // namespace gyrotherm::drivers
