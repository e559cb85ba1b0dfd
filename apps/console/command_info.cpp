// SPDX-License-Identifier: Apache-2.0
#include "apps/console/command_info.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "apps/console/command.hpp"

namespace gyrotherm::app {
namespace {

constexpr std::string_view kExampleMark = "Example: ";

/// Parses the permitted values in a type name of CLI11: "a" and "b" in "TEXT:{a,b}".
std::vector<std::string> parse_choices(std::string_view type) {
  std::vector<std::string> choices;
  const auto begins = type.find('{'), ends = type.rfind('}');
  if (begins == std::string_view::npos || ends == std::string_view::npos || ends < begins) return choices;
  for (auto left = type.substr(begins + 1, ends - begins - 1); !left.empty();) {
    const auto comma = left.find(',');
    choices.emplace_back(left.substr(0, comma));
    left = comma == std::string_view::npos ? std::string_view() : left.substr(comma + 1);
  }
  return choices;
}

std::string value_name(const std::string& type, bool has_choices) {
  const auto word = type.substr(0, type.find(':'));
  if (word == "UINT" || word == "INT" || word == "FLOAT") return "N";
  return has_choices && word == "TEXT" ? "WORD" : word;
}

OptionInfo describe_option(const CLI::Option& option) {
  OptionInfo info{.names = {}, .value = "", .choices = {}, .description = option.get_description()};
  for (const auto& name : option.get_snames()) info.names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) info.names.push_back("--" + name);
  info.is_required = option.get_required();
  if (option.get_items_expected_max() == 0) return info;  // a flag
  const auto type = option.get_type_name();
  info.choices = parse_choices(type);
  info.value = value_name(type, !info.choices.empty());
  info.is_repeatable = option.get_items_expected_max() > 1;
  return info;
}

CommandInfo describe_command(const CLI::App& app, const CLI::App& program, std::vector<std::string> path) {
  CommandInfo info{.path = std::move(path), .program = program.get_name(), .example = "", .description = ""};
  info.description = app.get_description();
  if (info.description.starts_with(kExampleMark)) {
    const auto ends = info.description.find("\n\n");
    info.example = info.description.substr(kExampleMark.size(), ends - kExampleMark.size());
    info.description = ends == std::string::npos ? "" : info.description.substr(ends + 2);
  }
  for (const auto* option : app.get_options([](const CLI::Option* each) { return !each->get_group().empty(); }))
    (option->nonpositional() ? info.options : info.positionals).push_back(describe_option(*option));
  for (const auto* subcommands : app.get_subcommands([](const CLI::App* each) { return !each->get_group().empty(); })) {
    auto subcommand_path = info.path;
    subcommand_path.push_back(subcommands->get_name());
    info.subcommands.push_back(describe_command(*subcommands, program, std::move(subcommand_path)));
  }
  return info;
}

const std::vector<ValueKind>& value_kinds() {
  static const std::vector<ValueKind> kinds{{value::kProfile, &kShippedProfile, {"toml"}},
                                            {value::kRig, &kShippedRig, {"toml"}},
                                            {value::kMap, &kShippedImportMap, {"toml"}},
                                            {value::kGyro, &kShippedGyro, {"toml"}},
                                            {value::kRecord, nullptr, {"db"}},
                                            {value::kRecordOrFolder, nullptr, {"db"}},
                                            {value::kModel, nullptr, {"json"}},
                                            {value::kTable, nullptr, {"csv", "txt", "tsv", "log", "ulg", "bin"}},
                                            {value::kToml, nullptr, {"toml"}},
                                            {value::kPem, nullptr, {"pem", "crt", "key"}},
                                            {value::kCode, nullptr, {"c"}},
                                            {value::kFile, nullptr, {}},
                                            {value::kFolder, nullptr, {}, true}};
  return kinds;
}

}  // namespace

const ValueKind* find_value_kind(std::string_view name) {
  const auto found = std::ranges::find(value_kinds(), name, &ValueKind::name);
  return found == value_kinds().end() ? nullptr : &*found;
}

CommandInfo describe_commands(const CLI::App& program) { return describe_command(program, program, {}); }

std::string short_description(const std::string& description) {
  auto text = description.substr(0, description.find_first_of(":;\n"));
  if (const auto ends = text.find(". "); ends != std::string::npos) text.resize(ends);
  if (text.ends_with('.')) text.pop_back();
  const bool is_word = text.size() > 1 && std::islower(static_cast<unsigned char>(text[1])) != 0;
  if (is_word) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

}  // namespace gyrotherm::app
