#include "tests/report/markup.hpp"

#include <regex>
#include <vector>

namespace gyrotherm {
namespace {

bool is_tag(std::string_view tag) {
  static const std::regex shape(R"(/?[A-Za-z][A-Za-z0-9]*( [A-Za-z:-]+="[^"<]*")*/?)");
  return std::regex_match(tag.begin(), tag.end(), shape);
}

bool has_bare_ampersand(std::string_view text) {
  static const std::regex entity("^&(amp|lt|gt|quot|nbsp|#[0-9]+);");
  for (auto at = text.find('&'); at != std::string_view::npos; at = text.find('&', at + 1)) {
    const std::string rest(text.substr(at, 12));
    if (!std::regex_search(rest, entity)) return true;
  }
  return false;
}

std::string_view name_of(std::string_view tag) { return tag.substr(0, tag.find_first_of(" /")); }

}  // namespace

std::string markup_mistake(std::string_view markup) {
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

int count_of(std::string_view text, std::string_view word) {
  int count = 0;
  for (auto at = text.find(word); at != std::string_view::npos; at = text.find(word, at + word.size())) ++count;
  return count;
}

}  // namespace gyrotherm
