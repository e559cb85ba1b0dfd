#include "core/toml_text.hpp"

#include <algorithm>

namespace gyrotherm {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool continues(char byte) { return (static_cast<unsigned char>(byte) & 0xC0) == 0x80; }

/// Bytes of the character that `text` begins with; 0 if it is not UTF-8 (RFC 3629: no overlong form, no surrogate,
/// nothing beyond U+10FFFF).
std::size_t character_size(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (first < 0x80) return 1;
  const std::size_t size = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < size) return 0;
  if (!std::all_of(text.begin() + 1, text.begin() + static_cast<std::ptrdiff_t>(size), continues)) return 0;
  const auto second = static_cast<unsigned char>(text[1]);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool beyond = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  return overlong || beyond ? 0 : size;
}

enum class Inside { plain, comment, text, literal, long_text, long_literal };

/// Goes through a text character by character and knows what each is part of.
class Scanner {
 public:
  /// Takes the beginning of `rest`, which is a whole character of `size` bytes or, of quotes, several; how many bytes.
  std::size_t take(std::string_view rest, std::size_t size);
  /// A character beyond ASCII may come next.
  [[nodiscard]] bool takes_any() const { return inside_ != Inside::plain && !escaped_ && !continued_; }
  /// The text that began on this line was not ended on it.
  [[nodiscard]] bool torn() const { return torn_; }

 private:
  std::size_t open(std::string_view rest);
  std::size_t close(std::string_view rest);

  Inside inside_ = Inside::plain;
  char quote_{};
  bool escaped_{};    ///< the last character was a backslash
  bool continued_{};  ///< blanks after a backslash at a line's end
  bool torn_{};
};

std::size_t Scanner::open(std::string_view rest) {
  quote_ = rest[0];
  const bool three = rest.size() >= 3 && rest[1] == quote_ && rest[2] == quote_;
  if (quote_ == '"')
    inside_ = three ? Inside::long_text : Inside::text;
  else
    inside_ = three ? Inside::long_literal : Inside::literal;
  return three ? 3 : 1;
}

/// A long text ends with three quotes; up to two more before them are its own.
std::size_t Scanner::close(std::string_view rest) {
  const auto quotes = std::min(rest.find_first_not_of(quote_), rest.size());
  const bool is_long = inside_ == Inside::long_text || inside_ == Inside::long_literal;
  if (is_long && quotes < 3) return quotes;
  inside_ = Inside::plain;
  return is_long ? std::min<std::size_t>(quotes, 5) : 1;
}

std::size_t Scanner::take(std::string_view rest, std::size_t size) {
  const char c = rest[0];
  const bool blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
  if (escaped_) {
    escaped_ = false;
    continued_ = inside_ == Inside::long_text && blank;
    torn_ = c == '\n' && inside_ == Inside::text;
    return size;
  }
  continued_ = continued_ && blank;
  if (inside_ == Inside::comment || (inside_ == Inside::plain && c == '#')) {
    inside_ = c == '\n' ? Inside::plain : Inside::comment;
    return size;
  }
  if (inside_ == Inside::plain) return c == '"' || c == '\'' ? open(rest) : size;
  escaped_ = c == '\\' && (inside_ == Inside::text || inside_ == Inside::long_text);
  torn_ = c == '\n' && (inside_ == Inside::text || inside_ == Inside::literal);
  return c == quote_ ? close(rest) : size;
}

}  // namespace

std::optional<TextFlaw> flaw_of(std::string_view text) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  Scanner scanner;
  TextFlaw at;
  while (!text.empty() && !scanner.torn()) {
    const auto size = character_size(text);
    if (size == 0) {
      at.what = "a byte that is not UTF-8, expected a text in UTF-8";
      return at;
    }
    if (size > 1 && !scanner.takes_any()) {
      at.what = "a character that stands in quoted texts and comments alone, expected plain ASCII here";
      return at;
    }
    const bool end_of_line = text[0] == '\n';
    const auto taken = scanner.take(text, size);
    text.remove_prefix(taken);
    at.column += static_cast<unsigned>(size > 1 ? 1 : taken);
    if (end_of_line) at = {.line = at.line + 1, .column = 1, .what = {}};
  }
  return std::nullopt;
}

}  // namespace gyrotherm
