// SPDX-License-Identifier: Apache-2.0
/// Pages made by WeasyPrint from the HTML of a report: page breaks, metadata, and forbidden contents.
#include "tests/apps/pdf/paper.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "report/plot/png.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::pdf {
namespace {

using report::Document;
using report::DocumentFigure;
using report::DocumentTable;
using report::Heading;
using report::Language;
using report::Logo;
using report::Paragraph;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Returns the text of each page.
std::vector<std::string> pages_of(const Paper& paper) {
  std::vector<std::string> pages;
  for (int page = 1; page <= paper.pages(); ++page) pages.push_back(paper.text(page));
  return pages;
}

/// Returns the index of the first page with a text, or the number of pages if none has it.
std::size_t page_with(const std::vector<std::string>& pages, const std::string& text) {
  return static_cast<std::size_t>(std::ranges::find_if(pages, [&](const auto& page) { return has(page, text); }) -
                                  pages.begin());
}

DocumentTable table_of(const std::string& name, int rows) {
  DocumentTable table{.caption = "Caption " + name, .header = {"Head " + name, "Value"}};
  for (int k = 0; k < rows; ++k)
    table.rows.push_back({{.text = "Row " + name + "-" + std::to_string(k) + "."}, {.text = std::to_string(k)}});
  return table;
}

TEST(PaperPages, KeepHeadingWithItsText) {
  Document document = small_document();
  for (int k = 0; k < 60; ++k) {
    const auto name = std::to_string(k) + ".";
    document.blocks.emplace_back(Heading{.text = "Heading " + name, .sub = k % 3 != 0});
    std::string text = "Begin " + name;
    for (int word = 0; word < 5 + 7 * (k % 9); ++word) text += " word";
    document.blocks.emplace_back(Paragraph{.text = text});
  }
  const auto pages = pages_of(Paper(document));
  ASSERT_GT(pages.size(), 3u);
  for (int k = 0; k < 60; ++k) {
    const auto heading = page_with(pages, "Heading " + std::to_string(k) + ".");
    ASSERT_LT(heading, pages.size());
    EXPECT_TRUE(has(pages[heading], "Begin " + std::to_string(k) + ".")) << k;
  }
}

TEST(PaperPages, RepeatHeaderOfContinuedTable) {
  Document document = small_document();
  document.blocks.emplace_back(table_of("long", 200));
  const auto pages = pages_of(Paper(document));
  ASSERT_GT(pages.size(), 3u);
  for (const auto& page : pages) EXPECT_EQ(has(page, "Row long-"), has(page, "Head long")) << page;
  for (int k = 0; k < 200; ++k) EXPECT_LT(page_with(pages, "Row long-" + std::to_string(k) + "."), pages.size()) << k;
}

TEST(PaperPages, KeepCaptionWithFirstRowsAndLastRowsTogether) {
  Document document = small_document();
  for (int k = 0; k < 40; ++k) document.blocks.emplace_back(table_of("t" + std::to_string(k), 2 + k % 9));
  const auto pages = pages_of(Paper(document));
  ASSERT_GT(pages.size(), 4u);
  for (int k = 0; k < 40; ++k) {
    const auto name = "t" + std::to_string(k);
    const int rows = 2 + k % 9;
    const auto row = [&](int index) { return page_with(pages, "Row " + name + "-" + std::to_string(index) + "."); };
    ASSERT_LT(row(rows - 1), pages.size());
    EXPECT_TRUE(has(pages[row(0)], "Caption " + name + "\n")) << name;
    EXPECT_EQ(row(0), row(1)) << name;
    EXPECT_EQ(row(rows - 2), row(rows - 1)) << name;
    EXPECT_TRUE(rows <= 5 || row(rows - 3) == row(rows - 1)) << name;
    EXPECT_TRUE(rows > 5 || row(0) == row(rows - 1)) << name;
  }
}

TEST(PaperPages, KeepFigureWithItsCaption) {
  Document document = small_document();
  for (int k = 0; k < 8; ++k) {
    plot::SvgWriter svg(760, 300, "figure");
    svg.text(100, 100, "Label " + std::to_string(k) + ".", {});
    document.blocks.emplace_back(DocumentFigure{
        .id = "f", .caption = "Caption " + std::to_string(k) + ".", .svg = std::move(svg).finish(), .data = {}});
  }
  const auto pages = pages_of(Paper(document));
  for (int k = 0; k < 8; ++k)
    EXPECT_EQ(page_with(pages, "Label " + std::to_string(k) + "."),
              page_with(pages, "Caption " + std::to_string(k) + "."));
  EXPECT_LT(page_with(pages, "Caption 7."), pages.size());
}

TEST(PaperFile, HasMetadataAsInfoAndXmp) {
  Document document = small_document();
  document.title = "Größe & <Maß>";
  document.number = "(1)";
  document.language = Language::german;
  const Paper paper(document, {.program = "gyrotherm 1", .source_sha256 = "00ff", .utc_s = 1795132800});
  const auto info = shell("TZ=UTC pdfinfo -isodates " + paper.pdf()).out,
             xmp = shell("pdfinfo -meta " + paper.pdf()).out;
  EXPECT_TRUE(has(info, "Größe & <Maß> (1)\n")) << info;
  EXPECT_TRUE(has(info, "CreationDate:    2026-11-20T00:00:00Z")) << info;
  EXPECT_TRUE(has(xmp, "<rdf:li xml:lang=\"x-default\">Größe &amp; &lt;Maß&gt; (1)</rdf:li>")) << xmp;
  for (const auto* fact : {"<xmp:CreateDate>2026-11-20T00:00:00Z</xmp:CreateDate>", "<pdfaid:part>1</pdfaid:part>",
                           "<pdfaid:conformance>B</pdfaid:conformance>", "sha256:00ff</pdf:Keywords>",
                           "<xmp:CreatorTool>gyrotherm 1</xmp:CreatorTool>", "<rdf:li>de</rdf:li>"})
    EXPECT_TRUE(has(xmp, fact)) << fact << xmp;
  EXPECT_TRUE(has(paper.bytes(), "/Lang (de)"));
}

TEST(PaperFile, HasNoDateWithoutDay) {
  const Paper paper(small_document());
  EXPECT_TRUE(has(paper.bytes(), "%%EOF"));
  EXPECT_FALSE(has(paper.bytes(), "CreationDate"));
  EXPECT_FALSE(has(shell("pdfinfo -meta " + paper.pdf()).out, "CreateDate"));
}

/// Requirements of ISO 19005-1 that are visible in the bytes. Files of a laboratory must not break them.
TEST(PaperFile, IsPdfAWithLogosAndTransparency) {
  Document document = small_document();
  document.mark = "DRAFT";
  plot::Picture picture{2, 2, {{200, 0, 0}, {0, 200, 0}, {0, 0, 200}, {200, 200, 0}}};
  document.logo = Logo{.media_type = "image/svg+xml",
                       .base64 = plot::base64("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 40 20\"><circle "
                                              "cx=\"9\" cy=\"9\" r=\"5\" fill=\"#f00\" opacity=\"0.5\"/></svg>")};
  plot::SvgWriter svg(760, 300, "figure");
  svg.rectangle(20, 20, 50, 50, "#000000", 0.2);
  svg.text(100, 100, "pale", {.opacity = 0.1});
  svg.picture(200, 20, 100, 50, to_png(picture));
  document.blocks.emplace_back(
      DocumentFigure{.id = "f", .caption = "Figure", .svg = std::move(svg).finish(), .data = {}});
  const Paper paper(document, {.program = "p", .source_sha256 = "", .utc_s = {}});
  EXPECT_EQ(paper.ran().out, "");
  const std::string bytes = paper.bytes();
  EXPECT_TRUE(bytes.starts_with("%PDF-1.4"));
  for (const auto* part : {"/OutputIntents", "/GTS_PDFA1", "/DestOutputProfile", "/CIDSet", "/ToUnicode", "/ID ["})
    EXPECT_TRUE(has(bytes, part)) << part;
  for (const auto* part : {"/SMask", "/Transparency", "/JavaScript", "/EmbeddedFile", "/Encrypt", "/OpenType", "/LZW"})
    EXPECT_FALSE(has(bytes, part)) << part;
  for (auto at = bytes.find("/ca "); at != std::string::npos; at = bytes.find("/ca ", at + 1))
    EXPECT_TRUE(bytes.substr(at + 4, 2) == "1 " || bytes.substr(at + 4, 2) == "1\n" || bytes.substr(at + 4, 3) == "1.0")
        << bytes.substr(at, 12);
}

TEST(PaperFile, HasSignatureFieldOnlyOnLastPage) {
  Document document = small_document();
  document.blocks.emplace_back(table_of("long", 100));
  const auto html = paper_html(document, {});
  const auto with = Paper(html, "--signature-field").bytes(), without = Paper(html).bytes();
  EXPECT_TRUE(has(with, "/SigFlags 1"));
  EXPECT_TRUE(has(with, "/T (Signature)"));
  ASSERT_TRUE(has(with, "/Annots"));
  EXPECT_EQ(with.find("/Annots"), with.rfind("/Annots"));
  EXPECT_GT(with.find("/Annots"), with.rfind("/Type /Page\n"));
  EXPECT_FALSE(has(without, "AcroForm"));
}

TEST(PaperText, EscapesHostileTexts) {
  Document document = small_document();
  const std::string hostile = "<b>\"x\"</style><img src=file:///etc/passwd>&amp;{content:url(/etc/passwd)}";
  document.laboratory = "L</style>\\\"*/";
  document.blocks.emplace_back(Heading{.text = hostile});
  document.blocks.emplace_back(Paragraph{.text = hostile});
  const Paper paper(document);
  EXPECT_EQ(paper.ran().out, "");
  EXPECT_TRUE(has(paper.text(), "<b>\"x\"</style><img src=file:///etc/passwd>&amp;{content:url(/etc/passwd)}"))
      << paper.text();
  EXPECT_TRUE(has(paper.text(), "L</style>\\\"*/")) << paper.text();
}

TEST(PaperText, FetchesNothing) {
  const tests::TestFolder folder;
  std::ofstream(folder / "style.css") << "p::before { content: 'fetched' }";
  const Paper paper("<link rel=\"stylesheet\" href=\"file://" + (folder / "style.css") + "\"/><style>@import 'file://" +
                    (folder / "style.css") + "';</style><p>text</p><img src=\"file:///etc/passwd\"/>");
  EXPECT_EQ(paper.ran().exit_code, 0) << paper.ran().out;
  EXPECT_TRUE(has(paper.ran().out, "is not embedded in the report")) << paper.ran().out;
  EXPECT_TRUE(has(paper.text(), "text"));
  EXPECT_FALSE(has(paper.text(), "fetched"));
}

}  // namespace
}  // namespace gyrotherm::pdf
