#include "report/html_sections.hpp"

#include <fmt/format.h>

#include <cmath>

#include "plot/svg.hpp"
#include "report/html_per_model.hpp"
#include "report/html_table.hpp"

namespace gyrotherm {
namespace {

std::string joined_text(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + escaped(text);
  return all;
}

std::string paragraph(const std::string& html) { return "<p>" + html + "</p>\n"; }

std::string key_figure(const std::string& label, double deg_per_h, const char* style = "") {
  return fmt::format(
      "<div class=\"key {}\"><span class=\"value\">{}</span><span class=\"unit\">°/h</span>"
      "<span class=\"label\">{}</span></div>\n",
      style, bias_text(deg_per_h), label);
}

std::string key_figures(const RunView& run) {
  const auto& residual = run.residual;
  return "<div class=\"keys\">\n" + key_figure("before compensation", run.raw.std) +
         key_figure("three-point", residual.three_point.all.std) +
         key_figure("multi-point", residual.multi_point.all.std) +
         key_figure("multi-point with temperature", residual.multi_point_t.all.std, "best") +
         key_figure("noise floor of the record", run.noise_floor_deg_per_h) + "</div>\n" +
         fmt::format("<p class=\"note\">Standard deviations of the {} run, {}.</p>\n", escaped(run.profile),
                     standing(run));
}

std::string summary_words(const ReportView& view) {
  const RunView& rate = view.rate;
  const RunView& random = view.random;
  return fmt::format(
      "In the {} run the bias varied by {}&nbsp;°/h (standard deviation of {} means over {}&nbsp;s); in the {} run by "
      "{}&nbsp;°/h ({} means). "
      "On the latter the model recommended for use, multi-point with temperature, leaves {}&nbsp;°/h: {} less than "
      "before, and "
      "{} less than the three-point model ({}&nbsp;°/h). The paper’s multi-point model, gradients alone, leaves "
      "{}&nbsp;°/h. "
      "The noise floor of the same record, below which no compensation can honestly go, is {}&nbsp;°/h.",
      escaped(rate.profile), bias_text(rate.raw.std), rate.clusters, decimal(view.cluster_length_s, 0),
      escaped(random.profile), bias_text(random.raw.std), random.clusters,
      bias_text(random.residual.multi_point_t.all.std), percent(random.gain.multi_point_t.from_original),
      percent(random.gain.multi_point_t.residual_reduction), bias_text(random.residual.three_point.all.std),
      bias_text(random.residual.multi_point.all.std), bias_text(random.noise_floor_deg_per_h));
}

std::string verdict_table(const ReportView& view) {
  if (view.limits.empty()) return "<p class=\"note\">The profiles set no limit; no verdict is given.</p>\n";
  HtmlTable table{.header = {"Figure held against a limit", "Value, °/h", "Limit, °/h", "Verdict"}};
  for (const LimitView& limit : view.limits) {
    table.rows.push_back({"<code>" + escaped(limit.figure) + "</code>", bias_text(limit.value), bias_text(limit.limit),
                          limit.passed ? "<b class=\"pass\">PASS</b>" : "<b class=\"fail\">FAIL</b>"});
  }
  return html_of(table);
}

std::string run_row(const RunView& run) {
  std::string text = fmt::format("{} · {} means", escaped(run.profile), run.clusters);
  if (run.gaps > 0) text += fmt::format(" · {} gaps", run.gaps);
  if (run.dropped_gaps > 0) text += fmt::format(" · {} means dropped at gaps", run.dropped_gaps);
  if (run.dropped_rest > 0) text += fmt::format(" · last {} samples not a whole mean", run.dropped_rest);
  return text + " · run <code>" + escaped(run.run_id.substr(0, 12)) + "</code>";
}

std::string definition(const std::string& term, const std::string& html) {
  return "<dt>" + term + "</dt><dd>" + html + "</dd>\n";
}

std::string bounds_text(const char* symbol, std::pair<double, double> log2_bounds) {
  const auto end = [](double value) { return decimal(value, value == std::round(value) ? 0 : 1); };
  return fmt::format("log<sub>2</sub>&nbsp;{}&nbsp;∈&nbsp;[{},&nbsp;{}]", symbol, end(log2_bounds.first),
                     end(log2_bounds.second));
}

}  // namespace

std::string identity_section(const ReportView& view) {
  return "<dl class=\"identity\">\n" +
         definition("Rig", escaped(view.rig_title) + " <code>" + escaped(view.rig_name) + "</code>" +
                               (view.simulated ? " – virtual instruments" : "")) +
         definition("Gyro", escaped(view.gyro)) + definition("Training", run_row(view.rate)) +
         definition("Verification", run_row(view.random)) +
         definition("Zero of the bias", escaped(view.rate.bias_zero)) +
         definition("Program", "gyrotherm " + escaped(view.program_version) + ", seed " + escaped(view.seed)) +
         "</dl>\n";
}

std::string summary_section(const ReportView& view) {
  std::string html = key_figures(view.random) + paragraph(summary_words(view));
  if (view.quick) {
    html += "<p class=\"caution\">Tuned with a small swarm (quick): for a try, not for a calibration.</p>\n";
  }
  if (!view.warnings.empty()) {
    html += fmt::format("<p class=\"note\">{} warning{}: see the section Warnings.</p>\n", view.warnings.size(),
                        view.warnings.size() == 1 ? "" : "s");
  }
  return html + verdict_table(view);
}

std::string selection_section(const ReportView& view) {
  const CorrelationView& correlation = view.correlation;
  HtmlTable table{.caption = "|r| of the bias with each temperature and its rate of change, for comparison",
                  .header = {""},
                  .rows = {{"temperature"}, {"rate of change"}}};
  for (std::size_t k = 0; k < correlation.names.size(); ++k) {
    table.header.push_back(escaped(correlation.names[k]));
    table.rows[0].push_back(decimal(std::abs(correlation.temperature[k]), 3));
    table.rows[1].push_back(decimal(std::abs(correlation.rate[k]), 3));
  }
  return paragraph(fmt::format("Selected: {} gradients of rank {}{}: {}.", correlation.selected_pairs.size(),
                               correlation.rank, correlation.fallback ? ", by the stated fallback" : "",
                               joined_text(correlation.selected_pairs))) +
         (correlation.statement.empty() ? "" : "<p class=\"note\">" + escaped(correlation.statement) + "</p>\n") +
         html_of(table);
}

std::string models_section(const ReportView& view) {
  const auto row = [&](const char* head, auto cell) { return cells(head, view.models, cell); };
  HtmlTable table{
      .caption = "The models, their tuning and their certificates", .header = model_header(""), .style = "even"};
  table.rows = {
      row("Inputs", [](const ModelView& m) { return fmt::format("{} (rank {})", m.terms.size(), m.rank); }),
      row("Trained on", [](const ModelView& m) { return escaped(m.trained_on); }),
      row("Training means", [](const ModelView& m) { return std::to_string(m.trained_clusters); }),
      row("Effective parameters", [](const ModelView& m) { return decimal(m.effective_parameters, 0); }),
      row("Numbers stored", [](const ModelView& m) { return std::to_string(m.stored_numbers); }),
      row("C", [](const ModelView& m) { return significant(m.C); }),
      row("σ", [](const ModelView& m) { return significant(m.sigma); }),
      row("ε (in °/h)",
          [](const ModelView& m) { return significant(m.epsilon) + " (" + decimal(m.epsilon_deg_per_h, 5) + ")"; }),
      row("Support vectors", [](const ModelView& m) { return std::to_string(m.support_vectors); }),
      row("Certified duality gap", [](const ModelView& m) { return significant(m.certified_gap); }),
      row("KKT violation", [](const ModelView& m) { return significant(m.kkt_violation); }),
      row("Swarm",
          [](const ModelView& m) { return fmt::format("{} particles, seed {}", m.particles, escaped(m.seed)); }),
      row("Iterations (evaluations)",
          [](const ModelView& m) {
            return fmt::format("{} of {} ({})", m.history.empty() ? 0 : m.history.size() - 1, m.iterations,
                               m.evaluations);
          }),
      row("End of the search", [](const ModelView& m) { return escaped(m.swarm_end); })};
  const ModelView& m = view.models.multi_point;
  return html_of(table) +
         fmt::format(
             "<p class=\"note\">C and ε are in units of the training STD of the bias, σ in units of standardised "
             "inputs. "
             "Searched: {}, {}, {}.</p>\n",
             bounds_text("C", m.log2_c), bounds_text("σ", m.log2_sigma),
             m.fixed_epsilon > 0 ? "ε fixed at " + significant(m.fixed_epsilon) : bounds_text("ε", m.log2_epsilon)) +
         "<p class=\"note\">Inputs of multi-point: " + joined_text(m.terms) +
         ". Inputs of three-point: " + joined_text(view.models.three_point.terms) + ".</p>\n";
}

std::string warnings_section(const ReportView& view) {
  if (view.warnings.empty()) return "<p>None.</p>\n";
  std::string html = "<ul class=\"warnings\">\n";
  for (const std::string& warning : view.warnings) html += "<li>" + escaped(warning) + "</li>\n";
  return html + "</ul>\n";
}

std::string segments_table(const ReportView& view) {
  HtmlTable table{.caption = "Every segment: its length, its means, and the STD of the residual, °/h",
                  .header = {"Run", "Segment", "", "Start", "Length", "Mean temp., °C", "Mean bias", "Three-point",
                             "Multi-point", "With temp."},
                  .text_columns = 3,
                  .style = "small"};
  for (const SegmentView& s : view.segments) {
    table.rows.push_back({escaped(s.run), escaped(s.name), s.hold ? "hold" : "ramp", hours_text(s.start_s),
                          hours_text(s.duration_s), decimal(s.mean_temperature_c, 2), bias_text(s.mean_bias_deg_per_h),
                          bias_text(s.residual.three_point.std), bias_text(s.residual.multi_point.std),
                          bias_text(s.residual.multi_point_t.std)});
  }
  return html_of(table);
}

std::string thermometers_section(const ReportView& view) {
  if (view.thermometers.empty()) return {};
  HtmlTable table{.header = {"Channel", "Instrument", "Calibration"}, .text_columns = 3, .style = "small"};
  for (const ThermometerView& one : view.thermometers)
    table.rows.push_back({escaped(one.channel), escaped(one.instrument), escaped(one.calibration)});
  return html_of(table);
}

std::string provenance_section(const ReportView& view) {
  const auto code = [](const std::string& text) { return "<code>" + escaped(text) + "</code>"; };
  HtmlTable table{.header = {"What", "Name", "SHA-256"}, .text_columns = 3, .style = "small"};
  table.rows = {{"Rate record", code(view.rate.run_id), code(view.rate.record_sha256)},
                {"Rate profile", escaped(view.rate.profile), code(view.rate.profile_sha256)},
                {"Random record", code(view.random.run_id), code(view.random.record_sha256)},
                {"Random profile", escaped(view.random.profile), code(view.random.profile_sha256)},
                {"Rig", escaped(view.rig_name), code(view.rig_sha256)}};
  return html_of(table);
}

}  // namespace gyrotherm
