#include "sequencer/watchdog/keyed_text.hpp"

#include <fmt/format.h>

namespace gyrotherm {

KeyedText::KeyedText(std::string_view text, std::string file, std::string_view schema)
    : left_(text), file_(std::move(file)) {
  if (line() != schema) mistake(fmt::format("another format, expected {}", schema));
}

std::string_view KeyedText::line() {
  if (wrong()) return {};
  ++line_;
  const auto end = left_.find('\n');
  if (end == std::string_view::npos) {
    mistake("ends too early");
    return {};
  }
  const auto found = left_.substr(0, end);
  left_.remove_prefix(end + 1);
  return found;
}

std::string_view KeyedText::text(std::string_view key) {
  const auto found = line();
  if (wrong()) return {};
  if (found.size() < key.size() + 2 || !found.starts_with(key) || found.substr(key.size(), 2) != ": ") {
    mistake(fmt::format("expected \"{}: …\"", key));
    return {};
  }
  return found.substr(key.size() + 2);
}

bool KeyedText::yes(std::string_view key) {
  const auto value = text(key);
  if (!wrong() && value != "yes" && value != "no") mistake(fmt::format("{}: expected yes or no", key));
  return value == "yes";
}

std::string_view KeyedText::rest(std::string_view length_key) {
  const auto length = number<std::uint32_t>(length_key);
  if (!wrong() && left_.size() != length) mistake(fmt::format("{} bytes follow, expected {}", left_.size(), length));
  if (wrong()) return {};
  const auto found = left_;
  left_ = {};
  return found;
}

void KeyedText::mistake(std::string what) {
  if (!fault_) fault_ = Fault{FaultKind::bad_file, fmt::format("{}:{}", file_, line_), std::move(what)};
}

Result<void> KeyedText::verdict() {
  if (!left_.empty()) mistake("more text than there should be");
  if (fault_) return failure(*fault_);
  return {};
}

}  // namespace gyrotherm
