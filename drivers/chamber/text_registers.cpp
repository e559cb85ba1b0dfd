// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/text_registers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/text.hpp"
#include "drivers/line/modbus_lines.hpp"
#include "drivers/line/text_exchange.hpp"
#include "drivers/line/text_frame.hpp"

namespace gyrotherm::drivers {
namespace {

/// A shorter identity may also be the answer to another question.
constexpr std::size_t kShortestIdentity = 5;
constexpr std::size_t kLongestQuote = 80;
constexpr Duration kConnectWithin = std::chrono::seconds(2);
constexpr int kReadTries = 2;
/// Number of failed questions in a row after which another unit may be on the line.
constexpr int kFailuresUntilNewUnit = 5;

std::string quote_line(const std::string& line) {
  const bool is_long = line.size() > kLongestQuote;
  return fmt::format("\"{}{}\"", plain(line.substr(0, kLongestQuote)), is_long ? "…" : "");
}

TextExchangeOptions exchange_options(const RegisterMap& map, const Clock* clock) {
  const auto& wire = map.link.text;
  auto answer_end = wire.frame ? std::string(1, frame_terminator(*wire.frame)) : wire.answer_end;
  return {.question_end = wire.frame ? "" : wire.question_end,
          .answer_end = std::move(answer_end),
          .within = map.link.modbus.timeout,
          .pause = wire.quiet,
          .is_only_instrument = !wire.prefix,
          .clock = clock,
          .longest = wire.longest_answer,
          .silence = wire.silence,
          .resynchronises_after_stray_bytes = true};
}

class TextRegisters final : public Registers {
 public:
  TextRegisters(const RegisterMap& map, std::unique_ptr<ByteStream> stream, std::string place, const Clock* clock)
      : map_(map),
        text_(*map_.text_link),
        place_(std::move(place)),
        exchange_(std::move(stream), exchange_options(map_, clock)) {
    if (map_.link.text.prefix)
      prefix_ = map_.link.text.prefix->format({{"address", static_cast<double>(map_.link.modbus.unit)}});
    // Another program may have asked the unit just before.
    exchange_.rest_before_next(std::max(map_.link.text.after_read, map_.link.text.after_write));
  }

  Result<std::vector<std::uint16_t>> read(ReadFunction, std::uint16_t address, std::uint16_t count) override {
    std::vector<std::uint16_t> words;
    while (words.size() < count) {
      const auto at = static_cast<std::uint16_t>(address + words.size());
      const auto* query = text_.find_query(at);
      if (!query) return failure(FaultKind::refused, place_, "this item has no question");
      auto answer = ask(*query);
      for (int tries = 1; !answer && answer.error().kind == FaultKind::corrupted && tries < kReadTries; ++tries)
        answer = ask(*query);
      if (!answer) return failure(std::move(answer.error()));
      const auto from = static_cast<std::size_t>(at - query->first);
      const auto size = std::min<std::size_t>(answer->size() - from, count - words.size());
      words.insert(words.end(), answer->begin() + static_cast<std::ptrdiff_t>(from),
                   answer->begin() + static_cast<std::ptrdiff_t>(from + size));
    }
    return words;
  }

  Result<void> write(WriteFunction, std::uint16_t address, std::span<const std::uint16_t> words) override {
    const auto* command = text_.find_command(map_, address);
    if (!command) return failure(FaultKind::refused, place_, "this item has no command");
    const auto& item = map_.items[command->item];
    if (words.size() != word_count(item))
      return failure(FaultKind::refused, place_, "only a whole item can be written");
    FieldValues values{{"value", to_field(item, command->codes, words)}};
    if (auto complete = add_present_values(command->tell, values); !complete) return complete;
    auto done = carry_out(*command, command->tell.format(values));
    for (const auto& line : command->then)
      if (done) done = send_line(line);
    return done;
  }

  void end_rest() override { exchange_.end_rest(); }
  std::uint64_t breaks() const override { return breaks_; }

 private:
  [[nodiscard]] ResyncQuery resync() const {
    return identity_answer_.empty()
               ? ResyncQuery{}
               : ResyncQuery{prefix_ + text_.identity_question, answer_prefix() + identity_answer_};
  }
  [[nodiscard]] std::string answer_prefix() const { return map_.link.text.answers_have_prefix ? prefix_ : ""; }

  /// Counts a failure and completes its fault. Forgets the identity after a broken connection, because another unit may
  /// answer on the next connection.
  Fault note_failure(Fault fault, const std::string& question) {
    ++failures_;
    // A unit whose answer to the question of the identity has changed would never resynchronise.
    if (fault.kind == FaultKind::disconnected || failures_ == kFailuresUntilNewUnit) {
      ++breaks_;
      identity_answer_.clear();
    }
    fault.where = place_;
    if (fault.kind == FaultKind::timeout)
      fault.what = fmt::format("no answer to {}: {}", quote_line(question), fault.what);
    return fault;
  }

