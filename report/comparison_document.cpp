// SPDX-License-Identifier: Apache-2.0
#include "report/comparison_document.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

namespace gyrotherm::report {
namespace {

class ComparisonWriter {
 public:
  ComparisonWriter(const Comparison& comparison, Language language)
      : comparison_(comparison), language_(language), by_weight_(by_weight(comparison)) {}

  [[nodiscard]] Document document() const {
    const std::string numbers = sentence(language_, "title.against", number_or_dash(comparison_.now_number),
                                         number_or_dash(comparison_.before_number));
    std::vector<Block> blocks{heading("heading.summary")};
    if (comparison_.simulated) blocks.push_back(caution("say.simulated"));
    if (!comparison_.same_model) blocks.push_back(caution("say.other_model"));
    blocks.push_back(what_is_compared());
    blocks.push_back(key_figures());
    blocks.push_back(Paragraph{.text = verdict()});
    blocks.push_back(heading("heading.changes"));
    blocks.push_back(changes());
    blocks.push_back(Paragraph{Paragraph::Style::note, say("say.normalised_error")});
    return {.language = language_,
            .title = say("title.comparison"),
            .number = numbers,
            .laboratory = comparison_.laboratory,
            .logo = {},
            .mark = comparison_.simulated ? say("mark.simulated") : "",
            .end = sentence(language_, "title.end_of_comparison", numbers),
            .page_of = say("title.page_of"),
            .blocks = std::move(blocks)};
  }

 private:
  [[nodiscard]] std::string say(std::string_view key) const { return std::string(word(language_, key)); }
  [[nodiscard]] Heading heading(std::string_view key) const {
    return {.text = say(key), .id = std::string(key.substr(key.find('.') + 1))};
  }
  [[nodiscard]] Paragraph caution(std::string_view key) const { return {Paragraph::Style::caution, say(key)}; }
  [[nodiscard]] static std::string number_or_dash(const std::string& number) { return number.empty() ? "–" : number; }

  [[nodiscard]] Definitions what_is_compared() const {
    const auto report = [&](const std::string& number, const std::string& sha256) {
      return fmt::format("{}\nSHA-256 {}", number_or_dash(number), sha256);
    };
    Definitions lines{
        {{say("label.item"), sentence(language_, "label.serial_short", comparison_.model, comparison_.serial_number)},
         {say("label.compared_now"), report(comparison_.now_number, comparison_.now_sha256)},
         {say("label.compared_before"), report(comparison_.before_number, comparison_.before_sha256)}}};
    if (std::isfinite(comparison_.days_between))
      lines.lines.emplace_back(say("label.days_between"), format_number(language_, comparison_.days_between, 0));
    return lines;
  }

  [[nodiscard]] std::size_t beyond() const { return count_beyond(comparison_); }

  [[nodiscard]] KeyFigures key_figures() const {
    KeyFigures keys{.title = "", .figures = {}};
    const double greatest = by_weight_.front()->normalised_error;
    keys.figures.push_back(
        {.value = format_number(language_, greatest, 2), .unit = "", .label = say("key.greatest_e_n")});
    keys.figures.push_back({.value = sentence(language_, "title.of", beyond(), by_weight_.size()),
                            .unit = "",
                            .label = say("key.changed"),
                            .best = beyond() == 0});
    return keys;
  }

  [[nodiscard]] std::string verdict() const {
    if (beyond() == 0) return say("say.agrees");
    return sentence(language_, "say.has_changed", beyond(), by_weight_.size());
  }

  [[nodiscard]] std::string stages(const ComparedResult& one) const {
    if (one.before_at == one.now_at) return say(name(one.now_at));
    return say(name(one.before_at)) + " → " + say(name(one.now_at));
  }

  /// "Stabilised bias: Bias / (°/h)", and below where: "u1.x, as left → as found, set point −40, random".
  [[nodiscard]] Cell what(const ComparedResult& one) const {
    std::string text = say(one.key);
    if (one.quantity != one.key) text += ": " + say(one.quantity);
    Cell cell{.text = with_unit(text, one.unit), .note = one.axis};
    const auto add = [&](const std::string& more) { cell.note += (cell.note.empty() ? "" : ", ") + more; };
    add(stages(one));
    if (const auto blank = one.condition.find(' '); blank != std::string::npos)
      add(say(one.condition.substr(0, blank)) + " " + one.condition.substr(blank + 1));
    if (!one.profile.empty()) add(one.profile);
    return cell;
  }

  [[nodiscard]] Cell normalised_error(const ComparedResult& one) const {
    const double found = one.normalised_error;
    if (!std::isfinite(found)) return {.text = "–"};
    return {.mark = std::abs(found) > 1 ? Cell::Mark::fail : Cell::Mark::pass,
            .text = format_number(language_, found, 2)};
  }

  [[nodiscard]] DocumentTable changes() const {
    DocumentTable table{.caption = say("title.table") + " 1: " + say("caption.changes"),
                        .header = {say("column.quantity"), say("column.e_n"), say("column.before"), say("column.now"),
                                   say("column.change")}};
    for (const ComparedResult* one : by_weight_)
      table.rows.push_back({what(*one),
                            normalised_error(*one),
                            {.text = format(language_, one->before)},
                            {.text = format(language_, one->now)},
                            {.text = format(language_, change_of(*one))}});
    return table;
  }

  const Comparison& comparison_;
  const Language language_;
  const std::vector<const ComparedResult*> by_weight_;
};

}  // namespace

Document document_of(const Comparison& comparison, Language language) {
  return ComparisonWriter(comparison, language).document();
}

}  // namespace gyrotherm::report
