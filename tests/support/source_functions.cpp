// SPDX-License-Identifier: Apache-2.0
#include "tests/support/source_functions.hpp"

#include <algorithm>
#include <cctype>
#include <regex>

namespace gyrotherm {
namespace {

bool is_in_a_name(char letter) { return std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_'; }
bool is_blank(char letter) { return std::isspace(static_cast<unsigned char>(letter)) != 0; }

/// Replaces everything except code by blanks in a copy of a source.
class Blanker {
 public:
  explicit Blanker(const std::string& source) : text_(source) {}

  std::string blank() {
    while (at_ < text_.size()) step();
    return text_;
  }

 private:
  void step() {
    if (text_[at_] == '#' && begins_a_line())
      blank_until(end_of_directive());
    else if (text_.compare(at_, 2, "//") == 0)
      blank_until(text_.find('\n', at_));
    else if (text_.compare(at_, 2, "/*") == 0)
      blank_until(after(text_.find("*/", at_ + 2), 2));
    else if (text_.compare(at_, 2, "R\"") == 0 && !(at_ > 0 && is_in_a_name(text_[at_ - 1])))
      blank_until(end_of_raw_string());
    else if (text_[at_] == '"' || (text_[at_] == '\'' && !separates_digits()))
      blank_until(end_of_literal(text_[at_]));
    else
      ++at_;
  }

  [[nodiscard]] bool begins_a_line() const {
    const auto before = at_ == 0 ? std::string::npos : text_.find_last_not_of(" \t", at_ - 1);
    return before == std::string::npos || text_[before] == '\n';
  }

  [[nodiscard]] std::size_t end_of_directive() const {
    auto end = text_.find('\n', at_);
    while (end != std::string::npos && text_[end - 1] == '\\') end = text_.find('\n', end + 1);
    return end;
  }

  /// Finds the end of R"mark( … )mark".
  [[nodiscard]] std::size_t end_of_raw_string() const {
    const auto open = text_.find('(', at_);
    if (open == std::string::npos) return open;
    const auto close = ")" + text_.substr(at_ + 2, open - at_ - 2) + "\"";
    return after(text_.find(close, open), close.size());
  }

  [[nodiscard]] std::size_t end_of_literal(char quote) const {
    auto end = at_ + 1;
    while (end < text_.size() && text_[end] != quote) end += text_[end] == '\\' ? 2 : 1;
    return end + 1;
  }

  /// Returns whether the apostrophe separates digits, as in 10'000.
  [[nodiscard]] bool separates_digits() const {
    auto begin = at_;
    while (begin > 0 && (is_in_a_name(text_[begin - 1]) || text_[begin - 1] == '\'')) --begin;
    return begin < at_ && std::isdigit(static_cast<unsigned char>(text_[begin])) != 0;
  }

  static std::size_t after(std::size_t found, std::size_t length) {
    return found == std::string::npos ? found : found + length;
  }

  void blank_until(std::size_t end) {
    for (end = std::min(end, text_.size()); at_ < end; ++at_)
      if (text_[at_] != '\n') text_[at_] = ' ';
  }

  std::string text_;
  std::size_t at_{};
};

/// Returns the position behind the bracket that closes the bracket at `open`, or the size of the text.
std::size_t end_of_brackets(const std::string& text, std::size_t open, char opening, char closing) {
  int depth = 0;
  for (auto at = open; at < text.size(); ++at) {
    if (closing == '>' && text[at] == '(') {
      at = end_of_brackets(text, at, '(', ')') - 1;
      continue;
    }
    if (text[at] == opening) ++depth;
    if (text[at] == closing && --depth == 0) return at + 1;
  }
  return text.size();
}

/// Reduces the head of a declaration to the part that decides its kind. Removes template lists, attributes and the
/// inside of parentheses, and replaces the symbol of an operator by a name.
std::string outline_of_head(std::string head) {
  static const std::regex symbol(R"(\boperator\s*(?:\(\s*\)|\[\s*\]|[^\s\w(]+))"), arrow("->"),
      attribute(R"(\[\[.*?\]\])"), declared(R"(\b(?:alignas|__attribute__|decltype|noexcept|explicit|throw)\s*(?=\())");
  head = std::regex_replace(head, symbol, "operator_symbol");
  head = std::regex_replace(head, arrow, " ");
  head = std::regex_replace(head, attribute, " ");
  std::string outline;
  for (std::size_t at = 0; at < head.size();) {
    std::smatch match;
    if (head[at] == '<') {
      at = end_of_brackets(head, at, '<', '>');
      outline += ' ';
    } else if (std::regex_search(head.cbegin() + static_cast<std::ptrdiff_t>(at), head.cend(), match, declared,
                                 std::regex_constants::match_continuous)) {
      at = end_of_brackets(head, at + static_cast<std::size_t>(match.length()), '(', ')');
      outline += ' ';
    } else if (head[at] == '(') {
      at = end_of_brackets(head, at, '(', ')');
      outline += "()";
    } else {
      outline += head[at++];
    }
  }
  return outline;
}

enum class BlockKind { scope, function, member, value };

/// Returns the kind of block that a brace opens. `head` is the text between the previous declaration and the brace.
BlockKind block_kind(const std::string& head) {
  static const std::regex scope(R"(^\s*(?:inline\s+)?namespace\b|^\s*extern\s*$)"), enumeration(R"(\benum\b)"),
      record(R"(^[^()=]*\b(?:class|struct|union)\b[^()=]*$)"), function(R"(^[^=]*\(\))"),
      initialisers(R"(\(\)[\w\s]*:(?!:))"), member(R"([\w>]\s*$)");
  if (std::regex_search(head, scope)) return BlockKind::scope;
  const auto outline = outline_of_head(head);
  if (std::regex_search(outline, enumeration)) return BlockKind::value;
  if (std::regex_search(outline, record)) return BlockKind::scope;
  if (!std::regex_search(outline, function)) return BlockKind::value;
  const bool is_a_list = std::regex_search(outline, initialisers);
  return is_a_list && std::regex_search(head, member) ? BlockKind::member : BlockKind::function;
}

/// Returns the length of access specifiers such as `public:` at the beginning of a head.
std::size_t length_of_access(const std::string& head) {
  static const std::regex access(
      R"(^(?:\s*(?:public|protected|private|signals|(?:public|private)\s+slots)\s*:(?!:))+)");
  std::smatch match;
  return std::regex_search(head, match, access) ? static_cast<std::size_t>(match.length()) : 0;
}

/// Replaces each sequence of blanks and line breaks by one blank.
std::string joined_lines(const std::string& text) {
  std::string line;
  for (const char letter : text) {
    if (!is_blank(letter))
      line += letter;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  if (line.ends_with(' ')) line.pop_back();
  return line;
}

class FunctionScanner {
 public:
  explicit FunctionScanner(const std::string& source) : text_(blank_literals(source)) {}

  ScannedSource scan() {
    found_.is_balanced = true;
    for (at_ = 0; at_ < text_.size(); ++at_) step();
    found_.is_balanced = found_.is_balanced && depth_ == 0;
    return std::move(found_);
  }

 private:
  void step() {
    switch (text_[at_]) {
      case '(': at_ = end_of_brackets(text_, at_, '(', ')') - 1; break;
      case ';': head_ = at_ + 1; break;
      case '{': open(); break;
      case '}':
        if (--depth_ < 0) found_.is_balanced = false;
        head_ = at_ + 1;
        break;
      default: break;
    }
  }

  void open() {
    skip_access();
    const auto kind = block_kind(text_.substr(head_, at_ - head_));
    if (kind == BlockKind::scope) {
      ++depth_;
      head_ = at_ + 1;
      return;
    }
    const auto end = end_of_brackets(text_, at_, '{', '}');
    if (text_[end - 1] != '}') found_.is_balanced = false;
    if (kind == BlockKind::function) {
      const auto first = text_.find_first_not_of(" \t\n", head_);
      found_.functions.push_back({joined_lines(text_.substr(first, at_ - first)), line_at(first), line_at(end - 1)});
      head_ = end;
    } else {
      blank_between(at_ + 1, end - 1);
    }
    at_ = end - 1;
  }

  void blank_between(std::size_t begin, std::size_t end) {
    for (auto at = begin; at < end; ++at)
      if (text_[at] != '\n') text_[at] = ' ';
  }

  void skip_access() { head_ += length_of_access(text_.substr(head_, at_ - head_)); }

  [[nodiscard]] std::size_t line_at(std::size_t position) {
    for (; counted_ < position; ++counted_)
      if (text_[counted_] == '\n') ++line_;
    return line_;
  }

  std::string text_;
  ScannedSource found_;
  std::size_t at_{};
  /// Start of the next declaration.
  std::size_t head_{};
  int depth_{};
  std::size_t counted_{}, line_{1};
};

}  // namespace

std::string blank_literals(const std::string& source) { return Blanker(source).blank(); }

ScannedSource scan_functions(const std::string& source) { return FunctionScanner(source).scan(); }

}  // namespace gyrotherm