  Result<std::string> ask_line(const std::string& question) {
    auto answer = exchange_.query(prefix_ + question, resync());
    exchange_.rest_before_next(map_.link.text.after_read);
    if (!answer) return failure(note_failure(std::move(answer.error()), question));
    const auto prefix = answer_prefix();
    if (!answer->starts_with(prefix)) {
      exchange_.reject_answer();
      return failure(FaultKind::corrupted, place_,
                     fmt::format("the answer {} is from another unit", quote_line(*answer)));
    }
    failures_ = 0;
    return answer->substr(prefix.size());
  }

  Result<void> send_line(const std::string& command) {
    auto sent = exchange_.send(prefix_ + command, resync());
    exchange_.rest_before_next(map_.link.text.after_write);
    return sent ? Result<void>{} : failure(note_failure(std::move(sent.error()), command));
  }

  /// Returns the refusal or the fault that an answer means that fits no template of its question.
  tl::unexpected<Fault> not_understood(const std::string& question, const std::string& answer) {
    for (const auto& refused : text_.refused)
      if (const auto found = refused.match(answer))
        return failure(FaultKind::refused, place_,
                       fmt::format("{} was refused: {}", quote_line(question), reason(*found, answer)));
    exchange_.reject_answer();
    return failure(FaultKind::corrupted, place_,
                   fmt::format("{} is no answer to {}", quote_line(answer), quote_line(question)));
  }

  [[nodiscard]] std::string reason(const FieldValues& fields, const std::string& answer) const {
    if (const auto found = fields.find("code"); found != fields.end()) {
      const auto* code = std::get_if<double>(&found->second);
      const auto known = code ? text_.refusals.find(static_cast<std::int64_t>(*code)) : text_.refusals.end();
      if (known != text_.refusals.end()) return fmt::format("{} ({})", known->second, known->first);
    }
    if (const auto found = fields.find("reason"); found != fields.end())
      if (const auto* text = std::get_if<std::string>(&found->second)) return plain(*text);
    return plain(answer);
  }

  /// Returns the words of all items in the answer.
  Result<std::vector<std::uint16_t>> ask(const TextQuery& query) {
    for (const auto& command : query.before)
      if (auto sent = send_line(command); !sent) return failure(std::move(sent.error()));
    const auto answer = ask_line(query.ask);
    if (!answer) return failure(answer.error());
    const bool is_identity = query.ask == text_.identity_question;
    for (const auto& form : query.answers) {
      const auto fields = form.match(*answer, true);
      if (!fields) continue;
      auto words = words_of(query, *fields);
      if (!words) break;
      if (is_identity && answer->size() >= kShortestIdentity) identity_answer_ = *answer;
      return std::move(*words);
    }
    return not_understood(query.ask, *answer);
  }

  /// Returns the registers of the question. An item whose field is missing in this form of the answer has the value
  /// NaN, which no reader accepts.
  [[nodiscard]] std::optional<std::vector<std::uint16_t>> words_of(const TextQuery& query,
                                                                   const FieldValues& fields) const {
    std::vector<std::uint16_t> words;
    for (const auto& cell : query.cells) {
      const auto& item = map_.items[cell.item];
      const auto field = fields.find(cell.field);
      auto its = std::optional<std::vector<std::uint16_t>>(std::in_place, word_count(item), std::uint16_t{0xFFFF});
      if (field != fields.end()) its = to_words(cell, item, field->second);
      if (!its) return std::nullopt;
      words.insert(words.end(), its->begin(), its->end());
    }
    return words;
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
      const auto cell = std::ranges::find(query->cells, field.name, &TextCell::field);
      values[field.name] = to_field(item, cell == query->cells.end() ? CodeTexts{} : cell->codes, words);
    }
    return {};
  }

  Result<void> carry_out(const TextCommand& command, const std::string& line) {
    if (command.acknowledged.empty()) return send_line(line);
    const auto answer = ask_line(line);
    exchange_.rest_before_next(map_.link.text.after_write);
    if (!answer) return failure(answer.error());
    for (const auto& form : command.acknowledged)
      if (form.match(*answer)) return {};
    return not_understood(line, *answer);
  }

  RegisterMap map_;
  const TextLink& text_;
  std::string place_;
  std::string prefix_;
  TextExchange exchange_;
  /// Last answer to the question of the identity on the present connection.
  std::string identity_answer_;
  std::uint64_t breaks_ = 0;
  int failures_ = 0;  ///< in a row
};

}  // namespace

std::unique_ptr<Registers> make_text_registers(const RegisterMap& map, std::unique_ptr<ByteStream> stream,
                                               std::string place, const Clock* clock) {
  if (map.link.text.frame) stream = make_framed_stream(std::move(stream), *map.link.text.frame, clock);
  return std::make_unique<TextRegisters>(map, std::move(stream), std::move(place), clock);
}

std::unique_ptr<Registers> make_registers(const Line& line, const RegisterMap& map) {
  const auto& link = map.link.modbus;
  if (!is_text(map.link.kind)) return make_modbus(line, link);
  const LineDefaults defaults{.port = link.port, .serial = link.serial};
  return make_text_registers(map, make_stream(line, defaults, kConnectWithin),
                             fmt::format("{} {}", map.name, text(line)));
}

}  // namespace gyrotherm::drivers
