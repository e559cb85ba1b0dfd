// SPDX-License-Identifier: Apache-2.0
#include "report/views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <filesystem>
#include <map>
#include <regex>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/file.hpp"
#include "report/html_page.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::report {

namespace {

template <class T, class Cell>
std::vector<std::string> cells(std::string head, const model::PerModel<T>& of, Cell cell) {
  return {std::move(head), cell(of.three_point), cell(of.multi_point), cell(of.multi_point_t)};
}

std::vector<std::string> model_header(std::string head) {
  return {std::move(head), "Three-point", "Multi-point", "Multi-point with temperature"};
}

std::string join_escaped(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + plot::escaped(text);
  return all;
}

std::string paragraph(const std::string& html) { return "<p>" + html + "</p>\n"; }

/// Returns a tile with a value and its standard error.
std::string key_figure(const std::string& label, double deg_per_h, double error, const char* style = "") {
  return fmt::format(
      "<div class=\"key {}\"><span class=\"value\">{}</span><span class=\"unit\">°/h</span>"
      "<span class=\"label\">{}</span></div>\n",
      style, plot::format_bias(deg_per_h),
      std::isfinite(error) && error > 0 ? fmt::format("{}, standard error {}", label, plot::format_error(error))
                                        : label);
}

std::string key_figures(const ReportedRun& run) {
  const auto& residual = run.residual;
  const auto tile = [](const std::string& label, const data::Figures& figures, const char* style = "") {
    return key_figure(label, figures.std, standard_error_of_std(figures), style);
  };
  const auto shown = [](const data::Figures& figures) { return plot::format_bias(figures.std); };
  const data::Figures* const models[] = {&residual.three_point.all, &residual.multi_point.all,
                                         &residual.multi_point_t.all};
  const data::Figures& least = **std::ranges::min_element(models, {}, [](const auto* one) { return one->std; });
  const auto model_tile = [&](const std::string& label, const data::Figures& figures) {
    const bool is_best = figures.std < run.raw.std && shown(figures) == shown(least);
    return tile(label, figures, is_best ? "best" : "");
  };
  return "<div class=\"keys\">\n" + tile("before compensation", run.raw) +
         model_tile("three-point", residual.three_point.all) + model_tile("multi-point", residual.multi_point.all) +
         model_tile("multi-point with temperature", residual.multi_point_t.all) +
         key_figure("noise floor of the record", run.floor.deg_per_h, run.floor.error_deg_per_h) + "</div>\n" +
         fmt::format("<p class=\"note\">Standard deviations of the {} run with their standard errors, {}.</p>\n",
                     plot::escaped(run.profile), in_sample_text(run));
}

std::string floor_sentence(const ReportedRun& run) {
  if (!std::isfinite(run.floor.deg_per_h)) {
    return fmt::format("The same record has no noise floor: {}.", plot::escaped(run.floor.statement));
  }
  return fmt::format(
      "The noise floor of the same record, the white noise of one such mean, is {}&nbsp;°/h. An independent model can "
      "fall below it only by chance.",
      plot::format_bias(run.floor.deg_per_h));
}

std::string recommendation_text(const Report& report) {
  const model::Recommendation& found = report.recommendation;
  const std::string statement = plot::escaped(found.statement);
  if (found.recommended.empty()) return fmt::format("Recommended by rule: {}.", statement);
  return fmt::format("Recommended by rule: <b>{}</b>, {}.", plot::escaped(found.recommended), statement);
}

/// Returns a sentence about the block temperatures in training; empty if no record has them.
std::string range_sentence(const Report& report) {
  std::vector<model::TrainingRecord> records;
  for (const ReportedTraining& record : report.models.multi_point_t.trained_on)
    records.emplace_back().block = record.block;
  const auto block = model::trained_block(records);
  if (!block) return {};
  return fmt::format(
      "Trained range: {}. Outside this block temperature a model extrapolates, regardless of the range of the chamber.",
      plot::escaped(model::describe(*block)));
}

std::string describe_summary(const Report& report) {
  const ReportedRun& rate = report.rate;
  const ReportedRun& random = report.random;
  return fmt::format(
      "In the {} run the bias varied by {}&nbsp;°/h (standard deviation of {} means over {}&nbsp;s); in the {} run by "
      "{}&nbsp;°/h ({} means). "
      "In the latter, the residual of multi-point with temperature is {}&nbsp;°/h: {} less than before compensation "
      "and {} less than the residual of the three-point model ({}&nbsp;°/h). The residual of the paper’s multi-point "
      "model "
      "with gradients only is {}&nbsp;°/h. {}",
      plot::escaped(rate.profile), plot::format_bias(rate.raw.std), rate.clusters,
      plot::decimal(report.cluster_length_s, 0), plot::escaped(random.profile), plot::format_bias(random.raw.std),
      random.clusters, plot::format_bias(random.residual.multi_point_t.all.std),
      plot::percent(random.gain.multi_point_t.from_original),
      plot::percent(random.gain.multi_point_t.residual_reduction),
      plot::format_bias(random.residual.three_point.all.std), plot::format_bias(random.residual.multi_point.all.std),
      floor_sentence(random));
}

std::string verdict_table(const Report& report) {
  if (report.accept.empty())
    return "<p class=\"note\">The profiles set no acceptance limit; the report gives no verdict.</p>\n";
  HtmlTable table{.caption = "Acceptance limits of the profiles",
                  .header = {"Parameter", "Value, °/h", "Limit, °/h", "Verdict"}};
  for (const AcceptedLimit& limit : report.accept) {
    table.rows.push_back({"<code>" + plot::escaped(limit.figure) + "</code>", plot::format_bias(limit.value),
                          plot::format_bias(limit.limit),
                          limit.passed ? "<b class=\"pass\">PASS</b>" : "<b class=\"fail\">FAIL</b>"});
  }
  return to_html(table);
}

std::string describe_run(const ReportedRun& run) {
  std::string text = fmt::format("{} · {} means", plot::escaped(run.profile), run.clusters);
  if (!run.gaps_s.empty()) text += fmt::format(" · {} gaps", run.gaps_s.size());
  if (run.dropped_gaps > 0) text += fmt::format(" · {} means dropped at gaps", run.dropped_gaps);
  if (run.dropped_rest > 0) text += fmt::format(" · last {} samples do not fill a mean", run.dropped_rest);
  return text + " · run <code>" + plot::escaped(run.run_id.substr(0, 12)) + "</code>";
}

std::string definition(const std::string& term, const std::string& html) {
  return "<dt>" + term + "</dt><dd>" + html + "</dd>\n";
}

std::string format_bounds(const char* symbol, std::pair<double, double> log2_bounds) {
  const auto end = [](double value) { return plot::decimal(value, value == std::round(value) ? 0 : 1); };
  return fmt::format("log<sub>2</sub>&nbsp;{}&nbsp;∈&nbsp;[{},&nbsp;{}]", symbol, end(log2_bounds.first),
                     end(log2_bounds.second));
}

std::string bias_reference_text(const Report& report) {
  const std::string &rate = report.rate.bias_zero, &random = report.random.bias_zero;
  return plot::escaped(rate == random ? rate : fmt::format("training: {}; verification: {}", rate, random));
}

std::string identity_section(const Report& report) {
  return "<dl class=\"identity\">\n" +
         definition("Rig", plot::escaped(report.rig.title) + " <code>" + plot::escaped(report.rig.name) + "</code>" +
                               (report.rig.is_virtual ? " – virtual instruments" : "")) +
         definition("Gyro", plot::escaped(report.rig.gyro)) + definition("Training", describe_run(report.rate)) +
         definition("Verification", describe_run(report.random)) +
         definition("Bias reference", bias_reference_text(report)) +
         definition("Program", "gyrotherm " + plot::escaped(report.program_version) + ", seed " +
                                   std::to_string(report.seed) +
                                   (report.days_later > 0 ? fmt::format(", {} days later", report.days_later) : "")) +
         "</dl>\n";
}

std::string summary_section(const Report& report) {
  std::string html =
      key_figures(report.random) + paragraph(describe_summary(report)) + paragraph(recommendation_text(report));
  if (const std::string range = range_sentence(report); !range.empty()) html += paragraph("<b>" + range + "</b>");
  if (report.quick) {
    html += "<p class=\"caution\">Tuned with a small swarm (quick): for a trial, not for a calibration.</p>\n";
  }
  if (!report.warnings.empty()) {
    html += fmt::format("<p class=\"note\">{} warning{}: see the section Warnings.</p>\n", report.warnings.size(),
                        report.warnings.size() == 1 ? "" : "s");
  }
  return html + verdict_table(report);
}

std::string selection_section(const Report& report) {
  const ReportedCorrelation& correlation = report.correlation;
  HtmlTable table{.caption = "|r| of the bias with each temperature and its rate of change, for comparison",
                  .header = {""},
                  .rows = {{"temperature"}, {"rate of change"}}};
  for (std::size_t k = 0; k < correlation.names.size(); ++k) {
    table.header.push_back(plot::escaped(correlation.names[k]));
    table.rows[0].push_back(plot::decimal(std::abs(correlation.temperature[k]), 3));
    table.rows[1].push_back(plot::decimal(std::abs(correlation.rate[k]), 3));
  }
  return paragraph(fmt::format("Selected {} gradients of rank {}{}: {}.", correlation.selected_pairs.size(),
                               correlation.rank, correlation.fallback ? ", by the fallback rule" : "",
                               join_escaped(correlation.selected_pairs))) +
         (correlation.statement.empty() ? "" : "<p class=\"note\">" + plot::escaped(correlation.statement) + "</p>\n") +
         to_html(table);
}

std::string training_records(const ReportedModel& model) {
  std::string all;
  for (const ReportedTraining& record : model.trained_on)
    all += fmt::format("{}{} (run {})", all.empty() ? "" : ", ", record.profile, record.run_id.substr(0, 8));
  return all;
}

int training_clusters(const ReportedModel& model) {
  int clusters = 0;
  for (const ReportedTraining& record : model.trained_on) clusters += record.clusters;
  return clusters;
}

std::string models_section(const Report& report) {
  const auto row = [&](const char* head, auto cell) { return cells(head, report.models, cell); };
  HtmlTable table{.caption = "Models: tuning and optimality certificates", .header = model_header(""), .style = "even"};
  table.rows = {
      row("Inputs", [](const ReportedModel& m) { return fmt::format("{} (rank {})", m.terms.size(), m.rank); }),
      row("Trained on", [](const ReportedModel& m) { return plot::escaped(training_records(m)); }),
      row("Training means", [](const ReportedModel& m) { return std::to_string(training_clusters(m)); }),
      row("Effective parameters", [](const ReportedModel& m) { return plot::decimal(m.effective_parameters, 0); }),
      row("Parameters stored", [](const ReportedModel& m) { return std::to_string(m.stored_numbers); }),
      row("C", [](const ReportedModel& m) { return plot::format_significant(m.parameters.C); }),
      row("σ", [](const ReportedModel& m) { return plot::format_significant(m.parameters.sigma); }),
      row("ε (in °/h)",
          [](const ReportedModel& m) {
            return plot::format_significant(m.parameters.epsilon) + " (" + plot::decimal(m.epsilon_deg_per_h, 5) + ")";
          }),
      row("Support vectors", [](const ReportedModel& m) { return std::to_string(m.support_vectors); }),
      row("Certified duality gap", [](const ReportedModel& m) { return plot::format_significant(m.certified_gap); }),
      row("KKT violation", [](const ReportedModel& m) { return plot::format_significant(m.kkt_violation); }),
      row("Swarm",
          [](const ReportedModel& m) {
            return fmt::format("{} particles, seed {}", m.options.swarm.particles, m.options.swarm.seed);
          }),
      row("Iterations (evaluations)",
          [](const ReportedModel& m) {
            const svm::SwarmSummary& swarm = m.tuning.swarm;
            return fmt::format("{} of {} ({})", swarm.history.empty() ? 0 : swarm.history.size() - 1,
                               m.options.swarm.iterations, swarm.evaluations);
          }),
      row("Stopping criterion", [](const ReportedModel& m) { return plot::escaped(name(m.tuning.swarm.end)); })};
  const ReportedModel& m = report.models.multi_point;
  const svm::TuningOptions& bounds = m.options;
  return to_html(table) +
         fmt::format(
             "<p class=\"note\">C and ε are in units of the training STD of the bias, σ in units of standardised "
             "inputs. "
             "Searched: {}, {}, {}.</p>\n",
             format_bounds("C", bounds.log2_c), format_bounds("σ", bounds.log2_sigma),
             bounds.fixed_epsilon > 0 ? "ε fixed at " + plot::format_significant(bounds.fixed_epsilon)
                                      : format_bounds("ε", bounds.log2_epsilon)) +
         "<p class=\"note\">Inputs of multi-point: " + join_escaped(m.terms) +
         ". Inputs of three-point: " + join_escaped(report.models.three_point.terms) + ".</p>\n";
}

std::string warnings_section(const Report& report) {
  if (report.warnings.empty()) return "<p>None.</p>\n";
  std::string html = "<ul class=\"warnings\">\n";
  for (const std::string& warning : report.warnings)
    html += "<li>" + plot::escaped(with_minus_signs(warning)) + "</li>\n";
  return html + "</ul>\n";
}

/// Returns the name of a segment with at most one decimal and the minus sign of typography: "ramp to −10.1 °C".
std::string format_segment_name(const std::string& name) {
  static const std::regex kNumber(R"(-?\d+(\.\d+)?(?= °C))");
  std::string text;
  auto rest = name.cbegin();
  for (std::sregex_iterator found(name.begin(), name.end(), kNumber), end; found != end; ++found) {
    const auto value = std::stod(found->str());
    text.append(rest, found->operator[](0).first);
    text += plot::decimal(value, std::abs(value - std::round(value)) < 0.05 ? 0 : 1);
    rest = found->operator[](0).second;
  }
  return text.append(rest, name.cend());
}

std::string segments_table(const Report& report) {
  HtmlTable table{.caption = "Segments: duration, mean values and STD of the residual, °/h",
                  .header = {"Run", "Segment", "Kind", "Start", "Duration", "Mean temp., °C", "Mean bias",
                             "Three-point", "Multi-point", "With temp."},
                  .text_columns = 3,
                  .style = "small"};
  for (const ReportedSegment& s : report.segments) {
    table.rows.push_back({s.run == "rate" ? "ramp" : plot::escaped(s.run), plot::escaped(format_segment_name(s.name)),
                          s.hold ? "hold" : "ramp", plot::format_hours(s.start_s), plot::format_hours(s.duration_s),
                          plot::decimal(s.mean_temperature_c, 2), plot::format_bias(s.mean_bias_deg_per_h),
                          plot::format_bias(s.residual.three_point.std), plot::format_bias(s.residual.multi_point.std),
                          plot::format_bias(s.residual.multi_point_t.std)});
  }
  return to_html(table);
}

std::string thermometers_section(const Report& report) {
  if (report.rig.thermometers.empty()) return {};
  HtmlTable table{.caption = "Thermometers and their calibration",
                  .header = {"Channel", "Instrument", "Calibration"},
                  .text_columns = 3,
                  .style = "small"};
  for (const ReportedThermometer& one : report.rig.thermometers)
    table.rows.push_back({plot::escaped(one.channel), plot::escaped(one.instrument), plot::escaped(one.calibration)});
  return to_html(table);
}

std::string code(const std::string& text) { return "<code>" + plot::escaped(text) + "</code>"; }

/// Appends the digests of a record: of its file, which `sha256sum` computes, and of its rows.
void add_record_digests(HtmlTable& table, const std::string& name, const ReportedRun& run) {
  if (!run.record_file_sha256.empty())
    table.rows.push_back({name + ", file", code(run.run_id), code(run.record_file_sha256)});
  table.rows.push_back({name + ", rows as exported", code(run.run_id), code(run.record_sha256)});
}

std::string provenance_section(const Report& report) {
  HtmlTable table{.caption = "Input files", .header = {"File", "Name", "SHA-256"}, .text_columns = 3, .style = "small"};
  add_record_digests(table, "Ramp record", report.rate);
  table.rows.push_back({"Ramp profile", plot::escaped(report.rate.profile), code(report.rate.profile_sha256)});
  add_record_digests(table, "Random record", report.random);
  table.rows.push_back({"Random profile", plot::escaped(report.random.profile), code(report.random.profile_sha256)});
  table.rows.push_back({"Rig", plot::escaped(report.rig.name), code(report.rig.sha256)});
  if (const auto& model = report.thermal.model)
    table.rows.push_back({"Gyro file", plot::escaped(model->gyro), code(model->gyro_sha256)});
  return to_html(table);
}

/// Returns the averaging time at which the coefficient is read from the Allan deviation: "1 h", "1.73 h" or "its
/// minimum".
std::string format_read_off(const data::NoiseCoefficient& noise) {
  const double hours = info(noise.term).read_off_s / kSecondsPerHour;
  if (!std::isfinite(hours)) return "its minimum";
  return plot::decimal(hours, hours == std::round(hours) ? 0 : 2) + "&nbsp;h";
}

std::string noise_cell(const data::NoiseCoefficient& noise) {
  if (noise.seen) return plot::format_with_error(noise.value, noise.error);
  return std::isfinite(noise.at_most) ? "not significant, &lt;&nbsp;" + plot::format_significant(noise.at_most) : "–";
}

std::string noise_note(const data::HoldNoise& holds, const char* name) {
  std::string text = fmt::format("<p class=\"note\">{}: {}.", name, plot::escaped(holds.statement));
  if (!holds.curve.empty()) {
    text += fmt::format(" Minimum of the fit at τ&nbsp;=&nbsp;{}&nbsp;s.",
                        plot::format_significant(holds.fit.lowest_tau_s));
  }
  if (holds.fit.misfit > 0) {
    text += fmt::format(" RMS misfit {}&nbsp;%, included in the standard errors.",
                        plot::format_significant(100 * holds.fit.misfit));
  }
  return text + "</p>\n";
}

std::string format_std_error(const data::Figures& figures) {
  return plot::format_error(standard_error_of_std(figures));
}

std::string format_effective(const data::Figures& figures) {
  return figures.effective.of_std > 0 ? plot::decimal(figures.effective.of_std, 0) : "–";
}

std::string describe_outside(const ReportedResidual& residual) {
  if (residual.outside.clusters == 0) return "0";
  return fmt::format("{} ({}: {}&nbsp;%)", residual.outside.clusters, plot::escaped(residual.outside.farthest_term),
                     format_digits(100 * residual.outside.farthest, 2));
}

const char* describe(model::Outside policy) {
  switch (policy) {
    case model::Outside::continued:
      return "the linear part of a model continues there, all other parts keep their value at the end of the range, "
             "and U is larger";
    case model::Outside::refuse: return "such means are not compensated and are excluded from the results";
    case model::Outside::extrapolate: return "the models extrapolate without restriction";
  }
  return "";
}

/// Formats a figure of the error relative to the true bias of a virtual rig. Marks a figure from which the mean was
/// removed.
std::string format_truth(const std::optional<model::TrueBiasError>& error, double data::Figures::*figure) {
  if (!error) return "–";
  return plot::format_bias(error->figures.*figure) + (error->mean_removed ? " (mean removed)" : "");
}

/// Adds the rows of one part of the program, one per model.
void add_part(HtmlTable& table, const char* part, const model::PerModel<ReportedResidual>& of,
              data::Figures ReportedResidual::*figures) {
  const auto add = [&](const char* head, const char* model, const ReportedResidual& residual) {
    const data::Figures& f = residual.*figures;
    const auto cell = [&](const std::string& text) { return f.count > 0 ? text : "–"; };
    table.rows.push_back({head, model, std::to_string(f.count), format_effective(f),
                          cell("<b>" + plot::format_with_error(f.std, standard_error_of_std(f)) + "</b>"),
                          cell(plot::format_with_error(f.mean, standard_error_of_mean(f))),
                          cell(plot::format_bias(f.rmse)), cell(plot::format_bias(f.max_abs))});
  };
  add(part, "three-point", of.three_point);
  add("", "multi-point", of.multi_point);
  add("", "with temperature", of.multi_point_t);
}

std::string method_name(const ReportedMethod& row, std::map<std::string, std::size_t>& sources) {
  std::string name = plot::escaped(row.title.empty() ? row.method : row.title);
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
    note += fmt::format("{}<sup>{}</sup>&nbsp;{}", number == 1 ? "" : " · ", number, plot::escaped(source));
  }
  return note + "</p>\n";
}

