// SPDX-License-Identifier: Apache-2.0
/// Writes XML in one canonical form: reading the text with any parser and writing the contents again gives the same
/// bytes. read_dcc() relies on this.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gyrotherm::report {

/// Returns a text that XML 1.0 permits (2.2): invalid UTF-8 and control characters become visible escapes ("\x1b"), and
/// blanks at both ends are removed.
[[nodiscard]] std::string xml_characters(std::string_view text);

/// Escapes & < >; in an attribute also the quote.
[[nodiscard]] std::string escaped_text(std::string_view text);
[[nodiscard]] std::string escaped_attribute(std::string_view text);

/// Returns true for canonical base64 (RFC 4648): no blanks, padded, unused bits 0.
[[nodiscard]] bool is_base64(std::string_view text);

class XmlText {
 public:
  using Attributes = std::vector<std::pair<const char*, std::string>>;

  XmlText() : text_("<?xml version=\"1.0\" encoding=\"UTF-8\"?>") {}

  /// Writes an element with a text, made safe by xml_characters(). Empty attributes are omitted.
  void leaf(const char* name, std::string_view text, const Attributes& attributes = {});
  /// Writes an element; `inside` writes its child elements.
  void element(const char* name, const Attributes& attributes, const std::function<void()>& inside);
  void element(const char* name, const std::function<void()>& inside) { element(name, {}, inside); }
  /// Returns the whole document, ending in a newline.
  [[nodiscard]] std::string text() && { return std::move(text_) + "\n"; }

 private:
  void begin(const char* name, const Attributes& attributes);

  std::string text_;
  std::size_t depth_ = 0;
};

}  // namespace gyrotherm::report
