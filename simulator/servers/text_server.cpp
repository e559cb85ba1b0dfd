// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/text_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/toml_reader.hpp"
#include "simulator/servers/text_unit_session.hpp"

namespace gyrotherm::simulator {
namespace {

/// Behaviour of a virtual text unit from the table [simulated].
struct TextBehaviour {
  struct Refusal {
    std::string item, answer;
  };
  std::vector<Refusal> refusals;
  /// Answer to an unknown line; none if empty.
  std::string unknown;
  Duration lag{};
};

std::string usual_refusal(const drivers::TextLink& text) {
  if (text.refused.empty()) return "";
  const double code = text.refusals.empty() ? 0 : static_cast<double>(text.refusals.begin()->first);
  drivers::FieldValues values{{"code", code}, {"reason", std::string("refused")}};
  return text.refused.front().format(values);
}

TextBehaviour read_behaviour(const drivers::RegisterMap& map) {
  const auto& text = *map.text_link;
  TextBehaviour behaviour{.refusals = {}, .unknown = usual_refusal(text)};
  const auto file = TomlTable::parse(map.text, map.name);
  if (!file) return behaviour;
  const auto table = file->table("simulated");
  const auto encoded = [&](const std::string& line) {
    return drivers::to_encoding(line, text.encoding).value_or(line);
  };
  behaviour.unknown = encoded(table.text("unknown", behaviour.unknown));
  behaviour.lag = table.duration("lag", Duration{});
  for (const auto& one : table.tables("refuses"))
    behaviour.refusals.push_back({one.text("item"), encoded(one.text("with"))});
  return behaviour;
}

/// A larger number of a step is none.
constexpr double kMostSteps = 10'000;

class UnitSession final : public TextUnitSession {
 public:
  UnitSession(ServedRegisters& registers, drivers::LinkKind kind, bool has_lag)
      : TextUnitSession(registers.map().find(kind) ? *registers.map().find(kind) : registers.map().link),
        registers_(registers),
        map_(registers.map()),
        text_(*map_.text_link),
        behaviour_(read_behaviour(map_)) {
    if (!has_lag) behaviour_.lag = {};
  }

 private:
  std::optional<std::string> answer_line(const std::string& line) override {
    for (const auto& query : text_.queries) {
      if (std::ranges::find(query.before, line) != query.before.end()) return std::nullopt;
      if (line == query.ask || std::ranges::find(query.also_asked, line) != query.also_asked.end())
        return answer_query(query);
    }
    for (const auto& stored : text_.memory) {
      if (const auto fields = stored.tell.match(line)) return store(stored, *fields, line);
      if (const auto asked = stored.ask ? stored.ask->match(line) : std::nullopt) return show(stored, *asked);
    }
    const drivers::TextCommand* refused = nullptr;
    for (const auto& command : text_.commands) {
      const auto fields = command.tell.match(line);
      if (!fields) continue;
      if (has_codes_of(command, *fields)) return carry_out(command, *fields, line);
      refused = &command;
    }
    if (refused) return refuse(map_.items[refused->item]);
    return refusal();
  }

  /// Returns whether the written value is a code of the command, if the command has codes. The line of another command
  /// may fit otherwise: "PRGM, END, CONST" also fits "PRGM, {value:s}".
  [[nodiscard]] static bool has_codes_of(const drivers::TextCommand& command, const drivers::FieldValues& fields) {
    const auto value = fields.find("value");
    const auto* text = value == fields.end() ? nullptr : std::get_if<std::string>(&value->second);
    return !text || command.codes.empty() || std::ranges::find(command.codes, *text) != command.codes.end();
  }

  [[nodiscard]] std::optional<std::string> refusal() const {
    return behaviour_.unknown.empty() ? std::nullopt : std::optional(behaviour_.unknown);
  }

  std::optional<std::string> answer_query(const drivers::TextQuery& query) {
    std::vector<std::uint16_t> words;
    if (!registers_.read(drivers::ReadFunction::holding_registers, query.first, query.count, words)) return refusal();
    drivers::FieldValues values;
    for (const auto& cell : query.cells) {
      const auto& item = map_.items[cell.item];
      const auto at = static_cast<std::size_t>(item.address - query.first);
      const auto its = std::span(words).subspan(at, word_count(item));
      auto value = to_field(item, cell.codes, words_before_lag(item, {its.begin(), its.end()}));
      if (auto* text = std::get_if<std::string>(&value)) pad_to_width(query.answers.front(), cell.field, *text);
      const auto* number = std::get_if<double>(&value);
      if (!cell.position || !number) {
        values[cell.field] = std::move(value);
        continue;
      }
      auto& list = values.try_emplace(cell.field, std::vector<double>()).first->second;
      std::get<std::vector<double>>(list).push_back(*number);
    }
    for (const auto& mirror : query.mirrors) {
      const auto& item = map_.items[mirror.item];
      std::vector<std::uint16_t> its;
      if (registers_.read(drivers::ReadFunction::holding_registers, item.address, word_count(item), its))
        values[mirror.field] = to_field(item, mirror.codes, words_before_lag(item, std::move(its)));
    }
    return query.answers.front().format(values);
  }

  /// Gives a text the width of its field. A text that was never set has blanks.
  static void pad_to_width(const drivers::TextTemplate& form, const std::string& field, std::string& text) {
    const auto* found = form.find(field);
    if (!found || found->form.kind != drivers::FieldForm::Kind::text || found->form.width == 0) return;
    const auto width = static_cast<std::size_t>(found->form.width);
    if (text.find_first_not_of('?') == std::string::npos) text.clear();
    text.resize(width, ' ');
  }