std::string noise_section(const Report& report) {
  HtmlTable table{
      .caption = "Noise coefficients with standard errors, from the overlapping Allan deviation of the holds",
      .header = {"", "Noise", "Unit", "Share of σ, τ in h", "Read at τ", "Ramp, raw", "Random, raw",
                 "Random, compensated"},
      .text_columns = 5,
      .style = "small"};
  const auto& rate = report.rate.noise.holds.fit.coefficients;
  const auto& random = report.random.noise.holds.fit.coefficients;
  const auto& compensated = report.random.noise.compensated_holds.fit.coefficients;
  for (std::size_t k = 0; k < data::kNoiseTerms; ++k) {
    const data::NoiseTermInfo& about = info(rate[k].term);
    table.rows.push_back({fmt::format("<b>{}</b>", about.symbol), plot::escaped(about.name), plot::escaped(about.unit),
                          plot::escaped(about.formula), format_read_off(rate[k]), noise_cell(rate[k]),
                          noise_cell(random[k]), noise_cell(compensated[k])});
  }
  return to_html(table) + noise_note(report.rate.noise.holds, "Ramp run") +
         noise_note(report.random.noise.holds, "Random run") +
         noise_note(report.random.noise.compensated_holds, "Random run") +
         "<p class=\"note\">The squares of the coefficients are fitted to σ² by non-negative weighted least squares; a "
         "term is significant if its square is at least twice its standard error. For other terms the table "
         "contains "
         "the 95&nbsp;% upper limit.</p>\n";
}

