// SPDX-License-Identifier: Apache-2.0
/// XML as text, in one fixed form: what is written here and read again by any parser is written again to the same
/// bytes (read_dcc() holds a file to that).
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gyrotherm::report {

/// Text that XML 1.0 may hold (2.2): what is not UTF-8, and controls, are shown as text ("\x1b"); blanks at both ends
/// are taken off.
[[nodiscard]] std::string xml_characters(std::string_view text);

/// & < > escaped; of an attribute also the quote.
[[nodiscard]] std::string escaped_text(std::string_view text);
[[nodiscard]] std::string escaped_attribute(std::string_view text);

/// Whether it is base64 (RFC 4648) as it is written by who writes it in one way: no blanks, padded, unused bits 0.
[[nodiscard]] bool is_base64(std::string_view text);

class XmlText {
 public:
  using Attributes = std::vector<std::pair<const char*, std::string>>;

  XmlText() : text_("<?xml version=\"1.0\" encoding=\"UTF-8\"?>") {}

  /// An element with text in it, made safe by xml_characters(). Attributes that are empty are left out.
  void leaf(const char* name, std::string_view text, const Attributes& attributes = {});
  /// An element with others in it, which `inside` writes.
  void element(const char* name, const Attributes& attributes, const std::function<void()>& inside);
  void element(const char* name, const std::function<void()>& inside) { element(name, {}, inside); }
  /// All of it, ending in a newline.
  [[nodiscard]] std::string text() && { return std::move(text_) + "\n"; }

 private:
  void begin(const char* name, const Attributes& attributes);

  std::string text_;
  std::size_t depth_ = 0;
};

}  // namespace gyrotherm::report
