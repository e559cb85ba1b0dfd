// SPDX-License-Identifier: Apache-2.0
/// Writes the calibration report as HTML for A4 pages. paper.py converts it to PDF (docs/decisions/0054).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "report/document.hpp"

namespace gyrotherm::pdf {

/// Data about the PDF file itself.
struct PaperFacts {
  std::string program;  ///< "gyrotherm 0.1.0"
  /// SHA-256 of the source, for the footer and the keywords; may be empty.
  std::string source_sha256;
  std::string source = "calibration.json";  ///< file name of the source
  /// Date of the PDF, s since 1970.
  std::optional<std::int64_t> utc_s;
};

/// Returns the complete page without style sheet; paper.css defines the classes used here. Title, author, keywords and
/// dates are meta elements. The same document and facts always give the same bytes.
[[nodiscard]] std::string paper_html(const report::Document& document, const PaperFacts& facts);

}  // namespace gyrotherm::pdf