std::string result_table(const ReportedRun& run) {
  const auto std_cell = [](const ReportedResidual& r) { return "<b>" + plot::format_bias(r.all.std) + "</b>"; };
  const auto raw = plot::format_bias(run.raw.std),
             floor = plot::format_with_error(run.floor.deg_per_h, run.floor.error_deg_per_h);
  HtmlTable table{.caption = "Bias compensation in the " + plot::escaped(run.profile) + " run – " + in_sample_text(run),
                  .header = model_header("Bias, °/h"),
                  .style = "even"};
  const auto& r = run.residual;
  table.rows = {{"Before compensation, STD", raw, raw, raw},
                cells("After compensation, STD", r, std_cell),
                cells("… its standard error", r, [](const ReportedResidual& v) { return format_std_error(v.all); }),
                {"Noise floor of this record", floor, floor, floor}};
  if (std::isfinite(r.multi_point.expected_in_sample_std)) {
    table.rows.push_back(cells("Expected in-sample STD of a fit to pure noise", r,
                               [](const ReportedResidual& v) { return plot::format_bias(v.expected_in_sample_std); }));
  }
  const std::vector<std::vector<std::string>> rest = {
      cells("After: mean", r, [](const ReportedResidual& v) { return plot::format_bias(v.all.mean); }),
      cells("After: RMSE", r, [](const ReportedResidual& v) { return plot::format_bias(v.all.rmse); }),
      cells("After: largest magnitude", r, [](const ReportedResidual& v) { return plot::format_bias(v.all.max_abs); }),
      cells("Improvement from original accuracy", run.gain,
            [](const ReportedGain& g) { return plot::percent(g.from_original); }),
      cells("Improvement from three-point, the paper’s ratio", run.gain,
            [](const ReportedGain& g) { return plot::percent(g.paper_ratio); }),
      cells("Reduction of the three-point residual", run.gain,
            [](const ReportedGain& g) { return plot::percent(g.residual_reduction); }),
      cells("Means with an input outside the trained range (farthest)", r, describe_outside)};
  table.rows.insert(table.rows.end(), rest.begin(), rest.end());
  if (r.multi_point.to_truth) {
    const auto to_truth = [&](const char* head, double data::Figures::*figure) {
      return cells(head, r, [&](const ReportedResidual& v) { return format_truth(v.to_truth, figure); });
    };
    table.rows.push_back(to_truth("Prediction minus the <b>true bias</b>, STD", &data::Figures::std));
    table.rows.push_back(to_truth("… RMSE", &data::Figures::rmse));
  }
  if (r.multi_point.streamed) {
    const auto streamed = [&](const char* head, auto figure) {
      return cells(head, r, [&](const ReportedResidual& v) {
        return v.streamed ? plot::format_bias(figure(*v.streamed)) : std::string("–");
      });
    };
    table.rows.push_back(streamed("Streamed second by second, STD of the same means",
                                  [](const model::StreamResult& s) { return s.residual.std; }));
    table.rows.push_back(streamed("… without the lag (predictions of the same seconds)",
                                  [](const model::StreamResult& s) { return s.aligned.std; }));
    if (r.multi_point.streamed->to_truth)
      table.rows.push_back(
          streamed("… streamed prediction minus the <b>true bias</b>, STD",
                   [](const model::StreamResult& s) { return s.to_truth ? s.to_truth->figures.std : kNotKnown; }));
  }
  return to_html(table) + fmt::format("<p class=\"note\">Noise floor: {}.</p>\n", plot::escaped(run.floor.statement));
}

