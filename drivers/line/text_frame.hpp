// SPDX-License-Identifier: Apache-2.0
/// Frames of text protocols: a start byte, the text, check characters and an end byte.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Check characters of a frame: none, the XOR of all data bytes, or the sum or negated sum of all bytes from the start
/// byte on as two hexadecimal digits.
enum class FrameChecksum { none, exclusive_or, negated_sum, sum };

/// Frame around each line of a serial link.
struct TextFrame {
  char begin = '\x02', end = '\x03';
  /// Bit 7 of each data byte and of the checksum is set.
  bool high_bit = false;
  FrameChecksum checksum = FrameChecksum::none;
};

/// Describes why the end of some frames cannot be found in a stream of bytes. Returns an empty text if it always can.
[[nodiscard]] std::string describe_ambiguity(const TextFrame& form);

/// Returns the frame of a text.
[[nodiscard]] std::string to_frame(const TextFrame& form, std::string_view text);
/// Returns the text of a whole frame, or nothing if its checksum or form is wrong.
[[nodiscard]] std::optional<std::string> from_frame(const TextFrame& form, std::string_view frame);

/// Returns the byte that ends a text of a framed stream: the end byte of the frame, with bit 7 set if data bytes have
/// it, so that no byte of a text equals it.
[[nodiscard]] char frame_terminator(const TextFrame& form);

/// Wraps `line`: each write sends one frame, and each read returns the text of one frame and frame_terminator().
/// Bytes outside frames are skipped. A check byte may be the start or end byte. A read fails with corrupted if a frame
/// has a wrong checksum or exceeds 4096 bytes, and otherwise as `line` does. `clock` is the clock of `line`; null means
/// the steady clock.
[[nodiscard]] std::unique_ptr<ByteStream> make_framed_stream(std::unique_ptr<ByteStream> line, const TextFrame& form,
                                                             const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
