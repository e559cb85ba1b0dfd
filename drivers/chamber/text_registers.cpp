// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/text_registers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "drivers/chamber/text_client.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/line/modbus_lines.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr Duration kConnectWithin = std::chrono::seconds(2);
constexpr int kReadTries = 2;
/// Content of all registers of an item whose field is missing in the form of the answer.
constexpr std::uint16_t kWordWithoutValue = 0xFFFF;

class TextRegisters final : public Registers {
 public:
  TextRegisters(const RegisterMap& map, std::unique_ptr<ByteStream> stream, std::string place, const Clock* clock)
      : map_(map), text_(*map_.text_link), place_(place), client_(map_, std::move(stream), std::move(place), clock) {}

  Result<std::vector<std::uint16_t>> read(ReadFunction, std::uint16_t address, std::uint16_t count) override {
    if (auto sent = send_pending_lines(); !sent) return failure(std::move(sent.error()));
    std::vector<std::uint16_t> words;
    while (words.size() < count) {
      const auto at = static_cast<std::uint16_t>(address + words.size());
      const auto* query = text_.find_query(at);
      const auto* line = query ? nullptr : text_.find_memory_line(at);
      if (!query && !(line && line->ask)) return failure(FaultKind::refused, place_, "this item has no question");
      const int step = line ? line->step_at(at) : 0;
      const auto read_once = [&] { return query ? ask(*query) : ask_stored(*line, step); };
      auto answer = read_once();
      for (int tries = 1; !answer && answer.error().kind == FaultKind::corrupted && tries < kReadTries; ++tries)
        answer = read_once();
      if (!answer) return failure(std::move(answer.error()));
      const auto from = static_cast<std::size_t>(at - (query ? query->first : line->address_of(step)));
      const auto size = std::min<std::size_t>(answer->size() - from, count - words.size());
      words.insert(words.end(), answer->begin() + static_cast<std::ptrdiff_t>(from),
                   answer->begin() + static_cast<std::ptrdiff_t>(from + size));
    }
    return words;
  }

  Result<void> write(WriteFunction, std::uint16_t address, std::span<const std::uint16_t> words) override {
    if (auto sent = send_pending_lines(); !sent) return sent;
    if (const auto* line = text_.find_memory_line(address)) return store(*line, address, words);
    const auto* command = text_.find_command(map_, address);
    if (!command) return failure(FaultKind::refused, place_, "this item has no command");
    const auto& item = map_.items[command->item];
    if (words.size() != word_count(item))
      return failure(FaultKind::refused, place_, "only a whole item can be written");
    FieldValues values{{"value", to_field(item, command->codes, words)}};
    if (auto complete = add_present_values(command->tell, values); !complete) return complete;
    if (!command->tell.can_format(values)) return value_does_not_fit();
    const auto follows = must_follow(*command);
    if (!follows) return failure(follows.error());
    auto done = client_.tell(command->tell.format(values), command->acknowledged);
    if (done && *follows) pending_ = command->then;
    return done;
  }

  /// Sends the lines that follow the command too, unless they depend on a state of the unit.
  Result<void> write_unconfirmed(WriteFunction, std::uint16_t address, std::span<const std::uint16_t> words) override {
    const auto* command = text_.find_command(map_, address);
    if (!command || words.size() != word_count(map_.items[command->item]))
      return failure(FaultKind::refused, place_, "this item has no command");
    const FieldValues values{{"value", to_field(map_.items[command->item], command->codes, words)}};
    for (const auto& field : command->tell.fields())
      if (field.name != "_" && field.name != "value")
        return failure(FaultKind::refused, place_, "the command repeats a value that must be read");
    if (!command->tell.can_format(values)) return value_does_not_fit();
    pending_.clear();
    auto sent = client_.send_unconfirmed(command->tell.format(values));
    for (const auto& line : command->then)
      if (sent && !command->then_when) sent = client_.send_unconfirmed(line);
    return sent;
  }

  void end_rest() override { client_.end_rest(); }
  std::uint64_t breaks() const override { return client_.breaks(); }

 private:
  [[nodiscard]] tl::unexpected<Fault> value_does_not_fit() const {
    return failure(FaultKind::refused, place_, "the value has more digits than its field in the command");
  }

  /// Returns the words of all items in the answer.
  Result<std::vector<std::uint16_t>> ask(const TextQuery& query) {
    for (const auto& command : query.before)
      if (auto sent = client_.tell(command); !sent) return failure(std::move(sent.error()));
    const auto answer = client_.ask(query.ask, query.answers, query.within);
    if (!answer) return failure(answer.error());
    auto words = words_of(query, answer->fields);
    return words ? Result<std::vector<std::uint16_t>>(std::move(*words))
                 : client_.not_understood(query.ask, answer->line);
  }

  /// Sends a line of a program.
  Result<void> store(const TextMemoryLine& line, std::uint16_t address, std::span<const std::uint16_t> words) {
    if (words.size() != line.count || address != line.address_of(line.step_at(address)))
      return failure(FaultKind::refused, place_, "only a whole line of a program can be written");
    const auto fields = to_fields(line, words);
    if (!line.tell.can_format(fields)) return value_does_not_fit();
    if (const auto number = fields.find(kProgramNumberField); number != fields.end()) program_ = number->second;
    return client_.tell(line.tell.format(fields), line.acknowledged);
  }

