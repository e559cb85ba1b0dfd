// SPDX-License-Identifier: Apache-2.0
// Reads the conditions of a register map or text description: { register, is | is_not | bits | above }.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_forms.hpp"

namespace gyrotherm::drivers {
namespace {

/// Returns the codes of an item that are not in `excluded`.
std::vector<std::int64_t> collect_other_codes(const RegisterItem& item, const std::vector<std::int64_t>& excluded) {
  std::vector<std::int64_t> others;
  for (const auto& [name, codes] : item.codes)
    for (const auto code : codes)
      if (std::ranges::find(excluded, code) == excluded.end()) others.push_back(code);
  return others;
}

/// Extends the named codes by each value that is not a code: the condition is then that the value is none of the codes
/// without a name in it.
void add_unlisted_values(const TomlTable& table, const char* key, const RegisterMap& map, const RegisterItem& item,
                         Condition& condition) {
  if (item.codes.empty())
    table.note_error(key, fmt::format("\"{}\" is the name of a value that is not in \"codes\", and {} \"{}\" has no "
                                      "codes; name the values that are not \"{}\" in \"codes\"",
                                      item.otherwise, item_kind(map), item.name, item.otherwise));
  if (condition.bits != 0)
    table.note_error(key, fmt::format("flags and \"{0}\", the name of any value that is not in \"codes\", exclude each "
                                      "other in one condition; write a condition for the flags and another for \"{0}\"",
                                      item.otherwise));
  condition.codes = collect_other_codes(item, condition.codes);
  condition.not_these = true;
}

/// Adds the codes and bits of the names in the condition.
void add_meanings(const TomlTable& table, const char* key, const RegisterMap& map, const RegisterItem& item,
                  Condition& condition) {
  bool has_unlisted = false;
  for (const auto& meaning : condition.meanings) {
    const auto codes = item.codes.find(meaning);
    const auto flag = item.flags.find(meaning);
    const bool is_otherwise = !meaning.empty() && meaning == item.otherwise;
    if (codes != item.codes.end())
      condition.codes.insert(condition.codes.end(), codes->second.begin(), codes->second.end());
    if (flag != item.flags.end()) condition.bits |= 1U << flag->second;
    has_unlisted = has_unlisted || is_otherwise;
    if (codes == item.codes.end() && flag == item.flags.end() && !is_otherwise)
      table.note_error(key, describe_unknown_code(map, item, meaning));
  }
  if (has_unlisted) add_unlisted_values(table, key, map, item, condition);
}

std::vector<std::string> read_one_or_more(const TomlTable& table, const char* key) {
  if (table.is_list(key)) return table.texts(key);
  return {table.text(key)};
}

void read_numbers(const TomlTable& table, Condition& condition) {
  for (const auto bit : read_integers(table, "bits", 0, kBitsOfAnyItem - 1))
    condition.bits |= 1U << static_cast<unsigned>(bit);
  if (table.has("above")) condition.above = table.number("above");
}

constexpr std::array kConditionKeys{"is", "is_not", "bits", "above"};

/// Notes an error at each key beside the first, and at a list without elements.
void note_several_keys(const TomlTable& table) {
  const char* first = nullptr;
  for (const auto* key : kConditionKeys) {
    if (!table.has(key)) continue;
    table.ignore(key);
    if (first)
      table.note_error(key,
                       fmt::format("\"{}\" and \"{}\" exclude each other in one condition, expected one of \"is\", "
                                   "\"is_not\", \"bits\", \"above\"",
                                   first, key));
    if (!first) first = key;
    const bool has_numbers = std::string_view(key) == "bits";
    if (table.is_list(key) && (has_numbers ? table.numbers(key).empty() : table.texts(key).empty()))
      table.note_error(key, fmt::format("\"{}\" is empty, expected at least one element", key));
  }
}

/// Notes an error for a condition that the value of the item can never satisfy.
void check_form(const TomlTable& table, const RegisterMap& map, const RegisterItem& item, const Condition& condition) {
  const bool is_number = item.type != RegisterType::text && item.type != RegisterType::date_time;
  const bool has_number = condition.bits != 0 || condition.above;
  if (!is_number && (has_number || !item.readable))
    table.note_error(item_key(table), fmt::format("{} \"{}\" is not a number", item_kind(map), item.name));
  if (const int bits = count_bits(map, item); (std::uint64_t{condition.bits} >> bits) != 0)
    table.note_error("bits", fmt::format("the field of \"{}\" has the bits 0 to {}", item.name, bits - 1));
  const bool is_scaled = item.scale != 1 || item.offset != 0 || item.fahrenheit || !item.decimals.empty();
  if (condition.bits != 0 && is_scaled)
    table.note_error("bits", fmt::format("\"{}\" has a scale, an offset or a unit, so that its value has no bits; "
                                         "expected an item without them",
                                         item.name));
  if (condition.above && item.highest && *condition.above >= *item.highest)
    table.note_error("above",
                     fmt::format("a value above {:g} is impossible by \"highest\" = {:g} of \"{}\", so that this "
                                 "condition would never be true",
                                 *condition.above, *item.highest, item.name));
}

}  // namespace

std::vector<std::int64_t> read_integers(const TomlTable& table, const char* key, std::int64_t low, std::int64_t high) {
  std::vector<std::int64_t> found;
  for (const double number : table.numbers(key))
    if (number >= static_cast<double>(low) && number <= static_cast<double>(high) && number == std::floor(number))
      found.push_back(static_cast<std::int64_t>(number));
    else
      table.note_error(key,
                       fmt::format("\"{}\" contains {}, expected whole numbers from {} to {}", key, number, low, high));
  return found;
}

std::string describe_unknown_code(const RegisterMap& map, const RegisterItem& item, const std::string& name) {
  std::vector<std::string> names;
  for (const auto& [code, numbers] : item.codes) names.push_back(code);
  for (const auto& [flag, bit] : item.flags) names.push_back(flag);
  if (!item.otherwise.empty()) names.push_back(item.otherwise);
  const auto* what = item.codes.empty() && !item.flags.empty() ? "flag" : "code";
  const auto known =
      names.empty() ? fmt::format("it has no {}s", what) : fmt::format("expected one of: {}", fmt::join(names, ", "));
  return fmt::format("{} \"{}\" has no {} named \"{}\"; {}", item_kind(map), item.name, what, name, known);
}

std::optional<double> find_code(const RegisterItem& item, const std::string& meaning) {
  if (const auto code = item.codes.find(meaning); code != item.codes.end() && !code->second.empty())
    return static_cast<double>(code->second.front());
  if (const auto flag = item.flags.find(meaning); flag != item.flags.end())
    return static_cast<double>(std::uint32_t{1} << flag->second);
  return std::nullopt;
}

Condition read_condition(const TomlTable& table, const RegisterMap& map) {
  Condition condition;
  condition.item = table.text(item_key(table));
  const auto* item = find_named_item(map, table, item_key(table), condition.item);
  note_several_keys(table);
  const bool is_negated = table.has("is_not");
  const char* key = is_negated ? "is_not" : "is";
  if (table.has(key)) condition.meanings = read_one_or_more(table, key);
  if (item) add_meanings(table, key, map, *item, condition);
  if (is_negated) condition.not_these = !condition.not_these;
  read_numbers(table, condition);
  if (item) check_form(table, map, *item, condition);
  const bool has_condition = std::ranges::any_of(kConditionKeys, [&](const char* one) { return table.has(one); });
  if (!has_condition && item && !item->flags.empty())
    for (const auto& [name, bit] : item->flags) condition.bits |= 1U << bit;
  else if (!has_condition)
    table.note_error("", "expected \"is\", \"is_not\", \"bits\" or \"above\"");
  return condition;
}

Condition read_readable_condition(const TomlTable& table, const RegisterMap& map) {
  auto condition = read_condition(table, map);
  const auto* item = map.find(condition.item);
  if (item && !item->readable)
    table.note_error(item_key(table),
                     fmt::format("{} \"{}\" cannot be read, so that this condition would never be true", item_kind(map),
                                 item->name));
  return condition;
}

}  // namespace gyrotherm::drivers
