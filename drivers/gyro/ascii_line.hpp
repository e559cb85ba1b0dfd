// SPDX-License-Identifier: Apache-2.0
/// A gyro's line of text: words between separators, ended by a terminator, perhaps with a check in hexadecimal digits.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_check.hpp"

namespace gyrotherm::drivers {

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

/// The [frame.line] table.
[[nodiscard]] LineFormat read_line_format(const TomlTable& table);

/// Where the first terminator begins.
[[nodiscard]] std::optional<std::size_t> find_terminator(const LineFormat& format, std::span<const std::byte> bytes);
/// The words of a line without its terminator; nothing if it begins otherwise, has another count of words or fails the
/// check. They point into `line`.
[[nodiscard]] std::optional<std::vector<std::string_view>> split_line(const LineFormat& format, const FrameCheck& check,
                                                                      std::string_view line);
/// The inverse, terminator and check included.
[[nodiscard]] std::string join_line(const LineFormat& format, const FrameCheck& check,
                                    const std::vector<std::string>& words);

}  // namespace gyrotherm::drivers
