// SPDX-License-Identifier: Apache-2.0
/// The layout of LabVIEW measurement files (.lvm): a header of the file, then one or more segments, each with its own
/// header, a line of column names, and rows. Source: NI, "Specification for the LabVIEW Measurement File (.lvm)".
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::exchange {

/// The first field of a segment's header, and the line that ends each header.
inline constexpr std::string_view kLvmSegment = "Channels", kLvmHeaderEnd = "***End_of_Header***";

struct LvmLayout {
  char separator = '\t';
  char decimal = '.';
  /// Index of the line with the column names of the first segment.
  std::size_t names{};
  /// Unit of each column; empty if the file states none.
  std::vector<std::string> units{};
  /// Spacing of the rows, in seconds, if the file has no column of times.
  std::optional<double> spacing_s{};
  /// Indices of the lines that are rows, of all segments.
  std::vector<std::size_t> rows{};
};

/// Returns nothing if the lines are not those of a LabVIEW measurement file with column names.
[[nodiscard]] std::optional<LvmLayout> find_lvm_layout(const std::vector<std::string_view>& lines);

}  // namespace gyrotherm::exchange
