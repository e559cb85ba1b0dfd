// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "report/document.hpp"
#include "report/document_chart.hpp"
#include "report/html_page.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::report {
namespace {

using plot::escaped;

constexpr const char* kScreenStyle = R"css(
:root { --ink: #1d2733; --faint: #525c68; --line: #d5dae0; --accent: #0b4f8a; --mark: #a8371b; --good: #006b4c; }
* { box-sizing: border-box; }
html { scroll-padding-top: 48px; -webkit-text-size-adjust: 100%; }
body { margin: 0; background: #eef0f2; color: var(--ink); overflow-wrap: anywhere;
  font: 15px/1.5 "Source Sans 3", "Helvetica Neue", Helvetica, Arial, "Liberation Sans", "DejaVu Sans", sans-serif; }
a { color: var(--accent); }
.skip { position: absolute; left: -9999px; }
.skip:focus { left: 8px; top: 8px; z-index: 5; background: #fff; padding: 6px 10px; }
.banner { position: sticky; top: 0; z-index: 4; background: var(--mark); color: #fff; text-align: center;
  padding: 6px 16px; font-weight: 600; font-size: 13px; letter-spacing: .14em; }
.watermark { display: none; }
.sheet { max-width: 940px; margin: 24px auto 56px; padding: 40px 52px 48px; background: #fff;
  box-shadow: 0 1px 3px rgba(20, 30, 40, .14); }
.letterhead { display: flex; flex-wrap: wrap; gap: 20px; align-items: flex-start; justify-content: space-between; }
.letterhead div { flex: 1 1 280px; }
.letterhead img { max-height: 64px; max-width: 180px; margin-bottom: 14px; }
.kind { margin: 0 0 6px; color: var(--faint); font-size: 14px; }
h1 { font-size: 27px; line-height: 1.2; font-weight: 600; margin: 0 0 4px; }
.report-number { margin: 0 0 18px; color: var(--faint); font-variant-numeric: tabular-nums; }
h2 { font-size: 19px; font-weight: 600; margin: 40px 0 12px; padding-top: 10px; border-top: 2px solid var(--ink); }
h3 { font-size: 16px; font-weight: 600; margin: 26px 0 8px; }
h2 .number, h3 .number { color: var(--faint); font-weight: 400; margin-right: .6em; }
p { margin: 0 0 12px; max-width: 76ch; hyphens: auto; }
.note { color: var(--faint); font-size: 13.5px; line-height: 1.45; }
.caution { border-left: 4px solid var(--mark); padding: 7px 12px; background: #fbf3f0; max-width: none; }
.contents { border: 1px solid var(--line); border-radius: 3px; padding: 10px 16px 12px; margin: 22px 0 0;
  font-size: 14px; }
.contents-title { font-weight: 600; margin: 0 0 4px; }
.contents ol { list-style: none; margin: 0; padding: 0; columns: 2; column-gap: 28px; }
.contents li { break-inside: avoid; padding: 2px 0; }
.contents .number { display: inline-block; min-width: 1.8em; color: var(--faint); }
dl { display: grid; grid-template-columns: minmax(110px, 190px) 1fr; margin: 0 0 18px; padding: 8px 0;
  border-top: 1px solid var(--line); border-bottom: 1px solid var(--line); font-size: 14.5px; }
dt { color: var(--faint); padding: 2px 14px 2px 0; hyphens: auto; }
dd { margin: 0; padding: 2px 0; white-space: pre-line; }
.keys-title { font-size: 14px; font-weight: 600; margin: 16px 0 4px; }
.keys { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 205px), 1fr)); margin: 4px 0 14px;
  border: 1px solid var(--line); border-radius: 3px; overflow: hidden; }
.key { padding: 12px 10px; box-shadow: -1px -1px 0 var(--line); }
.key .value { font-size: 16px; font-weight: 600; font-variant-numeric: tabular-nums; white-space: nowrap; }
.key .unit { color: var(--faint); font-size: 13px; margin-left: 4px; }
.key .label { display: block; color: var(--faint); font-size: 12.5px; line-height: 1.35; margin-top: 2px; }
.key.best { background: #eef6f2; border-top: 3px solid var(--good); }
.key.best .value { color: var(--good); }
.scroll { overflow-x: auto; margin: 16px 0 20px; }
.scroll:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; line-height: 1.4;
  font-variant-numeric: tabular-nums lining-nums; overflow-wrap: normal; }
caption { text-align: left; color: var(--faint); font-size: 13px; padding-bottom: 6px; }
caption span { display: block; position: sticky; left: 0; width: 0; min-width: min(100%, 100vw - 32px); }
caption b, figcaption b { color: var(--ink); margin-right: .3em; }
thead th { font-weight: 600; text-align: left; vertical-align: bottom; border-top: 1.5px solid var(--ink);
  border-bottom: 1px solid var(--ink); padding: 6px 14px 6px 0; hyphens: auto; }
tbody th, td { text-align: left; font-weight: 400; padding: 4px 14px 4px 0; border-bottom: 1px solid #e6eaee;
  vertical-align: top; }
tbody tr:last-child > * { border-bottom: 1.5px solid var(--ink); }
thead th.n, td.n, tbody th.n { text-align: right; padding-left: 10px; padding-right: 4px; }
td.n, tbody th.n { white-space: nowrap; }
td.long, th.long { overflow-wrap: anywhere; min-width: 15ch; }
.cell-note { display: block; color: var(--faint); font-size: 11.5px; }
.sign { font-weight: 700; margin-right: .35em; }
.pass { color: var(--good); font-weight: 600; } .fail { color: var(--mark); font-weight: 600; }
.care { color: #7a4a00; font-weight: 600; }
figure { margin: 20px 0 26px; break-inside: avoid; }
figcaption { font-size: 13px; line-height: 1.45; color: var(--faint); margin-top: 6px; }
.static { overflow-x: auto; }
/* A shade at an edge shows that the box continues there. The covers in the first two layers move with the content. */
.scroll, .static { background: linear-gradient(to right, #fff 30%, transparent) left / 30px 100% no-repeat local,
  linear-gradient(to left, #fff 30%, transparent) right / 30px 100% no-repeat local,
  linear-gradient(to right, rgba(0, 0, 0, .2), transparent) left / 11px 100% no-repeat scroll,
  linear-gradient(to left, rgba(0, 0, 0, .2), transparent) right / 11px 100% no-repeat scroll; }
.narrow { display: none; }
.static svg { width: 100%; min-width: 540px; height: auto; display: block; }
.chart, .chart-legend, .zoom-note { display: none; }
.live .chart { display: block; width: 100%; height: 300px; font-size: 12px; overflow-wrap: normal; }
.live .chart-legend { display: block; font-size: 12.5px; min-height: 1.5em; line-height: 1.5; }
.live .chart-legend i { display: inline-block; width: 22px; vertical-align: middle; }
.live .chart-legend { overflow-wrap: normal; }
.live .chart-legend span { display: inline-block; max-width: 100%; margin-right: 1em; }
.live .chart-legend b { display: inline-block; font-weight: 400; font-variant-numeric: tabular-nums; }
.live .static { display: none; }
.live .zoom-note { display: block; }
@media (pointer: coarse) { .live .zoom-note { display: none; } }
.end { margin: 40px 0 0; padding-top: 10px; border-top: 2px solid var(--ink); text-align: center; font-weight: 600;
  max-width: none; }
@media screen and (max-width: 760px) {
  .sheet { margin: 0; padding: 22px 16px 36px; box-shadow: none; }
  .contents ol { columns: 1; }
  dl { grid-template-columns: 1fr; } dt { padding-top: 7px; font-size: 13px; }
  h1 { font-size: 23px; } .live .chart { height: 240px; }
  .static.wide { display: none; }
  .narrow { display: block; }
  .narrow svg { display: block; width: 100%; max-width: 540px; height: auto; }
}
)css";

constexpr const char* kPrintStyle = R"css(
@media print {
  body { background: #fff; font-size: 9.6pt; line-height: 1.4; }
  .sheet { max-width: none; margin: 0; padding: 0; box-shadow: none; }
  .skip, .contents, .banner { display: none; }
  h1 { font-size: 18pt; } h2 { font-size: 13pt; margin-top: 20pt; } h3 { font-size: 11pt; margin-top: 14pt; }
  h2, h3, caption, .keys-title { break-after: avoid; }
  tr, .keys, .key, .caution, .short { break-inside: avoid; }
  .keys { grid-template-columns: repeat(auto-fit, minmax(112px, 1fr)); }
  p { orphans: 3; widows: 3; max-width: none; }
  dl { font-size: 9.4pt; margin-bottom: 10pt; padding: 4pt 0; } dt, dd { padding-top: 1pt; padding-bottom: 1pt; }
  thead { display: table-header-group; }
  .scroll { overflow: visible; margin: 8pt 0 12pt; background: none; }
  table { font-size: 8pt; } .cell-note { font-size: 7pt; } thead th, tbody th, td { padding-right: 8pt; }
  td.n, tbody th.n { padding-left: 4pt; }
  .note { font-size: 8.6pt; }
  .key .value { font-size: 10pt; } .key .label { font-size: 7.8pt; }
  .key { padding: 5pt 5pt; } .key .unit { font-size: 8pt; }
  .static, .live .static { display: block; overflow: visible; background: none; }
  .static svg { min-width: 0; width: 80%; }
  figure { margin: 8pt 0 12pt; }
  .live .chart, .live .chart-legend, .live .zoom-note, .zoom-note { display: none; }
  .watermark { display: block; position: fixed; top: 40%; left: -10%; right: -10%; text-align: center;
    transform: rotate(-28deg); white-space: nowrap; font-weight: 700; letter-spacing: .06em; color: var(--mark);
    opacity: .08; z-index: 3; }
}
)css";

/// Returns the style of the page margins in print.
std::string sheet_style(const Document& document) {
  constexpr const char* kFont =
      "font: 8pt \"Source Sans 3\", Helvetica, Arial, \"Liberation Sans\", sans-serif; color: #525c68;";
  std::string style = fmt::format(
      "@page {{ size: A4; margin: 20mm 17mm 18mm;\n  @top-left {{ content: {}; {} }}\n"
      "  @bottom-left {{ content: {}; {} }}\n  @bottom-right {{ content: {}; {} }}\n",
      css_string(document.laboratory), kFont, css_string(document.title + " " + document.number), kFont,
      page_counter(document.page_of), kFont);
  if (!document.mark.empty())
    style += fmt::format("  @top-right {{ content: {}; {} color: #a8371b; font-weight: 600; }}\n",
                         css_string(document.mark), kFont);
  return style + "}\n";
}

const char* mark_sign(Cell::Mark mark) {
  switch (mark) {
    case Cell::Mark::none: return "";
    case Cell::Mark::pass: return "✓";
    case Cell::Mark::caution: return "▲";
    case Cell::Mark::fail: return "✗";
  }
  return "";
}

const char* mark_class(Cell::Mark mark) {
  switch (mark) {
    case Cell::Mark::none: return "";
    case Cell::Mark::pass: return "pass";
    case Cell::Mark::caution: return "care";
    case Cell::Mark::fail: return "fail";
  }
  return "";
}

std::string cell_html(const Cell& cell) {
  std::string html = escaped(cell.text);
  if (cell.mark != Cell::Mark::none)
    html = fmt::format("<span class=\"{}\"><span class=\"sign\" aria-hidden=\"true\">{}</span>{}</span>",
                       mark_class(cell.mark), mark_sign(cell.mark), html);
  if (!cell.note.empty()) html += "<span class=\"cell-note\">" + escaped(cell.note) + "</span>";
  return html;
}

/// Returns true if a word is too long for a column, such as a hash. Such a word may break anywhere.
bool has_long_word(std::string_view text) {
  constexpr std::size_t kMaxUnbrokenLetters = 30;
  std::size_t length = 0;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0) == 0x80) continue;
    length = c == ' ' || c == '\n' ? 0 : length + 1;
    if (length > kMaxUnbrokenLetters) return true;
  }
  return false;
}

