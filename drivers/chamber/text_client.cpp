// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/text_client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/text.hpp"
#include "drivers/line/text_frame.hpp"

namespace gyrotherm::drivers {
namespace {

/// A shorter identity may also be the answer to another question.
constexpr std::size_t kShortestIdentity = 5;
constexpr std::size_t kLongestQuote = 80;
/// Number of failed questions in a row after which another unit may be on the line.
constexpr int kFailuresUntilNewUnit = 5;

std::string quote_line(const std::string& line) {
  const bool is_long = line.size() > kLongestQuote;
  return fmt::format("\"{}{}\"", plain(line.substr(0, kLongestQuote)), is_long ? "…" : "");
}

TextExchangeOptions exchange_options(const RegisterMap& unit, const Clock* clock) {
  const auto& wire = unit.link.text;
  auto answer_end = wire.frame ? std::string(1, frame_terminator(*wire.frame)) : wire.answer_end;
  return {.question_end = wire.frame ? "" : wire.question_end,
          .answer_end = std::move(answer_end),
          .within = unit.link.modbus.timeout,
          .pause = wire.quiet,
          .is_only_instrument = !wire.prefix,
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

ResyncQuery TextClient::resync() const {
  return identity_answer_.empty() ? ResyncQuery{}
                                  : ResyncQuery{prefix_ + text_.identity_question, answer_prefix() + identity_answer_};
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
  if (fault.kind == FaultKind::timeout)
    fault.what = fmt::format("no answer to {}: {}", quote_line(question), fault.what);
  return fault;
}

Result<std::string> TextClient::ask_line(const std::string& question) {
  auto answer = exchange_.query(prefix_ + question, resync());
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

tl::unexpected<Fault> TextClient::not_understood(const std::string& question, const std::string& answer) {
  for (const auto& refused : text_.refused)
    if (const auto found = refused.match(answer))
      return failure(FaultKind::refused, place_,
                     fmt::format("{} was refused: {}", quote_line(question), reason(*found, answer)));
  exchange_.reject_answer();
  return failure(FaultKind::corrupted, place_,
                 fmt::format("{} is no answer to {}", quote_line(answer), quote_line(question)));
}

std::string TextClient::reason(const FieldValues& fields, const std::string& answer) const {
  if (const auto found = fields.find("code"); found != fields.end()) {
    const auto* code = std::get_if<double>(&found->second);
    const auto known = code ? text_.refusals.find(static_cast<std::int64_t>(*code)) : text_.refusals.end();
    if (known != text_.refusals.end()) return fmt::format("{} ({})", known->second, known->first);
  }
  if (const auto found = fields.find("reason"); found != fields.end())
    if (const auto* text = std::get_if<std::string>(&found->second)) return plain(*text);
  return plain(answer);
}

Result<TextAnswer> TextClient::ask_any(const std::string& question, const std::vector<TextTemplate>& answers,
                                       bool exact) {
  auto line = ask_line(question);
  if (!line) return failure(std::move(line.error()));
  for (const auto& form : answers) {
    auto fields = form.match(*line, exact);
    if (!fields) continue;
    if (question == text_.identity_question && line->size() >= kShortestIdentity) identity_answer_ = *line;
    return TextAnswer{std::move(*line), std::move(*fields)};
  }
  return not_understood(question, *line);
}

Result<TextAnswer> TextClient::ask(const std::string& question, const std::vector<TextTemplate>& answers,
                                   std::optional<Duration> within) {
  exchange_.set_time_limit(within.value_or(unit_.link.modbus.timeout));
  return ask_any(question, answers, true);
}

Result<void> TextClient::tell(const std::string& command, const std::vector<TextTemplate>& acknowledged) {
  if (acknowledged.empty()) return send_line(command);
  exchange_.set_time_limit(unit_.link.modbus.timeout);
  auto answer = ask_any(command, acknowledged, false);
  exchange_.rest_before_next(unit_.link.text.after_write);
  return answer ? Result<void>{} : failure(std::move(answer.error()));
}

}  // namespace gyrotherm::drivers
