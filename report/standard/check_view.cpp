// SPDX-License-Identifier: Apache-2.0
#include "report/standard/check_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/json.hpp"
#include "core/number_text.hpp"
#include "report/standard/check_words.hpp"

namespace gyrotherm::standard {
namespace {

using assurance::CheckedAxis;
using assurance::CheckResult;
using assurance::Hypothesis;

constexpr auto kEnglish = plot::Language::english;
/// Hypotheses with less than this probability are not listed.
constexpr double kListed = 0.005;

const char* chart_verdict(const assurance::ChartPoint& point) {
  if (!point.is_judged) return "not judged";
  if (point.individual_is_out && point.ewma_is_out) return "value and EWMA";
  return point.individual_is_out ? "value" : point.ewma_is_out ? "EWMA" : "in control";
}

/// Returns how many decimals give `width` this number of significant digits; at least 0 and at most 9.
int decimals_for(double width, int digits) {
  if (!std::isfinite(width) || width <= 0) return 4;
  return std::clamp(digits - 1 - static_cast<int>(std::floor(std::log10(width) + 1e-9)), 0, 9);
}

/// Returns "98.2 %". A probability that would round to 0 % or 100 % is "< 0.1 %" or "> 99.9 %", as in the figures.
std::string format_percent(double probability) {
  constexpr double kMinPrinted = 0.0005;
  if (probability < kMinPrinted) return "< 0.1 %";
  if (probability > 1 - kMinPrinted) return "> 99.9 %";
  return fmt::format("{:.1f} %", 100 * probability);
}

/// Returns the value with its limits, or the EWMA with its limit if only the EWMA is out of control.
std::string describe_point(const CheckResult& of, const assurance::ChartPoint& point,
                           const assurance::ChartLimits& limits) {
  const int decimals = decimals_for(point.high - point.low, 3);
  const auto value = fmt::format("{:>12} {}", decimal(point.value, decimals), of.unit);
  if (point.ewma_is_out && !point.individual_is_out)
    return value + fmt::format(", EWMA {}, limits ±{:.2f}", decimal(point.ewma * limits.ewma, 2), limits.ewma);
  return value + fmt::format(", expected {} to {}", decimal(point.low, decimals), decimal(point.high, decimals));
}

std::string list_open_runs(const CheckedStandard& standard) {
  const auto& [file, history, assessment, diagnosis] = standard;
  std::string text;
  for (std::size_t r = 0; r < assessment.runs.size(); ++r) {
    if (!assessment.runs[r].is_open()) continue;
    text += fmt::format("  {} {} {}:\n", r + 1, history.checks[r].started_utc, history.checks[r].record);
    for (const std::size_t c : assessment.runs[r].charts) {
      const auto& chart = assessment.charts[c];
      const auto& point = chart.points[r];
      const auto& limits =
          chart.of.kind == assurance::CheckKind::thermometer ? assessment.limits.thermometers : assessment.limits.gyro;
      text += fmt::format("    {:<36} {} ({})\n", label(chart.of), describe_point(chart.of, point, limits),
                          chart_verdict(point));
    }
  }
  return text;
}

std::string describe_hypothesis(const Hypothesis& one) {
  auto text = fmt::format("    {:>8}  {}", format_percent(one.posterior), name(one.cause));
  if (!one.part.empty()) text += " " + one.part;
  if (std::isfinite(one.amount))
    text += fmt::format(": {} {} (k = 1)", format_with_error(one.amount, one.amount_u), one.unit);
  return text + fmt::format("; χ² {:.1f} of {:g}, P = {:.3f}\n", one.chi_squared, one.degrees, one.fits);
}

Json diagnosis_json(const CheckedStandard& standard) {
  const auto& diagnosis = *standard.diagnosis;
  Json json{{"named", diagnosis.named ? Json(name(*diagnosis.named)) : Json(nullptr)},
            {"since_run_id", standard.history.checks[diagnosis.since].run_id},
            {"runs_before", diagnosis.before},
            {"runs_since", diagnosis.after},
            {"tilt_equals_drift", diagnosis.tilt_equals_drift},
            {"hypotheses", Json::array()}};
  for (const Hypothesis& one : diagnosis.hypotheses)
    json["hypotheses"].push_back({{"cause", name(one.cause)},
                                  {"part", one.part},
                                  {"probability", one.posterior},
                                  {"chi_squared", one.chi_squared},
                                  {"degrees", one.degrees},
                                  {"p", one.fits},
                                  {"amount", one.amount},
                                  {"amount_u", one.amount_u},
                                  {"unit", one.unit}});
  return json;
}

/// Returns a verdict as one of four terms that stay stable.
const char* run_verdict(const CheckedStandard& standard, std::size_t r) {
  const auto& run = standard.assessment.runs[r];
  if (run.explanation) return "explained";
  if (run.is_out()) return "out of control";
  const auto is_judged = [&](const assurance::Chart& chart) { return chart.points[r].is_judged; };
  return std::ranges::any_of(standard.assessment.charts, is_judged) ? "in control" : "not judged";
}

Json limits_json(const assurance::ChartLimits& limits) {
  return {{"values", limits.individuals}, {"ewma", limits.ewma}};
}

Json chart_json(const assurance::Chart& chart) {
  Json json{{"result", label(chart.of)}, {"unit", chart.of.unit}, {"points", Json::array()}};
  for (const auto& point : chart.points)
    json["points"].push_back({{"value", point.value},
                              {"centre", point.centre},
                              {"low", point.low},
                              {"high", point.high},
                              {"q", point.q},
                              {"ewma", point.ewma},
                              {"value_is_out", point.individual_is_out},
                              {"ewma_is_out", point.ewma_is_out}});
  return json;
}

}  // namespace

CheckedStandard assess_standard(assurance::History history, std::string file) {
  CheckedStandard checked{.file = std::move(file), .history = std::move(history), .assessment = {}, .diagnosis = {}};
  checked.assessment = assess(checked.history);
  if (checked.assessment.is_open()) checked.diagnosis = diagnose(checked.history, checked.assessment);
  return checked;
}

Result<CheckedStandard> assess_standard(std::string_view text, const std::string& file) {
  return assurance::parse_history(text, file).map([&](assurance::History history) {
    return assess_standard(std::move(history), file);
  });
}

std::string describe(const CheckedStandard& standard) {
  const auto& [file, history, assessment, diagnosis] = standard;
  const auto& head = history.head;
  auto text = fmt::format("{}check standard {} of the rig {}: {} check runs, {} results each\n",
                          head.simulated ? "SIMULATED " : "", fmt::join(head.serial_numbers, ", "), head.rig,
                          history.checks.size(), assessment.charts.size());
  text += fmt::format(
      "false alarms in control: at most {:g} per run; limits ±{:.2f} (values), ±{:.2f} (EWMA), thermometers "
      "±{:.2f}, ±{:.2f}\n",
      head.false_alarm_rate, assessment.limits.gyro.individuals, assessment.limits.gyro.ewma,
      assessment.limits.thermometers.individuals, assessment.limits.thermometers.ewma);
  if (const auto open = list_open_runs(standard); !open.empty()) {
    text += "out of control and not explained:\n" + open;
  } else {
    const bool judges = !assessment.charts.empty() && assessment.charts.front().points.back().is_judged;
    text += judges ? "in control\n" : std::string(check_word(kEnglish, "learning")) + "\n";
  }
  if (!diagnosis) return text;
  text += fmt::format("cause: {}; change since run {}, {} runs before it and {} since\n",
                      diagnosis->named ? name(*diagnosis->named) : "cannot be told, repeat the check run",
                      diagnosis->since + 1, diagnosis->before, diagnosis->after);
  for (const Hypothesis& one : diagnosis->hypotheses)
    if (one.posterior >= kListed) text += describe_hypothesis(one);
  if (diagnosis->tilt_equals_drift) text += fmt::format("  {}\n", check_word(kEnglish, "equal"));
  return text;
}

std::string to_json(const CheckedStandard& standard) {
  const auto& [file, history, assessment, diagnosis] = standard;
  Json json{{"schema", "gyrotherm-control-charts/1"},
            {"file", file},
            {"head", make_json(history.head)},
            {"is_open", assessment.is_open()},
            {"limits", limits_json(assessment.limits.gyro)},
            {"limits_of_thermometers", limits_json(assessment.limits.thermometers)},
            {"lambda", assurance::kLambda},
            {"runs", Json::array()},
            {"charts", Json::array()},
            {"explanations", Json::array()},
            {"diagnosis", diagnosis ? diagnosis_json(standard) : Json(nullptr)}};
  for (std::size_t r = 0; r < history.checks.size(); ++r) {
    Json charts = Json::array();
    for (const std::size_t c : assessment.runs[r].charts) charts.push_back(label(assessment.charts[c].of));
    json["runs"].push_back({{"run_id", history.checks[r].run_id},
                            {"started_utc", history.checks[r].started_utc},
                            {"record", history.checks[r].record},
                            {"sha256", history.checks[r].sha256},
                            {"out_of_control", std::move(charts)},
                            {"verdict", run_verdict(standard, r)},
                            {"is_explained", assessment.runs[r].explanation.has_value()}});
  }
  for (const auto& chart : assessment.charts) json["charts"].push_back(chart_json(chart));
  for (const auto& one : history.explanations) json["explanations"].push_back(make_json(one));
  return json_text(json) + "\n";
}

}  // namespace gyrotherm::standard
