// SPDX-License-Identifier: Apache-2.0
/// Reads XML documents from other programs into a tree: UTF-8, without a document type and entities of its own, of
/// limited size and depth. Never uses the network or another file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::report {

struct XmlElement {
  std::string space{};  ///< URI of its namespace
  std::string name{};   ///< without prefix
  /// Qualified names and values, without the declarations of namespaces.
  std::vector<std::pair<std::string, std::string>> attributes{};
  /// The characters directly in this element, without those of its children and without comments.
  std::string text{};
  std::vector<XmlElement> children{};
  std::int64_t line{};

  /// Returns the value of an attribute; empty if it is missing.
  [[nodiscard]] std::string_view attribute(std::string_view qualified) const;
  /// Returns true for an element with this name in this namespace.
  [[nodiscard]] bool is(std::string_view its_space, std::string_view its_name) const;
  /// Returns the children of that name in the namespace of this element.
  [[nodiscard]] std::vector<const XmlElement*> all(std::string_view its_name) const;
  /// Returns the only child of that name in the namespace of this element; null if there is none or more than one.
  [[nodiscard]] const XmlElement* only(std::string_view its_name) const;
};

struct XmlDocument {
  XmlElement root{};
  /// The document in the form in which XmlText writes it.
  std::string canonical{};
};

inline constexpr std::size_t kDeepestXml = 64, kMostXmlElements = 500'000;

/// Reads a document. Fails with bad_file at file:line if it is not XML or is incomplete, is not UTF-8, has a document
/// type, has more than `most` bytes, more than kMostXmlElements elements, or more than kDeepestXml levels.
[[nodiscard]] Result<XmlDocument> read_xml(std::string_view bytes, const std::string& file, std::size_t most);

}  // namespace gyrotherm::report
