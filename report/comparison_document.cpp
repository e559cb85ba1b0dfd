// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "report/comparison.hpp"
#include "report/document_parts.hpp"
#include "report/standard/check_chart.hpp"
#include "report/standard/check_words.hpp"

namespace gyrotherm::report {
namespace {

class ComparisonWriter : public BlockWriter {
 public:
  ComparisonWriter(const Comparison& comparison, Language in_language)
      : BlockWriter(in_language), comparison_(comparison), by_weight_(sort_by_normalised_error(comparison)) {}

  [[nodiscard]] Document document() && {
    heading("heading.summary");
    if (comparison_.simulated) paragraph(translated("say.simulated"), Paragraph::Style::caution);
    add_state(comparison_.now_number, comparison_.now_state);
    add_state(comparison_.before_number, comparison_.before_state);
    if (!comparison_.same_model) paragraph(translated("say.other_model"), Paragraph::Style::caution);
    if (is_check_open(comparison_)) paragraph(check_text("compared.open"), Paragraph::Style::caution);
    add(compared_reports());
    add(key_figures());
    paragraph(describe_changes());
    heading("heading.changes");
    table(changes());
    paragraph(translated("say.normalised_error") + " " + translated("say.expected_share"), Paragraph::Style::note);
    if (comparison_.standard) add_check_standard();
    number_captions();
    const std::string numbers =
        sentence("title.against", number_or_dash(comparison_.now_number), number_or_dash(comparison_.before_number));
    return {.language = language,
            .title = translated("title.comparison"),
            .number = numbers,
            .laboratory = comparison_.laboratory,
            .logo = {},
            .mark = comparison_.simulated ? translated("mark.simulated") : "",
            .end = sentence("title.end_of_comparison", numbers),
            .page_of = translated("title.page_of"),
            .blocks = std::move(blocks)};
  }

 private:
  /// Adds a caution about a compared report that is not valid.
  void add_state(const std::string& number, ReportState state) {
    if (state == ReportState::authorised) return;
    paragraph(sentence(state == ReportState::draft ? "say.compared_draft" : "say.compared_superseded",
                       number_or_dash(number)),
              Paragraph::Style::caution);
  }
  [[nodiscard]] static std::string number_or_dash(const std::string& number) { return number.empty() ? "–" : number; }

  [[nodiscard]] Definitions compared_reports() const {
    const auto report = [&](const std::string& number, ReportState state, const std::string& sha256) {
      return fmt::format("{} ({})\nSHA-256 {}", number_or_dash(number), translated(name(state)), sha256);
    };
    Definitions lines{
        {{translated("label.item"), sentence("label.serial_short", comparison_.model, comparison_.serial_number)},
         {translated("label.compared_now"),
          report(comparison_.now_number, comparison_.now_state, comparison_.now_sha256)},
         {translated("label.compared_before"),
          report(comparison_.before_number, comparison_.before_state, comparison_.before_sha256)}}};
    if (std::isfinite(comparison_.days_between))
      lines.lines.emplace_back(translated("label.days_between"), format_number(language, comparison_.days_between, 0));
    return lines;
  }

  [[nodiscard]] std::string check_text(std::string_view key) const {
    return std::string(standard::check_word(language, key));
  }

  /// Adds the state of the check standard at each record, and its control charts.
  void add_check_standard() {
    add(Heading{.text = check_text("title"), .id = "check-standard"});
    paragraph(describe_standing(*comparison_.standard, language));
    DocumentTable records{.caption = check_text("compared.table"),
                          .header = {check_text("record"), check_text("compared.state"), check_text("compared.before"),
                                     check_text("compared.after")},
                          .text_columns = 4};
    const auto instant = [&](const std::string& utc) { return utc.empty() ? "–" : format_instant(language, utc); };
    for (const CheckedRecord& one : comparison_.checked)
      records.rows.push_back({{.text = one.name,
                               .note = translated(one.is_before ? "label.compared_before" : "label.compared_now") +
                                       ", " + instant(one.started_utc)},
                              {.mark = state_mark(one.state), .text = check_text("state." + one.state)},
                              {.text = instant(one.checked_before)},
                              {.text = instant(one.checked_after)}});
    table(std::move(records));
    const auto sheets = to_svg_sheets(*comparison_.standard, {.language = language});
    for (std::size_t i = 0; i < sheets.size(); ++i)
      add(DocumentFigure{.id = fmt::format("check-standard-charts-{}", i + 1),
                         .caption = sheets[i].caption,
                         .svg = sheets[i].svg,
                         .data = {.logarithmic = true}});  // no data: the page shows the SVG
  }

