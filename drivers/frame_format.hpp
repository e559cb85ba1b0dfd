/// A gyro's framed binary stream, described in the rig file instead of in code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm {

enum class FieldType { u8, u16, u24, u32, i8, i16, i24, i32 };
enum class FieldRole {
  pulse_count,  ///< accumulated up–down counter, wraps at its width
  increment,    ///< pulses since the last frame
  sequence,     ///< frame counter, wraps at its width
  timestamp,    ///< device time, wraps at its width
  status,       ///< must equal `good` under `mask`
};
enum class CheckKind { none, sum8, xor8, crc16, crc32 };

struct FrameField {
  FieldRole role{};
  FieldType type{};
  std::size_t offset{};
  bool big_endian{};
  double unit_s = 1e-6;    ///< timestamp: seconds per count
  std::uint32_t mask = 0;  ///< status
  std::uint32_t good = 0;  ///< status
};

/// CRC parameters in the usual model: polynomial, initial value, reflected in and out alike, final XOR.
struct FrameCheck {
  CheckKind kind = CheckKind::none;
  std::size_t from{};  ///< first byte covered; covers up to the check itself
  std::size_t offset{};
  bool big_endian{};
  std::uint32_t polynomial{};
  std::uint32_t initial{};
  bool reflected{};
  std::uint32_t final_xor{};
};

struct FrameFormat {
  std::string name;
  std::vector<std::byte> sync;
  std::size_t length{};
  std::vector<FrameField> fields;
  FrameCheck check;

  [[nodiscard]] const FrameField* find(FieldRole role) const;
};

/// One frame's fields, unscaled. A role that the format lacks is absent.
struct GyroFrame {
  std::optional<std::int64_t> pulses{};  ///< pulse_count or increment
  std::optional<std::uint32_t> sequence{};
  std::optional<std::uint64_t> timestamp{};
  bool good = true;
};

[[nodiscard]] std::size_t byte_count(FieldType type);
[[nodiscard]] bool is_signed(FieldType type);

/// Reads a [frame] table; mistakes are noted in it (the caller asks for the verdict).
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
[[nodiscard]] FrameFormat read_frame_format(const TomlTable& table);

/// Takes bytes as they come, gives whole good frames; resynchronises from the byte after a false sync.
class FrameDecoder {
 public:
  explicit FrameDecoder(FrameFormat format);
  void feed(std::span<const std::byte> bytes);
  /// The next whole good frame; nothing if more bytes are needed.
  [[nodiscard]] std::optional<GyroFrame> take();
  /// Bytes that were part of no good frame, so far.
  [[nodiscard]] std::uint64_t rejected_bytes() const { return rejected_; }

 private:
  FrameFormat format_;
  std::vector<std::byte> buffer_;
  std::size_t begin_{};  ///< of what is not yet taken, in the buffer
  std::uint64_t rejected_{};
};

/// The bytes of a frame (used by the virtual gyro, and by tests). Counts wrap at the width of their fields; bytes of no
/// field are zero.
[[nodiscard]] std::vector<std::byte> encode_frame(const FrameFormat& format, const GyroFrame& frame);

}  // namespace gyrotherm