std::string parts_table(const ReportedRun& run) {
  HtmlTable table{
      .caption = fmt::format("Residual in the {} run by part of the profile, °/h", plot::escaped(run.profile)),
      .header = {"Part", "Model", "Means", "n<sub>eff</sub>", "STD", "Mean", "RMSE", "Max"},
      .text_columns = 2,
      .style = "small"};
  add_part(table, "all", run.residual, &ReportedResidual::all);
  add_part(table, "ramps", run.residual, &ReportedResidual::ramps);
  add_part(table, "holds", run.residual, &ReportedResidual::holds);
  add_part(table, "10 min after set-point corners", run.residual, &ReportedResidual::corners);
  return to_html(table) + fmt::format(
                              "<p class=\"note\">± is a standard error, STD/√(2&nbsp;n<sub>eff</sub>) of the STD: "
                              "residuals are autocorrelated, and n<sub>eff</sub> is the effective sample size. Inputs "
                              "outside the trained range: {}.</p>\n",
                              describe(run.residual.multi_point.outside.policy));
}

std::string methods_section(const Report& report) {
  HtmlTable table{
      .caption = fmt::format("STD of every method, °/h. Held-out: {}, parameters chosen with all cycles. Nested: "
                             "nested cross-validation, parameters chosen without the held-out cycle. ±, mean, maximum "
                             "and, for a virtual gyro, the error relative to the true bias refer to the random run",
                             plot::escaped(report.folds)),
      .header = {"Inputs", "Method", "Ramp, in-sample", "Held-out", "Nested", "<b>Random</b>", "±", "Mean", "Max",
                 "RMSE, true bias", "Effective par.", "Parameters stored"},
      .text_columns = 2,
      .style = "small"};
  std::map<std::string, std::size_t> sources;
  for (const ReportedMethod& row : report.methods) {
    const data::Figures& random = row.random.figures;
    table.rows.push_back(
        {plot::escaped(row.inputs), method_name(row, sources), plot::format_bias(row.in_sample.std),
         plot::format_bias(row.leave_cycle_out.std), row.nested ? plot::format_bias(row.nested->std) : "–",
         "<b>" + plot::format_bias(random.std) + "</b>", format_std_error(random), plot::format_bias(random.mean),
         plot::format_bias(random.max_abs), format_truth(row.random.to_truth, &data::Figures::rmse),
         plot::decimal(row.effective_parameters, 0),
         row.stored_numbers > 0 ? std::to_string(row.stored_numbers) : "–"});
  }
  return to_html(table) + sources_note(sources);
}

