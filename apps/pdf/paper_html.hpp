// SPDX-License-Identifier: Apache-2.0
/// The calibration report as HTML for A4 pages, which paper.py makes a PDF of (docs/decisions/0054).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "report/document.hpp"

namespace gyrotherm::pdf {

/// Facts about the file itself.
struct PaperFacts {
  std::string program;  ///< "gyrotherm 0.1.0"
  /// SHA-256 of calibration.json, for the footer and the keywords; may be empty.
  std::string source_sha256;
  std::optional<std::int64_t> utc_s;  ///< date of the PDF, s since 1970
};

/// Returns the whole page without style sheet: its sheet is paper.css, which needs the classes used here. Title,
/// author, keywords and dates are meta elements. Equal documents and facts give equal bytes.
[[nodiscard]] std::string paper_html(const report::Document& document, const PaperFacts& facts);

}  // namespace gyrotherm::pdf
