// SPDX-License-Identifier: Apache-2.0
#include "report/dcc_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>

#include "analysis/model/budget.hpp"
#include "report/dsi.hpp"

namespace gyrotherm::report {
namespace {

std::string insert_value(std::string_view text, std::string_view value) {
  std::string result(text);
  if (const auto at = result.find("{}"); at != std::string::npos) result.replace(at, 2, value);
  return result;
}

/// Returns the non-empty texts that persons wrote for this report.
std::vector<const Texts*> collect_texts(const CalibrationReport& report) {
  std::vector<const Texts*> all{&report.title,  &report.item.description, &report.item.condition, &report.place,
                                &report.method, &report.traceability,     &report.remarks};
  for (const Texts& statement : report.statements) all.push_back(&statement);
  for (const Influence& influence : report.influences) all.push_back(&influence.name);
  if (report.replaces) all.push_back(&report.replaces->reason);
  if (report.replaced_by) all.push_back(&report.replaced_by->reason);
  std::erase_if(all, [](const Texts* texts) { return texts->empty(); });
  return all;
}

std::string join_values(const std::vector<ReportedValue>& values, std::string (*text)(const ReportedValue&)) {
  std::string list;
  for (const ReportedValue& value : values) list += (list.empty() ? "" : " ") + text(value);
  return list;
}

std::string repeat_item(std::string_view word, std::size_t count) {
  std::string list(word);
  for (std::size_t i = 1; i < count; ++i) list.append(" ").append(word);
  return list;
}

const char* distribution_name(Certainty certainty) { return certainty == Certainty::with_normal_u ? "normal" : "t"; }

}  // namespace

Texts texts_for(std::string_view key) {
  return {std::string(translate(Language::english, key)), std::string(translate(Language::german, key))};
}

Texts texts_for(std::string_view key, std::string_view value) {
  return {insert_value(translate(Language::english, key), value),
          insert_value(translate(Language::german, key), value)};
}

Texts texts_or_key(std::string_view key) {
  return has_text(key) ? texts_for(key) : Texts{std::string(key), std::string(key)};
}

Texts same_text(std::string_view text) { return {std::string(text), std::string(text)}; }

Texts join_texts(const Texts& first, std::string_view between, const Texts& second) {
  return {fmt::format("{}{}{}", first.en, between, second.en), fmt::format("{}{}{}", first.de, between, second.de)};
}

Language mandatory_language(const CalibrationReport& report) {
  const auto all = collect_texts(report);
  const bool english = std::ranges::none_of(all, [](const Texts* texts) { return texts->en.empty(); });
  const bool german = std::ranges::none_of(all, [](const Texts* texts) { return texts->de.empty(); });
  return german && !english ? Language::german : Language::english;
}

std::string text_or_not_given(std::string_view text) {
  const std::string safe = xml_characters(text);
  return safe.empty() ? "not given" : safe;
}

std::optional<std::string> calendar_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  int numbers[3] = {};
  const std::size_t begins[3] = {0, 5, 8}, lengths[3] = {4, 2, 2};
  for (int part = 0; part < 3; ++part)
    for (const char digit : text.substr(begins[part], lengths[part])) {
      if (std::isdigit(static_cast<unsigned char>(digit)) == 0) return std::nullopt;
      numbers[part] = 10 * numbers[part] + (digit - '0');
    }
  const std::chrono::year_month_day day{std::chrono::year(numbers[0]), std::chrono::month(unsigned(numbers[1])),
                                        std::chrono::day(unsigned(numbers[2]))};
  return day.ok() && numbers[0] > 0 ? std::optional<std::string>(text) : std::nullopt;
}

void DccText::text(const char* name, const Texts& texts, const XmlText::Attributes& attributes) {
  const std::string english = xml_characters(texts.en), german = xml_characters(texts.de);
  xml_.element(name, attributes, [&] {
    const bool replaces_english = english.empty() && mandatory_ == Language::english;
    const bool replaces_german = german.empty() && mandatory_ == Language::german;
    if (!english.empty() || replaces_english)
      xml_.leaf("dcc:content", replaces_english ? "(in German only) " + text_or_not_given(german) : english,
                {{"lang", "en"}});
    if (!german.empty() || replaces_german)
      xml_.leaf("dcc:content", replaces_german ? "(nur auf Englisch) " + text_or_not_given(english) : german,
                {{"lang", "de"}});
  });
}

void DccText::proper_name(const char* name, std::string_view proper) {
  xml_.element(name, [&] { xml_.leaf("dcc:content", text_or_not_given(proper)); });
}

void DccText::identification(const char* issuer, std::string_view value, const Texts& name,
                             const XmlText::Attributes& attributes) {
  xml_.element("dcc:identification", attributes, [&] {
    xml_.leaf("dcc:issuer", issuer);
    xml_.leaf("dcc:value", text_or_not_given(value));
    if (!name.empty()) text("dcc:name", name);
  });
}