constexpr const char* kFiguresNote =
    "<p>Results of the ramp run are <b>in-sample</b>: the models were fitted to these data. They show how well a model "
    "can describe the record, not how well it will compensate. They are not a verification. Leave-cycle-out predicts "
    "each cycle with a model that was refitted without this cycle. Only the random run verifies a model: it is not "
    "used for selection, scaling, tuning or fitting.</p>\n";

constexpr const char* kNumbersMeaning =
    "<p class=\"note\">STD is the sample standard deviation of the cluster means (eq. 11). The noise floor comes from "
    "second differences of "
    "neighbouring means within the last hour of each hold; it does not contain bias instability that is slower than a "
    "few minutes. "
    "The paper’s "
    "“improvement from traditional method” is a ratio of two percentages; the practical gain is the reduction of the "
    "three-point residual.</p>\n";

constexpr const char* kNoiseMeaning =
    "<p>The bias in the last hour of each hold shows the noise of the gyro, which compensation cannot remove. At "
    "longer averaging times the whole run shows the effect of temperature and the residual effect after "
    "compensation.</p>\n";

/// Builds the page. Numbers sections, tables and figures from 1 in the order of their creation.
class Page {
 public:
  explicit Page(const std::vector<ReportFigure>& figures) : figures_(figures) {}

