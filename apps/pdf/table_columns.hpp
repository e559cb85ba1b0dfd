// SPDX-License-Identifier: Apache-2.0
/// How wide the columns of a table are: arithmetic alone, no font, no Qt.
#pragma once

#include <vector>

namespace gyrotherm::report {

/// What a column asks for, in one unit for all.
struct ColumnWish {
  double least{};    ///< narrower than this, words or numbers are cut apart
  double natural{};  ///< wide enough that nothing is broken; not less than `least`
};

/// Widths that add up to `width`. Where all can be as wide as they would, what is left is shared in proportion; where
/// they cannot, the widest give way, all down to one width, but none below its least. Only where not even the least fit
/// are columns narrower than that: again the widest.
[[nodiscard]] std::vector<double> column_widths(const std::vector<ColumnWish>& wishes, double width);

/// Whether every column can have its least.
[[nodiscard]] bool least_fit(const std::vector<ColumnWish>& wishes, double width);

}  // namespace gyrotherm::report
