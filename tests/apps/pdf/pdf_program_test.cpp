// SPDX-License-Identifier: Apache-2.0
/// gyrotherm-pdf as used by a laboratory, and its files as read by other programs.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "report/document.hpp"
#include "report/plot/png.hpp"
#include "tests/apps/pdf/shell.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::pdf {
namespace {

using report::Block;
using report::CalibrationReport;
using report::Definitions;
using report::Document;
using report::DocumentFigure;
using report::DocumentTable;
using report::Heading;
using report::KeyFigures;
using report::Language;
using report::Logo;
using report::Paragraph;
using report::ReportState;
using report::sample_calibration;

const std::string kProgram = "env -u DISPLAY -u SOURCE_DATE_EPOCH " GYROTHERM_PDF " ";

/// The PDFs of a report in both languages.
class RenderedReport {
 public:
  explicit RenderedReport(const CalibrationReport& report) : report_(report) {
    std::ofstream(folder_ / "calibration.json") << to_json(report);
    for (const auto* language : {"en", "de"})
      remarks_ += shell(kProgram + source() + " --language " + language + " --out " + pdf(language)).out;
  }
  [[nodiscard]] std::string source() const { return folder_ / "calibration.json"; }
  [[nodiscard]] std::string pdf(const std::string& language) const { return folder_ / (language + ".pdf"); }
  [[nodiscard]] std::string operator/(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] Document document(const std::string& language) const {
    return make_document(report_, language == "de" ? Language::german : Language::english);
  }
  [[nodiscard]] const std::string& remarks() const { return remarks_; }

