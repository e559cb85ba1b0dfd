#include "simulator/servers/session.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kLongestCommand = 64;

}  // namespace

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \r\n";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

bool TextSession::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  for (const auto byte : bytes) {
    const char character = static_cast<char>(byte);
    if (character != end_) {
      if (line_.size() < kLongestCommand)
        line_.push_back(character);
      else
        line_too_long_ = true;
      continue;
    }
    const auto text = line_too_long_ ? std::string{} : answer(without_blanks(line_));
    const auto answered = std::as_bytes(std::span(text));
    reply.insert(reply.end(), answered.begin(), answered.end());
    line_.clear();
    line_too_long_ = false;
  }
  return true;
}

}  // namespace gyrotherm
