// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/text_unit_session.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "drivers/line/text_frame.hpp"

namespace gyrotherm::simulator {
namespace {

/// A longer line violates the protocol.
constexpr std::size_t kLongestLine = 4096;

}  // namespace

TextUnitSession::TextUnitSession(drivers::MapLink link) : link_(std::move(link)) {
  if (link_.text.prefix) prefix_ = link_.text.prefix->format({{"address", static_cast<double>(link_.modbus.unit)}});
}

bool TextUnitSession::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  received_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  while (auto line = take_line()) {
    const auto answer = answer_prefixed(*line);
    if (!answer) continue;
    const auto sent = link_.text.frame ? to_frame(*link_.text.frame, *answer) : *answer + link_.text.answer_end;
    const auto all = std::as_bytes(std::span(sent));
    reply.insert(reply.end(), all.begin(), all.end());
  }
  return received_.size() <= kLongestLine;
}

/// Removes and returns the next line. Without a terminator, all received bytes are one line.
std::optional<std::string> TextUnitSession::take_line() {
  const auto& wire = link_.text;
  const auto terminator = wire.frame ? std::string(1, wire.frame->end) : wire.question_end;
  if (terminator.empty())
    return received_.empty() ? std::nullopt : std::optional(std::exchange(received_, std::string()));
  // The last character of a terminator is enough: some clients send only that one.
  const auto end = received_.find(terminator.back());
  if (end == std::string::npos) return std::nullopt;
  auto line = received_.substr(0, end + 1);
  received_.erase(0, end + 1);
  if (wire.frame) {
    const auto begin = line.rfind(wire.frame->begin);
    return begin == std::string::npos ? std::string() : from_frame(*wire.frame, line.substr(begin)).value_or("");
  }
  const std::string kLineEnds = "\r\n" + terminator;
  while (!line.empty() && kLineEnds.find(line.back()) != std::string_view::npos) line.pop_back();
  line.erase(0, std::min(line.find_first_not_of(kLineEnds), line.size()));
  return line;
}

std::optional<std::string> TextUnitSession::answer_prefixed(const std::string& line) {
  if (line.empty() || !line.starts_with(prefix_)) return std::nullopt;
  auto answer = answer_line(line.substr(prefix_.size()));
  if (answer && link_.text.answers_have_prefix) answer = prefix_ + *answer;
  return answer;
}

}  // namespace gyrotherm::simulator
