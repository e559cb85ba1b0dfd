// SPDX-License-Identifier: Apache-2.0
/// A gyro's framed stream, described in a file instead of in code: how frames or lines of text are found in it, how
/// they are checked, and from bytes to whole good frames. What is in them: frame_fields.hpp.
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

/// sum16: of 16-bit words in the byte order of the check. Parity: of all bits covered, the bit itself among them.
enum class CheckKind { none, sum8, sum16, xor8, crc, odd_parity, even_parity };

/// Positions count from the frame's start, or (negative) from its end. In a line of text the check is hexadecimal
/// digits after `LineFormat::mark`, covers what lies before the mark, and has no position of its own.
struct FrameCheck {
  CheckKind kind = CheckKind::none;
  std::ptrdiff_t from{};    ///< first byte covered
  std::ptrdiff_t offset{};  ///< of the stored check
  std::ptrdiff_t to{};      ///< end of what is covered; by default where the check is stored
  bool big_endian{};
  Crc model{};                ///< crc
  std::size_t padded_to = 1;  ///< what is covered is filled up with zeros to a multiple of this, for the sum alone
  unsigned bit{};             ///< parity: which bit of the byte at `offset`
  std::uint32_t mask = 0xFFFFFFFF;  ///< bits of the check that are compared
};

[[nodiscard]] std::size_t byte_count(const FrameCheck& check);  ///< of the stored check
/// A [frame.check] table; `shortest`: of the frames that it must fit in, bytes. In a line nothing has a position.
[[nodiscard]] FrameCheck read_frame_check(const TomlTable& table, std::size_t shortest, bool in_line);

/// The check of these bytes, all of them covered.
[[nodiscard]] std::uint32_t check_value(const FrameCheck& check, std::span<const std::byte> covered);
[[nodiscard]] bool passes(const FrameCheck& check, std::span<const std::byte> frame);
/// Writes the check that makes the frame pass.
void seal(const FrameCheck& check, std::span<std::byte> frame);

/// A line of text: words between separators, ended by a terminator, perhaps with a check in hexadecimal digits.
struct LineFormat {
  std::string starts_with;  ///< the first word; empty: any line
  std::string terminator = "\r\n";
  std::string separators = " ";
  bool merges = true;          ///< several separators in a row are one, and those at the ends are none
  std::size_t header_words{};  ///< the first words, behind which `header_end` stands instead of a separator; 0: none
  std::string header_end;
  std::string mark;           ///< the check's digits follow it; empty: no check
  std::size_t words{};        ///< exactly so many
  std::size_t longest = 256;  ///< bytes, terminator included
};

/// An unsigned number in the frame's head: its message id, or its length.
struct HeadNumber {
  std::size_t offset{};
  std::size_t bytes{};  ///< 1 to 4
  bool big_endian{};
};

/// One message of a stream that has several.
struct FrameVariant {
  std::uint32_t id{};
  std::size_t length{};               ///< bytes in all; 0: the head tells
  std::optional<FrameCheck> check{};  ///< where it differs from the stream's
};

struct FrameFormat {
  std::string name{};
  std::vector<std::byte> sync{};  ///< may be empty
  std::size_t length{};           ///< bytes in all: of every frame, or of the first message, or the longest by the head
  std::vector<FrameField> fields{};
  FrameCheck check{};

  std::vector<std::string> axes{};      ///< of the gyro, in the order asked for; one empty name if the gyro has none
  std::vector<std::string> all_axes{};  ///< that the description names, in its order
  std::optional<HeadNumber> id{};       ///< which message a frame is
  std::vector<FrameVariant>
      variants{};  ///< with an id: all that there are (any other too, if the head tells the length)
  std::optional<HeadNumber> length_at{};  ///< the head tells the length,
  std::size_t length_plus{};              ///< … less this
  std::vector<std::byte> tail{};          ///< may follow a frame
  std::size_t lock_frames{};              ///< frames that must fit in a row before the first is believed
  std::optional<LineFormat> line{};       ///< lines of text instead of bytes
  double rate_hz{};                       ///< nominal; 0: not said
  bool clocked_by_sequence{};             ///< time is frames counted, at the nominal rate

  /// The first field with this role; a gyro's field of an axis that was not asked for has the role `other_axis`.
  [[nodiscard]] const FrameField* find(FieldRole role) const;
  /// The fields that biases are made of, one for each of `axes`, in their order; of an axis that comes in several
  /// messages the first field. At least one in a format that was read without mistakes. They point into `fields`.
  [[nodiscard]] std::vector<const FrameField*> gyros() const;
  /// The first of them; null if there is none.
  [[nodiscard]] const FrameField* gyro() const;
  /// The housekeeping: every temperature and every value that has a unit, in the order of `fields`, one for each name.
  [[nodiscard]] std::vector<const FrameField*> values() const;
  /// Bytes that must be seen before a frame's length is known.
  [[nodiscard]] std::size_t head_size() const;
};

/// What a gyro tells of itself in each reading, beside its axes.
struct HousekeepingValue {
  std::string name;  ///< letters, digits and '_'; no two of one format are the same
  std::string unit;  ///< of a temperature "°C", of a number "1"
  bool is_temperature{};
};

