// SPDX-License-Identifier: Apache-2.0
/// Where a row of pieces of text, tables and figures is broken into pages: arithmetic alone, no font, no Qt.
#pragma once

#include <cstddef>
#include <vector>

namespace gyrotherm::report {

/// The height of something that is never cut, and how it stands to its neighbours. All lengths are of one unit.
struct Extent {
  double height{};
  double least_height{};  ///< it may be drawn smaller, down to this; 0: it may not
  double space_before{};  ///< left out at the top of a page
  double repeated{};      ///< height of what stands above it again where it begins a page: the head of its table; or 0
  bool keep_with_next{};  ///< no page ends with it
};

/// Where a piece lies.
struct Placement {
  std::size_t page{};
  double top{};     ///< from the top of the page's text
  double height{};  ///< the extent's, or less
  bool repeats{};   ///< what it repeats lies directly above it
};

/// A placement for each extent, in their order: pages are filled from the first on. Pieces that keep with the next are
/// parted only where they are higher than a page together; a piece that alone is higher than a page begins one and is
/// made smaller as far as it may.
[[nodiscard]] std::vector<Placement> page_breaks(const std::vector<Extent>& extents, double page_height);

}  // namespace gyrotherm::report