  void section(const std::string& title) {
    html_ += fmt::format("<h2><span class=\"number\">{}</span>{}</h2>\n", ++sections_, title);
  }
  /// Adds HTML and numbers the captions of its tables.
  void add(std::string html) {
    constexpr std::string_view kCaption = "<caption><span>";
    for (auto at = html.find(kCaption); at != std::string::npos; at = html.find(kCaption, at)) {
      at += kCaption.size();
      html.insert(at, fmt::format("<b>Table {}</b> ", ++tables_));
    }
    html_ += html;
  }
  void figure(const std::string& id, const char* style = "") {
    const auto found = std::ranges::find(figures_, id, &ReportFigure::id);
    assert(found != figures_.end());
    html_ += fmt::format(
        "<figure id=\"{}\" class=\"{}\" tabindex=\"0\">\n{}<figcaption><b>Figure {}</b> {}</figcaption>\n</figure>\n",
        id, style, found->svg, ++numbered_figures_, plot::escaped(found->caption));
  }
  [[nodiscard]] const std::string& html() const { return html_; }

 private:
  const std::vector<ReportFigure>& figures_;
  std::string html_;
  int sections_ = 0, tables_ = 0, numbered_figures_ = 0;
};

void add_experiment(Page& page, const Report& report) {
  page.section("Thermal model of the gyro");
  page.add(thermal_html(report));
  if (report.thermal.model) page.figure("figure-1");
  page.section("Experiment");
  page.add(
      "<p>The chamber follows the profile. Thermometers and gyro are read once a second. All results below are "
      "computed from means over " +
      plot::decimal(report.cluster_length_s, 0) + "&nbsp;s.</p>\n");
  page.figure("figure-4");
  page.section("Noise of the gyro");
  page.add(kNoiseMeaning);
  page.add(noise_section(report));
  page.figure("allan");
  page.section("Selection of gradients");
  page.figure("table-3", "narrow");
  page.figure("figure-5");
  page.add(selection_section(report));
}

