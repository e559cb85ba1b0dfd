// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/text_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/deadline.hpp"
#include "core/sample.hpp"
#include "core/text.hpp"

namespace gyrotherm::drivers {

namespace {

constexpr std::size_t kReadBufferSize = 256;
constexpr std::size_t kLongestQuote = 80;
/// Bytes that an idle bus adds between lines. They do not occur in a line.
constexpr std::string_view kNoise("\0\xFF", 2);

void remove_noise_before(std::string& text) { text.erase(0, std::min(text.find_first_not_of(kNoise), text.size())); }
/// Not a whole number of seconds, to avoid synchronisation with faults that repeat every second.
constexpr Duration kRestPeriod = std::chrono::milliseconds(3250);

}  // namespace

std::string quote_line(std::string_view line) {
  return fmt::format("\"{}{}\"", plain(line.substr(0, kLongestQuote)), line.size() > kLongestQuote ? "…" : "");
}

TextExchange::TextExchange(std::unique_ptr<ByteStream> line, TextExchangeOptions options)
    : line_(std::move(line)), options_(std::move(options)) {}

Result<void> TextExchange::wait_for_silence(bool resync_follows) {
  std::array<std::byte, kReadBufferSize> stale;
  const bool is_in_order = options_.is_only_instrument && resync_follows && !is_resync_outstanding_;
  auto pause = answer_may_come_late_ && !is_in_order ? options_.within : options_.pause;
  if (quiet_until_) pause = std::max(pause, quiet_until_->left());
  quiet_until_.reset();
  const Deadline deadline(std::max(options_.within, pause), options_.clock);
  do {
    const auto size = line_->read(stale, pause);
    const bool is_unexpected = size && !answer_may_come_late_ && !must_resynchronise_;
    if (is_unexpected && options_.resynchronises_after_stray_bytes) must_resynchronise_ = true;
    if (size) continue;
    if (size.error().kind != FaultKind::timeout) return failure(size.error());
    answer_may_come_late_ = answer_may_come_late_ && is_in_order;
    return {};
  } while (!deadline.has_passed());
  return failure(FaultKind::corrupted, "", "the line does not become silent");
}

/// Reads lines until `expected` accepts one. Discards earlier lines, which answer older questions. Without a
/// terminator, the bytes up to a silence are one line.
Result<std::string> TextExchange::receive(const ResyncQuery& expected) {
  std::string text;
  std::array<std::byte, kReadBufferSize> buffer;
  const Deadline deadline(options_.within, options_.clock);
  const bool ends_by_silence = options_.answer_end.empty();
  while (true) {
    const auto patience = ends_by_silence && !text.empty() ? options_.silence : deadline.left();
    const auto size =
        line_->read(std::span(buffer).first(std::min(kReadBufferSize, options_.longest - text.size())), patience);
    if (!size) {
      const bool is_end = ends_by_silence && !text.empty() && size.error().kind == FaultKind::timeout;
      if (expected.accepts(text) && is_end) return text;
      if (!text.empty()) discarded_ = text;
      if (!is_end) return failure(with_discarded(size.error()));
      return failure(with_discarded({FaultKind::corrupted, "", "answer to another question"}));
    }
    text.append(reinterpret_cast<const char*>(buffer.data()), *size);
    remove_noise_before(text);
    for (auto end = ends_by_silence ? std::string::npos : text.find(options_.answer_end); end != std::string::npos;
         end = text.find(options_.answer_end)) {
      auto after = text.substr(end + options_.answer_end.size());
      remove_noise_before(after);
      text.resize(end);
      if (expected.accepts(text) && after.empty()) return text;
      if (expected.accepts(text)) {
        discarded_ = text;
        return failure(with_discarded({FaultKind::corrupted, "", "more than one line in the answer"}));
      }
      discarded_ = std::exchange(text, std::move(after));
    }
    if (text.size() == options_.longest)
      return failure(FaultKind::corrupted, "", fmt::format("no end of line in {} bytes", options_.longest));
  }
}

Fault TextExchange::with_discarded(Fault fault) const {
  if (!discarded_.empty() && fault.kind != FaultKind::disconnected)
    fault.what += std::string(kReceived) + quote_line(discarded_);
  return fault;
}

Result<void> TextExchange::discard(Duration first_pause, Duration pause, Duration within) {
  std::array<std::byte, kReadBufferSize> stale;
  const Deadline deadline(within, options_.clock);
  for (auto silence = first_pause; !deadline.has_passed(); silence = pause) {
    const auto size = line_->read(stale, std::min(silence, deadline.left()));
    if (!size && size.error().kind == FaultKind::disconnected) return failure(size.error());
    if (!size) return {};
  }
  return {};
}

/// Waits after the command too, because a unit may not take the next command while it answers this one.
Result<void> TextExchange::send_unconfirmed(std::string_view command) {
  end_rest();
  const auto pause = std::max(options_.pause, quiet_until_ ? quiet_until_->left() : Duration{});
  quiet_until_.reset();
  if (auto ready = discard(pause, pause, std::max(pause, options_.within)); !ready) return ready;
  const auto sent = transmit(command);
  must_resynchronise_ = answer_may_come_late_ = true;
  // An echo that differs shows that the bytes were sent.
  if (!sent && sent.error().kind != FaultKind::corrupted) return sent;
  return discard(options_.within, options_.pause, options_.within);
}

Result<void> TextExchange::transmit(std::string_view text) {
  const auto line = std::string(text) + options_.question_end;
  auto sent = line_->write(std::as_bytes(std::span(line)), options_.within);
  if (!sent) answer_may_come_late_ = answer_may_come_late_ || sent.error().kind != FaultKind::disconnected;
  return sent;
}

Result<std::string> TextExchange::exchange(std::string_view question, const ResyncQuery& expected) {
  if (auto sent = transmit(question); !sent) return failure(std::move(sent.error()));
  answer_may_come_late_ = true;
  auto answer = receive(expected);
  answer_may_come_late_ = !answer;
  if (answer) discarded_.clear();
  return answer;
}

Result<void> TextExchange::send_resync(const ResyncQuery& resync) {
  const auto answer = exchange(resync.question, resync);
  must_resynchronise_ = !answer;
  is_resync_outstanding_ = is_resync_outstanding_ || (answers_in_order() && !answer);
  if (answer) return {};
  rest_.emplace(kRestPeriod, options_.clock);
  return failure(answer.error());
}

/// Waits for silence, and resynchronises after a lost answer.
Result<void> TextExchange::prepare(const ResyncQuery& resync) {
  if (rest_ && !rest_->has_passed())
    return failure(with_discarded({FaultKind::timeout, "", "waiting after lost answers"}));
  rest_.reset();
  if (auto silent = wait_for_silence(must_resynchronise_ && !resync.question.empty()); !silent) return silent;
  return must_resynchronise_ && !resync.question.empty() ? send_resync(resync) : Result<void>{};
}

Result<void> TextExchange::send(std::string_view command, const ResyncQuery& resync) {
  if (auto ready = prepare(resync); !ready) return ready;
  return transmit(command);
}

Result<std::string> TextExchange::query(std::string_view question, const ResyncQuery& resync) {
  if (auto ready = prepare(resync); !ready) return failure(std::move(ready.error()));
  auto answer = exchange(question);
  const bool is_resync = question == resync.question;
  if (answer && answers_in_order() && !is_resync && !resync.question.empty() && resync.accepts(*answer))
    answer = failure(FaultKind::corrupted, "", "answer to an earlier command");
  must_resynchronise_ = !answer;
  if (!answer && is_resync_outstanding_) rest_.emplace(kRestPeriod, options_.clock);
  if (answer && !is_resync) is_resync_outstanding_ = false;  // no answer to resync can follow
  if (!answer && is_resync) is_resync_outstanding_ = answers_in_order();
  return answer;
}

}  // namespace gyrotherm::drivers
