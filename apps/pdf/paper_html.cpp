// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/paper_html.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <ctime>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "report/html_page.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::pdf {
namespace {

using plot::escaped;
using report::Cell;
using report::Definitions;
using report::Document;
using report::DocumentFigure;
using report::DocumentTable;
using report::Heading;
using report::KeyFigures;
using report::Paragraph;

constexpr double kTextWidthPt = 174 / 25.4 * 72;
constexpr double kBold = 1.17;  ///< width ratio, bold to regular

double count_letters(std::string_view text) {
  return static_cast<double>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

/// Estimates the width of a text in DejaVu Sans, as a multiple of the font size. The estimate is about 3 % too large.
double estimate_width(std::string_view text) {
  double width = 0;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0) == 0x80) continue;  // continuation byte
    if (static_cast<unsigned char>(c) == 0xE2)                     // narrow blanks, dashes, signs
      width += 0.6;
    else if (std::string_view("ijl").find(c) != std::string_view::npos)
      width += 0.29;
    else if (std::string_view(" .,:;-/()frt").find(c) != std::string_view::npos)
      width += 0.4;
    else if (std::string_view("mwMW%").find(c) != std::string_view::npos)
      width += 0.95;
    else
      width += std::isupper(static_cast<unsigned char>(c)) != 0 ? 0.71 : 0.64;
  }
  return width;
}

/// Calls `visit` with each word and each separator (blank or line break) of a text, in order.
template <class Visit>
void for_each_word(std::string_view text, Visit visit) {
  while (!text.empty()) {
    const std::size_t end = text.find_first_of(" \n");
    visit(text.substr(0, end));
    if (end == std::string_view::npos) return;
    visit(text.substr(end, 1));
    text.remove_prefix(end + 1);
  }
}

double longest_word(std::string_view text, double (&measure)(std::string_view)) {
  double longest = 0;
  for_each_word(text, [&](std::string_view word) { longest = std::max(longest, measure(word)); });
  return longest;
}

/// Escapes a text. Prevents line breaks inside a short word that contains a slash or hyphen, such as "°/h" or "A-D".
std::string text_to_html(std::string_view text) {
  constexpr double kMaxUnbrokenLetters = 16;
  std::string html;
  for_each_word(text, [&](std::string_view word) {
    const bool is_unbreakable =
        word.find_first_of("/-") != std::string_view::npos && count_letters(word) <= kMaxUnbrokenLetters;
    html += is_unbreakable ? "<span class=\"whole\">" + escaped(word) + "</span>" : escaped(word);
  });
  return html;
}

struct Mark {
  const char *sign, *style;
};

/// Returns sign and style of a verdict. The sign makes it readable without colours.
Mark mark_style(Cell::Mark mark) {
  switch (mark) {
    case Cell::Mark::none: break;
    case Cell::Mark::pass: return {"✓", "pass"};
    case Cell::Mark::caution: return {"▲", "care"};
    case Cell::Mark::fail: return {"✗", "fail"};
  }
  return {"", ""};
}

/// Returns true if a note is printed on one line wherever the table is wide enough.
bool is_short_note(std::string_view note) { return count_letters(note) <= 32; }

std::string cell_to_html(const Cell& cell) {
  std::string html = text_to_html(cell.text);
  if (const auto [sign, style] = mark_style(cell.mark); *sign != '\0')
    html = fmt::format("<span class=\"{}\">{}\u00a0{}</span>", style, sign, html);
  if (!cell.note.empty())
    html += fmt::format("<div class=\"cell-note{}\">{}</div>", is_short_note(cell.note) ? " brief" : "",
                        text_to_html(cell.note));
  return html;
}

/// Returns the minimum width of a cell, as a multiple of the font size. Words, numbers and short notes are not broken.
double min_width(const Cell& cell, bool is_text) {
  constexpr double kNote = 0.86;  // size ratio, note to cell
  const double bold = cell.mark == Cell::Mark::none ? 1 : kBold, sign = cell.mark == Cell::Mark::none ? 0 : 1.2;
  const double text = is_text ? longest_word(cell.text, estimate_width) : estimate_width(cell.text);
  const double note = is_short_note(cell.note) ? estimate_width(cell.note) : longest_word(cell.note, estimate_width);
  return std::max(sign + bold * text, kNote * note);
}

/// Returns the CSS class of the largest font size at which all columns fit. If none of the three sizes fits, returns
/// "crowded", the class with the smallest size, in which any word may break. Very long words may break at every size.
const char* size_class(const DocumentTable& table) {
  constexpr double kMaxTextColumnWidth = 18;
  double width = 0;
  for (std::size_t k = 0; k < table.header.size(); ++k) {
    double widest = kBold * longest_word(table.header[k], estimate_width);
    for (const auto& row : table.rows) widest = std::max(widest, min_width(row[k], k < table.text_columns));
    width += k < table.text_columns ? std::min(kMaxTextColumnWidth, widest) : widest;
  }
  const double available_pt = kTextWidthPt - 3 / 25.4 * 72 * static_cast<double>(table.header.size() - 1);
  for (const auto& [name, size] : {std::pair("large", 8.0), std::pair("medium", 7.2), std::pair("small", 6.4)})
    if (width * size <= available_pt) return name;
  return "crowded";
}