/// The names and units of GyroCount::values, in their order: those of FrameFormat::values(), and where there are any,
/// "frames", the number of frames that were averaged, and "flagged", the number of frames whose status broke a rule or
/// was not good.
[[nodiscard]] std::vector<HousekeepingValue> housekeeping_of(const FrameFormat& format);

/// What a frame says of one axis; nothing if the frame lacks it.
struct AxisReading {
  std::optional<std::int64_t> pulses{};  ///< the axis's field unscaled, if it is an integer
  std::optional<double> value{};         ///< the axis's field scaled, in its unit
};

/// One frame's fields. A role that the format, or this message, lacks is absent.
struct GyroFrame {
  std::optional<std::uint32_t> id{};  ///< message id
  std::vector<AxisReading> axes{};    ///< in the order of FrameFormat::axes
  std::optional<std::uint32_t> sequence{};
  std::optional<std::uint64_t> timestamp{};  ///< counts of the field's unit_s
  bool good = true;
  bool flagged = false;                         ///< a status is not good, or breaks a rule that only warns
  std::vector<std::optional<double>> values{};  ///< in the order of FrameFormat::values(), each in its unit
};

/// Reads a [frame] table; mistakes are noted in it (the caller asks for the verdict). The keys are described, with
/// examples, in profiles/gyro-streams/README.md. The least that is needed:
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
///     kind = "crc16"              # none, sum8, xor8, crc16, crc32
///     from = 0                    # first byte covered; covers up to the check itself
///     offset = 14
///     polynomial = 0x1021
///     initial = 0xFFFF
///     reflected = false
///     final_xor = 0
///
/// `axes`: the axes wanted, in this order, each of them one of FrameFormat::all_axes; none: the file's own choice,
/// which is its key `axis`, or else the first. `rate_hz`: replaces the table's nominal rate.
[[nodiscard]] FrameFormat read_frame_format(const TomlTable& table, const std::vector<std::string>& axes = {},
                                            std::optional<double> rate_hz = {});

/// The keywords of a file for the roles.
inline constexpr auto kFieldRoles = words_in_order<FieldRole::pulse_count, FieldRole::value>(
    "pulse_count", "increment", "rate", "integrated_angle", "sequence", "timestamp", "status", "temperature", "value");

/// Gives the fields of `format`, which have all been read, their axes and slots. `wanted`: the axes, as for
/// read_frame_format. Mistakes are noted in `table`, or in the field's own of `fields`: an axis that does not exist or
/// is wanted twice; two fields of one frame that fill the same column of the record; fields of one axis, or of one
/// name, that differ in meaning; a name of housekeeping that is not valid.
void settle_roles(const TomlTable& table, const std::vector<TomlTable>& fields, const std::vector<std::string>& wanted,
                  FrameFormat& format);

/// Takes bytes as they come, gives whole good frames; resynchronises from the byte after a false sync, in lines of text
/// at the next line. The first line is not believed, as its beginning may be missing, unless it begins as `starts_with`
/// says and has a check.
class FrameDecoder {
 public:
  explicit FrameDecoder(FrameFormat format);
  void feed(std::span<const std::byte> bytes);
  /// The next whole good frame, which is kept until the next call; null if more bytes are needed.
  [[nodiscard]] const GyroFrame* take();
  /// Bytes that were part of no good frame, so far.
  [[nodiscard]] std::uint64_t rejected_bytes() const { return rejected_; }
  /// Every field of the frame taken last, scaled, in the format's order; nothing where that frame lacks it.
  [[nodiscard]] const std::vector<std::optional<double>>& values() const { return values_; }
  /// What the frame taken last says against itself: the meanings of the rules that its status breaks.
  [[nodiscard]] std::vector<std::string> complaints() const;
  /// Returns the meanings of the rules of the verdict `mismatch` that the frame taken last breaks; nothing if that
  /// frame carries no field with such a rule.
  [[nodiscard]] std::optional<std::vector<std::string>> differing_settings() const;

 private:
  [[nodiscard]] std::span<const std::byte> waiting() const { return std::span(buffer_).subspan(begin_); }
  [[nodiscard]] const GyroFrame* take_line();
  [[nodiscard]] const GyroFrame* take_bytes();
  void reject(std::size_t bytes);

  FrameFormat format_;
  std::vector<std::byte> buffer_;
  std::size_t begin_{};  ///< of what is not yet taken, in the buffer
  std::uint64_t rejected_{};
  bool has_settings_{};  ///< some rule has verdict `mismatch`
  bool locked_{};        ///< the last bytes taken were a good frame, or a whole line
  std::optional<std::uint32_t> sequence_{};
  GyroFrame frame_;  ///< taken last
  std::vector<std::optional<double>> values_;
};

/// The bytes of a frame (used by the virtual gyro, and by tests): of the message that carries most axes, and of those
/// the most housekeeping. Counts wrap at the width of their fields, housekeeping stops at it; what `frame` lacks is
/// zero in its unit, or not there if the frame may do without; bytes of no field are zero.
[[nodiscard]] std::vector<std::byte> encode_frame(const FrameFormat& format, const GyroFrame& frame);
/// Returns the message `id`, one of the format's, with the settings that the description expects; `differs`: each field
/// of settings breaks its first rule.
[[nodiscard]] std::vector<std::byte> encode_settings(const FrameFormat& format, std::uint32_t id, bool differs);

}  // namespace gyrotherm::drivers
