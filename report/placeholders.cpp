// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "core/text.hpp"
#include "report/order.hpp"

namespace gyrotherm::report {
namespace {

constexpr std::array<std::string_view, 7> kExamples{
    "inertial laboratory", "1 gyro street",    "a sentence that stands in each report.",      "a. metrologist",
    "o. perator",          "navigation works", "temperatures are traceable to the si through"};
constexpr std::array<std::string_view, 2> kUnfinished{"…", "..."};
constexpr std::array<std::string_view, 4> kMarks{"todo", "tbd", "fixme", "xxx"};
constexpr std::array<std::string_view, 4> kExampleDomains{"example.org", "example.com", "example.net", ".example"};

/// Returns the text with ASCII letters in lower case and without blanks at its ends.
std::string to_lower_trimmed(std::string_view text) {
  std::string lower(trimmed(text, " \t\r\n"));
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

/// Returns true if the text contains `word` between non-alphanumeric characters.
bool has_separate_word(std::string_view text, std::string_view word) {
  const auto is_letter = [&](std::size_t at) {
    return at < text.size() && std::isalnum(static_cast<unsigned char>(text[at])) != 0;
  };
  for (auto at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1))
    if ((at == 0 || !is_letter(at - 1)) && !is_letter(at + word.size())) return true;
  return false;
}

/// Collects the placeholders among the given texts.
class Placeholders {
 public:
  void check(const std::string& key, const std::string& text) {
    if (is_placeholder(text)) found_.push_back(fmt::format("{}, which is the example text \"{}\"", key, plain(text)));
  }
  void check(const std::string& key, const Texts& texts) {
    if (texts.en == texts.de) return check(key, texts.en);
    check(key + ".en", texts.en);
    check(key + ".de", texts.de);
  }
  /// Checks the texts by language or, if there are none, the text.
  void check(const std::string& key, const Texts& texts, const std::string& text) {
    texts.empty() ? check(key, text) : check(key, texts);
  }
  void check(const std::string& prefix, const Party& party) {
    check(prefix + "name", party.name);
    for (const std::string& line : party.address) check(prefix + "address", line);
    check(prefix + "postal_code", party.postal_code);
    check(prefix + "city", party.city);
    check(prefix + "email", party.email);
    check(prefix + "phone", party.phone);
  }
  [[nodiscard]] std::vector<std::string> found() && { return std::move(found_); }

 private:
  std::vector<std::string> found_;
};

void check_laboratory(Placeholders& all, const CalibrationReport& report) {
  const std::string file = "laboratory.toml: ";
  all.check(file, report.laboratory);
  all.check(file + "title", report.title);
  all.check(file + "traceability", report.traceability);
  for (std::size_t i = 0; i < report.statements.size(); ++i)
    all.check(fmt::format("{}statement[{}]", file, i), report.statements[i]);
  for (const Equipment& one : report.equipment) {
    if (!one.channel.empty()) all.check("records: certificate of " + one.channel, one.certificate);
    // Other equipment is taken from the records.
    const bool is_of_laboratory = one.role == "reference" || (one.role == "thermometer" && one.channel.empty());
    if (!is_of_laboratory) continue;
    all.check(file + "equipment.name", one.names, one.name);
    all.check(file + "equipment.serial_number", one.serial_number);
    all.check(file + "equipment.certificate", one.certificate);
  }
  for (std::size_t i = 0; i < report.people.size(); ++i) {
    const std::string person = fmt::format("laboratory.toml or order.toml: person[{}].", i);
    all.check(person + "name", report.people[i].name);
    all.check(person + "email", report.people[i].email);
  }
}

void check_order(Placeholders& all, const CalibrationReport& report) {
  const std::string file = "order.toml: ", unit = file + "unit.";
  all.check(file + "number", report.number);
  all.check(file + "customer.", report.customer);
  all.check(unit + "description", report.item.description);
  all.check(unit + "manufacturer", report.item.manufacturer);
  all.check(unit + "model", report.item.model);
  all.check(unit + "serial_number", report.item.serial_number);
  all.check(unit + "customers_number", report.item.customers_number);
  all.check(unit + "condition", report.item.condition);
  all.check(file + "place", report.place);
  all.check(file + "method", report.method);
  all.check(file + "remarks", report.remarks);
  for (const Influence& one : report.influences) all.check(file + "influence.name", one.name);
  for (const Deviation& one : report.deviations)
    if (one.kind == "stated") all.check(file + "deviation.text", one.translations, one.text);
  if (report.replaces) all.check(file + "replaces.reason", report.replaces->reason);
}

}  // namespace

bool is_placeholder(std::string_view text) {
  const std::string lower = to_lower_trimmed(text);
  const auto has = [&](std::string_view part) { return lower.find(part) != std::string::npos; };
  return std::ranges::find(kExamples, lower) != kExamples.end() || std::ranges::any_of(kUnfinished, has) ||
         std::ranges::any_of(kMarks, [&](std::string_view mark) { return has_separate_word(lower, mark); }) ||
         std::ranges::any_of(kExampleDomains, [&](std::string_view domain) { return lower.ends_with(domain); });
}

std::vector<std::string> find_placeholders(const CalibrationReport& report) {
  Placeholders all;
  check_laboratory(all, report);
  check_order(all, report);
  return std::move(all).found();
}

}  // namespace gyrotherm::report
