// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/ascii_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "core/toml_reader.hpp"

namespace gyrotherm::drivers {

namespace {

std::span<const std::byte> bytes_in(std::string_view text) { return std::as_bytes(std::span(text)); }

bool digits_pass(const FrameCheck& check, std::string_view covered, std::string_view digits) {
  const auto from = static_cast<std::size_t>(check.from);
  if (digits.size() != 2 * byte_count(check) || covered.size() <= from) return false;
  std::uint32_t stored{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), stored, 16);
  if (error != std::errc{} || end != digits.data() + digits.size()) return false;
  return stored == check_value(check, bytes_in(covered.substr(from)));
}

std::vector<std::string_view> words_between(const LineFormat& format, std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t begin = 0; begin <= line.size();) {
    const auto end = std::min(line.find_first_of(format.separators, begin), line.size());
    if (end > begin || !format.merges) words.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

/// None where the header is not as long as it should be.
std::vector<std::string_view> words_of(const LineFormat& format, std::string_view line) {
  if (format.header_words == 0) return words_between(format, line);
  const auto end = line.find(format.header_end);
  if (end == std::string_view::npos) return {};
  auto words = words_between(format, line.substr(0, end));
  if (words.size() != format.header_words) return {};
  const auto rest = words_between(format, line.substr(end + format.header_end.size()));
  words.insert(words.end(), rest.begin(), rest.end());
  return words;
}

void read_header(const TomlTable& table, LineFormat& format) {
  if (!table.has("header_words") && !table.has("header_end")) return;
  format.header_words = bounded<std::size_t>(table, "header_words", table.integer("header_words"), 1, 255);
  format.header_end = table.text("header_end");
  if (format.header_end.empty() || format.header_end.find_first_of(format.separators) != std::string::npos)
    table.mistake("header_end", "expected what stands behind the header and is no separator, like \";\"");
  if (format.header_words >= format.words)
    table.mistake("header_words", "the whole line is header, expected fewer than \"words\"");
}

}  // namespace

LineFormat read_line_format(const TomlTable& table) {
  LineFormat format;
  format.starts_with = table.text("starts_with", "");
  format.terminator = table.text("terminator", "\r\n");
  if (format.terminator.empty()) table.mistake("terminator", "empty, expected what ends a line, like \"\\r\\n\"");
  format.separators = table.text("separators", " ");
  if (format.separators.empty()) table.mistake("separators", "empty, expected what stands between words");
  format.merges = table.boolean("merges", true);
  format.mark = table.text("mark", "");
  format.words = bounded<std::size_t>(table, "words", table.integer("words"), 1, 256);
  format.longest = bounded<std::size_t>(table, "longest", table.integer("longest", 256), 1, 4096);
  read_header(table, format);
  return format;
}

std::optional<std::size_t> find_terminator(const LineFormat& format, std::span<const std::byte> bytes) {
  const auto wanted = bytes_in(format.terminator);
  const auto found = std::search(bytes.begin(), bytes.end(), wanted.begin(), wanted.end());
  if (found == bytes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - bytes.begin());
}

std::optional<std::vector<std::string_view>> split_line(const LineFormat& format, const FrameCheck& check,
                                                        std::string_view line) {
  if (!line.starts_with(format.starts_with)) return std::nullopt;
  if (check.kind != CheckKind::none) {
    const auto mark = line.rfind(format.mark);
    if (mark == std::string_view::npos) return std::nullopt;
    if (!digits_pass(check, line.substr(0, mark), line.substr(mark + format.mark.size()))) return std::nullopt;
    line = line.substr(0, mark);
  }
  auto words = words_of(format, line);
  if (words.size() != format.words) return std::nullopt;
  if (!format.starts_with.empty() && words.front() != format.starts_with) return std::nullopt;
  return words;
}

std::string join_line(const LineFormat& format, const FrameCheck& check, const std::vector<std::string>& words) {
  std::string line;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) line += i == format.header_words ? format.header_end : format.separators.substr(0, 1);
    line += words[i];
  }
  if (check.kind != CheckKind::none) {
    const auto covered = bytes_in(line).subspan(std::min(static_cast<std::size_t>(check.from), line.size()));
    line += fmt::format("{}{:0{}x}", format.mark, check_value(check, covered), 2 * byte_count(check));
  }
  return line + format.terminator;
}

}  // namespace gyrotherm::drivers
