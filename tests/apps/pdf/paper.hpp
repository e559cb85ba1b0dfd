// SPDX-License-Identifier: Apache-2.0
/// Small documents as PDF, made by paper.py alone.
#pragma once

#include <fstream>
#include <string>

#include "apps/pdf/paper_html.hpp"
#include "tests/apps/pdf/shell.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::pdf {

/// Returns a document without blocks.
inline report::Document small_document() {
  report::Document document;
  document.title = "Calibration report";
  document.number = "C-1";
  document.laboratory = "Laboratory";
  document.end = "End";
  document.page_of = "page {} of {}";
  return document;
}

/// The PDF of an HTML page, and the output of paper.py.
class Paper {
 public:
  explicit Paper(const std::string& html, const std::string& option = "--plain") {
    std::ofstream(folder_ / "page.html") << html;
    ran_ = shell(GYROTHERM_SOURCE_DIR "/apps/pdf/paper.py pdf " + (folder_ / "page.html") + " " + pdf() + " " + option);
  }
  explicit Paper(const report::Document& document, const PaperFacts& facts = {}) : Paper(paper_html(document, facts)) {}

  [[nodiscard]] const Ran& ran() const { return ran_; }
  [[nodiscard]] std::string pdf() const { return folder_ / "page.pdf"; }
  [[nodiscard]] std::string bytes() const { return content_of(pdf()); }
  [[nodiscard]] std::string text(int page = 0) const {
    const auto pages = page > 0 ? "-f " + std::to_string(page) + " -l " + std::to_string(page) + " " : std::string();
    return shell("pdftotext -layout " + pages + pdf() + " -").out;
  }
  [[nodiscard]] int pages() const {
    const auto info = shell("pdfinfo " + pdf()).out;
    return std::stoi(info.substr(info.find("Pages:") + 6));
  }

 private:
  tests::TestFolder folder_;
  Ran ran_;
};

}  // namespace gyrotherm::pdf
