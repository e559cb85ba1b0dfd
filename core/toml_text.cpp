// SPDX-License-Identifier: Apache-2.0
#include "core/toml_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF", kUtf16Mark = "\xFF\xFE", kBigUtf16Mark = "\xFE\xFF";

enum class LexicalElement { plain, comment, text, literal, long_text, long_literal };

/// Reads a text character by character and tracks the lexical element that contains it.
class Scanner {
 public:
  /// Consumes the start of `rest`: one character of `size` bytes, or several quotes. Returns the number of bytes
  /// consumed.
  std::size_t take(std::string_view rest, std::size_t size) {
    const char c = rest[0];
    const bool blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (escaped_) {
      escaped_ = false;
      continued_ = inside_ == LexicalElement::long_text && blank;
      unterminated_ = c == '\n' && inside_ == LexicalElement::text;
      return size;
    }
    continued_ = continued_ && blank;
    if (inside_ == LexicalElement::comment || (inside_ == LexicalElement::plain && c == '#')) {
      inside_ = c == '\n' ? LexicalElement::plain : LexicalElement::comment;
      return size;
    }
    if (inside_ == LexicalElement::plain) return c == '"' || c == '\'' ? open(rest) : size;
    escaped_ = c == '\\' && (inside_ == LexicalElement::text || inside_ == LexicalElement::long_text);
    unterminated_ = c == '\n' && (inside_ == LexicalElement::text || inside_ == LexicalElement::literal);
    return c == quote_ ? close(rest) : size;
  }

  /// Returns whether the next character may be outside ASCII.
  [[nodiscard]] bool accepts_non_ascii() const { return inside_ != LexicalElement::plain && !escaped_ && !continued_; }
  /// Returns whether the closing quote of a text is missing at the end of its line.
  [[nodiscard]] bool is_unterminated() const { return unterminated_; }
  [[nodiscard]] LexicalElement inside() const { return inside_; }

 private:
  std::size_t open(std::string_view rest) {
    quote_ = rest[0];
    const bool three = rest.size() >= 3 && rest[1] == quote_ && rest[2] == quote_;
    if (quote_ == '"')
      inside_ = three ? LexicalElement::long_text : LexicalElement::text;
    else
      inside_ = three ? LexicalElement::long_literal : LexicalElement::literal;
    return three ? 3 : 1;
  }

  /// Consumes closing quotes. A long text ends with three quotes; up to two more before them belong to its content.
  std::size_t close(std::string_view rest) {
    rest = rest.substr(0, 5);
    const auto quotes = std::min(rest.find_first_not_of(quote_), rest.size());
    const bool is_long = inside_ == LexicalElement::long_text || inside_ == LexicalElement::long_literal;
    if (is_long && quotes < 3) return quotes;
    inside_ = LexicalElement::plain;
    return is_long ? quotes : 1;
  }

  LexicalElement inside_ = LexicalElement::plain;
  char quote_{};
  /// The last character was a backslash.
  bool escaped_{};
  /// The scanner is in the blanks that follow a backslash at the end of a line.
  bool continued_{};
  bool unterminated_{};
};

/// The limit that a text exceeds.
enum class ExceededLimit { none, depth, keys, values, text, word };

std::string describe(ExceededLimit excess) {
  switch (excess) {
    case ExceededLimit::none: break;
    case ExceededLimit::depth:
      return fmt::format("is nested more than {} keys, tables and arrays deep, expected fewer", TomlBounds::kDepth);
    case ExceededLimit::keys: return fmt::format("more than {} keys and tables, expected fewer", TomlBounds::kKeys);
    case ExceededLimit::values:
      return fmt::format("more than {} values in arrays, expected fewer", TomlBounds::kValues);
    case ExceededLimit::text:
      return fmt::format("a text of more than {} bytes, expected a shorter one", TomlBounds::kText);
    case ExceededLimit::word:
      return fmt::format("a token of more than {} bytes, expected a shorter one", TomlBounds::kWord);
  }
  return {};
}

/// Follows the scanner and counts keys, values, nesting depth and lengths.
class LimitCounter {
 public:
  /// Counts one step of the scanner over `text`. `before` and `after` are the lexical elements before and after the
  /// step.
  ExceededLimit step(LexicalElement before, LexicalElement after, std::string_view text) {
    const auto quotes = [](LexicalElement inside) {
      return inside != LexicalElement::plain && inside != LexicalElement::comment;
    };
    if (quotes(before) || quotes(after)) return take_text(text.size());
    text_ = 0;
    const bool in_comment = before == LexicalElement::comment || after == LexicalElement::comment;
    return in_comment && text[0] != '\n' ? ExceededLimit::none : take(text[0]);
  }