std::string row_html(const std::vector<Cell>& row, std::size_t text_columns) {
  std::string html = "<tr>";
  for (std::size_t k = 0; k < row.size(); ++k) {
    std::string classes = k < text_columns ? "" : "n";
    if (k < text_columns && (has_long_word(row[k].text) || has_long_word(row[k].note))) classes = "long";
    const std::string attribute = classes.empty() ? "" : " class=\"" + classes + "\"";
    html += k == 0 ? fmt::format("<th scope=\"row\"{}>{}</th>", attribute, cell_html(row[k]))
                   : fmt::format("<td{}>{}</td>", attribute, cell_html(row[k]));
  }
  return html + "</tr>\n";
}

/// Returns "Table 3: Budget" with the number in bold.
std::string caption_html(const std::string& caption) {
  const auto colon = caption.find(": ");
  if (colon == std::string::npos) return escaped(caption);
  return "<b>" + escaped(caption.substr(0, colon + 1)) + "</b> " + escaped(caption.substr(colon + 2));
}

/// Writes the body of the page, block by block.
class BodyWriter {
 public:
  explicit BodyWriter(const Document& document) : document_(document) {
    constexpr std::size_t kMostPoints = 4000, kPointsOfThePage = 160'000;
    std::size_t lines = 0;
    for (const Block& block : document.blocks)
      if (const auto* figure = std::get_if<DocumentFigure>(&block)) lines += figure->data.lines.size();
    most_points_ = std::clamp<std::size_t>(kPointsOfThePage / std::max<std::size_t>(1, lines), 400, kMostPoints);
    for (const Block& block : document.blocks) std::visit(*this, block);
    close_section();
  }

