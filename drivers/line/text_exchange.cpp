// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/text_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/deadline.hpp"

namespace gyrotherm::drivers {

namespace {

constexpr std::size_t kReadBufferSize = 256;
/// Bytes that an idle bus adds between lines. They do not occur in a line.
constexpr std::string_view kNoise("\0\xFF", 2);

void remove_noise_before(std::string& text) { text.erase(0, std::min(text.find_first_not_of(kNoise), text.size())); }
/// Not a whole number of seconds, to avoid synchronisation with faults that repeat every second.
constexpr Duration kRestPeriod = std::chrono::milliseconds(3250);

}  // namespace

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
      if (!is_end) return failure(size.error());
      if (expected.accepts(text)) return text;
      return failure(FaultKind::corrupted, "", "answer to another question");
    }
    text.append(reinterpret_cast<const char*>(buffer.data()), *size);
    remove_noise_before(text);
    for (auto end = ends_by_silence ? std::string::npos : text.find(options_.answer_end); end != std::string::npos;
         end = text.find(options_.answer_end)) {
      auto after = text.substr(end + options_.answer_end.size());
      remove_noise_before(after);
      text.resize(end);
      if (expected.accepts(text))
        return after.empty() ? Result<std::string>(std::move(text))
                             : failure(FaultKind::corrupted, "", "more than one line in the answer");
      text = after;
    }
    if (text.size() == options_.longest)
      return failure(FaultKind::corrupted, "", fmt::format("no end of line in {} bytes", options_.longest));
  }
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
  if (rest_ && !rest_->has_passed()) return failure(FaultKind::timeout, "", "waiting after lost answers");
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
