// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <utility>

#include "report/html_page.hpp"
#include "report/plot/svg.hpp"
#include "report/views.hpp"
#include "report/words.hpp"

namespace gyrotherm::report {
namespace {

using model::BudgetRow;

using Cells = std::vector<std::string>;

std::string format_freedom(double degrees) { return std::isfinite(degrees) ? plot::decimal(degrees, 0) : "∞"; }

Cells budget_row(const BudgetRow& row) {
  return {std::string(translate(Language::english, std::string("source.") + name(row.source))) +
              (row.of.empty() ? "" : " " + plot::escaped(row.of)),
          row.evaluation == model::Evaluation::a ? "A" : "B",
          name(row.distribution),
          name(variability(row.source)),
          remarks(row).empty() ? "known" : fmt::format("<b>{}</b>", fmt::join(remarks(row), ", ")),
          plot::escaped(append_unit(plot::format_significant(row.standard_uncertainty), row_unit(row))),
          plot::format_significant(row.sensitivity),
          plot::format_significant(contribution_deg_per_h(row)),
          format_freedom(row.degrees_of_freedom)};
}

HtmlTable budget_table(const model::Uncertainty& uncertainty) {
  const model::CombinedUncertainty all = combined(uncertainty.budget.rows);
  HtmlTable table{
      .caption = fmt::format("Budget of one mean over {} h, compensated by multi-point with temperature. Combined: U = "
                             "{}&nbsp;°/h, k = {}",
                             plot::decimal(uncertainty.budget.averaging_s / 3600, 0),
                             plot::format_bias(all.expanded_deg_per_h), plot::decimal(all.coverage_factor, 2)),
      .header = {"Source", "Type", "Distribution", "Varies", "Basis", "u(xᵢ)", "cᵢ, °/h per unit", "uᵢ(y), °/h", "νᵢ"},
      .text_columns = 5,
      .style = "small"};
  for (const BudgetRow& row : uncertainty.budget.rows) table.rows.push_back(budget_row(row));
  table.rows.push_back({"<b>Combined</b>", "", "", "", "", "", "",
                        "<b>" + plot::format_significant(all.standard_deg_per_h) + "</b>",
                        // Truncated like the degrees of freedom that determine k.
                        format_freedom(model::whole_degrees(all.degrees_of_freedom))});
  return table;
}

/// Adds the cells of one record: RMSE, RMSE relative to the true bias, and coverage.
void add_cells(Cells& cells, const ReportedVerification& found) {
  cells.push_back(plot::format_bias(found.figures.rmse));
  cells.push_back(found.to_truth ? plot::format_bias(found.to_truth->figures.rmse) : "–");
  cells.push_back(found.coverage ? plot::decimal(100 * found.coverage->seen, 1) : "–");
}

HtmlTable validity_table(const Report& report) {
  HtmlTable table{
      .caption =
          "Validity over time: U of one mean over 1 h, °/h; sensitivity to the thermometers, °/h/K; for "
          "the random run and later runs the RMSE, the RMSE of the error relative to the true bias (virtual gyros), "
          "°/h, and the share of means inside the 95&nbsp;% prediction intervals of the model",
      .header = {"Inputs", "Method", "U", "rss ∂b/∂T", "RMSE", "RMSE, true bias", "% in 95&nbsp;%"},
      .text_columns = 2,
      .style = "small"};
  for (const ReportedLaterRun& run : report.later)
    for (const std::string& head :
         {plot::escaped(run.name) + ": RMSE", std::string("RMSE, true bias"), table.header[6]})
      table.header.push_back(head);
  for (const ReportedMethod& method : report.methods) {
    const std::optional<ReportedUncertainty>& known = method.uncertainty;
    Cells cells{plot::escaped(method.inputs), plot::escaped(method.method),
                known ? plot::format_bias(known->expanded_deg_per_h) : "–",
                known ? plot::format_significant(known->sensitivity_deg_per_h_per_k) : "–"};
    add_cells(cells, method.random);
    for (const ReportedVerification& later : method.later) add_cells(cells, later);
    table.rows.push_back(std::move(cells));
  }
  return table;
}

}  // namespace

std::string uncertainty_html(const Report& report) {
  const std::optional<model::Uncertainty>& uncertainty = report.models.multi_point_t.uncertainty;
  return (uncertainty ? to_html(budget_table(*uncertainty)) : "") + to_html(validity_table(report)) +
         "<p class=\"note\">A source that varies <i>never</i> has the same error in training and in use: it is part of "
         "U but not of the prediction interval. <b>assumed</b>: neither the rig file nor the record contains the "
         "value, and gyrotherm uses a default.</p>\n";
}

}  // namespace gyrotherm::report
