#include "drivers/line/text_exchange.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace gyrotherm {

namespace {

constexpr std::size_t kLongestLine = 256;
constexpr Duration kRest = std::chrono::seconds(3);

}  // namespace

TextExchange::TextExchange(std::unique_ptr<ByteStream> line, TextExchangeOptions options)
    : line_(std::move(line)), options_(std::move(options)) {}

Result<void> TextExchange::wait_for_silence() {
  std::array<std::byte, kLongestLine> stale;
  const auto pause = answer_may_come_late_ ? options_.within : options_.pause;
  const Deadline deadline(options_.within, options_.clock);
  do {
    const auto size = line_->read(stale, pause);
    if (size) continue;
    if (size.error().kind != FaultKind::timeout) return failure(size.error());
    answer_may_come_late_ = false;
    return {};
  } while (!deadline.over());
  return failure(FaultKind::corrupted, "", "the line does not fall silent");
}

Result<std::string> TextExchange::receive() {
  std::string text;
  std::array<std::byte, kLongestLine> buffer;
  const Deadline deadline(options_.within, options_.clock);
  while (true) {
    const auto size = line_->read(std::span(buffer).first(kLongestLine - text.size()), deadline.left());
    if (!size) return failure(size.error());
    text.append(reinterpret_cast<const char*>(buffer.data()), *size);
    if (const auto end = text.find(options_.answer_end); end != std::string::npos) {
      if (end + options_.answer_end.size() != text.size())
        return failure(FaultKind::corrupted, "", "more than one line answers");
      text.resize(end);
      return text;
    }
    if (text.size() == kLongestLine) return failure(FaultKind::corrupted, "", "no end of line in 256 bytes");
  }
}

Result<std::string> TextExchange::exchange(std::string_view question) {
  const auto line = std::string(question) + options_.question_end;
  if (auto sent = line_->write(std::as_bytes(std::span(line)), options_.within); !sent)
    return failure(std::move(sent.error()));
  answer_may_come_late_ = true;
  auto answer = receive();
  answer_may_come_late_ = !answer;
  return answer;
}

Result<void> TextExchange::find(const Beat& beat) {
  const auto answer = exchange(beat.question);
  beat_is_lost_ = !answer || !answer->starts_with(beat.answer_begins);
  if (!beat_is_lost_) return {};
  rest_.emplace(kRest, options_.clock);
  return answer ? failure(FaultKind::corrupted, "", fmt::format("\"{}\" is answered by an older answer", beat.question))
                : failure(answer.error());
}

Result<std::string> TextExchange::ask(std::string_view question, const Beat& beat) {
  if (rest_ && !rest_->over()) return failure(FaultKind::timeout, "", "rests after lost answers");
  rest_.reset();
  if (auto silent = wait_for_silence(); !silent) return failure(std::move(silent.error()));
  if (beat_is_lost_ && !beat.question.empty())
    if (auto found = find(beat); !found) return failure(std::move(found.error()));
  auto answer = exchange(question);
  beat_is_lost_ = !answer;
  return answer;
}

}  // namespace gyrotherm