 private:
  ExceededLimit take(char c) {
    constexpr std::string_view kBlanks = " \t\r\n";
    constexpr std::string_view kBetween = "=,[]{}";
    const bool blank = kBlanks.find(c) != std::string_view::npos;
    word_ = blank || kBetween.find(c) != std::string_view::npos ? 0 : word_ + 1;
    if (c == '.') ++dots_;
    if (c == '=') {
      ++keys_;
      key_ = std::exchange(dots_, 0);
    }
    if (c == ',') {
      ++values_;
      dots_ = key_ = 0;
    }
    if (c == '[' || c == '{') open(c);
    if (c == ']' || c == '}') close();
    line_is_new_ = line_is_new_ && blank;
    if (c == '\n') end_line();
    if (depth() > TomlBounds::kDepth) return ExceededLimit::depth;
    if (keys_ > TomlBounds::kKeys) return ExceededLimit::keys;
    if (values_ > TomlBounds::kValues) return ExceededLimit::values;
    return word_ > TomlBounds::kWord ? ExceededLimit::word : ExceededLimit::none;
  }

  ExceededLimit take_text(std::size_t size) {
    line_is_new_ = false;
    text_ += size;
    return text_ > TomlBounds::kText ? ExceededLimit::text : ExceededLimit::none;
  }

  void open(char bracket) {
    if (bracket == '[' && line_is_new_ && brackets_ == 0) {
      is_header_ = true;
      header_ = 0;
      ++keys_;
    }
    if (brackets_ == bracket_dots_.size()) return;  // exceeds the depth limit
    around_ += bracket_dots_[brackets_++] = key_;
    key_ = dots_ = 0;
  }

  void close() {
    if (is_header_ && dots_ > 0) header_ = dots_;
    if (brackets_ > 0) around_ -= bracket_dots_[--brackets_];
    dots_ = key_ = 0;
  }

  void end_line() {
    line_is_new_ = true;
    is_header_ = false;
    dots_ = 0;
    if (brackets_ == 0) key_ = 0;
  }

  [[nodiscard]] std::size_t depth() const { return header_ + around_ + brackets_ + dots_; }

  /// Number of dots in the key before each open bracket.
  std::array<std::size_t, TomlBounds::kDepth + 1> bracket_dots_{};
  std::size_t brackets_{};  ///< open brackets
  /// Sum of `bracket_dots_` over the open brackets.
  std::size_t around_{};
  std::size_t header_{};  ///< dots in the newest table header
  /// Dots in the key or number being read.
  std::size_t dots_{};
  /// Dots in the key of the value being read.
  std::size_t key_{};
  std::size_t keys_{}, values_{}, word_{}, text_{};
  bool line_is_new_ = true;  ///< only blanks so far
  bool is_header_ = false;
};

/// Returns the ASCII character that a word processor has replaced by this one, with "; " in front.
std::string_view hint_at_character(std::string_view character) {
  for (const std::string_view quote : {"\u201C", "\u201D", "\u201E", "\u2018", "\u2019", "\u00AB", "\u00BB"})
    if (character == quote) return "; write the quotation mark \"";
  for (const std::string_view minus : {"\u2212", "\u2013", "\u2014", "\u2011"})
    if (character == minus) return "; write the minus sign -";
  return character == "\u00A0" ? "; this is a no-break space, write a space" : "";
}

}  // namespace

std::optional<TextFlaw> find_flaw(std::string_view text) {
  if (text.size() > kLargestText)
    return TextFlaw{.what = fmt::format("the text has {} bytes, expected at most {}", text.size(), kLargestText)};
  const bool is_utf16 = text.starts_with(kUtf16Mark) || text.starts_with(kBigUtf16Mark);
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  Scanner scanner;
  LimitCounter measure;
  TextFlaw at;
  while (!text.empty() && !scanner.is_unterminated()) {
    const auto size = character_size(text);
    if (size == 0) {
      at.what = is_utf16 ? "the file is in UTF-16, expected UTF-8: save it as UTF-8, without \"Unicode\" or \"UTF-16\""
                         : "invalid UTF-8, expected a file in UTF-8";
      return at;
    }
    if (size > 1 && !scanner.accepts_non_ascii()) {
      at.what =
          fmt::format("a character that is allowed only in quoted texts and comments, expected plain ASCII here{}",
                      hint_at_character(text.substr(0, size)));
      return at;
    }
    const bool end_of_line = text[0] == '\n';
    const auto before = scanner.inside();
    const auto taken = scanner.take(text, size);
    const auto excess = measure.step(before, scanner.inside(), text.substr(0, taken));
    if (excess != ExceededLimit::none) {
      at.what = describe(excess);
      return at;
    }
    text.remove_prefix(taken);
    at.column += static_cast<unsigned>(size > 1 ? 1 : taken);
    if (end_of_line) at = {.line = at.line + 1, .column = 1, .what = {}};
  }
  return std::nullopt;
}

std::string toml_quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += code < ' ' || code == 0x7F ? fmt::format("\\u{:04x}", code) : std::string(1, c);
  }
  return quoted + "\"";
}

}  // namespace gyrotherm
