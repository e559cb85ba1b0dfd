// SPDX-License-Identifier: Apache-2.0
/// A gyro's framed stream, described in a file instead of in code: how frames are found in it (this header), what is in
/// them (frame_fields.hpp), how they are checked (frame_check.hpp), and lines of text (ascii_line.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/gyro/ascii_line.hpp"
#include "drivers/gyro/frame_check.hpp"
#include "drivers/gyro/frame_fields.hpp"

namespace gyrotherm::drivers {

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

  std::string axis{};              ///< of the gyro, where the stream has several
  std::optional<HeadNumber> id{};  ///< which message a frame is
  std::vector<FrameVariant>
      variants{};  ///< with an id: all that there are (any other too, if the head tells the length)
  std::optional<HeadNumber> length_at{};  ///< the head tells the length,
  std::size_t length_plus{};              ///< … less this
  std::vector<std::byte> tail{};          ///< may follow a frame
  std::size_t lock_frames{};              ///< frames that must fit in a row before the first is believed
  std::optional<LineFormat> line{};       ///< lines of text instead of bytes
  double rate_hz{};                       ///< nominal; 0: not said
  bool clocked_by_sequence{};             ///< time is frames counted, at the nominal rate

  /// The first field with this role; a gyro's field of another axis has the role `value`.
  [[nodiscard]] const FrameField* find(FieldRole role) const;
  /// The field that the bias is made of: never null in a format that was read without mistakes.
  [[nodiscard]] const FrameField* gyro() const;
};

/// One frame's fields. A role that the format, or this message, lacks is absent.
struct GyroFrame {
  std::optional<std::int64_t> pulses{};  ///< the gyro's field unscaled, if it is an integer
  std::optional<std::uint32_t> sequence{};
  std::optional<std::uint64_t> timestamp{};  ///< counts of the field's unit_s
  bool good = true;
  std::optional<double> gyro{};         ///< the gyro's field scaled, in its unit
  std::optional<double> temperature{};  ///< °C
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
/// `axis`: the gyro wanted, instead of the file's own choice.
[[nodiscard]] FrameFormat read_frame_format(const TomlTable& table, const std::string& axis = "");

/// Takes bytes as they come, gives whole good frames; resynchronises from the byte after a false sync, in lines of text
/// at the next line. The first line is not believed, as its beginning may be missing, unless it begins as `starts_with`
/// says and has a check.
class FrameDecoder {
 public:
  explicit FrameDecoder(FrameFormat format);
  void feed(std::span<const std::byte> bytes);
  /// The next whole good frame; nothing if more bytes are needed.
  [[nodiscard]] std::optional<GyroFrame> take();
  /// Bytes that were part of no good frame, so far.
  [[nodiscard]] std::uint64_t rejected_bytes() const { return rejected_; }
  /// Every field of the frame taken last, scaled, in the format's order; nothing where that frame lacks it.
  [[nodiscard]] const std::vector<std::optional<double>>& values() const { return values_; }
  /// What the frame taken last says against itself: the meanings of the rules that its status breaks.
  [[nodiscard]] std::vector<std::string> complaints() const;

 private:
  [[nodiscard]] std::span<const std::byte> waiting() const { return std::span(buffer_).subspan(begin_); }
  [[nodiscard]] std::optional<GyroFrame> take_line();
  [[nodiscard]] std::optional<GyroFrame> take_bytes();
  void reject(std::size_t bytes);

  FrameFormat format_;
  std::vector<std::byte> buffer_;
  std::size_t begin_{};  ///< of what is not yet taken, in the buffer
  std::uint64_t rejected_{};
  bool locked_{};  ///< the last bytes taken were a good frame, or a whole line
  std::optional<std::uint32_t> sequence_{};
  std::vector<std::optional<double>> values_;
};

/// The bytes of a frame (used by the virtual gyro, and by tests): of the first message that carries the gyro. Counts
/// wrap at the width of their fields; bytes of no field are zero.
[[nodiscard]] std::vector<std::byte> encode_frame(const FrameFormat& format, const GyroFrame& frame);

/// One field of `format`, of which everything but the fields is known. Mistakes are noted in the table.
[[nodiscard]] FrameField read_frame_field(const TomlTable& table, const FrameFormat& format);

/// Whole numbers from 0 to `highest`.
[[nodiscard]] std::vector<std::uint32_t> read_whole_numbers(const TomlTable& table, const char* key, double highest,
                                                            const char* what);

/// The words of roles, for messages.
[[nodiscard]] const char* name(FieldRole role);

}  // namespace gyrotherm::drivers
