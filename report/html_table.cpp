// SPDX-License-Identifier: Apache-2.0
#include "report/html_table.hpp"

#include <fmt/format.h>

#include <cassert>

namespace gyrotherm::report {
namespace {

std::string row_of(const std::vector<std::string>& cells, const char* tag, std::size_t text_columns) {
  std::string row = "<tr>";
  for (std::size_t k = 0; k < cells.size(); ++k) {
    // A header that says nothing is none.
    row += fmt::format("<{0}{1}>{2}</{0}>", cells[k].empty() ? "td" : tag, k < text_columns ? "" : " class=\"n\"",
                       cells[k]);
  }
  return row + "</tr>\n";
}

}  // namespace

std::string html_of(const HtmlTable& table) {
  std::string html = table.style.empty() ? "<table>\n" : fmt::format("<table class=\"{}\">\n", table.style);
  if (!table.caption.empty()) html += fmt::format("<caption>{}</caption>\n", table.caption);
  html += "<thead>" + row_of(table.header, "th", table.text_columns) + "</thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    assert(row.size() == table.header.size());
    html += row_of(row, "td", table.text_columns);
  }
  return html + "</tbody>\n</table>\n";
}

}  // namespace gyrotherm::report
