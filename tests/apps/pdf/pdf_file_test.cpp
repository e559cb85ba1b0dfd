// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/pdf_file.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::report {
namespace {

/// A file built as QPdfWriter builds it: two pages without content.
std::string small_pdf() {
  const std::vector<std::string> objects{"<<\n/Producer (Qt)\n/CreationDate (D:20261125144857Z)\n>>",
                                         "<<\n/Type /Metadata /Subtype /XML\n/Length 3\n>>\nstream\n<x>\nendstream",
                                         "<<\n/Type /Catalog\n/Pages 4 0 R\n/Metadata 2 0 R\n>>",
                                         "<<\n/Type /Pages\n/Kids \n[\n5 0 R\n7 0 R\n]\n/Count 2\n>>",
                                         "<<\n/Type /Page\n/Parent 4 0 R\n/Annots 6 0 R\n/MediaBox [0 0 595 842]\n>>",
                                         "[ ]",
                                         "<<\n/Type /Page\n/Parent 4 0 R\n/Annots 8 0 R\n/MediaBox [0 0 595 842]\n>>",
                                         "[ ]"};
  std::string pdf = "%PDF-1.4\n", table;
  for (std::size_t k = 0; k < objects.size(); ++k) {
    auto place = std::to_string(pdf.size());
    table += std::string(10 - place.size(), '0') + place + " 00000 n \n";
    pdf += std::to_string(k + 1) + " 0 obj\n" + objects[k] + "\nendobj\n";
  }
  const auto place = std::to_string(pdf.size());
  return pdf + "xref\n0 9\n0000000000 65535 f \n" + table +
         "trailer\n<<\n/Size 9\n/Info 1 0 R\n/Root 3 0 R\n>>\nstartxref\n" + place + "\n%%EOF\n";
}

PdfFacts facts() {
  return {.title = "Größe & <Maß>",
          .author = "计量院",
          .keywords = "k",
          .creator = "gyrotherm",
          .producer = "gyrotherm",
          .language = "de",
          .utc_s = 1795132800,
          .bookmarks = {{"1  Eins", false, 0, 100}, {"1.1  Eins", true, 1, 50}, {"2  Zwei", false, 1, 400}},
          .has_signature_field = true};
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(PdfFile, BookmarksAreATreeThatLeadsToPlaces) {
  const auto pdf = finished(small_pdf(), facts(), 842);
  ASSERT_TRUE(pdf) << text(pdf.error());
  EXPECT_TRUE(has(*pdf, "/Outlines 12 0 R\n/PageMode /UseOutlines"));
  EXPECT_TRUE(has(*pdf, "12 0 obj\n<<\n/First 9 0 R\n/Last 11 0 R\n/Type /Outlines\n/Count 2\n"));
  EXPECT_TRUE(has(*pdf, "9 0 obj\n<<\n/Parent 12 0 R\n/Next 11 0 R\n/First 10 0 R\n/Last 10 0 R\n/Count -1\n"));
  EXPECT_TRUE(has(*pdf, "10 0 obj\n<<\n/Parent 9 0 R\n/Title"));
  EXPECT_TRUE(has(*pdf, "/Dest [5 0 R /XYZ 0 742.0 null]"));
  EXPECT_TRUE(has(*pdf, "/Dest [7 0 R /XYZ 0 792.0 null]"));
}

TEST(PdfFile, ItSaysWhatItIsOnceForReadersAndOnceForArchives) {
  const auto pdf = finished(small_pdf(), facts(), 842);
  ASSERT_TRUE(pdf);
  EXPECT_TRUE(has(*pdf, "/Title <FEFF004700720"));
  EXPECT_TRUE(has(*pdf, "<rdf:li xml:lang=\"x-default\">Größe &amp; &lt;Maß&gt;</rdf:li>"));
  EXPECT_TRUE(has(*pdf, "/Author <FEFF8BA191CF9662>"));
  EXPECT_TRUE(has(*pdf, "/CreationDate (D:20261120000000+00'00')"));
  EXPECT_TRUE(has(*pdf, "<xmp:CreateDate>2026-11-20T00:00:00+00:00</xmp:CreateDate>"));
  EXPECT_TRUE(has(*pdf, "<pdfaid:part>1</pdfaid:part>"));
  EXPECT_TRUE(has(*pdf, "/Lang (de)"));
  EXPECT_FALSE(has(*pdf, "20261125144857")) << "the time of day went";
}

TEST(PdfFile, TheFieldForASignatureIsOnTheLastPageAlone) {
  const auto pdf = finished(small_pdf(), facts(), 842);
  ASSERT_TRUE(pdf);
  EXPECT_TRUE(has(*pdf, "/AcroForm <</Fields [13 0 R] /SigFlags 1>>"));
  EXPECT_TRUE(has(*pdf, "6 0 obj\n[ ]\n"));
  EXPECT_TRUE(has(*pdf, "8 0 obj\n[  13 0 R ]\n"));
  auto without = facts();
  without.has_signature_field = false;
  EXPECT_FALSE(has(finished(small_pdf(), without, 842).value_or(""), "AcroForm"));
}

TEST(PdfFile, WithoutADayItSaysNone) {
  auto undated = facts();
  undated.utc_s.reset();
  EXPECT_FALSE(has(finished(small_pdf(), undated, 842).value_or("CreationDate"), "CreationDate"));
}

TEST(PdfFile, ABookmarkToNoPageIsAFault) {
  auto wrong = facts();
  wrong.bookmarks.back().page = 2;
  EXPECT_FALSE(finished(small_pdf(), wrong, 842));
}

TEST(PdfFile, WhatIsBuiltOtherwiseIsAFaultAndNoMore) {
  const std::string whole = small_pdf();
  EXPECT_FALSE(finished("", facts(), 842));
  for (std::size_t size = 0; size < whole.size() - 8; ++size)
    EXPECT_FALSE(finished(whole.substr(0, size), facts(), 842)) << size;
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const char other : {'0', '9', ' ', '>'}) {
      std::string changed = whole;
      changed[at] = other;
      (void)finished(changed, facts(), 842);
    }
}

}  // namespace
}  // namespace gyrotherm::report
