// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/text_forms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr int kHexadecimalBase = 16, kDecimalBase = 10, kBitsOfHexadecimalDigit = 4, kBitsOfRegister = 16;

bool is_hexadecimal(const FieldForm& form) { return form.kind == FieldForm::Kind::hexadecimal; }
bool is_single_bit(const FieldForm& form) { return form.kind == FieldForm::Kind::bits && form.width == 1; }

/// Returns the number of values of a hexadecimal field.
double count_values(const FieldForm& form) { return std::exp2(kBitsOfHexadecimalDigit * form.width); }

int count_bits_of_form(const FieldForm& form) {
  return is_single_bit(form) ? 1 : is_hexadecimal(form) ? kBitsOfHexadecimalDigit * form.width : kBitsOfAnyItem;
}

/// Range of the numbers of a field; nothing if any number is possible.
struct FormRange {
  double lowest, highest;
};
std::optional<FormRange> find_form_range(const FieldForm& form, bool has_sign) {
  if (is_single_bit(form)) return FormRange{0, 1};
  if (!is_hexadecimal(form)) return std::nullopt;
  const double size = count_values(form);
  return has_sign ? FormRange{-size / 2, size / 2 - 1} : FormRange{0, size - 1};
}

/// Converts the text of a code to the number that the field reads.
std::optional<std::int64_t> read_code_number(const FieldForm& form, const std::string& text) {
  if (text.starts_with("+-")) return std::nullopt;
  std::int64_t number = 0;
  const auto* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto* end = text.data() + text.size();
  const auto [stop, error] =
      std::from_chars(begin, end, number, is_hexadecimal(form) ? kHexadecimalBase : kDecimalBase);
  return error == std::errc{} && stop == end && begin != end ? std::optional(number) : std::nullopt;
}

CodeTexts assign_texts(const TomlTable& table, const WrittenCodes& written, RegisterItem& item) {
  CodeTexts texts;
  for (const auto& [name, numbers] : written.numbers) {
    item.codes[name] = numbers;
    table.note_error(
        "codes",
        fmt::format("the field of \"{}\" is a text, which is never the number {}; expected a text, as in "
                    "codes = {{ {} = \"{}\" }}",
                    item.name, numbers.empty() ? 0 : numbers.front(), name, numbers.empty() ? 0 : numbers.front()));
  }
  for (const auto& [name, all] : written.texts) {
    auto& codes = item.codes[name];
    for (const auto& text : all) {
      auto found = std::ranges::find(texts, text);
      if (found == texts.end()) found = texts.insert(texts.end(), text);
      const auto position = static_cast<std::int64_t>(found - texts.begin());
      if (std::ranges::find(codes, position) == codes.end()) codes.push_back(position);
    }
  }
  return texts;
}

bool has_negative_code(const RegisterItem& item) {
  return std::ranges::any_of(item.codes, [](const auto& codes) {
    return std::ranges::any_of(codes.second, [](auto code) { return code < 0; });
  });
}

void check_codes_fit(const TomlTable& table, const FieldForm& form, const RegisterItem& item) {
  const auto range = find_form_range(form, !form.is_unsigned && has_negative_code(item));
  if (!range) return;
  for (const auto& [name, codes] : item.codes)
    for (const auto code : codes)
      if (static_cast<double>(code) < range->lowest || static_cast<double>(code) > range->highest)
        table.note_error("codes", fmt::format("the code {} of \"{}\" never occurs: the field has numbers from {} to {}",
                                              code, name, range->lowest, range->highest));
}

/// Calls `act` for each template whose field belongs to an item, with the field.
template <class Action>
void visit_fields(const RegisterMap& map, TextLink& text, const Action& act) {
  for (auto& query : text.queries)
    for (const auto* cells : {&query.cells, &query.mirrors})
      for (const auto& cell : *cells)
        for (auto& answer : query.answers) act(map.items[cell.item].name, answer, cell.field);
  for (auto& command : text.commands) {
    const auto visit = [&](TextTemplate& line) {
      const auto fields = line.fields();
      for (const auto& field : fields)
        act(field.name == "value" ? map.items[command.item].name : field.name, line, field.name);
    };
    visit(command.tell);
    for (auto& line : command.acknowledged) visit(line);
  }
}