/// Returns the font size in points at which a key value fills its cell on one line. `available_pt` is the cell width.
double key_size(const KeyFigures::Entry& one, double available_pt) {
  constexpr double kLargest = 14, kSmallest = 7, kUnit = 7.6;
  const double value_pt = available_pt - kUnit * (estimate_width(one.unit) + 0.4);
  return std::clamp(value_pt / (kBold * std::max(1.0, estimate_width(one.value))), kSmallest, kLargest);
}

/// Converts the blocks of a document to HTML and numbers its headings: 1, 1.1.
class PaperWriter {
 public:
  explicit PaperWriter(const Document& document) {
    for (const report::Block& block : document.blocks) std::visit(*this, block);
  }

  [[nodiscard]] std::string html() && { return std::move(html_); }

  void operator()(const Heading& heading) {
    if (!heading.sub) ++section_;
    subsection_ = heading.sub ? subsection_ + 1 : 0;
    const std::string number = heading.sub ? fmt::format("{}.{}", section_, subsection_) : std::to_string(section_);
    html_ += fmt::format("<h{0} data-bookmark=\"{1}  {2}\"><span class=\"number\">{1}</span> {3}</h{0}>\n",
                         heading.sub ? 3 : 2, number, escaped(heading.text), text_to_html(heading.text));
  }

  void operator()(const Paragraph& paragraph) {
    constexpr const char* kStyles[] = {"plain", "note", "caution"};
    html_ += fmt::format("<p class=\"{}\">{}</p>\n", kStyles[static_cast<std::size_t>(paragraph.style)],
                         text_to_html(paragraph.text));
  }

  void operator()(const Definitions& definitions) {
    html_ += "<table class=\"definitions\">\n";
    for (const auto& [what, value] : definitions.lines)
      html_ += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", text_to_html(what), text_to_html(value));
    html_ += "</table>\n";
  }

  void operator()(const KeyFigures& keys) {
    constexpr std::size_t kMaxPerRow = 4;
    if (keys.figures.empty()) return;
    if (!keys.title.empty()) html_ += "<p class=\"keys-title\">" + text_to_html(keys.title) + "</p>\n";
    const std::size_t rows = (keys.figures.size() + kMaxPerRow - 1) / kMaxPerRow;
    const std::size_t per_row = (keys.figures.size() + rows - 1) / rows;
    html_ += "<table class=\"keys\">\n";
    for (std::size_t k = 0; k < keys.figures.size(); ++k) {
      if (k % per_row == 0) html_ += k == 0 ? "<tr>" : "</tr>\n<tr>";
      add_key(keys.figures[k], per_row);
    }
    html_ += "</tr>\n</table>\n";
  }

  void operator()(const DocumentTable& table) {
    // A table of up to kUnsplitRows rows stays on one page, and of a longer one the first and last kRowsTogether rows.
    constexpr std::size_t kUnsplitRows = 5, kRowsTogether = 3;
    if (table.header.empty()) return;
    html_ += fmt::format("<div class=\"results {}{}\">\n", size_class(table),
                         table.rows.size() <= kUnsplitRows ? " short" : "");
    if (!table.caption.empty()) html_ += "<p class=\"caption\">" + text_to_html(table.caption) + "</p>\n";
    html_ += "<table><thead><tr>";
    for (std::size_t k = 0; k < table.header.size(); ++k)
      html_ += fmt::format("<th{}>{}</th>", cell_class(table, k, table.header[k]), text_to_html(table.header[k]));
    html_ += "</tr></thead>\n<tbody>\n";
    // WeasyPrint splits a table between any rows, but not a group of rows that avoids breaks.
    const auto last = table.rows.size() - std::min(table.rows.size(), kRowsTogether);
    for (std::size_t k = 0; k < table.rows.size(); ++k) {
      if (table.rows.size() > kUnsplitRows && (k == kRowsTogether || k == last)) html_ += "</tbody>\n<tbody>\n";
      add_row(table, table.rows[k]);
    }
    html_ += "</tbody>\n</table></div>\n";
  }

  void operator()(const DocumentFigure& figure) {
    html_ += fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", figure.svg, text_to_html(figure.caption));
  }

