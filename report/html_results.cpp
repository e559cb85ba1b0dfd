#include "report/html_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "plot/svg.hpp"
#include "report/html_per_model.hpp"
#include "report/html_table.hpp"

namespace gyrotherm {
namespace {

/// "1 h", "1.73 h" or "anywhere".
std::string read_off_text(const NoiseView& noise) {
  if (!std::isfinite(noise.read_off_s)) return "its minimum";
  const double hours = noise.read_off_s / 3600;
  return decimal(hours, hours == std::round(hours) ? 0 : 2) + "&nbsp;h";
}

std::string noise_cell(const NoiseView& noise) {
  if (noise.seen) return with_error(noise.value, noise.error);
  return std::isfinite(noise.at_most) ? "not seen, &lt;&nbsp;" + significant(noise.at_most) : "–";
}

std::string noise_note(const HoldNoiseView& holds, const char* name) {
  std::string text = fmt::format("<p class=\"note\">{}: {}.", name, escaped(holds.statement));
  if (!holds.curve.empty()) {
    text += fmt::format(" The fit is least at τ&nbsp;=&nbsp;{}&nbsp;s.", significant(holds.lowest_tau_s));
  }
  if (holds.misfit > 0) {
    text += fmt::format(" The curve departs from the five terms by {}&nbsp;%; the errors hold that too.",
                        significant(100 * holds.misfit));
  }
  return text + "</p>\n";
}

std::string std_error_text(const Figures& figures) { return error_text(std_error(figures)); }

std::string effective_text(const Figures& figures) {
  return figures.effective.of_std > 0 ? decimal(figures.effective.of_std, 0) : "–";
}

std::string outside_text(const ResidualView& residual) {
  if (residual.outside == 0) return "0";
  return fmt::format("{} ({}: {}&nbsp;%)", residual.outside, escaped(residual.outside_farthest_term),
                     significant(100 * residual.outside_farthest));
}

const char* policy_words(const std::string& policy) {
  if (policy == "clamp") return "such inputs are moved to the nearer end of their range";
  if (policy == "refuse") return "such means are not compensated and left out of the figures";
  return "the models are used there as they are";
}

/// The rows of one part of the program, a model each.
void add_part(HtmlTable& table, const char* part, const PerModel<ResidualView>& of, Figures ResidualView::*figures) {
  const auto add = [&](const char* head, const char* model, const ResidualView& residual) {
    const Figures& f = residual.*figures;
    const auto cell = [&](const std::string& text) { return f.count > 0 ? text : "–"; };
    table.rows.push_back({head, model, std::to_string(f.count), effective_text(f),
                          cell("<b>" + with_error(f.std, std_error(f)) + "</b>"),
                          cell(with_error(f.mean, mean_error(f))), cell(bias_text(f.rmse)),
                          cell(bias_text(f.max_abs))});
  };
  add(part, "three-point", of.three_point);
  add("", "multi-point", of.multi_point);
  add("", "with temperature", of.multi_point_t);
}

std::string method_name(const MethodView& row, std::map<std::string, std::size_t>& sources) {
  std::string name = escaped(row.title.empty() ? row.method : row.title);
  if (row.citation.empty()) return name;
  const auto number = sources.try_emplace(row.citation, sources.size() + 1).first->second;
  return name + fmt::format("&nbsp;<sup>{}</sup>", number);
}

std::string sources_note(const std::map<std::string, std::size_t>& sources) {
  if (sources.empty()) return "";
  std::map<std::size_t, std::string> by_number;
  for (const auto& [source, number] : sources) by_number[number] = source;
  std::string note = "<p class=\"note\">";
  for (const auto& [number, source] : by_number) {
    note += fmt::format("{}<sup>{}</sup>&nbsp;{}", number == 1 ? "" : " · ", number, escaped(source));
  }
  return note + "</p>\n";
}

}  // namespace

std::string noise_section(const ReportView& view) {
  HtmlTable table{
      .caption = "Noise coefficients with standard errors, from the overlapping Allan deviation of the holds",
      .header = {"", "Noise", "Unit", "Share of σ, τ in h", "Read at τ", "Rate, raw", "Random, raw",
                 "Random, compensated"},
      .text_columns = 5,
      .style = "small"};
  const auto& rate = view.rate.allan.holds.coefficients;
  const auto& random = view.random.allan.holds.coefficients;
  const auto& compensated = view.random.allan.compensated_holds.coefficients;
  for (std::size_t k = 0; k < std::min({rate.size(), random.size(), compensated.size()}); ++k) {
    table.rows.push_back({"<b>" + escaped(rate[k].symbol) + "</b>", escaped(rate[k].name), escaped(rate[k].unit),
                          escaped(rate[k].formula), read_off_text(rate[k]), noise_cell(rate[k]), noise_cell(random[k]),
                          noise_cell(compensated[k])});
  }
  return html_of(table) + noise_note(view.rate.allan.holds, "Rate run") +
         noise_note(view.random.allan.holds, "Random run") +
         noise_note(view.random.allan.compensated_holds, "Random run") +
         "<p class=\"note\">The squares of the coefficients are fitted to σ² by non-negative weighted least squares; a "
         "term counts as seen if its square is at least twice its standard error, else its upper limit of 95&nbsp;% "
         "stands in its place.</p>\n";
}

std::string result_table(const RunView& run, const std::string& heading) {
  const auto std_cell = [](const ResidualView& r) { return "<b>" + bias_text(r.all.std) + "</b>"; };
  const auto raw = bias_text(run.raw.std),
             floor = with_error(run.noise_floor_deg_per_h, run.noise_floor_error_deg_per_h);
  HtmlTable table{
      .caption = "<b>" + heading + "</b> Bias compensation in the " + escaped(run.profile) + " run – " + standing(run),
      .header = model_header("Bias, °/h"),
      .style = "even"};
  const auto& r = run.residual;
  table.rows = {{"Before compensation, STD", raw, raw, raw},
                cells("After compensation, STD", r, std_cell),
                cells("… its standard error", r, [](const ResidualView& v) { return std_error_text(v.all); }),
                {"Noise floor of this record", floor, floor, floor}};
  if (std::isfinite(r.multi_point.expected_in_sample_std)) {
    table.rows.push_back(cells("Expected of a fit to noise alone, in-sample", r,
                               [](const ResidualView& v) { return bias_text(v.expected_in_sample_std); }));
  }
  const std::vector<std::vector<std::string>> rest = {
      cells("After: mean", r, [](const ResidualView& v) { return bias_text(v.all.mean); }),
      cells("After: RMSE", r, [](const ResidualView& v) { return bias_text(v.all.rmse); }),
      cells("After: greatest magnitude", r, [](const ResidualView& v) { return bias_text(v.all.max_abs); }),
      cells("Improvement from original accuracy", run.gain, [](const GainView& g) { return percent(g.from_original); }),
      cells("Improvement from three-point, the paper’s ratio", run.gain,
            [](const GainView& g) { return percent(g.paper_ratio); }),
      cells("Reduction of the three-point residual", run.gain,
            [](const GainView& g) { return percent(g.residual_reduction); }),
      cells("Means with an input outside the trained range (farthest)", r, outside_text)};
  table.rows.insert(table.rows.end(), rest.begin(), rest.end());
  return html_of(table);
}

std::string parts_table(const RunView& run) {
  HtmlTable table{.caption = fmt::format("Residual in the {} run by part of the program, °/h", escaped(run.profile)),
                  .header = {"Part", "Model", "Means", "n<sub>eff</sub>", "STD", "Mean", "RMSE", "Max"},
                  .text_columns = 2,
                  .style = "small"};
  add_part(table, "all", run.residual, &ResidualView::all);
  add_part(table, "ramps", run.residual, &ResidualView::ramps);
  add_part(table, "holds", run.residual, &ResidualView::holds);
  add_part(table, "10 min after corners", run.residual, &ResidualView::corners);
  return html_of(table) +
         fmt::format(
             "<p class=\"note\">± is a standard error, STD/√(2&nbsp;n<sub>eff</sub>) of the STD: neighbouring "
             "residuals are alike, and n<sub>eff</sub> independent ones would tell as much of the STD. Inputs "
             "outside the trained range: {}.</p>\n",
             policy_words(run.residual.multi_point.outside_policy));
}

std::string methods_section(const ReportView& view) {
  HtmlTable table{.caption = fmt::format(
                      "STD of every method, °/h. Held-out: {}; parameters chosen with all cycles. Nested: the same, "
                      "parameters chosen without the held-out cycle too. ±, mean and maximum are of the random run",
                      escaped(view.folds)),
                  .header = {"Inputs", "Method", "Rate, in-sample", "Held-out", "Nested", "<b>Random</b>", "±", "Mean",
                             "Max", "Effective par.", "Numbers stored"},
                  .text_columns = 2,
                  .style = "small"};
  std::map<std::string, std::size_t> sources;
  for (const MethodView& row : view.methods) {
    table.rows.push_back({escaped(row.inputs), method_name(row, sources), bias_text(row.in_sample.std),
                          bias_text(row.leave_cycle_out.std), row.nested ? bias_text(row.nested->std) : "–",
                          "<b>" + bias_text(row.random.std) + "</b>", std_error_text(row.random),
                          bias_text(row.random.mean), bias_text(row.random.max_abs),
                          decimal(row.effective_parameters, 0),
                          row.stored_numbers > 0 ? std::to_string(row.stored_numbers) : "–"});
  }
  return html_of(table) + sources_note(sources);
}

}  // namespace gyrotherm
