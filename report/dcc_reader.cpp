// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "core/file.hpp"
#include "report/dcc.hpp"
#include "report/xml_reader.hpp"

namespace gyrotherm::report {
namespace {

int line_of_difference(std::string_view dcc, std::string_view canonical) {
  const auto differs = std::ranges::mismatch(dcc, canonical).in1;
  return 1 + static_cast<int>(std::count(dcc.begin(), differs, '\n'));
}

/// Returns the text of the only child; empty if there is none.
std::string text_of_child(const XmlElement& element, std::string_view name) {
  const XmlElement* child = element.only(name);
  return child == nullptr ? "" : child->text;
}

/// Reads the name and the hash of an issued file. The name is the text without a language.
IssuedFile read_issued_file(const XmlElement& identification) {
  IssuedFile file{.name = "", .sha256 = text_of_child(identification, "value")};
  if (const XmlElement* names = identification.only("name"))
    for (const XmlElement* content : names->all("content"))
      if (content->attribute("lang").empty()) file.name = content->text;
  return file;
}

}  // namespace

Result<ReadDcc> read_dcc(std::string_view dcc, const std::string& file) {
  const auto document = read_xml(dcc, file, kLargestTable);
  if (!document) return failure(document.error());
  if (document->canonical != dcc)
    return failure(FaultKind::bad_file, fmt::format("{}:{}", file, line_of_difference(dcc, document->canonical)),
                   "is not in the form in which gyrotherm writes it");
  ReadDcc found;
  const XmlElement* data = document->root.only("administrativeData");
  const XmlElement* core = data == nullptr ? nullptr : data->only("coreData");
  if (core == nullptr) return found;
  found.identifier = text_of_child(*core, "uniqueIdentifier");
  if (const XmlElement* identifications = core->only("identifications"))
    for (const XmlElement* one : identifications->all("identification"))
      if (one->attribute("refType") == kFileDigestType) found.files.push_back(read_issued_file(*one));
  return found;
}

}  // namespace gyrotherm::report