void add_results(Page& page, const Report& report) {
  page.section("Compensation in the ramp run");
  page.add(kFiguresNote);
  page.add(result_table(report.rate));
  page.add(kNumbersMeaning);
  page.add(parts_table(report.rate));
  for (const char* id : {"figure-6", "figure-7", "figure-7-with-temperature"}) page.figure(id);
  page.section("Characterisation of the bias");
  page.add(characterisation_html(report));
  page.section("Verification in the random run");
  page.add(result_table(report.random));
  page.add(parts_table(report.random));
  page.figure("figure-8");
  page.figure("figure-8-program");
  page.section("Comparison of methods");
  page.add(methods_section(report));
  page.section("Uncertainty");
  page.add(uncertainty_html(report));
}

void add_appendix(Page& page, const Report& report) {
  page.section("Models and tuning");
  page.add(models_section(report));
  page.figure("tuning");
  page.section("Warnings");
  page.add(warnings_section(report));
  if (const auto thermometers = thermometers_section(report); !thermometers.empty()) {
    page.section("Thermometers");
    page.add(thermometers);
  }
  page.section("Provenance");
  page.add(provenance_section(report));
  page.section("Segments");
  page.add(segments_table(report));
}

}  // namespace

std::string body_html(const Report& report, const std::vector<ReportFigure>& figures) {
  Page page(figures);
  page.add(identity_section(report));
  page.section("Result");
  page.add(summary_section(report));
  add_experiment(page, report);
  add_results(page, report);
  add_appendix(page, report);
  return page.html();
}

