// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/expression_example.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "drivers/chamber/item_exchange.hpp"

namespace gyrotherm::drivers {
namespace {

/// Writes a text that a regular expression without groups matches. Only the first alternative is used.
class ExampleWriter {
 public:
  explicit ExampleWriter(std::string_view expression) : left_(expression.substr(0, find_end(expression))) {}

  std::string write() {
    while (!left_.empty()) {
      const char c = take();
      if (c == '^' || c == '$') continue;
      const auto piece = c == '[' ? take_class() : c == '\\' ? take_escaped() : std::string(1, c == '.' ? kAny : c);
      for (int i = take_count(); i > 0; --i) text_ += piece;
    }
    return text_;
  }

 private:
  static constexpr char kAny = '0';

  /// Returns the position of the first "|" outside classes.
  static std::size_t find_end(std::string_view expression) {
    bool in_class = false;
    for (std::size_t i = 0; i < expression.size(); ++i) {
      const char c = expression[i];
      if (c == '\\') ++i;
      if (c == '[') in_class = true;
      if (c == ']') in_class = false;
      if (c == '|' && !in_class) return i;
    }
    return expression.size();
  }

  char take() {
    const char c = left_.empty() ? '\0' : left_.front();
    if (!left_.empty()) left_.remove_prefix(1);
    return c;
  }

  std::string take_escaped() {
    switch (const char c = take()) {
      case 'd':
      case 'w': return "0";
      case 'D':
      case 'S': return "A";
      case 's':
      case 'W': return " ";
      case 'b':
      case 'B':
      case '\0': return "";
      default: return std::string(1, c);
    }
  }

  /// Takes the first character of a class, or one outside a negated class.
  std::string take_class() {
    const auto end = left_.find(']', left_.starts_with("^]") ? 2 : 1);
    const auto characters = left_.substr(0, end);
    left_.remove_prefix(std::min(characters.size() + 1, left_.size()));
    if (!characters.starts_with('^')) {
      if (!characters.starts_with('\\')) return std::string(characters.substr(0, 1));
      return ExampleWriter(characters.substr(0, 2)).write();
    }
    constexpr std::string_view kCharacters = "A0_ -.z";
    const auto other =
        std::ranges::find_if(kCharacters, [&](char c) { return characters.find(c) == std::string_view::npos; });
    return other == kCharacters.end() ? "" : std::string(1, *other);
  }

  /// Takes a quantifier, and returns its smallest number; 1 without quantifier.
  int take_count() {
    int count = 1;
    if (left_.starts_with('*') || left_.starts_with('?')) {
      count = 0;
      take();
    } else if (left_.starts_with('+')) {
      take();
    } else if (left_.starts_with('{')) {
      const auto end = left_.find('}');
      (void)std::from_chars(left_.data() + 1, left_.data() + std::min(end, left_.size()), count);
      left_.remove_prefix(std::min(end, left_.size() - 1) + 1);
    } else {
      return 1;
    }
    if (left_.starts_with('?')) take();
    return std::clamp(count, 0, static_cast<int>(kLongestIdentity));
  }

  std::string_view left_;
  std::string text_;
};

}  // namespace

bool fits(const Fingerprint& print, const std::string& text) {
  return print.is_expression ? fits_expression(print.pattern, text) : matches(print.pattern, text);
}

std::optional<std::string> make_example(const Fingerprint& print) {
  if (auto example = make_example(print.pattern); fits(print, example)) return example;
  if (!print.is_expression) return std::nullopt;
  auto example = ExampleWriter(print.pattern).write();
  return fits(print, example) ? std::optional(std::move(example)) : std::nullopt;
}

}  // namespace gyrotherm::drivers
