// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/standard/check_page.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/number_text.hpp"
#include "report/document.hpp"
#include "report/standard/check_chart.hpp"
#include "report/standard/check_words.hpp"

namespace gyrotherm::app {
namespace {

using assurance::CheckKind;
using report::Cell;
using standard::check_sentence;
using standard::check_word;
using standard::CheckedStandard;
using standard::shown_plateau;

/// Writes the page.
class CheckDocument {
 public:
  CheckDocument(const CheckedStandard& standard, report::Language language)
      : standard_(standard), language_(language) {}

  [[nodiscard]] report::Document document() && {
    const auto& head = standard_.history.head;
    heading("heading.standing");
    if (head.simulated) paragraph(word("simulated"), report::Paragraph::Style::caution);
    add_standing();
    if (standard_.diagnosis) add_cause();
    heading("heading.charts");
    const auto sheets = to_svg_sheets(standard_, {.language = language_});
    for (std::size_t i = 0; i < sheets.size(); ++i)
      blocks_.emplace_back(report::DocumentFigure{.id = fmt::format("charts-{}", i + 1),
                                                  .caption = sheets[i].caption,
                                                  .svg = sheets[i].svg,
                                                  .data = {.logarithmic = true}});  // no data: the page shows the SVG
    heading("heading.runs");
    add_runs();
    if (!standard_.history.explanations.empty()) add_explanations();
    return {.language = language_,
            .title = word("title"),
            .number = fmt::format("{}", fmt::join(head.serial_numbers, ", ")),
            .laboratory = head.rig,
            .logo = {},
            .mark = head.simulated ? std::string(report::translate(language_, "mark.simulated")) : "",
            .end = word("end"),
            .page_of = word("page_of"),
            .blocks = std::move(blocks_)};
  }

 private:
  [[nodiscard]] std::string word(std::string_view key) const { return std::string(check_word(language_, key)); }
  template <class... Values>
  [[nodiscard]] std::string sentence(std::string_view key, const Values&... values) const {
    return check_sentence(language_, key, values...);
  }
  [[nodiscard]] std::string number(double value, int decimals) const {
    return report::format_number(language_, value, decimals);
  }
  void heading(const std::string& key) {
    blocks_.emplace_back(report::Heading{.text = word(key), .id = key.substr(key.find('.') + 1)});
  }
  void paragraph(std::string text, report::Paragraph::Style style = report::Paragraph::Style::plain) {
    blocks_.emplace_back(report::Paragraph{style, std::move(text)});
  }

  void add_standing() {
    const auto& [file, history, assessment, diagnosis] = standard_;
    const auto runs = assessment.runs.size();
    paragraph(describe_standing(standard_, language_),
              assessment.is_open() ? report::Paragraph::Style::caution : report::Paragraph::Style::plain);
    blocks_.emplace_back(
        report::Definitions{{{word("rig"), history.head.rig},
                             {word("serials"), fmt::format("{}", fmt::join(history.head.serial_numbers, ", "))},
                             {word("profile"), history.head.profile},
                             {word("runs"), fmt::format("{}", runs)},
                             {word("last"), report::format_instant(language_, history.checks.back().started_utc)}}});
    const auto rate = report::format_plain(language_, history.head.false_alarm_rate);
    const auto lambda = report::format_plain(language_, assurance::kLambda);
    const auto& [gyro, thermometers] = assessment.limits;
    paragraph(sentence("rate", rate, assessment.charts.size(), number(gyro.individuals, 2), number(gyro.ewma, 2),
                       lambda, number(thermometers.individuals, 2), number(thermometers.ewma, 2)),
              report::Paragraph::Style::note);
  }

  [[nodiscard]] std::string cause(assurance::ChangeCause which) const {
    return word(std::string("cause.") + name(which));
  }

  /// Returns "x, constant" in the language of the page.
  [[nodiscard]] std::string part(const std::string& text) const {
    const auto comma = text.find(", ");
    if (comma == std::string::npos) return text;
    return text.substr(0, comma + 2) + word("part." + text.substr(comma + 2));
  }

