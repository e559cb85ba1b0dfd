// SPDX-License-Identifier: Apache-2.0
/// The blocks of a report as pieces that are never cut: a line of a paragraph, a row of a table, a figure; only for the
/// sources of this folder. Lengths are those of typesetter.hpp.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/pdf/page_breaks.hpp"
#include "apps/pdf/pdf_file.hpp"
#include "apps/pdf/typesetter.hpp"
#include "report/document.hpp"

namespace gyrotherm::report {

/// Something to be painted from the left edge of the text on.
struct Piece {
  Extent extent;
  std::function<void(QPainter&, double top, double height)> paint;
  std::function<void(QPainter&, double top)> paint_repeated = {};  ///< what the extent repeats, above `top`
  std::optional<Bookmark> bookmark = {};                           ///< the page adds its place
};

struct Pieces {
  std::vector<Piece> pieces;
  std::vector<std::string> faults;  ///< sentences about figures that cannot be painted, and are left out
};

/// The document's blocks in their order, and its last line. Headings are numbered: 1, 1.1.
[[nodiscard]] Pieces pieces_of(const Document& document, Typesetter& typesetter, double width);

/// A table's caption, its head and its rows; the head is repeated on each page. A row of many lines is several pieces.
[[nodiscard]] std::vector<Piece> pieces_of(const DocumentTable& table, Typesetter& typesetter, double width);

/// Big numbers in cells of one width, in as few rows as let each be set large.
[[nodiscard]] std::vector<Piece> pieces_of(const KeyFigures& figures, Typesetter& typesetter, double width);

/// A piece for each line, of which the first two keep together, and the last two.
[[nodiscard]] std::vector<Piece> pieces_of(const Lines& lines, double left, double space_before);

void paint_rule(QPainter& painter, double left, double right, double y, const QColor& colour, double thickness);

}  // namespace gyrotherm::report
