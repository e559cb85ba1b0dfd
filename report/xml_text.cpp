// SPDX-License-Identifier: Apache-2.0
#include "report/xml_text.hpp"

#include "core/text.hpp"

namespace gyrotherm::report {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

}  // namespace

std::string xml_characters(std::string_view text) {
  std::string safe = substitute(substitute(text, "\r\n", "\n"), "\r", "\n");
  safe = plain(safe, Blanks::kept);
  for (const char* forbidden : {"\uFFFE", "\uFFFF"}) safe = substitute(safe, forbidden, "\uFFFD");
  return std::string(trimmed(safe, kBlanks));
}

std::string escaped_text(std::string_view text) {
  return substitute(substitute(substitute(text, "&", "&amp;"), "<", "&lt;"), ">", "&gt;");
}

std::string escaped_attribute(std::string_view text) {
  return substitute(substitute(substitute(escaped_text(text), "\"", "&quot;"), "\n", " "), "\t", " ");
}

bool is_base64(std::string_view text) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  if (text.empty() || text.size() % 4 != 0) return false;
  const std::size_t padding = text.ends_with("==") ? 2 : text.ends_with('=') ? 1 : 0;
  text.remove_suffix(padding);
  if (text.find_first_not_of(kLetters) != std::string_view::npos) return false;
  const std::size_t unused = padding == 2 ? 0x0F : padding == 1 ? 0x03 : 0;
  return (kLetters.find(text.back()) & unused) == 0;
}

void XmlText::begin(const char* name, const Attributes& attributes) {
  text_.append("\n").append(2 * depth_, ' ').append("<").append(name);
  for (const auto& [key, value] : attributes)
    if (!value.empty())
      text_.append(" ").append(key).append("=\"").append(escaped_attribute(xml_characters(value))).append("\"");
  text_ += '>';
}

void XmlText::leaf(const char* name, std::string_view text, const Attributes& attributes) {
  begin(name, attributes);
  text_.append(escaped_text(xml_characters(text))).append("</").append(name).append(">");
}

void XmlText::element(const char* name, const Attributes& attributes, const std::function<void()>& inside) {
  begin(name, attributes);
  ++depth_;
  inside();
  --depth_;
  text_.append("\n").append(2 * depth_, ' ').append("</").append(name).append(">");
}

}  // namespace gyrotherm::report