  [[nodiscard]] static Cell::Mark state_mark(const std::string& state) {
    if (state == "in_control") return Cell::Mark::pass;
    return state == "out_of_control" ? Cell::Mark::fail : Cell::Mark::caution;
  }

  [[nodiscard]] std::string describe_changes() const {
    if (disagreeing() == 0) return translated("say.agrees");
    return disagreeing() == 1 ? sentence("say.one_has_changed", by_weight_.size())
                              : sentence("say.has_changed", disagreeing(), by_weight_.size());
  }
  [[nodiscard]] std::size_t disagreeing() const { return count_disagreements(comparison_); }

  [[nodiscard]] KeyFigures key_figures() const {
    KeyFigures keys{.title = "", .figures = {}};
    const double greatest = by_weight_.front()->normalised_error;
    keys.figures.push_back(
        {.value = format_number(language, greatest, 2), .unit = "", .label = translated("key.greatest_e_n")});
    keys.figures.push_back({.value = sentence("title.of", disagreeing(), by_weight_.size()),
                            .unit = "",
                            .label = translated("key.changed"),
                            .best = disagreeing() == 0});
    return keys;
  }

  [[nodiscard]] std::string stages(const ComparedResult& one) const {
    if (one.before_at == one.now_at) return translated(name(one.now_at));
    return translated(name(one.before_at)) + " → " + translated(name(one.now_at));
  }

  /// Returns "Set point −33.6 °C", or "Set point 20 °C, 2" for the second of several, for a condition of a result.
  [[nodiscard]] std::string condition_text(const std::string& condition) const {
    const auto blank = std::min(condition.find(' '), condition.size());
    std::string text = translated(condition.substr(0, blank));
    double value = 0;
    const char* const end = condition.data() + condition.size();
    const auto read = std::from_chars(condition.data() + std::min(blank + 1, condition.size()), end, value);
    if (read.ec != std::errc{}) return text + condition.substr(blank);
    return text + " " + format_plain(language, value) + "\u00a0°C" + std::string(read.ptr, end);
  }

  /// Returns "R2 → R1, 335 days" for the compared records; empty if both reports have one record.
  [[nodiscard]] std::string pair_text(const ComparedResult& one) const {
    if (one.before_record.empty() && one.now_record.empty()) return {};
    const auto label = [](const std::string& record) { return record.empty() ? std::string("R1") : record; };
    const std::string pair = label(one.before_record) + " → " + label(one.now_record);
    if (!std::isfinite(one.days_between)) return pair;
    return pair + ", " + sentence("label.days", format_number(language, one.days_between, 0));
  }

  /// Returns the name "Hold bias: Bias / (°/h)" with the note "u1.x, as left → as found, set point −40, random".
  [[nodiscard]] Cell result_name(const ComparedResult& one) const {
    std::string text = translated(one.key) + (one.detail.empty() ? "" : " " + one.detail);
    if (const auto quantity = translated(one.quantity); quantity != translated(one.key)) text += ": " + quantity;
    Cell cell{.text = name_with_unit(text, one.unit), .note = one.axis};
    const auto add = [&](const std::string& more) { cell.note += (cell.note.empty() ? "" : ", ") + more; };
    add(stages(one));
    const auto comma = std::min(one.condition.find(", "), one.condition.size());
    if (!one.condition.empty()) add(condition_text(one.condition.substr(0, comma)));
    if (comma < one.condition.size()) add(sentence("label.row", one.condition.substr(comma + 2)));
    if (!one.profile.empty()) add(one.profile);
    if (const std::string pair = pair_text(one); !pair.empty()) add(pair);
    return cell;
  }

  [[nodiscard]] Cell normalised_error(const ComparedResult& one) const {
    const double found = one.normalised_error;
    if (!std::isfinite(found)) return {.text = "–"};
    return {.mark = std::abs(found) > 1 ? Cell::Mark::fail : Cell::Mark::pass,
            .text = format_number(language, found, 2)};
  }

  [[nodiscard]] DocumentTable changes() const {
    DocumentTable table{.caption = translated("caption.changes"),
                        .header = {translated("column.quantity"), translated("column.e_n"), translated("column.before"),
                                   translated("column.now"), translated("column.change")}};
    for (const ComparedResult* one : by_weight_)
      table.rows.push_back({result_name(*one),
                            normalised_error(*one),
                            {.text = format(language, one->before)},
                            {.text = format(language, one->now)},
                            {.text = format(language, change_with_uncertainty(*one))}});
    return table;
  }

  const Comparison& comparison_;
  const std::vector<const ComparedResult*> by_weight_;
};

}  // namespace

Document make_document(const Comparison& comparison, Language language) {
  return ComparisonWriter(comparison, language).document();
}

}  // namespace gyrotherm::report