  [[nodiscard]] bool has_charts() const { return has_charts_; }
  /// Returns the body with the table of contents after the first section.
  [[nodiscard]] std::string html() const {
    const std::size_t at = first_end_ == 0 ? html_.size() : first_end_;
    return html_.substr(0, at) + contents_html() + html_.substr(at);
  }

  void operator()(const Heading& heading) {
    if (heading.sub) {
      ++sub_;
      const std::string number = fmt::format("{}.{}", section_, sub_);
      html_ += fmt::format("<h3 id=\"{}\"><span class=\"number\">{}</span>{}</h3>\n", escaped(heading.id), number,
                           escaped(heading.text));
      return;
    }
    close_section();
    ++section_;
    sub_ = 0;
    const std::string id = heading.id.empty() ? fmt::format("section-{}", section_) : escaped(heading.id);
    contents_ += fmt::format("<li><a href=\"#{}\"><span class=\"number\">{}</span>{}</a></li>\n", id, section_,
                             escaped(heading.text));
    html_ +=
        fmt::format("<section aria-labelledby=\"{0}\">\n<h2 id=\"{0}\"><span class=\"number\">{1}</span>{2}</h2>\n", id,
                    section_, escaped(heading.text));
    open_ = true;
  }
  void operator()(const Paragraph& paragraph) {
    using Style = Paragraph::Style;
    const char* style = paragraph.style == Style::note      ? " class=\"note\""
                        : paragraph.style == Style::caution ? " class=\"caution\" role=\"note\""
                                                            : "";
    html_ += fmt::format("<p{}>{}</p>\n", style, escaped(paragraph.text));
  }
  void operator()(const Definitions& definitions) {
    if (definitions.lines.empty()) return;
    html_ += "<dl>\n";
    for (const auto& [what, value] : definitions.lines)
      html_ += "<dt>" + escaped(what) + "</dt><dd>" + escaped(value) + "</dd>\n";
    html_ += "</dl>\n";
  }
  void operator()(const KeyFigures& keys) {
    if (!keys.title.empty()) html_ += "<p class=\"keys-title\">" + escaped(keys.title) + "</p>\n";
    html_ += "<div class=\"keys\">\n";
    for (const KeyFigures::Entry& one : keys.figures)
      html_ += fmt::format(
          "<div class=\"key{}\"><span class=\"value\">{}</span><span class=\"unit\">{}</span>"
          "<span class=\"label\">{}</span></div>\n",
          one.best ? " best" : "", escaped(one.value), escaped(one.unit), escaped(one.label));
    html_ += "</div>\n";
  }
  void operator()(const DocumentTable& table) {
    // Tables of up to this number of rows are not split between sheets.
    constexpr std::size_t kShort = 16;
    html_ += fmt::format(
        "<div class=\"scroll{}\" role=\"region\" tabindex=\"0\" "
        "aria-label=\"{}\"><table>\n<caption><span>{}</span></caption>\n"
        "<thead><tr>",
        table.rows.size() <= kShort ? " short" : "", escaped(table.caption), caption_html(table.caption));
    for (std::size_t k = 0; k < table.header.size(); ++k)
      html_ += fmt::format("<th scope=\"col\"{}>{}</th>", k < table.text_columns ? "" : " class=\"n\"",
                           escaped(table.header[k]));
    html_ += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) html_ += row_html(row, table.text_columns);
    html_ += "</tbody>\n</table></div>\n";
  }
  void operator()(const DocumentFigure& figure) {
    const bool enlargeable = can_be_enlarged(figure.data);
    has_charts_ = has_charts_ || enlargeable;
    html_ += fmt::format("<figure id=\"{}\"{}>\n", escaped(figure.id), enlargeable ? " class=\"enlargeable\"" : "");
    if (enlargeable)
      html_ += fmt::format(
          "<div class=\"chart-legend\"></div><div class=\"chart\" role=\"img\" aria-label=\"{}\"></div>\n"
          "<script type=\"application/json\">{}</script>\n",
          escaped(figure.caption), chart_data(figure.data, document_.language, most_points_, document_.mark));
    html_ += fmt::format("<div class=\"static{}\" role=\"group\" tabindex=\"0\" aria-label=\"{}\">{}</div>\n",
                         figure.narrow_svg.empty() ? "" : " wide", escaped(figure.caption), figure.svg);
    if (!figure.narrow_svg.empty()) html_ += "<div class=\"narrow\">" + figure.narrow_svg + "</div>\n";
    html_ += "<figcaption>" + caption_html(figure.caption);
    if (enlargeable)
      html_ += " <span class=\"zoom-note\">" + escaped(translate(document_.language, "page.zoom")) + "</span>";
    html_ += "</figcaption>\n</figure>\n";
  }

 private:
  void close_section() {
    if (!open_) return;
    html_ += "</section>\n";
    open_ = false;
    if (first_end_ == 0) first_end_ = html_.size();
  }
  [[nodiscard]] std::string contents_html() const {
    const std::string title = escaped(translate(document_.language, "title.contents"));
    return fmt::format(
        "<nav class=\"contents\" aria-label=\"{0}\">\n<p class=\"contents-title\">{0}</p>\n<ol>\n{1}</ol>\n</nav>\n",
        title, contents_);
  }

  const Document& document_;
  std::size_t most_points_{};
  int section_ = 0, sub_ = 0;
  bool open_ = false, has_charts_ = false;
  std::size_t first_end_ = 0;
  std::string html_{}, contents_{};
};

