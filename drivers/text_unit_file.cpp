// SPDX-License-Identifier: Apache-2.0
#include "drivers/text_unit_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/text_file_reader.hpp"
#include "drivers/supply/supply_description.hpp"
#include "drivers/thermometer/thermometer_description.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::string_view kSchema = "gyrotherm-text/1";
constexpr std::string_view kChamber = "chamber", kSupply = "supply";

/// Returns the confidence of a description after its own reader has checked it.
using KindCheck = Result<std::string> (*)(std::string_view text, const std::string& file,
                                          const TextParameters& parameters);

Result<std::string> check_chamber(std::string_view text, const std::string& file, const TextParameters& parameters) {
  return parse_register_map(text, file, {}, parameters).map([](const RegisterMap& map) {
    return describe_confidence(map);
  });
}

Result<std::string> check_thermometer(std::string_view text, const std::string& file,
                                      const TextParameters& parameters) {
  return parse_thermometer_description(text, file, parameters).map([](const ThermometerDescription& description) {
    return describe_confidence(description);
  });
}

Result<std::string> check_supply(std::string_view text, const std::string& file, const TextParameters& parameters) {
  TextParameters of_supply = parameters;
  of_supply.erase(kOutputParameter);
  return parse_supply_description(text, file, of_supply).map([](const SupplyDescription& description) {
    return describe_confidence(description);
  });
}

/// Kinds with their own reader.
constexpr std::array<std::pair<std::string_view, KindCheck>, 3> kChecks{
    {{kChamber, check_chamber}, {"thermometer", check_thermometer}, {kSupply, check_supply}}};

/// Returns the parameters that a kind has without listing them: the number of a supply's output, by default its first.
TextParameters find_own_parameters(std::string_view kind, const TextParameters& parameters) {
  if (kind != kSupply) return {};
  const auto output = parameters.find(kOutputParameter);
  return {{kOutputParameter, output == parameters.end() ? "1" : output->second}};
}

/// Returns the confidence of the items of a kind without its own reader.
std::string describe_items(const RegisterMap& unit) {
  std::vector<std::string> parts;
  for (const auto& [word, confidence] : kConfidences)
    if (const auto count = std::ranges::count(unit.items, confidence, &RegisterItem::confidence); count > 0)
      parts.push_back(fmt::format("{} {}", count, word));
  return fmt::format("items: {}", parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ", ")));
}

std::vector<PreparingLine> read_preparation(const TomlTable& file, const TextParameters& parameters) {
  const TemplateReader templates(file, read_text_encoding(file.table("link")), parameters);
  std::vector<PreparingLine> lines;
  for (const auto& table : file.table("sequence").tables("prepare")) {
    const auto* const key = table.has("ask") ? "ask" : "tell";
    lines.push_back({.line = templates.read_constant(table, key, table.text(key, "")),
                     .answers = templates.read_all(table, table.has("ask") ? "answer" : "acknowledged")});
  }
  return lines;
}

void ignore_keys(const TomlTable& table) {
  for (const auto& key : table.keys()) table.ignore(key);
}

/// Ignores the keys that belong to a kind of instrument, also in the tables that were read.
void ignore_other_keys(const TomlTable& file) {
  for (const auto& item : file.tables("item")) ignore_keys(item);
  for (const auto& step : file.table("sequence").tables("prepare")) ignore_keys(step);
  for (const auto* read : {"link", "identity", "sequence"}) ignore_keys(file.table(read));
  ignore_keys(file);
}

}  // namespace

Result<TextUnitFile> read_text_unit_file(std::string_view text, const std::string& file,
                                         const TextParameters& parameters) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());
  if (parsed->text("schema", "") != kSchema)
    return failure(FaultKind::usage, file, fmt::format("is not the file of a text instrument (schema {})", kSchema));
  const auto kind = parsed->text("kind");
  TextUnitFile found;
  const auto own = std::ranges::find(kChecks, kind, &decltype(kChecks)::value_type::first);
  if (own != kChecks.end()) {
    auto confidence = own->second(text, file, parameters);
    if (!confidence) return failure(std::move(confidence.error()));
    found.confidence = std::move(*confidence);
  }
  read_text_lines(*parsed, parameters, find_own_parameters(kind, parameters), found.unit);
  found.preparation = read_preparation(*parsed, parameters);
  ignore_other_keys(*parsed);
  if (kind == kChamber) {
    auto map = parse_register_map(text, file, {}, parameters);
    if (!map) return failure(std::move(map.error()));
    found.unit = std::move(*map);
  } else if (auto verdict = parsed->verdict(); !verdict) {
    return failure(std::move(verdict.error()));
  }
  if (own == kChecks.end()) found.confidence = describe_items(found.unit);
  if (auto known = check_parameters(found.unit, parameters); !known) return failure(std::move(known.error()));
  return found;
}

}  // namespace gyrotherm::drivers
