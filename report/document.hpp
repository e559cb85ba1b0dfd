// SPDX-License-Identifier: Apache-2.0
/// The calibration report as a human-readable document in one language: a sequence of blocks. Page and PDF lay out the
/// same blocks and therefore have the same contents.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "report/calibration.hpp"
#include "report/words.hpp"

namespace gyrotherm::report {

// All texts are plain; views escape them.

/// A heading. Views number sections from 1 and subsections as 1.1.
struct Heading {
  std::string text;
  bool sub = false;
  std::string id = {};  ///< link target: "results-u1-x"
};

struct Paragraph {
  enum class Style { plain, note, caution } style = Style::plain;
  std::string text;
};

/// A list of labels with values, such as "Customer" and "Navigation Works, …". A value may contain line breaks.
struct Definitions {
  std::vector<std::pair<std::string, std::string>> lines;
};

/// Large labelled numbers at the top of the document.
struct KeyFigures {
  std::string title;  ///< "Axis u1.x"; empty: none
  struct Entry {
    std::string value, unit, label;
    bool best = false;
  };
  std::vector<Entry> figures;
};

/// A table cell. A mark is shown as text and sign, not only by colour.
struct Cell {
  enum class Mark { none, pass, caution, fail } mark = Mark::none;
  std::string text;
  /// Small text on its own line below: "k = 2.03, ν = 35"; empty for none.
  std::string note = {};
};

struct DocumentTable {
  std::string caption;  ///< numbered: "Table 3: …"
  std::vector<std::string> header;
  std::vector<std::vector<Cell>> rows = {};  ///< each as long as the header
  /// Number of leading columns with text, aligned left; the others have numbers, aligned right.
  std::size_t text_columns = 1;
};

struct DocumentFigure {
  std::string id;
  std::string caption;  ///< numbered: "Figure 2: …"
  /// Figure for print, the PDF, and the page without scripts.
  std::string svg;
  /// The same figure for a narrow screen. Empty if zoom and cursor replace it there.
  std::string narrow_svg = {};
  /// Data for zoom and cursor; labelled like the SVG.
  FigureData data;
};

/// Returns the legend entry of a line. It contains only the parts that distinguish the line from the other lines.
[[nodiscard]] std::string line_name(Language language, const FigureData& figure, std::size_t index);
/// Returns the colour of a line as "#rrggbb".
[[nodiscard]] std::string line_colour(const FigureData& figure, std::size_t index);
/// Returns true if the line is dashed, which distinguishes it from others in print without colour.
[[nodiscard]] bool is_line_dashed(const FigureData& figure, std::size_t index);

using Block = std::variant<Heading, Paragraph, Definitions, KeyFigures, DocumentTable, DocumentFigure>;

struct Document {
  Language language{};
  std::string title;  ///< "Calibration report (draft)"
  /// Shown on every page; the number is "–" for a draft without one.
  std::string number;
  std::string laboratory;
  std::optional<Logo> logo;
  /// Printed across every page: "DRAFT", "SIMULATED", "SUPERSEDED", several joined by " · ", or empty.
  std::string mark;
  /// Last line: "End of the calibration report C-2026-0042".
  std::string end;
  std::string page_of;  ///< "page {} of {}"
  std::vector<Block> blocks;
};

/// Returns the report in a language: first a summary with the item, the result with its U, conformity and an
/// explanation; then the details required by ISO/IEC 17025, results by group, budgets, deviations and files.
[[nodiscard]] Document make_document(const CalibrationReport& report, Language language);

/// Returns the document as one HTML page for a screen of any width and for print, without network access. With scripts
/// enabled, dygraphs draws the figures with zoom and cursor. Without scripts, in print, and for logarithmic axes, the
/// page shows the SVGs of the document. The mark of the document is above the page and on every sheet. The page depends
/// only on the document.
[[nodiscard]] std::string to_html(const Document& document);

}  // namespace gyrotherm::report