std::string to_html(const Report& report, const std::vector<ReportFigure>& figures) {
  return to_html(HtmlPage{.title = "Qualification report – " + report.rig.title,
                          .kind = "Qualification report",
                          .heading = "Temperature compensation of gyro bias",
                          .subtitle = report.rig.title,
                          .simulated = report.rig.is_virtual,
                          .body = body_html(report, figures),
                          .footer = fmt::format("gyrotherm {} · generated from report.json", report.program_version)});
}

namespace {

namespace fs = std::filesystem;

/// Writes all views except report.json.
Result<void> write_views(const std::string& report_json_text, const fs::path& folder) {
  const auto report = read_report(report_json_text, (folder / "report.json").string());
  if (!report) return failure(report.error());
  const auto figures = all_figures(*report);
  std::error_code error;
  fs::create_directories(folder / "figures", error);
  if (error) return failure(FaultKind::storage, (folder / "figures").string(), error.message());
  for (const ReportFigure& figure : figures) {
    if (auto written = replace_text_file((folder / "figures" / (figure.id + ".svg")).string(), figure.svg); !written)
      return written;
  }
  return replace_text_file((folder / "report.html").string(), to_html(*report, figures));
}

}  // namespace

Result<void> write_report(const std::string& report_json_text, const std::string& folder) {
  if (auto written = write_views(report_json_text, folder); !written) return written;
  return replace_text_file((fs::path(folder) / "report.json").string(), report_json_text);
}

Result<void> rebuild_report(const std::string& folder) {
  const auto text = read_text_file((fs::path(folder) / "report.json").string(), kLargestTable);
  if (!text) return failure(text.error());
  return write_views(*text, folder);
}

}  // namespace gyrotherm::report