void DccText::single_value(const std::string& unit, const ReportedValue& value) {
  xml_.element("si:real", [&] {
    xml_.leaf("si:value", dsi_value(value));
    xml_.leaf("si:unit", unit);
    const Certainty certainty = classify_certainty(value);
    if (certainty <= Certainty::value) return;
    xml_.element("si:measurementUncertaintyUnivariate", [&] {
      xml_.element("si:expandedMU", [&] {
        xml_.leaf("si:valueExpandedMU", dsi_expanded(value));
        xml_.leaf("si:coverageFactor", dsi_coverage_factor(value));
        xml_.leaf("si:coverageProbability", dsi_number(model::kCoverage));
        xml_.leaf("si:distribution", distribution_name(certainty));
      });
    });
  });
}

void DccText::list(const std::string& unit, const std::vector<ReportedValue>& values) {
  xml_.element("si:realListXMLList", [&] {
    xml_.leaf("si:valueXMLList", join_values(values, dsi_value));
    xml_.leaf("si:unitXMLList", unit);
    const Certainty certainty = classify_certainty(values.front());
    if (certainty <= Certainty::value) return;
    const std::size_t count = values.size();
    xml_.element("si:measurementUncertaintyUnivariateXMLList", [&] {
      xml_.element("si:expandedMUXMLList", [&] {
        xml_.leaf("si:valueExpandedMUXMLList", join_values(values, dsi_expanded));
        xml_.leaf("si:coverageFactorXMLList", join_values(values, dsi_coverage_factor));
        xml_.leaf("si:coverageProbabilityXMLList", repeat_item(dsi_number(model::kCoverage), count));
        xml_.leaf("si:distributionXMLList", repeat_item(distribution_name(certainty), count));
      });
    });
  });
}

void DccText::degrees_of_freedom(const std::vector<ReportedValue>& values, const char* element) {
  std::vector<ReportedValue> freedom;
  for (const ReportedValue& value : values) freedom.push_back({.value = value.degrees_of_freedom});
  quantity({"Effective degrees of freedom", "Effektive Freiheitsgrade"}, "gyrotherm_degreesOfFreedom", "1", freedom,
           element);
}

void DccText::quantity(const Texts& name, const std::string& ref_type, std::string_view unit,
                       const std::vector<ReportedValue>& values, const char* element) {
  const auto dsi = dsi_unit(unit);
  if (!dsi) {
    for (const ReportedValue& value : values) quantity_as_text(name, ref_type, unit, value.value, element);
    return;
  }
  xml_.element(element, {{"refType", ref_type}}, [&] {
    text("dcc:name", name);
    values.size() == 1 ? single_value(*dsi, values.front()) : list(*dsi, values);
  });
  if (classify_certainty(values.front()) == Certainty::with_students_u) degrees_of_freedom(values, element);
}

void DccText::quantity(const Texts& name, const std::string& ref_type, const std::vector<std::string>& units,
                       const std::vector<ReportedValue>& values) {
  std::string all;
  std::vector<std::string> in_words;
  bool has_foreign_unit = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto dsi = dsi_unit(units[i]);
    has_foreign_unit = has_foreign_unit || !dsi;
    all += (all.empty() ? "" : " ") + dsi.value_or("");
    in_words.push_back(fmt::format("{} {}", dsi_number(values[i].value), units[i]));
  }
  if (has_foreign_unit) return quantity_of_texts(name, ref_type, in_words);
  xml_.element("dcc:quantity", {{"refType", ref_type}}, [&] {
    text("dcc:name", name);
    values.size() == 1 ? single_value(all, values.front()) : list(all, values);
  });
}

void DccText::quantity_of_texts(const Texts& name, const std::string& ref_type,
                                const std::vector<std::string>& values) {
  std::string list;
  for (const std::string& value : values) {
    std::string item = text_or_not_given(value);
    const auto is_blank = [](char c) { return c == ' ' || c == '\n' || c == '\t'; };
    std::ranges::replace_if(item, is_blank, '_');
    list += (list.empty() ? "" : " ") + item;
  }
  xml_.element("dcc:quantity", {{"refType", ref_type}}, [&] {
    text("dcc:name", name);
    xml_.leaf("dcc:charsXMLList", list);
  });
}

void DccText::quantity_as_text(const Texts& name, const std::string& ref_type, std::string_view unit, double value,
                               const char* element) {
  const Texts not_known = texts_for("label.not_known");
  xml_.element(element, {{"refType", ref_type}}, [&] {
    text("dcc:name", name);
    const std::string number = fmt::format("{} {}", dsi_number(value), unit);
    text("dcc:noQuantity", std::isfinite(value) ? Texts{number, number} : not_known);
  });
}

}  // namespace gyrotherm::report