  /// Reads a line of the program that was written last. Returns its registers.
  Result<std::vector<std::uint16_t>> ask_stored(const TextMemoryLine& line, int step) {
    FieldValues fields{{kProgramNumberField, program_},
                       {kProgramStepField, static_cast<double>(step + map_.memory->first_step)}};
    const auto question = line.ask->format(fields);
    const auto answer = client_.ask(question, line.answers);
    if (!answer) return failure(answer.error());
    for (const auto& [field, value] : answer->fields) fields[field] = value;
    auto words = to_words(line, fields);
    return words ? Result<std::vector<std::uint16_t>>(std::move(*words))
                 : client_.not_understood(question, answer->line);
  }

  /// Returns the registers of the question. An item whose field is missing in this form of the answer has no value
  /// (has_no_value()).
  [[nodiscard]] std::optional<std::vector<std::uint16_t>> words_of(const TextQuery& query,
                                                                   const FieldValues& fields) const {
    std::vector<std::uint16_t> words;
    for (const auto& cell : query.cells) {
      const auto& item = map_.items[cell.item];
      const auto field = fields.find(cell.field);
      auto its = std::optional(std::vector<std::uint16_t>(word_count(item), kWordWithoutValue));
      if (field != fields.end()) its = to_words(cell, item, field->second);
      if (!its) return std::nullopt;
      words.insert(words.end(), its->begin(), its->end());
    }
    return words;
  }

  /// Sends the lines that follow the last command. They wait until the next exchange, because a unit that needs a long
  /// pause would otherwise delay the caller.
  Result<void> send_pending_lines() {
    for (const auto& line : std::exchange(pending_, {}))
      if (auto sent = client_.tell(line); !sent) return sent;
    return {};
  }

  /// Returns whether the lines after a command are sent.
  Result<bool> must_follow(const TextCommand& command) {
    if (command.then.empty() || !command.then_when) return true;
    const auto& item = *map_.find(command.then_when->item);
    const auto words = read(ReadFunction::holding_registers, item.address, word_count(item));
    if (!words) return failure(words.error());
    const auto value = decode(item, *words);
    if (!value) return failure(value.error());
    return evaluate(*command.then_when, item, *value);
  }

  /// Adds the values of the other items that a command repeats.
  Result<void> add_present_values(const TextTemplate& tell, FieldValues& values) {
    std::vector<std::pair<const TextQuery*, std::vector<std::uint16_t>>> answers;
    for (const auto& field : tell.fields()) {
      if (field.name == "_" || values.contains(field.name)) continue;
      const auto& item = *map_.find(field.name);
      const auto* query = text_.find_query(item.address);
      auto known = std::ranges::find(answers, query, &decltype(answers)::value_type::first);
      if (known == answers.end()) {
        auto answer = ask(*query);
        if (!answer) return failure(std::move(answer.error()));
        known = answers.emplace(answers.end(), query, std::move(*answer));
      }
      const auto words =
          std::span(known->second).subspan(static_cast<std::size_t>(item.address - query->first), word_count(item));
      const auto cell =
          std::ranges::find(query->cells, static_cast<std::size_t>(&item - map_.items.data()), &TextCell::item);
      values[field.name] = to_field(item, cell == query->cells.end() ? CodeTexts{} : cell->codes, words);
    }
    return {};
  }

  RegisterMap map_;
  const TextLink& text_;
  std::string place_;
  TextClient client_;
  std::vector<std::string> pending_;
  /// Number of the program that was written last.
  FieldValue program_ = 0.0;
};

}  // namespace

bool has_no_value(const RegisterMap& map, const RegisterItem& item, std::span<const std::uint16_t> words) {
  return map.text_link && item.type != RegisterType::text && !words.empty() &&
         std::ranges::all_of(words, [](std::uint16_t word) { return word == kWordWithoutValue; });
}

std::unique_ptr<Registers> make_text_registers(const RegisterMap& map, std::unique_ptr<ByteStream> stream,
                                               std::string place, const Clock* clock) {
  return std::make_unique<TextRegisters>(map, std::move(stream), std::move(place), clock);
}

std::unique_ptr<ByteStream> make_text_stream(const Line& line, const RegisterMap& map) {
  const auto& link = map.link.modbus;
  auto stream = make_stream(line, {.port = link.port, .serial = link.serial}, kConnectWithin);
  return link.echo ? make_echo_stream(std::move(stream), nullptr, map.link.text.longest_answer) : std::move(stream);
}

std::unique_ptr<Registers> make_registers(const Line& line, const RegisterMap& map) {
  if (!is_text(map.link.kind)) return make_modbus(line, map.link.modbus);
  return make_text_registers(map, make_text_stream(line, map), fmt::format("{} {}", map.name, text(line)));
}

}  // namespace gyrotherm::drivers
