// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "plot/svg.hpp"
#include "report/views.hpp"

namespace gyrotherm::report {
namespace {

using model::BudgetRow;

std::string cell(const std::string& text) { return fmt::format("<td>{}</td>", text); }
std::string number(const std::string& text) { return fmt::format("<td class=\"n\">{}</td>", text); }

std::string table(const std::string& caption, const std::string& header, const std::string& rows) {
  return fmt::format(
      "<table class=\"small\">\n<caption>{}</caption>\n<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody>\n</table>\n",
      caption, header, rows);
}

std::string header(std::initializer_list<const char*> text, std::initializer_list<std::string> numbers) {
  std::string all;
  for (const char* one : text) all += fmt::format("<th>{}</th>", one);
  for (const std::string& one : numbers) all += fmt::format("<th class=\"n\">{}</th>", one);
  return all;
}

std::string budget_row(const BudgetRow& row) {
  const std::string of = row.of.empty() ? "" : " " + plot::escaped(row.of);
  const std::string nu = std::isfinite(row.degrees_of_freedom) ? plot::decimal(row.degrees_of_freedom, 0) : "∞";
  return "<tr>" + cell(name(row.source) + of) + cell(row.evaluation == model::Evaluation::a ? "A" : "B") +
         cell(name(row.distribution)) + cell(name(differs(row.source))) +
         cell(row.assumed ? "<b>assumed</b>" : "known") +
         number(fmt::format("{}&nbsp;{}", plot::significant(row.standard_uncertainty), unit_of(row.source))) +
         number(plot::significant(row.sensitivity)) + number(plot::format_bias(contribution_deg_per_h(row))) +
         number(nu) + "</tr>\n";
}

std::string budget_table(const model::Uncertainty& uncertainty) {
  std::string rows;
  for (const BudgetRow& row : uncertainty.budget.rows) rows += budget_row(row);
  const model::CombinedUncertainty all = combined(uncertainty.budget.rows);
  const std::string nu =  // cut, as k is taken for it
      std::isfinite(all.degrees_of_freedom) ? plot::decimal(std::floor(all.degrees_of_freedom), 0) : "∞";
  rows += fmt::format(
      "<tr><td colspan=\"7\"><b>Combined: U = {}&nbsp;°/h, k = {}</b></td><td class=\"n\"><b>{}</b></td>"
      "<td class=\"n\">{}</td></tr>\n",
      plot::format_bias(all.expanded_deg_per_h), plot::decimal(all.coverage_factor, 2),
      plot::format_bias(all.standard_deg_per_h), nu);
  return table(fmt::format("Budget of one mean over {} h, compensated by multi-point with temperature",
                           plot::decimal(uncertainty.budget.averaging_s / 3600, 0)),
               header({"Source", "Type", "Distribution", "Differs", ""}, {"u", "∂b, °/h per unit", "°/h", "ν"}), rows);
}

std::string share(const std::optional<model::Coverage>& coverage) {
  return coverage ? plot::decimal(100 * coverage->seen, 1) : "–";
}

/// Of one record: RMSE, RMSE to truth and coverage.
std::string cells_of(const ReportedVerification& found) {
  return number(plot::format_bias(found.figures.rmse)) +
         number(found.to_truth ? plot::format_bias(found.to_truth->figures.rmse) : "–") + number(share(found.coverage));
}

std::string lasting_table(const Report& report) {
  std::string head = header({"Inputs", "Method"}, {"U", "rss ∂b/∂T", "RMSE", "to truth", "% in 95&nbsp;%"});
  for (const ReportedLaterRun& run : report.later)
    head += header({}, {plot::escaped(run.name) + ": RMSE", "to truth", "% in 95&nbsp;%"});
  std::string rows;
  for (const ReportedMethod& method : report.methods) {
    const std::optional<ReportedUncertainty>& known = method.uncertainty;
    rows += "<tr>" + cell(plot::escaped(method.inputs)) + cell(plot::escaped(method.method)) +
            number(known ? plot::format_bias(known->expanded_deg_per_h) : "–") +
            number(known ? plot::significant(known->sensitivity_deg_per_h_per_k) : "–") + cells_of(method.random);
    for (const ReportedVerification& later : method.later) rows += cells_of(later);
    rows += "</tr>\n";
  }
  return table(
      "Whether it lasts: U of one mean over 1 h, °/h; the sensitivity to the thermometers, °/h/K; and on the random "
      "run, and on later ones, the RMSE, the RMSE of the error to the true bias (virtual gyros), °/h, and how many "
      "means "
      "lie within the intervals of 95&nbsp;% that the model’s own budget gives",
      head, rows);
}

}  // namespace

std::string uncertainty_html(const Report& report) {
  const std::optional<model::Uncertainty>& uncertainty = report.models.multi_point_t.uncertainty;
  return (uncertainty ? budget_table(*uncertainty) : "") + lasting_table(report) +
         "<p class=\"note\">A source that differs <i>never</i> is the same in training and in use: the models have "
         "learnt it, so that it is in U and in no interval. What is <b>assumed</b> is said by neither the rig file nor "
         "the record.</p>\n";
}

}  // namespace gyrotherm::report
