// SPDX-License-Identifier: Apache-2.0
#include "report/html_page.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cctype>
#include <string_view>

#include "report/plot/svg.hpp"

namespace gyrotherm::report {
namespace {

/// Texts of a page with simulated data.
struct SimulatedTexts {
  std::string_view mark, banner, sheet;
};

SimulatedTexts simulated_texts(std::string_view language) {
  if (language == "de")
    return {"SIMULIERT", "virtuelle Instrumente: jede Zahl beschreibt die Simulation, keinen wirklichen Kreisel",
            "virtuelle Instrumente, keine Kalibrierung"};
  return {"SIMULATED", "virtual instruments: every number below describes the simulation, not a real gyro",
          "virtual instruments, not a calibration"};
}

std::string simulated_banner(const SimulatedTexts& texts) {
  return fmt::format(
      "<header class=\"banner\"><b>{0}</b>{1}</header>\n<div class=\"watermark\" aria-hidden=\"true\">{0}</div>\n",
      texts.mark, texts.banner);
}

constexpr const char* kScreenCss = R"css(
:root { --ink: #1d2733; --faint: #5b6673; --line: #d5dae0; --accent: #0b4f8a; --mark: #a8371b; }
* { box-sizing: border-box; }
body { margin: 0; background: #eef0f2; color: var(--ink);
  font: 15.5px/1.55 "Source Serif 4", "Source Serif Pro", Charter, "Bitstream Charter", Georgia,
  "Liberation Serif", "DejaVu Serif", serif; }
main { max-width: 880px; margin: 28px auto 60px; padding: 52px 60px 64px; background: #fff;
  box-shadow: 0 1px 3px rgba(20, 30, 40, .14); }
h1, h2, h3, table, .keys, dl, .banner, figcaption, .note, .caution, .watermark, footer {
  font-family: "Source Sans 3", "Helvetica Neue", Helvetica, Arial, "Liberation Sans", "DejaVu Sans", sans-serif; }
h1 { font-size: 28px; line-height: 1.2; font-weight: 600; letter-spacing: -.01em; margin: 0 0 4px; }
.kind { font: 600 12.5px/1 "Source Sans 3", "Helvetica Neue", Helvetica, Arial, "Liberation Sans", "DejaVu Sans",
  sans-serif;
  letter-spacing: .12em; text-transform: uppercase; color: var(--accent); margin: 0 0 12px; }
.subtitle { color: var(--faint); margin: 0 0 24px; font-size: 16px; }
h2 { font-size: 19px; font-weight: 600; margin: 46px 0 12px; padding-top: 12px; border-top: 2px solid var(--ink); }
h2 .number { color: var(--faint); font-weight: 400; margin-right: .6em; }
p { margin: 0 0 12px; hyphens: auto; }
code { font: 0.84em/1.4 "Source Code Pro", Menlo, Consolas, "Liberation Mono", "DejaVu Sans Mono", monospace;
  overflow-wrap: anywhere; }
.note { color: var(--faint); font-size: 13px; line-height: 1.45; }
.caution { border-left: 3px solid var(--mark); padding: 6px 12px; background: #fbf3f0; font-size: 14px; }
.banner { position: sticky; top: 0; z-index: 2; background: var(--mark); color: #fff; text-align: center;
  padding: 6px 16px;
  font-size: 13px; letter-spacing: .02em; }
.banner b { letter-spacing: .14em; margin-right: .8em; }
.watermark { display: none; }
dl.identity { display: grid; grid-template-columns: 132px 1fr; margin: 0; padding: 12px 0; font-size: 14px;
  border-top: 1px solid var(--line); border-bottom: 1px solid var(--line); }
dl.identity dt { color: var(--faint); padding: 2px 0; }
dl.identity dd { margin: 0; padding: 2px 0; overflow-wrap: anywhere; }
.keys { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 138px), 1fr)); margin: 4px 0 8px;
  border: 1px solid var(--line); border-radius: 3px; }
.key { padding: 14px 12px 12px 16px; border-left: 1px solid var(--line); }
.key:first-child { border-left: 0; }
.key .value { font-size: 25px; font-weight: 600; white-space: nowrap; font-variant-numeric: tabular-nums;
  letter-spacing: -.01em; }
.key .unit { color: var(--faint); font-size: 13px; margin-left: 4px; white-space: nowrap; }
.key .label { display: block; color: var(--faint); font-size: 12.5px; line-height: 1.3; margin-top: 2px; }
.key.best { background: #eef6f2; box-shadow: inset 0 3px 0 #00855f; }
.key.best .value { color: #006b4c; }
table { border-collapse: collapse; width: 100%; margin: 18px 0 20px; font-size: 13.5px; line-height: 1.4;
  font-variant-numeric: tabular-nums lining-nums; }
caption { text-align: left; color: var(--faint); font-size: 13px; padding-bottom: 6px; }
caption span { display: block; position: sticky; left: 0; width: 0; min-width: min(100%, 100vw - 36px); }
caption b { color: var(--ink); margin-right: .5em; }
thead :is(th, td) { text-align: left; font-weight: 600; vertical-align: bottom; border-top: 1.5px solid var(--ink);
  border-bottom: 1px solid var(--ink); padding: 6px 14px 6px 0; }
td { padding: 4px 14px 4px 0; border-bottom: 1px solid #eceff2; vertical-align: top; }
td:not(.n) { overflow-wrap: break-word; }
sub, sup { line-height: 0; }
tbody tr:last-child td { border-bottom: 1.5px solid var(--ink); }
th.n, td.n { text-align: right; padding: 4px 0 4px 14px; }
table.small td.n { white-space: nowrap; }
table.small th.n, table.small td.n { padding-left: 8px; }
th.n { padding: 6px 0 6px 14px; }
table.even { table-layout: fixed; }
table.even th:first-child { width: 40%; }
table.small { font-size: 12px; }
table.small td { padding-top: 2px; padding-bottom: 2px; }
.pass { color: #006b4c; } .fail { color: var(--mark); }
figure { margin: 22px 0 26px; break-inside: avoid; }
figure svg { width: 100%; height: auto; display: block; }
figure.narrow svg { max-width: 620px; }
figcaption { font-size: 13px; line-height: 1.45; color: var(--faint); margin-top: 6px; }
figcaption b { color: var(--ink); margin-right: .4em; }
ul.warnings { padding-left: 20px; margin: 0; font-size: 14.5px; }
footer { margin-top: 44px; padding-top: 10px; border-top: 1px solid var(--line); color: var(--faint);
  font-size: 12.5px; }
@media screen and (max-width: 760px) { main { margin: 0; padding: 28px 18px;
  } .keys { grid-template-columns: repeat(2, 1fr); }
  main { overflow-wrap: anywhere; }
  table, figure { overflow-x: auto; overflow-wrap: normal; }
  table { display: block; }
  table, figure { background: linear-gradient(to right, #fff 30%, transparent) left / 30px 100% no-repeat local,
    linear-gradient(to left, #fff 30%, transparent) right / 30px 100% no-repeat local,
    linear-gradient(to right, rgba(0, 0, 0, .2), transparent) left / 11px 100% no-repeat scroll,
    linear-gradient(to left, rgba(0, 0, 0, .2), transparent) right / 11px 100% no-repeat scroll; }
  figure svg { min-width: 620px; }
  dl.identity { grid-template-columns: 1fr; } dl.identity dd { overflow-wrap: anywhere; padding-bottom: 7px; } }
)css";

constexpr const char* kPrintCss = R"css(
@page { size: A4; margin: 19mm 16mm 17mm; @bottom-right { content: counter(page) " / " counter(pages);
  font: 8.5pt sans-serif; color: #5b6673; } }
@media print {
  body { background: #fff; font-size: 10.2pt; }
  main { max-width: none; margin: 0; padding: 0; box-shadow: none; }
  h2 { break-after: avoid; margin-top: 26px; }
  tr, .keys, dl.identity, p { break-inside: avoid; }
  caption { break-after: avoid; }
  thead { display: table-header-group; }
  table { font-size: 8.8pt; } table.small { font-size: 7.6pt; }
  .key .value { font-size: 16pt; }
  .banner { position: static; margin-bottom: 8mm; border: 1px solid var(--mark); background: #fff;
  color: var(--mark); }
  .watermark { display: block; position: fixed; top: 42%; left: 0; right: 0; text-align: center;
  transform: rotate(-28deg);
    font-size: 78pt; font-weight: 700; letter-spacing: .06em; color: var(--mark); opacity: .07; z-index: 3; }
}
)css";

/// Returns the style sheet for screen and print, without external references. The printed pages of simulated data are
/// marked in their margin and across the text.
std::string style_sheet(bool is_simulated, const SimulatedTexts& texts) {
  std::string style = std::string(kScreenCss) + kPrintCss;
  if (is_simulated)
    style += fmt::format(
        "@page {{ @top-center {{ content: \"{} – {}\"; font: 600 8.5pt sans-serif;\n  color: #a8371b; }} }}\n",
        texts.mark, texts.sheet);
  return style;
}

std::string row_html(const std::vector<std::string>& cells, const char* tag, std::size_t text_columns) {
  std::string row = "<tr>";
  for (std::size_t k = 0; k < cells.size(); ++k) {
    // An empty header cell is not a header.
    row += fmt::format("<{0}{1}>{2}</{0}>", cells[k].empty() ? "td" : tag, k < text_columns ? "" : " class=\"n\"",
                       cells[k]);
  }
  return row + "</tr>\n";
}

}  // namespace

std::string to_html(const HtmlPage& page) {
  const SimulatedTexts texts = simulated_texts(page.language);
  auto head =
      fmt::format("<p class=\"kind\">{}</p>\n<h1>{}</h1>\n", plot::escaped(page.kind), plot::escaped(page.heading));
  if (!page.subtitle.empty()) head += fmt::format("<p class=\"subtitle\">{}</p>\n", plot::escaped(page.subtitle));
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"/>\n<title>{}{}</title>\n<style>{}</style>\n"
      "</head>\n<body>\n{}<main tabindex=\"0\">\n{}{}<footer>{}</footer>\n</main>\n</body>\n</html>\n",
      plot::escaped(page.language), page.simulated ? fmt::format("{} – ", texts.mark) : "", plot::escaped(page.title),
      style_sheet(page.simulated, texts), page.simulated ? simulated_banner(texts) : "", head, page.body,
      plot::escaped(page.footer));
}

std::string to_html(const HtmlTable& table) {
  std::string html = table.style.empty() ? "<table tabindex=\"0\">\n"
                                         : fmt::format("<table class=\"{}\" tabindex=\"0\">\n", table.style);
  if (!table.caption.empty()) html += fmt::format("<caption><span>{}</span></caption>\n", table.caption);
  html += "<thead>" + row_html(table.header, "th", table.text_columns) + "</thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    assert(row.size() == table.header.size());
    html += row_html(row, "td", table.text_columns);
  }
  return html + "</tbody>\n</table>\n";
}

std::string css_string(std::string_view text) {
  std::string safe = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80 || std::isalnum(byte) != 0)
      safe += c;
    else
      safe += fmt::format("\\{:x} ", byte);
  }
  return safe + "\"";
}

std::string page_counter(const std::string& page_of) {
  const auto first = page_of.find("{}"), second = page_of.find("{}", first + 2);
  if (first == std::string::npos || second == std::string::npos) return "counter(page)";
  return fmt::format("{} counter(page) {} counter(pages) {}", css_string(page_of.substr(0, first)),
                     css_string(page_of.substr(first + 2, second - first - 2)), css_string(page_of.substr(second + 2)));
}

}  // namespace gyrotherm::report