  /// Returns the former words of an item that was written less than the lag ago.
  std::vector<std::uint16_t> words_before_lag(const drivers::RegisterItem& item, std::vector<std::uint16_t> present) {
    const auto found = former_.find(item.address);
    if (found == former_.end()) return present;
    if (std::chrono::steady_clock::now() < found->second.second) return found->second.first;
    former_.erase(found);
    return present;
  }

  std::optional<std::string> carry_out(const drivers::TextCommand& command, const drivers::FieldValues& fields,
                                       const std::string& line) {
    const auto& own = map_.items[command.item];
    for (const auto& field : command.tell.fields()) {
      const auto value = fields.find(field.name);
      if (value == fields.end()) continue;
      const auto& item = field.name == "value" ? own : *map_.find(field.name);
      if (item.writable && !write_item(item, command.codes, value->second)) return refuse(item);
    }
    if (!command.tell.find("value") && !write_item(own, command.codes, 0.0)) return refuse(own);
    return acknowledge(command.acknowledged, fields, line);
  }

  /// Returns the first form of the acknowledgement of a line; nothing if there is none.
  static std::optional<std::string> acknowledge(const std::vector<drivers::TextTemplate>& forms,
                                                const drivers::FieldValues& fields, const std::string& line) {
    if (forms.empty()) return std::nullopt;
    const auto& acknowledged = forms.front();
    drivers::FieldValues values;
    const auto* rest = acknowledged.find("_");
    if (rest && rest->form.kind == drivers::FieldForm::Kind::text) values["_"] = line;
    if (const auto value = fields.find("value"); value != fields.end()) values["value"] = value->second;
    return acknowledged.format(values);
  }

  /// Returns the index of the step that the fields name; 0 if they name none.
  [[nodiscard]] int find_step(const drivers::FieldValues& fields) const {
    const auto found = fields.find(drivers::kProgramStepField);
    const auto* number = found == fields.end() ? nullptr : std::get_if<double>(&found->second);
    return number ? static_cast<int>(std::clamp(*number, -1.0, kMostSteps)) - map_.memory->first_step : 0;
  }

  /// Stores a line of a program.
  std::optional<std::string> store(const drivers::TextMemoryLine& stored, const drivers::FieldValues& fields,
                                   const std::string& line) {
    const int step = find_step(fields);
    const auto words = to_words(stored, fields);
    if (!words || step < 0 || step >= stored.steps) return refusal();
    if (!words->empty() &&
        !registers_.write(drivers::WriteFunction::registers, stored.address_of(step), *words).has_value())
      return refusal();
    return acknowledge(stored.acknowledged, fields, line);
  }

  /// Answers a question about a line of a program. A step that was not stored is refused.
  [[nodiscard]] std::optional<std::string> show(const drivers::TextMemoryLine& stored,
                                                const drivers::FieldValues& asked) const {
    const int step = find_step(asked);
    const int count = count_steps();
    if (step < 0 || (stored.stride > 0 && step >= count)) return refusal();
    std::vector<std::uint16_t> words;
    if (!registers_.read(drivers::ReadFunction::holding_registers, stored.address_of(step), stored.count, words))
      return refusal();
    auto values = to_fields(stored, words);
    for (const auto& [field, value] : asked) values[field] = value;
    values[drivers::kProgramStepCountField] = static_cast<double>(count);
    return stored.answers.front().format(values);
  }

  /// Counts the steps that were stored since the memory was cleared.
  [[nodiscard]] int count_steps() const {
    const auto first = std::ranges::find_if(text_.memory, [](const auto& one) { return one.stride > 0; });
    if (first == text_.memory.end()) return 0;
    int count = 0;
    for (; count < first->steps; ++count) {
      std::vector<std::uint16_t> words;
      if (!registers_.read(drivers::ReadFunction::holding_registers, first->address_of(count), first->count, words) ||
          std::ranges::all_of(words, [](auto word) { return word == 0; }))
        break;
    }
    return count;
  }

  bool write_item(const drivers::RegisterItem& item, const drivers::CodeTexts& codes,
                  const drivers::FieldValue& value) {
    const auto words = to_words({.field = {}, .item = 0, .codes = codes}, item, value);
    if (!words) return false;
    if (behaviour_.lag > Duration{} && item.readable) {
      std::vector<std::uint16_t> before;
      if (registers_.read(drivers::ReadFunction::holding_registers, item.address, word_count(item), before))
        former_.insert_or_assign(item.address,
                                 std::pair(std::move(before), std::chrono::steady_clock::now() + behaviour_.lag));
    }
    return registers_.write(drivers::WriteFunction::registers, item.address, *words).has_value();
  }

  [[nodiscard]] std::optional<std::string> refuse(const drivers::RegisterItem& item) {
    former_.erase(item.address);
    const auto found = std::ranges::find(behaviour_.refusals, item.name, &TextBehaviour::Refusal::item);
    return found == behaviour_.refusals.end() ? refusal() : std::optional(found->answer);
  }

  ServedRegisters& registers_;
  const drivers::RegisterMap& map_;
  const drivers::TextLink& text_;
  TextBehaviour behaviour_;
  /// Words before the last write and the time until which they are shown, by address.
  std::map<std::uint16_t, std::pair<std::vector<std::uint16_t>, std::chrono::steady_clock::time_point>> former_;
};

}  // namespace

std::unique_ptr<Session> make_text_session(ServedRegisters& registers, drivers::LinkKind kind, bool has_lag) {
  return std::make_unique<UnitSession>(registers, kind, has_lag);
}

}  // namespace gyrotherm::simulator
