// SPDX-License-Identifier: Apache-2.0
#include "tests/support/markup.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <vector>

namespace gyrotherm::tests {
namespace {

bool is_letter_or_digit(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == ':'; }

/// Removes a name from the start of the text. Returns false if there is none.
bool skip_name(std::string_view& text) {
  const auto end = std::ranges::find_if_not(text, is_letter_or_digit);
  const auto length = static_cast<std::size_t>(end - text.begin());
  text.remove_prefix(length);
  return length > 0;
}

/// Returns whether the text between < and > is a name followed by attributes ' name="value"'.
bool is_tag(std::string_view tag) {
  if (tag.starts_with('/')) tag.remove_prefix(1);
  if (!skip_name(tag)) return false;
  while (tag.starts_with(' ')) {
    tag.remove_prefix(1);
    if (!skip_name(tag) || !tag.starts_with("=\"")) return false;
    tag.remove_prefix(2);
    const auto quote = tag.find('"');
    if (quote == std::string_view::npos || tag.substr(0, quote).find('<') != std::string_view::npos) return false;
    tag.remove_prefix(quote + 1);
  }
  return tag.empty() || tag == "/";
}

/// Returns whether the text starts with one of the entities that the reports use.
bool starts_with_entity(std::string_view text) {
  constexpr std::array kEntities = {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;", "&nbsp;"};
  return std::ranges::any_of(kEntities, [&](const char* entity) { return text.starts_with(entity); });
}

bool has_bare_ampersand(std::string_view text) {
  for (auto at = text.find('&'); at != std::string_view::npos; at = text.find('&', at + 1)) {
    if (!starts_with_entity(text.substr(at))) return true;
  }
  return false;
}

std::string_view name_of(std::string_view tag) { return tag.substr(0, tag.find_first_of(" /")); }

}  // namespace

std::string markup_error(std::string_view markup) {
  if (has_bare_ampersand(markup)) return "bare &";
  constexpr std::string_view kDoctype = "<!DOCTYPE html>";
  if (markup.starts_with(kDoctype)) markup.remove_prefix(kDoctype.size());
  std::vector<std::string_view> open;
  for (auto from = markup.find('<'); from != std::string_view::npos; from = markup.find('<', from + 1)) {
    const auto to = markup.find('>', from);
    if (to == std::string_view::npos) return "unclosed <";
    const std::string_view tag = markup.substr(from + 1, to - from - 1);
    if (!is_tag(tag)) return "not a tag: " + std::string(tag.substr(0, 80));
    if (tag.ends_with('/')) continue;
    if (!tag.starts_with('/')) {
      open.push_back(name_of(tag));
      continue;
    }
    if (open.empty() || open.back() != tag.substr(1)) return "closes what is not open: " + std::string(tag);
    open.pop_back();
  }
  return open.empty() ? "" : "never closed: " + std::string(open.back());
}

int count_occurrences(std::string_view text, std::string_view word) {
  int count = 0;
  for (auto at = text.find(word); at != std::string_view::npos; at = text.find(word, at + word.size())) ++count;
  return count;
}

}  // namespace gyrotherm::tests
