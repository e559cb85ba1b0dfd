// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/text_client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/sample.hpp"
#include "core/text.hpp"
#include "drivers/chamber/register_item.hpp"
#include "drivers/line/text_frame.hpp"

namespace gyrotherm::drivers {
namespace {

/// A shorter identity may also be the answer to another question.
constexpr std::size_t kShortestIdentity = 5;
/// Number of failed questions in a row after which another unit may be on the line.
constexpr int kFailuresUntilNewUnit = 5;

TextExchangeOptions exchange_options(const RegisterMap& unit, const Clock* clock) {
  const auto& wire = unit.link.text;
  auto answer_end = wire.frame ? std::string(1, frame_terminator(*wire.frame)) : wire.answer_end;
  return {.question_end = wire.frame ? "" : wire.question_end,
          .answer_end = std::move(answer_end),
          .within = unit.link.modbus.timeout,
          .pause = wire.quiet,
          .is_only_instrument = !wire.prefix,
          .is_in_order = true,
          .clock = clock,
          .longest = wire.longest_answer,
          .silence = wire.silence,
          .resynchronises_after_stray_bytes = true};
}

std::unique_ptr<ByteStream> frame_stream(const RegisterMap& unit, std::unique_ptr<ByteStream> stream,
                                         const Clock* clock) {
  const auto& frame = unit.link.text.frame;
  return frame ? make_framed_stream(std::move(stream), *frame, clock) : std::move(stream);
}

}  // namespace

TextClient::TextClient(const RegisterMap& unit, std::unique_ptr<ByteStream> stream, std::string place,
                       const Clock* clock)
    : unit_(unit),
      text_(*unit.text_link),
      place_(std::move(place)),
      exchange_(frame_stream(unit, std::move(stream), clock), exchange_options(unit, clock)) {
  if (unit_.link.text.prefix)
    prefix_ = unit_.link.text.prefix->format({{"address", static_cast<double>(unit_.link.modbus.unit)}});
  // Another program may have asked the unit just before.
  exchange_.rest_before_next(std::max(unit_.link.text.after_read, unit_.link.text.after_write));
}

/// After a broken connection, another unit may answer. Its identity is not known yet, but must fit the file.
ResyncQuery TextClient::resync() const {
  ResyncQuery query{.question = prefix_ + text_.identity_question, .answer_begins = answer_prefix() + identity_answer_};
  if (!identity_answer_.empty()) return query;
  if (!had_identity_) return {};
  query.is_answer = [this](std::string_view answer) { return is_identity(answer.substr(answer_prefix().size())); };
  return query;
}

bool TextClient::is_identity(std::string_view line) const {
  if (line.size() < kShortestIdentity) return false;
  const auto fits = [&](const TextTemplate& form) {
    const auto fields = form.match(line, NumberCheck::point);
    const auto value = fields ? fields->find("value") : FieldValues::const_iterator();
    if (!fields || value == fields->end()) return false;
    const auto* text = std::get_if<std::string>(&value->second);
    return text && (!unit_.identity || fits_expression(unit_.identity->pattern, text->substr(0, kLongestIdentity)));
  };
  const auto fits_as_numbers = [&](const TextTemplate& form) {
    const auto is_text = [](const TextTemplate::Field& field) { return field.form.kind == FieldForm::Kind::text; };
    return std::ranges::none_of(form.fields(), is_text) && form.match(line);
  };
  return std::ranges::any_of(text_.identity_answers, fits) &&
         std::ranges::none_of(text_.queries, [&](const TextQuery& query) {
           return std::ranges::any_of(query.answers, fits_as_numbers);
         });
}

std::string TextClient::answer_prefix() const { return unit_.link.text.answers_have_prefix ? prefix_ : ""; }

/// Notes a broken connection: on the next one no old answer can arrive, and another unit may answer.
Fault TextClient::noted(Fault fault, const std::string& question) {
  ++failures_;
  // A unit whose answer to the question of the identity has changed would never resynchronise.
  if (fault.kind == FaultKind::disconnected || failures_ == kFailuresUntilNewUnit) {
    ++breaks_;
    identity_answer_.clear();
  }
  fault.where = place_;
  if (received_text(fault.what) == std::string(kReceived) + quote_line(prefix_ + question)) {
    fault.kind = FaultKind::corrupted;
    fault.what = echo_hint(question);
  } else if (fault.kind == FaultKind::timeout) {
    fault.what = fmt::format("no answer to {}: {}", quote_line(question), fault.what);
  }
  return fault;
}

Result<std::string> TextClient::ask_line(const std::string& question) {
  // The identity of an unknown unit is reported even if it does not resynchronise the line.
  const bool asks_unknown = identity_answer_.empty() && question == text_.identity_question;
  auto answer = exchange_.query(prefix_ + question, asks_unknown ? ResyncQuery{} : resync());
  exchange_.rest_before_next(unit_.link.text.after_read);
  if (!answer) return failure(noted(std::move(answer.error()), question));
  const auto prefix = answer_prefix();
  if (!answer->starts_with(prefix)) {
    exchange_.reject_answer();
    return failure(FaultKind::corrupted, place_,
                   fmt::format("the answer {} is from another unit", quote_line(*answer)));
  }
  failures_ = 0;
  return answer->substr(prefix.size());
}

Result<void> TextClient::send_line(const std::string& command) {
  auto sent = exchange_.send(prefix_ + command, resync());
  exchange_.rest_before_next(unit_.link.text.after_write);
  return sent ? Result<void>{} : failure(noted(std::move(sent.error()), command));
}

Result<void> TextClient::send_unconfirmed(const std::string& command) {
  exchange_.set_time_limit(unit_.link.modbus.timeout);
  auto sent = exchange_.send_unconfirmed(prefix_ + command);
  exchange_.rest_before_next(unit_.link.text.after_write);
  return sent ? Result<void>{} : failure(noted(std::move(sent.error()), command));
}

bool TextClient::is_echo(const std::string& question, const std::string& answer) const {
  return answer == question || answer == prefix_ + question;
}

bool TextClient::begins_with_echo(const std::string& question, const std::string& answer) const {
  const auto begins_with = [&](const std::string& line) {
    return !line.empty() && answer.size() > line.size() && answer.starts_with(line) &&
           (answer[line.size()] == '\r' || answer[line.size()] == '\n');
  };
  return begins_with(question) || begins_with(prefix_ + question);
}

std::string TextClient::echo_hint(const std::string& question) const {
  return fmt::format("the line repeats the question {}; set echo = true in [{}.link]", quote_line(prefix_ + question),
                     unit_.find("air_temperature") ? "chamber" : "thermometer");
}

tl::unexpected<Fault> TextClient::not_understood(const std::string& question, const std::string& answer) {
  if (is_echo(question, answer)) {
    exchange_.reject_answer();
    return failure(FaultKind::corrupted, place_, echo_hint(question));
  }
  for (const auto& refused : text_.refused)
    if (const auto found = refused.match(answer))
      return failure(FaultKind::refused, place_,
                     fmt::format("{} was refused: {}", quote_line(question), reason(*found, answer)));
  exchange_.reject_answer();
  const auto hint =
      begins_with_echo(question, answer)
          ? fmt::format(": {}, or write the repeated question into the template of the answer", echo_hint(question))
          : "";
  return failure(FaultKind::corrupted, place_,
                 fmt::format("{} is no answer to {}{}", quote_line(answer), quote_line(question), hint));
}

std::string TextClient::reason(const FieldValues& fields, const std::string& answer) const {
  if (const auto found = fields.find("code"); found != fields.end()) {
    const auto* code = std::get_if<double>(&found->second);
    const bool is_whole = code && std::abs(*code) <= static_cast<double>(kLargestCode);
    const auto known = is_whole ? text_.refusals.find(static_cast<std::int64_t>(*code)) : text_.refusals.end();
    if (known != text_.refusals.end()) return fmt::format("{} ({})", known->second, known->first);
  }
  if (const auto found = fields.find("reason"); found != fields.end())
    if (const auto* text = std::get_if<std::string>(&found->second)) return plain(*text);
  return plain(answer);
}

Result<TextAnswer> TextClient::ask_any(const std::string& question, const std::vector<TextTemplate>& answers,
                                       NumberCheck check) {
  auto line = ask_line(question);
  if (!line) return failure(std::move(line.error()));
  // A command may be acknowledged by itself.
  if (check != NumberCheck::none && is_echo(question, *line)) return not_understood(question, *line);
  for (const auto& form : answers) {
    auto fields = form.match(*line, check);
    if (!fields) continue;
    if (question == text_.identity_question) note_identity(*line);
    return TextAnswer{std::move(*line), std::move(*fields)};
  }
  return not_understood(question, *line);
}

/// An answer that only may be an identity does not resynchronise the line.
void TextClient::note_identity(const std::string& line) {
  if (is_identity(line)) {
    identity_answer_ = line;
    had_identity_ = true;
  } else if (had_identity_) {
    identity_answer_.clear();
    exchange_.reject_answer();
  }
}

Result<TextAnswer> TextClient::ask(const std::string& question, const std::vector<TextTemplate>& answers,
                                   std::optional<Duration> within) {
  exchange_.set_time_limit(within.value_or(unit_.link.modbus.timeout));
  const bool can_be_cut = unit_.link.text.answer_end.empty() && !unit_.link.text.frame;
  return ask_any(question, answers, can_be_cut ? NumberCheck::all_decimals : NumberCheck::point);
}

Result<void> TextClient::tell(const std::string& command, const std::vector<TextTemplate>& acknowledged) {
  if (acknowledged.empty()) return send_line(command);
  exchange_.set_time_limit(unit_.link.modbus.timeout);
  auto answer = ask_any(command, acknowledged, NumberCheck::none);
  exchange_.rest_before_next(unit_.link.text.after_write);
  return answer ? Result<void>{} : failure(std::move(answer.error()));
}

}  // namespace gyrotherm::drivers