std::string letterhead_html(const Document& document) {
  std::string html = fmt::format("<header class=\"letterhead\"><div>\n<p class=\"kind\">{}</p>\n<h1>{}</h1>\n",
                                 escaped(document.laboratory), escaped(document.title));
  html += "<p class=\"report-number\">" + escaped(document.number) + "</p>\n</div>\n";
  if (document.logo)
    html += fmt::format("<img src=\"data:{};base64,{}\" alt=\"{}\"/>\n", escaped(document.logo->media_type),
                        escaped(document.logo->base64), escaped(document.laboratory));
  return html + "</header>\n";
}

/// Returns the banner and the watermark. The watermark is as large as the diagonal of a sheet permits.
std::string marks_html(const Document& document) {
  if (document.mark.empty()) return {};
  // Letter width relative to the estimate of text_width().
  constexpr double kLargestPt = 62, kLongestPt = 640, kBoldCapitals = 1.5;
  const double size_pt = std::min(kLargestPt, kLongestPt / (kBoldCapitals * plot::text_width(document.mark, 1)));
  return fmt::format(
      "<header class=\"banner\">{0}</header>\n"
      "<div class=\"watermark\" aria-hidden=\"true\" style=\"font-size: {1:.0f}pt\">{0}</div>\n",
      escaped(document.mark), size_pt);
}

}  // namespace

std::string to_html(const Document& document) {
  const BodyWriter body(document);
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{}{} {}</title>\n<style>{}{}",
      code(document.language), document.mark.empty() ? "" : escaped(document.mark) + " – ", escaped(document.title),
      escaped(document.number), kScreenStyle, kPrintStyle);
  html += sheet_style(document);
  if (body.has_charts()) html += dygraphs_style();
  html += "</style>\n</head>\n<body>\n<a class=\"skip\" href=\"#report-body\">" +
          escaped(translate(document.language, "page.skip")) + "</a>\n" + marks_html(document) +
          "<main id=\"report-body\" class=\"sheet\">\n" + letterhead_html(document) + body.html() +
          "<p class=\"end\">" + escaped(document.end) + "</p>\n</main>\n";
  if (body.has_charts()) html += "<script>" + chart_script() + "</script>\n";
  return html + "</body>\n</html>\n";
}

}  // namespace gyrotherm::report
