// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/text_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "acquisition/record/csv.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF", kLittleMark = "\xFF\xFE", kBigMark = "\xFE\xFF";

/// Returns the 16-bit unit at a position of a text in the given byte order.
std::uint16_t unit_at(std::string_view bytes, std::size_t at, Encoding encoding) {
  const auto first = static_cast<unsigned char>(bytes[at]), second = static_cast<unsigned char>(bytes[at + 1]);
  const int unit = encoding == Encoding::utf16_little ? second << 8 | first : first << 8 | second;
  return static_cast<std::uint16_t>(unit);
}

void add_utf8(std::string& text, char32_t character) {
  const auto byte = [&](char32_t bits) { text += static_cast<char>(bits); };
  const auto follower = [&](int shift) { byte(0x80 | (character >> shift & 0x3F)); };
  if (character < 0x80) return byte(character);
  if (character < 0x800) {
    byte(0xC0 | character >> 6);
  } else if (character < 0x10000) {
    byte(0xE0 | character >> 12);
    follower(6);
  } else {
    byte(0xF0 | character >> 18);
    follower(12);
    follower(6);
  }
  follower(0);
}

/// Converts UTF-16 to UTF-8 (RFC 2781). An incomplete pair becomes the replacement character.
void decode(std::string_view bytes, Encoding encoding, std::string& text) {
  constexpr char32_t kReplacement = 0xFFFD;
  text.clear();
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
    const char32_t unit = unit_at(bytes, at, encoding);
    const bool is_high = unit >= 0xD800 && unit < 0xDC00;
    if (!is_high) {
      add_utf8(text, unit >= 0xDC00 && unit < 0xE000 ? kReplacement : unit);
      continue;
    }
    const char32_t low = at + 3 < bytes.size() ? unit_at(bytes, at + 2, encoding) : 0;
    const bool is_pair = low >= 0xDC00 && low < 0xE000;
    add_utf8(text, is_pair ? 0x10000 + ((unit - 0xD800) << 10) + (low - 0xDC00) : kReplacement);
    if (is_pair) at += 2;
  }
}

/// Returns the position of the end of the line; npos if it is not in the text.
std::size_t end_of_line(std::string_view ahead, Encoding encoding) {
  if (encoding == Encoding::utf8) return ahead.find('\n');
  for (std::size_t at = 0; at + 1 < ahead.size(); at += 2)
    if (unit_at(ahead, at, encoding) == '\n') return at;
  return std::string_view::npos;
}

std::size_t unit_size(Encoding encoding) { return encoding == Encoding::utf8 ? 1 : 2; }

bool is_separator_declaration(std::string_view line) { return line.size() == 5 && line.starts_with("sep="); }

}  // namespace

std::string in_utf8(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string converted;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80) converted += static_cast<char>(0xC0 | byte >> 6);
    converted += byte >= 0x80 ? static_cast<char>(0x80 | (byte & 0x3F)) : c;
  }
  return converted;
}

Result<TextLines> TextLines::open(Bytes bytes, std::string comment) {
  const auto ahead = bytes.peek(kUtf8Mark.size());
  if (!ahead) return failure(ahead.error());
  const auto begins = [&](std::string_view mark) {
    if (!ahead->starts_with(mark)) return false;
    bytes.skip(mark.size());
    return true;
  };
  const bool has_nul = ahead->substr(0, 2).find('\0') != std::string_view::npos;
  if (begins(kLittleMark)) return TextLines(std::move(bytes), std::move(comment), Encoding::utf16_little);
  if (begins(kBigMark)) return TextLines(std::move(bytes), std::move(comment), Encoding::utf16_big);
  if (has_nul)
    return failure(FaultKind::bad_file, bytes.name() + ":1:1",
                   "a NUL byte, expected UTF-8, or UTF-16 with a byte order mark");
  (void)begins(kUtf8Mark);
  return TextLines(std::move(bytes), std::move(comment), Encoding::utf8);
}

Fault TextLines::fault_at(std::size_t column, std::string what) const {
  return {FaultKind::bad_file, fmt::format("{}:{}:{}", file(), std::max<std::size_t>(number_, 1), column),
          std::move(what)};
}

bool TextLines::has_content() const {
  const bool is_separator_line = number_ == 1 && is_separator_declaration(line_);
  return !is_separator_line && !is_comment() && !record::trimmed(line_).empty();
}

bool TextLines::is_comment() const { return !comment_.empty() && line_.starts_with(comment_); }

/// Advances to the next line. Returns false at the end of the file.
Result<bool> TextLines::read_line() {
  bytes_.skip(bytes_to_skip_);
  bytes_to_skip_ = 0;
  const std::size_t size = unit_size(encoding_);
  const std::size_t most = (record::kLongestLine + 2) * size;  // followed by CRLF
  auto ahead = bytes_.peek(1);
  if (ahead && end_of_line(ahead->substr(0, most), encoding_) == std::string_view::npos) ahead = bytes_.peek(most);
  if (!ahead) return failure(ahead.error());
  line_ = {};
  if (ahead->empty()) return false;
  const std::string_view window = ahead->substr(0, most);
  const std::size_t end = end_of_line(window, encoding_);
  const bool ended = end != std::string_view::npos;
  cut_short_ = !ended && window.size() == most;
  has_end_ = ended;
  bytes_to_skip_ = ended ? end + size : window.size();
  line_ = window.substr(0, std::min(end, window.size()));
  if (encoding_ != Encoding::utf8) {
    decode(line_, encoding_, decoded_);
    line_ = decoded_;
  }
  while (line_.ends_with('\r')) line_.remove_suffix(1);
  ++number_;
  return true;
}

/// Fails if the line contains a CR. A file whose lines end only with CR would otherwise be read as one wrong row.
Result<void> TextLines::check_ends() const {
  const std::size_t at = line_.find('\r');
  if (at == std::string_view::npos) return {};
  return failure(fault_at(at + 1, "a carriage return within the line, expected lines that end with LF or CRLF"));
}

/// Skips the remainder of a line of which line() has only the beginning.
Result<void> TextLines::skip_remainder() {
  while (cut_short_) {
    const std::size_t before = number_;
    if (auto read = read_line(); !read) return failure(read.error());
    number_ = before;
  }
  return {};
}

Result<bool> TextLines::next() {
  while (true) {
    const auto read = read_line();
    if (!read || !*read) return read;
    if (auto ends = check_ends(); !ends) return failure(ends.error());
    const bool good = has_content();
    if (good && (cut_short_ || line_.size() > record::kLongestLine))
      return failure(fault_at(record::kLongestLine + 1,
                              fmt::format("more than {} bytes in a line, expected fewer", record::kLongestLine)));
    if (good) return true;
    if (auto passed = skip_remainder(); !passed) return failure(passed.error());
  }
}

Result<bool> TextLines::skip_any_line() {
  const auto read = read_line();
  if (!read || !*read) return read;
  return skip_remainder().map([] { return true; });
}

Result<bool> TextLines::skip_line() {
  while (true) {
    const auto read = read_line();
    if (!read || !*read) return read;
    const bool passed_one = !is_comment();
    if (auto passed = skip_remainder(); !passed) return failure(passed.error());
    if (passed_one) return true;
  }
}

}  // namespace gyrotherm::exchange
