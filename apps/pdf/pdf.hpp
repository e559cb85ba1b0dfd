// SPDX-License-Identifier: Apache-2.0
/// The calibration report as a PDF on A4 that a laboratory signs: PDF/A-1b, fonts inside, text that can be found and
/// copied, a table of contents (docs/decisions/0020).
///
/// Needs the font DejaVu Sans, and for characters that it has not any other that is installed. A program has one
/// PdfProgram, first of all, and calls come from its main thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "report/document.hpp"

namespace gyrotherm::report {

/// What the file tells beside the document.
struct PdfOptions {
  std::string program;                ///< in the footer: "gyrotherm 0.1.0"
  std::string source_sha256;          ///< of calibration.json; in the footer and among the keywords; or empty
  std::optional<std::int64_t> utc_s;  ///< its date, s since 1970; nothing: it has none
  bool has_signature_field = false;   ///< for what is authorised: an empty field for a signature, not seen
};

struct FinishedFile {
  std::string bytes;
  std::vector<std::string> remarks;  ///< sentences: a logo that was left out, characters that no font has
};

struct PngOptions {
  int width_px = 1600;
};

/// Qt for as long as it lives, without any display.
class PdfProgram {
 public:
  PdfProgram();
  ~PdfProgram();
  PdfProgram(const PdfProgram&) = delete;
  PdfProgram& operator=(const PdfProgram&) = delete;

  /// Equal documents and options give equal bytes where the same fonts and the same Qt are installed. Fails with
  /// bad_file where the font is not installed, and with corrupted where Qt's file is not as expected.
  [[nodiscard]] Result<FinishedFile> pdf_of(const Document& document, const PdfOptions& options) const;

  /// A figure of plot/ as the bytes of a PNG, as high as its shape asks for. Fails with bad_file where it is no SVG, or
  /// would have more than 100 million pixels.
  [[nodiscard]] Result<FinishedFile> png_of(const std::string& svg, const PngOptions& options) const;

 private:
  struct Application;
  std::unique_ptr<Application> application_;
};

}  // namespace gyrotherm::report