 private:
  /// Returns the class of a cell. Long words such as hashes may break anywhere.
  static const char* cell_class(const DocumentTable& table, std::size_t column, std::string_view text) {
    constexpr double kMaxUnbrokenLetters = 30;
    if (column >= table.text_columns) return " class=\"n\"";
    return longest_word(text, count_letters) > kMaxUnbrokenLetters ? " class=\"long\"" : "";
  }

  void add_row(const DocumentTable& table, const std::vector<Cell>& row) {
    html_ += "<tr>";
    for (std::size_t k = 0; k < row.size(); ++k)
      html_ +=
          fmt::format("<td{}>{}</td>", cell_class(table, k, row[k].text + "\n" + row[k].note), cell_to_html(row[k]));
    html_ += "</tr>\n";
  }

  void add_key(const KeyFigures::Entry& one, std::size_t per_row) {
    const double available_pt = kTextWidthPt / static_cast<double>(per_row) - 2 * 3 / 25.4 * 72;
    html_ +=
        fmt::format("<td{}><b style=\"font-size: {:.1f}pt\">{}</b> <span class=\"unit\">{}</span><div>{}</div></td>",
                    one.best ? " class=\"best\"" : "", key_size(one, available_pt), text_to_html(one.value),
                    text_to_html(one.unit), text_to_html(one.label));
  }

  std::string html_{};
  int section_ = 0, subsection_ = 0;
};

/// Truncates a text to the width of a page margin, with "…". The first page contains the whole text.
std::string truncate_to_margin(std::string_view text) {
  // Width of the margin, in multiples of the font size.
  constexpr double kMaxWidth = 24;
  if (estimate_width(text) <= kMaxWidth) return std::string(text);
  while (estimate_width(text) > kMaxWidth - 1) {
    while ((static_cast<unsigned char>(text.back()) & 0xC0) == 0x80) text.remove_suffix(1);
    text.remove_suffix(1);
  }
  return std::string(text) + "…";
}

/// Returns the texts in the margins of every page; paper.css defines their appearance.
std::string margin_style(const Document& document, const PaperFacts& facts) {
  const auto source = facts.source_sha256.empty() ? "" : facts.source + " SHA-256 " + facts.source_sha256;
  return fmt::format(
      "@page {{ @top-left {{ content: {} }} @top-center {{ content: {} }} @top-right {{ content: {} }}\n"
      "@bottom-left {{ content: {} }} @bottom-center {{ content: {} }} @bottom-right {{ content: {} }} }}",
      report::css_string(truncate_to_margin(document.laboratory)), report::css_string(document.mark),
      report::css_string(truncate_to_margin(document.number)), report::css_string(facts.program),
      report::css_string(source), report::page_counter(document.page_of));
}

std::string meta_element(std::string_view name, std::string_view content) {
  return fmt::format("<meta name=\"{}\" content=\"{}\"/>\n", name, escaped(content));
}

std::string head_html(const Document& document, const PaperFacts& facts) {
  std::string html = fmt::format("<title>{} {}</title>\n", escaped(document.title), escaped(document.number));
  html += meta_element("author", document.laboratory) + meta_element("generator", facts.program);
  if (!facts.source_sha256.empty()) html += meta_element("keywords", facts.source + " sha256:" + facts.source_sha256);
  if (facts.utc_s) {
    const auto day = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(*facts.utc_s)));
    html += meta_element("dcterms.created", day) + meta_element("dcterms.modified", day);
  }
  return html + "<style>" + margin_style(document, facts) + "</style>\n";
}

/// Returns the mark that is printed diagonally across each page, behind the text, as large as fits.
std::string mark_html(const std::string& mark) {
  constexpr double kLargestPt = 90, kLongestPt = 265 / 25.4 * 72;
  if (mark.empty()) return {};
  // Capitals are about 0.78 font sizes wide.
  const double size = std::min(kLargestPt, kLongestPt / (0.78 * count_letters(mark)));
  return fmt::format("<div class=\"mark\" style=\"font-size: {:.0f}pt\">{}</div>\n", size, escaped(mark));
}

}  // namespace

std::string paper_html(const Document& document, const PaperFacts& facts) {
  std::string html = fmt::format("<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\"/>\n{}</head>\n",
                                 report::code(document.language), head_html(document, facts));
  html += "<body>\n" + mark_html(document.mark) + "<header>";
  if (document.logo && !document.logo->base64.empty())
    html += fmt::format("<img alt=\"\" src=\"data:{};base64,{}\"/>", escaped(document.logo->media_type),
                        escaped(document.logo->base64));
  html += fmt::format("<p class=\"laboratory\">{}</p>\n<h1>{}</h1>\n<p class=\"report-number\">{}</p></header>\n",
                      text_to_html(document.laboratory), text_to_html(document.title), text_to_html(document.number));
  return html + PaperWriter(document).html() + "<p class=\"end\">— " + text_to_html(document.end) +
         " —</p>\n</body>\n</html>\n";
}

}  // namespace gyrotherm::pdf
