// SPDX-License-Identifier: Apache-2.0
/// The calibration report as a text for people, in one language, before it is set as a page or as a PDF: a row of
/// blocks. Both views set the same blocks, so that neither says what the other does not.
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

// All text is plain: views escape it.

/// Sections are numbered from 1 by the views, subsections 1.1.
struct Heading {
  std::string text;
  bool sub = false;
  std::string id = {};  ///< for links: "results", "results-u1-x"
};

struct Paragraph {
  enum class Style { plain, note, caution } style = Style::plain;
  std::string text;
};

/// What and its value, a line each: "Customer", "Navigation Works, …". A value may hold line breaks.
struct Definitions {
  std::vector<std::pair<std::string, std::string>> lines;
};

/// The first thing to be seen: big numbers, each with what it is.
struct KeyFigures {
  std::string title;  ///< "Axis u1.x"; empty: none
  struct One {
    std::string value, unit, label;
    bool best = false;
  };
  std::vector<One> figures;
};

/// The verdict of the whole or of a row is said in words and by a sign, not by its colour alone.
struct Cell {
  enum class Mark { none, pass, caution, fail } mark = Mark::none;
  std::string text;
  std::string note = {};  ///< on a line of its own below, small: "k = 2.03, ν = 35"; empty: none
};

struct DocumentTable {
  std::string caption;  ///< with its number: "Table 3: …"
  std::vector<std::string> header;
  std::vector<std::vector<Cell>> rows = {};  ///< each as long as the header
  std::size_t text_columns = 1;              ///< the first ones are set left, the rest, numbers, right
};

struct DocumentFigure {
  std::string id;
  std::string caption;  ///< with its number: "Figure 2: …"
  std::string svg;      ///< for print, for the PDF, and without script
  FigureData data;      ///< for zoom and cursor, where a view has them; labels are those of the SVG
};

/// What a line of a figure is called in its legend: only what tells it from the others.
[[nodiscard]] std::string line_name(Language language, const FigureData& figure, std::size_t index);
/// Its colour, as "#rrggbb", and whether it is dashed, so that lines differ without colours too.
[[nodiscard]] std::string line_colour(const FigureData& figure, std::size_t index);
[[nodiscard]] bool line_is_dashed(const FigureData& figure, std::size_t index);

using Block = std::variant<Heading, Paragraph, Definitions, KeyFigures, DocumentTable, DocumentFigure>;

struct Document {
  Language language{};
  std::string title;       ///< "Calibration report (draft)"
  std::string number;      ///< on every page; "–" of a draft without one
  std::string laboratory;  ///< on every page
  std::optional<Logo> logo;
  std::string mark;     ///< across every page: "DRAFT", "SIMULATED", "SUPERSEDED", several joined by " · "; or empty
  std::string end;      ///< the last line: "End of the calibration report C-2026-0042"
  std::string page_of;  ///< "page {} of {}"
  std::vector<Block> blocks;
};

/// The report in a language. First what was calibrated, the result with its U, conformity and what it means; then what
/// ISO/IEC 17025 asks for, results by group, budgets, deviations, files.
[[nodiscard]] Document document_of(const CalibrationReport& report, Language language);

/// Returns the document as one page of HTML, which needs no network, for a screen of any width and for paper. Where
/// scripts run, dygraphs draws the figures, which can then be enlarged and have a cursor. Without scripts, on paper,
/// and where an axis is logarithmic, the page shows the document's SVGs. The mark of the document is above the page and
/// on every sheet. Equal documents give equal bytes.
[[nodiscard]] std::string html_of(const Document& document);

}  // namespace gyrotherm::report