/// Calls `act` for each condition of a map.
template <class Action>
void visit_conditions(const RegisterMap& map, const Action& act) {
  const auto visit_steps = [&](const Sequence& steps) {
    for (const auto& step : steps) {
      if (step.kind == SequenceStep::Kind::wait) act(step.until);
      if (step.only_if) act(*step.only_if);
    }
  };
  for (const auto& state : map.states) act(state.when);
  for (const auto& alarm : map.alarms) act(alarm.when);
  for (const auto& [name, steps] : map.sequences) visit_steps(steps);
  for (const auto& power : map.power_switches) {
    act(power.is_on);
    visit_steps(power.on);
    visit_steps(power.off);
  }
  for (const auto& command : map.text_link->commands)
    if (command.then_when) act(*command.then_when);
}

std::set<std::string> find_unsigned_items(const RegisterMap& map) {
  std::set<std::string> names;
  for (const auto& item : map.items)
    if ((!item.codes.empty() || !item.flags.empty()) && !has_negative_code(item)) names.insert(item.name);
  visit_conditions(map, [&](const Condition& condition) {
    const auto* item = map.find(condition.item);
    const bool has_number = condition.bits != 0 || condition.above;
    if (item && has_number && !map.text_link->quantities.contains(item->name) && !has_negative_code(*item))
      names.insert(item->name);
  });
  return names;
}

}  // namespace

bool is_text_form(const FieldForm& form) {
  return form.kind == FieldForm::Kind::text || (form.kind == FieldForm::Kind::bits && form.width > 1);
}

CodeTexts assign_codes(const TomlTable& table, const FieldForm& form, const WrittenCodes& written, RegisterItem& item) {
  if (is_text_form(form)) return assign_texts(table, written, item);
  item.codes = written.numbers;
  for (const auto& [name, texts] : written.texts)
    for (const auto& text : texts) {
      auto& codes = item.codes[name];
      const auto number = read_code_number(form, text);
      if (number && std::ranges::find(codes, *number) == codes.end()) codes.push_back(*number);
      if (!number)
        table.note_error("codes", fmt::format("the field of \"{}\" is a number, which is never the text \"{}\"; for a "
                                              "text write the form s, as in {{value:s}}",
                                              item.name, plain(text)));
    }
  check_codes_fit(table, form, item);
  return {};
}

void check_flags_and_sentinels(const TomlTable& table, const FieldForm& form, const RegisterItem& item) {
  if (is_text_form(form) && !item.flags.empty())
    table.note_error("flags", fmt::format("the field of \"{}\" is a text, expected a whole number for flags, as in "
                                          "{{value:d}} or {{value:x4}}",
                                          item.name));
  const int bits = count_bits_of_form(form);
  for (const auto& [name, bit] : item.flags)
    if (bit >= bits)
      table.note_error("flags",
                       fmt::format("the bit {} of \"{}\" is never set: the field has {} bits", bit, name, bits));
  if (!is_hexadecimal(form)) return;
  const auto lowest = form.is_unsigned ? 0 : -count_values(form) / 2, highest = count_values(form) - 1;
  for (const auto& [why, number] : item.sentinels)
    if (number < lowest || number > highest)
      table.note_error("sentinels", fmt::format("the sentinel {:g} of \"{}\" never occurs: the field has numbers from "
                                                "{} to {}",
                                                number, why, lowest, highest));
}

int count_bits(const RegisterMap& map, const RegisterItem& item) {
  if (!map.text_link) {
    const bool is_bits = item.type == RegisterType::bits;
    const bool is_word = item.type == RegisterType::u16 || item.type == RegisterType::s16;
    return is_bits ? item.bit_count : is_word ? kBitsOfRegister : kBitsOfAnyItem;
  }
  for (const auto& query : map.text_link->queries)
    for (const auto& cell : query.cells)
      for (const auto& answer : query.answers)
        if (const auto* field = &map.items[cell.item] == &item ? answer.find(cell.field) : nullptr)
          return count_bits_of_form(field->form);
  return kBitsOfAnyItem;
}

void select_unsigned_fields(RegisterMap& map) {
  const auto names = find_unsigned_items(map);
  auto text = std::make_shared<TextLink>(*map.text_link);
  std::map<std::string, FieldForm> forms;
  visit_fields(map, *text, [&](const std::string& item, TextTemplate& line, const std::string& field) {
    if (names.contains(item)) line.remove_sign(field);
    if (const auto* found = line.find(field); found && is_hexadecimal(found->form)) forms.emplace(item, found->form);
  });
  for (auto& item : map.items) {
    const auto form = forms.find(item.name);
    if (form == forms.end()) continue;
    const double size = count_values(form->second);
    for (auto& [why, number] : item.sentinels) {
      if (form->second.is_unsigned && number < 0) number += size;
      if (!form->second.is_unsigned && number >= size / 2) number -= size;
    }
  }
  map.text_link = std::move(text);
}

}  // namespace gyrotherm::drivers
