// SPDX-License-Identifier: Apache-2.0
#include "report/xml_reader.hpp"

#include <fmt/format.h>

#include <QXmlStreamReader>
#include <algorithm>
#include <optional>

#include "report/xml_text.hpp"

namespace gyrotherm::report {
namespace {

std::string utf8(QStringView text) { return text.toUtf8().toStdString(); }

class TreeReader {
 public:
  TreeReader(std::string_view bytes, std::string file)
      : file_(std::move(file)), xml_(QByteArray::fromRawData(bytes.data(), std::ssize(bytes))) {}

  Result<XmlDocument> read() && {
    while (!xml_.atEnd() && refusal_.empty()) take(xml_.readNext());
    if (!refusal_.empty()) return refused(refusal_);
    if (xml_.hasError() || !root_) return refused("is not XML or is incomplete");
    return XmlDocument{std::move(*root_), std::move(canonical_) + "\n"};
  }

 private:
  tl::unexpected<Fault> refused(std::string what) const {
    return failure(FaultKind::bad_file, fmt::format("{}:{}", file_, xml_.lineNumber()), std::move(what));
  }

  void take(QXmlStreamReader::TokenType token) {
    switch (token) {
      case QXmlStreamReader::StartDocument: begin_document(); break;
      case QXmlStreamReader::DTD: refusal_ = "has a document type or entities, which are not permitted"; break;
      case QXmlStreamReader::EntityReference: refusal_ = "has an entity, which is not permitted"; break;
      case QXmlStreamReader::StartElement: begin_element(); break;
      case QXmlStreamReader::Characters: characters(utf8(xml_.text())); break;
      case QXmlStreamReader::EndElement: end_element(); break;
      // Comments and processing instructions are not part of the contents.
      default: break;
    }
  }

  void begin_document() {
    const auto encoding = xml_.documentEncoding();
    if (!encoding.isEmpty() && encoding.compare(QLatin1String("UTF-8"), Qt::CaseInsensitive) != 0)
      refusal_ = "is not in UTF-8";
    canonical_ += "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  }

  void begin_element() {
    if (open_.size() == kDeepestXml) refusal_ = fmt::format("has more than {} levels of elements", kDeepestXml);
    if (++elements_ > kMostXmlElements) refusal_ = fmt::format("has more than {} elements", kMostXmlElements);
    XmlElement element{.space = utf8(xml_.namespaceUri()), .name = utf8(xml_.name()), .line = xml_.lineNumber()};
    canonical_ += "<" + utf8(xml_.qualifiedName());
    for (const auto& one : xml_.namespaceDeclarations())
      add_canonical(one.prefix().isEmpty() ? "xmlns" : "xmlns:" + utf8(one.prefix()), utf8(one.namespaceUri()));
    for (const auto& one : xml_.attributes()) {
      element.attributes.emplace_back(utf8(one.qualifiedName()), utf8(one.value()));
      add_canonical(element.attributes.back().first, element.attributes.back().second);
    }
    canonical_ += ">";
    open_.push_back(std::move(element));
  }

  void add_canonical(const std::string& name, const std::string& value) {
    canonical_ += fmt::format(" {}=\"{}\"", name, escaped_attribute(value));
  }

  void characters(const std::string& text) {
    canonical_ += escaped_text(text);
    if (!open_.empty()) open_.back().text += text;
  }

  void end_element() {
    canonical_ += "</" + utf8(xml_.qualifiedName()) + ">";
    XmlElement element = std::move(open_.back());
    open_.pop_back();
    open_.empty() ? (void)root_.emplace(std::move(element)) : open_.back().children.push_back(std::move(element));
  }

  std::string file_;
  QXmlStreamReader xml_;
  std::string canonical_, refusal_;
  std::vector<XmlElement> open_;
  std::optional<XmlElement> root_;
  std::size_t elements_ = 0;
};

}  // namespace

std::string_view XmlElement::attribute(std::string_view qualified) const {
  for (const auto& [key, value] : attributes)
    if (key == qualified) return value;
  return {};
}

bool XmlElement::is(std::string_view its_space, std::string_view its_name) const {
  return space == its_space && name == its_name;
}

std::vector<const XmlElement*> XmlElement::all(std::string_view its_name) const {
  std::vector<const XmlElement*> found;
  for (const XmlElement& child : children)
    if (child.is(space, its_name)) found.push_back(&child);
  return found;
}

const XmlElement* XmlElement::only(std::string_view its_name) const {
  const auto found = all(its_name);
  return found.size() == 1 ? found.front() : nullptr;
}

Result<XmlDocument> read_xml(std::string_view bytes, const std::string& file, std::size_t most) {
  if (bytes.size() > most)
    return failure(FaultKind::bad_file, file + ":1", fmt::format("has {} bytes, at most {}", bytes.size(), most));
  for (const std::string_view mark : {"\xFE\xFF", "\xFF\xFE"})
    if (bytes.starts_with(mark)) return failure(FaultKind::bad_file, file + ":1", "is not in UTF-8");
  return TreeReader(bytes, file).read();
}

}  // namespace gyrotherm::report