  void add_cause() {
    const auto& diagnosis = *standard_.diagnosis;
    heading("heading.cause");
    const auto day = report::format_day(language_, standard_.history.checks[diagnosis.since].started_utc.substr(0, 10));
    std::string causes;
    for (int c = 0; c < 4; ++c) {
      constexpr double kMentioned = 0.05;
      if (diagnosis.probabilities[c] < kMentioned) continue;
      causes += (causes.empty() ? "" : ", ") + cause(static_cast<assurance::ChangeCause>(c)) + " " +
                report::format_probability(language_, diagnosis.probabilities[c]);
    }
    paragraph(sentence(diagnosis.named ? "named" : "not_named", causes, diagnosis.since + 1, day, diagnosis.before,
                       diagnosis.after));
    if (diagnosis.tilt_equals_drift) paragraph(word("equal"), report::Paragraph::Style::note);
    report::DocumentTable table{.caption = word("hypotheses_table"),
                                .header = {word("cause"), word("probability"), word("amount"), word("fit")}};
    constexpr double kListedOnPage = 0.005;
    for (const auto& one : diagnosis.hypotheses) {
      if (one.posterior < kListedOnPage) continue;
      const int decimals = one.amount_u > 0 ? decimals_for(one.amount_u) : 4;
      const auto amount = std::isfinite(one.amount) ? fmt::format("{} ± {} {}", number(one.amount, decimals),
                                                                  number(one.amount_u, decimals), one.unit)
                                                    : "–";
      table.rows.push_back({{.text = cause(one.cause), .note = part(one.part)},
                            {.text = report::format_probability(language_, one.posterior)},
                            {.text = amount},
                            {.text = report::format_probability(language_, one.fits)}});
    }
    blocks_.emplace_back(std::move(table));
  }

  [[nodiscard]] Cell verdict(std::size_t r) const {
    const auto& run = standard_.assessment.runs[r];
    if (run.explanation) return {.mark = Cell::Mark::caution, .text = word("verdict.explained")};
    if (run.is_out()) return {.mark = Cell::Mark::fail, .text = word("verdict.out")};
    const auto& charts = standard_.assessment.charts;
    if (charts.empty() || !charts.front().points[r].is_judged) return {.text = word("verdict.learning")};
    return {.mark = Cell::Mark::pass, .text = word("verdict.in")};
  }

  [[nodiscard]] std::string list_charts(std::size_t r) const {
    std::string text;
    for (const std::size_t c : standard_.assessment.runs[r].charts) {
      const auto& of = standard_.assessment.charts[c].of;
      if (!text.empty()) text += "; ";
      text += of.kind == CheckKind::thermometer ? word("cause.thermometer") + " " + of.thermometer
                                                : word("kind." + name(of.kind)) + " " + of.axis;
      if (!of.plateau.empty()) text += " " + shown_plateau(of.plateau);
    }
    return text.empty() ? "–" : text;
  }

  void add_runs() {
    report::DocumentTable table{.caption = word("runs_table"),
                                .header = {word("run"), word("day"), word("record"), word("verdict"), word("out_in")},
                                .text_columns = 5};
    for (std::size_t r = 0; r < standard_.history.checks.size(); ++r) {
      const auto& check = standard_.history.checks[r];
      table.rows.push_back({{.text = fmt::format("{}", r + 1)},
                            {.text = report::format_day(language_, check.started_utc.substr(0, 10))},
                            {.text = check.record, .note = "SHA-256 " + check.sha256.substr(0, 16) + "…"},
                            verdict(r),
                            {.text = list_charts(r)}});
    }
    blocks_.emplace_back(std::move(table));
  }

  void add_explanations() {
    heading("heading.explanations");
    report::DocumentTable table{.caption = word("explanations_table"),
                                .header = {word("day"), word("cause"), word("by"), word("runs"), word("note")},
                                .text_columns = 5};
    for (const auto& one : standard_.history.explanations) {
      auto note = one.note;
      if (one.new_level) note += (note.empty() ? "" : "; ") + word("new_level");
      table.rows.push_back({{.text = report::format_instant(language_, one.utc)},
                            {.text = word("cause." + one.cause), .note = one.part},
                            {.text = one.by},
                            {.text = fmt::format("{}", one.run_ids.size())},
                            {.text = note.empty() ? "–" : note}});
    }
    blocks_.emplace_back(std::move(table));
  }

  const CheckedStandard& standard_;
  report::Language language_;
  std::vector<report::Block> blocks_;
};

}  // namespace

std::string to_html(const CheckedStandard& standard, report::Language language) {
  return report::to_html(CheckDocument(standard, language).document());
}

}  // namespace gyrotherm::app