 private:
  tests::TestFolder folder_;
  CalibrationReport report_;
  std::string remarks_;
};

const RenderedReport& sample() {
  static const RenderedReport made(sample_calibration());
  return made;
}

/// Splits a text at blanks, including narrow and non-breaking ones. Removes word joiners, some of which a PDF lacks.
std::vector<std::string> split_words(std::string text) {
  text = report::remove_word_joiners(std::move(text));
  for (const std::string blank : {"\u202f", "\u00a0", "\u2009"})
    for (auto at = text.find(blank); at != std::string::npos; at = text.find(blank, at))
      text.replace(at, blank.size(), " ");
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// Returns the text found by pdftotext.
std::string text_in(const std::string& pdf) {
  return joined(split_words(shell("pdftotext -layout " + pdf + " -").out));
}

/// Returns the words found by pdftotext.
std::set<std::string> words_in(const std::string& pdf) {
  std::istringstream boxes(shell("pdftotext -bbox " + pdf + " -").out);
  std::set<std::string> words;
  for (std::string line; std::getline(boxes, line);) {
    const auto begin = line.find('>') + 1, end = line.find("</word>");
    if (end == std::string::npos) continue;
    std::string word = line.substr(begin, end - begin);
    for (const auto& [code, letter] :
         {std::pair("&lt;", "<"), {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}})
      for (auto at = word.find(code); at != std::string::npos; at = word.find(code))
        word.replace(at, std::strlen(code), letter);
    words.insert(report::remove_word_joiners(std::move(word)));
  }
  return words;
}

/// Returns every text of a document.
std::vector<std::string> collect_texts(const Document& document) {
  std::vector<std::string> texts{document.title, document.number, document.laboratory, document.end};
  for (const Block& block : document.blocks) {
    if (const auto* heading = std::get_if<Heading>(&block)) texts.push_back(heading->text);
    if (const auto* paragraph = std::get_if<Paragraph>(&block)) texts.push_back(paragraph->text);
    if (const auto* figure = std::get_if<DocumentFigure>(&block)) texts.push_back(figure->caption);
    if (const auto* definitions = std::get_if<Definitions>(&block))
      for (const auto& [what, value] : definitions->lines) texts.insert(texts.end(), {what, value});
    if (const auto* figures = std::get_if<KeyFigures>(&block))
      for (const auto& one : figures->figures) texts.insert(texts.end(), {one.value, one.unit, one.label});
    if (const auto* table = std::get_if<DocumentTable>(&block)) {
      texts.push_back(table->caption);
      texts.insert(texts.end(), table->header.begin(), table->header.end());
      for (const auto& row : table->rows)
        for (const auto& cell : row) texts.insert(texts.end(), {cell.text, cell.note});
    }
  }
  return texts;
}

TEST(Pdf, TextHasNoWordJoiners) {
  for (const std::string language : {"en", "de"}) {
    const auto text = text_in(sample().pdf(language));
    EXPECT_EQ(text.find("\u2060"), std::string::npos) << language;
    EXPECT_NE(text.find("°/h"), std::string::npos) << language;
  }
}

TEST(Pdf, ContainsEveryWordOfReport) {
  EXPECT_EQ(sample().remarks(), "");
  for (const std::string language : {"en", "de"}) {
    const auto all = words_in(sample().pdf(language));
    for (const auto& text : collect_texts(sample().document(language)))
      for (const auto& word : split_words(text))
        EXPECT_TRUE(all.contains(word) || word.size() > 30) << language << ": " << word << " of " << text;
  }
}

TEST(Pdf, ContainsEachValueWithUncertainty) {
  for (const std::string language : {"en", "de"}) {
    const auto text = text_in(sample().pdf(language));
    const auto document = sample().document(language);
    int values = 0;
    for (const Block& block : document.blocks) {
      const auto* table = std::get_if<DocumentTable>(&block);
      if (table == nullptr) continue;
      for (const auto& row : table->rows)
        for (const auto& cell : row) {
          if (cell.text.find("±") == std::string::npos) continue;
          ++values;
          EXPECT_NE(text.find(joined(split_words(cell.text))), std::string::npos) << language << ": " << cell.text;
        }
    }
    EXPECT_GT(values, 60);
    EXPECT_NE(text.find(language == "de" ? "0,002 140 ± 0,000 061" : "0.002 140 ± 0.000 061"), std::string::npos);
  }
}

TEST(Pdf, EmbedsFontsWithUnicode) {
  for (const std::string language : {"en", "de"}) {
    std::istringstream fonts(shell("pdffonts " + sample().pdf(language)).out);
    int count = 0;
    for (std::string line; std::getline(fonts, line);) {
      if (line.find("Identity-H") == std::string::npos) continue;
      const auto words = split_words(line.substr(line.find("Identity-H")));
      ++count;
      ASSERT_GE(words.size(), 4u) << line;
      EXPECT_EQ(words[1], "yes") << "emb: " << line;
      EXPECT_EQ(words[3], "yes") << "uni: " << line;
    }
    EXPECT_GE(count, 2);
  }
}

TEST(Pdf, IdentifiesLaboratoryReportAndMarkOnEveryPage) {
  for (const std::string language : {"en", "de"}) {
    const auto info = shell("pdfinfo " + sample().pdf(language)).out;
    const int pages = std::stoi(info.substr(info.find("Pages:") + 6));
    ASSERT_GE(pages, 5);
    for (int page = 1; page <= pages; ++page) {
      const auto number = std::to_string(page);
      const auto text = joined(split_words(
          shell("pdftotext -f " + number + " -l " + number + " -layout " + sample().pdf(language) + " -").out));
      const std::string word = language == "de" ? "Seite " : "page ", of = language == "de" ? " von " : " of ";
      EXPECT_NE(text.find(word + number + of + std::to_string(pages)), std::string::npos) << text;
      EXPECT_NE(text.find("Inertial Laboratory"), std::string::npos);
      EXPECT_NE(text.find("C-2026-0042"), std::string::npos);
      EXPECT_NE(text.find(sample().document(language).mark), std::string::npos);
      const bool is_last = page == pages;
      EXPECT_EQ(text.find(sample().document(language).end) != std::string::npos, is_last);
    }
  }
}

TEST(Pdf, HasTitleNumberAndDateOfIssue) {
  const auto info = shell("TZ=UTC pdfinfo -isodates " + sample().pdf("de")).out;
  for (const std::string fact : {"Kalibrierbericht", "C-2026-0042", "Inertial Laboratory", "sha256:", "gyrotherm",
                                 "2026-11-20T00:00:00Z", "A4", "Metadata Stream: yes"})
    EXPECT_NE(info.find(fact), std::string::npos) << fact << "\n" << info;
}

/// Bookmarks have the numbers of the headings.
TEST(Pdf, HasHeadingsAsBookmarks) {
  const auto xml = shell("cd /tmp && pdftohtml -xml -stdout -i " + sample().pdf("en")).out;
  const auto outline = xml.substr(std::min(xml.size(), xml.find("<outline>")));
  int section = 0, sub = 0;
  for (const Block& block : sample().document("en").blocks) {
    const auto* heading = std::get_if<Heading>(&block);
    if (heading == nullptr) continue;
    sub = heading->sub ? sub + 1 : 0;
    if (!heading->sub) ++section;
    const auto number = std::to_string(section) + (heading->sub ? "." + std::to_string(sub) : "");
    EXPECT_NE(outline.find(number + "  " + heading->text + "</item>"), std::string::npos) << number << heading->text;
  }
  EXPECT_GT(section, 5);
}

TEST(Pdf, EqualReportsGiveEqualBytes) {
  const auto again = sample() / "again.pdf";
  EXPECT_EQ(
      shell("TZ=Asia/Tokyo LC_ALL=C PYTHONHASHSEED=7 " + kProgram + sample().source() + " --out " + again).exit_code,
      0);
  EXPECT_EQ(content_of(again), content_of(sample().pdf("en")));
  EXPECT_NE(content_of(sample().pdf("de")), content_of(again));
}

TEST(Pdf, UsesSourceDateEpoch) {
  const auto dated = sample() / "dated.pdf";
  EXPECT_EQ(shell("SOURCE_DATE_EPOCH=86400 " GYROTHERM_PDF " " + sample().source() + " --out " + dated).exit_code, 0);
  EXPECT_NE(shell("TZ=UTC pdfinfo -isodates " + dated).out.find("1970-01-02T00:00:00Z"), std::string::npos);
}

TEST(Pdf, KeepsEveryByteWhenSigned) {
  if (!installed("certutil")) GTEST_SKIP() << "libnss3-tools is not installed";
  const auto keys = sample() / "keys", made = sample().pdf("en"), signed_pdf = sample() / "signed.pdf";
  std::filesystem::create_directory(keys);
  std::ofstream(sample() / "noise") << std::string(64, 'n');
  ASSERT_EQ(shell("certutil -N -d " + keys + " --empty-password && certutil -S -d " + keys +
                  " -n lab -s 'CN=Laboratory' -x"
                  " -t CTu,Cu,Cu -g 2048 -z " +
                  (sample() / "noise"))
                .exit_code,
            0);
  shell("pdfsig -nssdir " + keys + " -sign 1 -nick lab " + made + " " + signed_pdf);
  const auto judged = shell("pdfsig -nssdir " + keys + " " + signed_pdf).out;
  EXPECT_NE(judged.find("Signature is Valid"), std::string::npos) << judged;
  EXPECT_NE(judged.find("Total document signed"), std::string::npos) << judged;
  EXPECT_TRUE(content_of(signed_pdf).starts_with(content_of(made)));
  EXPECT_LT(content_of(signed_pdf).size(), content_of(made).size() + 20'000) << "no font came with it";
}

/// A report with extremely long names, tables of hundreds of rows, and no number.
CalibrationReport hard_report() {
  auto report = sample_calibration();
  report.state = ReportState::draft;
  report.number.clear();
  report.issued.clear();
  report.customer.name = std::string(300, 'W');
  report.laboratory.name = std::string(120, 'M') + " Größenordnung";
  report.item.description = {"fine office flow " + std::string(400, 'x'), ""};
  for (int k = 0; k < 300; ++k)
    report.deviations.push_back({.utc = "2026-11-12T08:00:00Z", .kind = "note", .text = "note " + std::to_string(k)});
  std::string endless;
  for (int k = 0; k < 4000; ++k) endless += "word" + std::to_string(k) + " ";
  report.deviations.push_back({.utc = "2026-11-12T09:00:00Z", .kind = "note", .text = endless});
  return report;
}

/// Returns the words outside the sheet, or over its header or footer, from the boxes of pdftotext.
std::vector<std::string> words_outside(const std::string& pdf) {
  std::istringstream boxes(shell("pdftotext -bbox " + pdf + " -").out);
  std::vector<std::string> outside;
  for (std::string line; std::getline(boxes, line);) {
    const auto number = [&](const std::string& name) {
      const auto at = line.find(name + "=\"");
      return at == std::string::npos ? -1.0 : std::stod(line.substr(at + name.size() + 2));
    };
    if (line.find("<word") == std::string::npos) continue;
    const bool is_turned = number("yMax") - number("yMin") > 40;  // the mark across the page
    if (is_turned) continue;
    if (number("xMin") < 50 || number("xMax") > 595 - 50 || number("yMax") > 842 - 24) outside.push_back(line);
  }
  return outside;
}

TEST(Pdf, KeepsLongTextsInsideSheet) {
  const RenderedReport made(hard_report());
  EXPECT_EQ(made.remarks(), "");
  for (const std::string language : {"en", "de"}) {
    EXPECT_EQ(words_outside(made.pdf(language)), std::vector<std::string>{});
    const auto text = text_in(made.pdf(language));
    for (const auto* word : {"word0 ", "word2000 ", "word3999", "note 299"})
      EXPECT_NE(text.find(word), std::string::npos) << word;
    std::size_t letters = 0;
    for (const auto& word : split_words(text))  // a single letter belongs to the turned mark "ENTWURF" of a figure
      if (word.size() > 1 && word.find_first_not_of('W') == std::string::npos) letters += word.size();
    EXPECT_EQ(letters, 600u) << "the customer is named twice";
    EXPECT_EQ(shell("pdfsig " + made.pdf(language)).out.find("not signed"), std::string::npos)
        << "a draft is not signed";
  }
  EXPECT_EQ(words_outside(sample().pdf("de")), std::vector<std::string>{});
}

TEST(Pdf, NamesCharactersMissingFromFonts) {
  auto report = sample_calibration();
  report.customer.name = "\U0001E900";  // Adlam
  const RenderedReport made(report);
  EXPECT_TRUE(made.remarks().empty() || made.remarks().find("U+1E900") != std::string::npos) << made.remarks();
  EXPECT_TRUE(std::filesystem::exists(made.pdf("en")));
}

/// Private and unassigned characters have no glyph in any font.
TEST(Pdf, NamesCharactersWithoutGlyph) {
  const std::array<std::pair<const char*, const char*>, 4> all{
      {{"\uE777", "U+E777"}, {"\U000E0FFF", "U+E0FFF"}, {"\U0010FFF0", "U+10FFF0"}, {"\u0378", "U+0378"}}};
  auto report = sample_calibration();
  for (const auto& [letter, name] : all) report.customer.name += letter;
  report.item.description = {"\uE778", "\uE779"};
  const RenderedReport made(report);
  for (const auto& [letter, name] : all) EXPECT_NE(made.remarks().find(name), std::string::npos) << made.remarks();
  for (const char* name : {"U+E778", "U+E779", "they are omitted; install fonts-noto-cjk"})
    EXPECT_NE(made.remarks().find(name), std::string::npos) << made.remarks();
}

TEST(Pdf, DemandsNoFontForInvisibleCharacters) {
  auto report = sample_calibration();
  report.customer.name = "House\u00a0of\u200b Gyros\u2028\ufe0f";
  EXPECT_EQ(RenderedReport(report).remarks(), "");
}

TEST(Pdf, OmitsBrokenLogoWithRemark) {
  auto report = sample_calibration();
  report.logo =
      Logo{.media_type = "image/svg+xml", .base64 = plot::base64("<svg><image href=\"http://a/b.png\"/></svg>")};
  const RenderedReport made(report);
  EXPECT_NE(made.remarks().find("laboratory.logo"), std::string::npos) << made.remarks();
  EXPECT_TRUE(std::filesystem::exists(made.pdf("en")));
}

TEST(PdfProgram, ReportsErrorsInOneSentenceWithExitCode) {
  const auto& made = sample();
  const auto out = " --out " + (made / "no.pdf");
  EXPECT_EQ(shell(kProgram).exit_code, 2);
  EXPECT_EQ(shell(kProgram + made.source()).exit_code, 2) << "no --out";
  EXPECT_EQ(shell(kProgram + made.source() + " --language fr" + out).exit_code, 2);
  EXPECT_EQ(shell(kProgram + made.source() + " --out " + made.pdf("en")).exit_code, 2) << "it is there";
  EXPECT_EQ(shell(kProgram + made.source() + " --force --out " + made.pdf("en")).exit_code, 0);
  EXPECT_EQ(shell(kProgram + "/nowhere.json" + out).exit_code, 4);
  std::ofstream(made / "wrong.json") << "{\"schema\": \"gyrotherm-calibration/1\",\n}";
  const auto wrong = shell(kProgram + (made / "wrong.json") + out);
  EXPECT_EQ(wrong.exit_code, 4);
  EXPECT_NE(wrong.out.find("wrong.json"), std::string::npos) << wrong.out;
  EXPECT_EQ(std::count(wrong.out.begin(), wrong.out.end(), '\n'), 1) << wrong.out;
  EXPECT_EQ(shell(kProgram + made.source() + " --out /nowhere/report.pdf").exit_code, 4);
  EXPECT_FALSE(std::filesystem::exists(made / "no.pdf"));
}

TEST(PdfProgram, RefusesToReplaceOtherFiles) {
  const auto& made = sample();
  const auto record = made / "run.db";
  const std::string bytes = "SQLite format 3 and a week of measurements";
  std::ofstream(record) << bytes;
  const auto ran = shell(kProgram + made.source() + " --force --out " + record);
  EXPECT_EQ(ran.exit_code, 2) << ran.out;
  EXPECT_EQ(content_of(record), bytes);
  std::ofstream(record, std::ios::trunc).close();
  EXPECT_EQ(shell(kProgram + made.source() + " --force --out " + record).exit_code, 0) << "an empty file";
}

TEST(PdfProgram, HelpOpensWithAnExample) {
  const auto help = shell(kProgram + "--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_TRUE(help.out.starts_with("Example: gyrotherm-pdf")) << help.out;
}

TEST(PdfProgram, WritesPngOfRequestedWidth) {
  const auto& made = sample();
  for (const Block& block : made.document("en").blocks) {
    const auto* figure = std::get_if<DocumentFigure>(&block);
    if (figure == nullptr) continue;
    std::ofstream(made / "figure.svg") << figure->svg;
    const auto png = made / "figure.png";
    const auto ran = shell(kProgram + "--force --png " + (made / "figure.svg") + " --width 800 --out " + png);
    EXPECT_EQ(ran.exit_code, 0) << ran.out;
    const auto bytes = content_of(png);
    ASSERT_GT(bytes.size(), 1000u);
    EXPECT_EQ(bytes.substr(1, 3), "PNG");
    EXPECT_EQ(bytes.substr(16, 4), std::string("\0\0\x03\x20", 4));
  }
  std::ofstream(made / "no.svg") << "<svg";
  EXPECT_EQ(shell(kProgram + "--png " + (made / "no.svg") + " --out " + (made / "no.png")).exit_code, 4);
}

}  // namespace
}  // namespace gyrotherm::pdf
