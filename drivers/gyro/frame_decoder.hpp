// SPDX-License-Identifier: Apache-2.0
/// The fields of one frame: from its bytes or words to values, and back.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

/// One whole frame, bytes or words, that lies in someone's buffer.
struct FrameView {
  std::span<const std::byte> bytes{};
  std::vector<std::string_view> words{};
  std::optional<std::uint32_t> id{};
};

/// Of one field; nothing if this message lacks it (or, in a line, if the word is no number).
[[nodiscard]] std::optional<RawValue> raw_of(const FrameField& field, const FrameView& view);
[[nodiscard]] bool has_field(const FrameField& field, std::optional<std::uint32_t> id);
/// A status rule of the verdict `reject` is broken, or a word that is to be a number is none.
[[nodiscard]] bool is_refuted(const FrameFormat& format, const FrameView& view);
[[nodiscard]] std::optional<std::uint32_t> sequence_of(const FrameFormat& format, const FrameView& view);

/// `values` becomes every field, scaled, in the format's order.
[[nodiscard]] GyroFrame decode_frame(const FrameFormat& format, const FrameView& view,
                                     std::vector<std::optional<double>>& values);

}  // namespace gyrotherm::drivers
