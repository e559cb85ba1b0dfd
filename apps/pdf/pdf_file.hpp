// SPDX-License-Identifier: Apache-2.0
/// What a PDF tells of itself beside its pages: title, author, day, language, and the table of contents that a reader
/// shows beside them.
///
/// QPdfWriter of Qt 6.4 writes no table of contents, stamps the file with the time of day and marks it with a random
/// number. Its file is plain, though: a row of objects, a table of their places, a trailer. finished() takes it apart,
/// replaces what is said of the document, adds the table of contents, and writes all of it again as one revision, so
/// that a signature is the first change that is ever appended. Equal pages and facts give equal bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::report {

/// A line of the table of contents, which leads to a place.
struct Bookmark {
  std::string title;
  bool sub = false;      ///< below the last one that is not
  std::size_t page = 0;  ///< from 0
  double top_pt = 0;     ///< from the top of the sheet, in points of 1/72 inch
};

struct PdfFacts {
  std::string title, author, keywords;
  std::string creator, producer;      ///< programs: that made the document, that made the PDF of it
  std::string language;               ///< "en", "de"
  std::optional<std::int64_t> utc_s;  ///< when it was made, s since 1970; nothing: the file does not say
  std::vector<Bookmark> bookmarks;    ///< the first one is not sub
  /// The last page has an empty field, which is not seen, for a signature: filled, it adds the signature and nothing
  /// else, while a signature without a field brings one along, and some programs (pdfsig) a font, too.
  bool has_signature_field = false;
};

/// The pages of a PDF/A-1b by QPdfWriter with these facts. Fails with corrupted where the bytes are not built as this
/// Qt builds them, or a bookmark leads to no page.
[[nodiscard]] Result<std::string> finished(std::string_view pdf, const PdfFacts& facts, double page_height_pt);

}  // namespace gyrotherm::report
