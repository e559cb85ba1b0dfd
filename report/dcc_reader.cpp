// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <QXmlStreamReader>
#include <algorithm>

#include "report/dcc.hpp"
#include "report/xml_text.hpp"

namespace gyrotherm::report {
namespace {

std::string utf8(QStringView text) { return text.toUtf8().toStdString(); }

class DccReader {
 public:
  explicit DccReader(std::string_view dcc) : xml_(QByteArray::fromRawData(dcc.data(), std::ssize(dcc))) {}

  Result<ReadDcc> read(std::string_view dcc, const std::string& file) {
    while (!xml_.atEnd()) take(xml_.readNext());
    if (xml_.hasError())
      return failure(FaultKind::bad_file, fmt::format("{}:{}", file, xml_.lineNumber()), "is not XML or is incomplete");
    if (written_ + "\n" != dcc)
      return failure(FaultKind::bad_file, fmt::format("{}:{}", file, line_of_difference(dcc)),
                     "is not in the form in which gyrotherm writes it");
    return std::move(found_);
  }

 private:
  void take(QXmlStreamReader::TokenType token) {
    switch (token) {
      case QXmlStreamReader::StartDocument: written_ += "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"; break;
      case QXmlStreamReader::StartElement: start(); break;
      case QXmlStreamReader::Characters: characters(utf8(xml_.text())); break;
      case QXmlStreamReader::EndElement: end(); break;
      // Other tokens are not rewritten; the comparison with the file then fails.
      default: break;
    }
  }

  void start() {
    written_ += "<" + utf8(xml_.qualifiedName());
    for (const auto& one : xml_.namespaceDeclarations())
      attribute(one.prefix().isEmpty() ? "xmlns" : "xmlns:" + utf8(one.prefix()), utf8(one.namespaceUri()));
    for (const auto& one : xml_.attributes()) attribute(utf8(one.qualifiedName()), utf8(one.value()));
    written_ += ">";
    path_.push_back(utf8(xml_.qualifiedName()));
    text_.clear();
    has_language_ = xml_.attributes().hasAttribute("lang");
    if (path_.back() == "dcc:identification") {
      is_file_ = xml_.attributes().value("refType") == QLatin1String(kFileDigestType);
      file_ = {};
    }
  }

  void attribute(const std::string& name, const std::string& value) {
    written_ += fmt::format(" {}=\"{}\"", name, escaped_attribute(value));
  }

  void characters(const std::string& text) {
    written_ += escaped_text(text);
    text_ += text;
  }

  void end() {
    written_ += "</" + utf8(xml_.qualifiedName()) + ">";
    const std::string name = path_.back();
    path_.pop_back();
    const bool in_core_data = std::ranges::find(path_, "dcc:coreData") != path_.end();
    if (in_core_data && name == "dcc:uniqueIdentifier") found_.identifier = text_;
    if (in_core_data && name == "dcc:value") file_.sha256 = text_;
    if (in_core_data && name == "dcc:content" && !has_language_) file_.name = text_;
    if (in_core_data && name == "dcc:identification" && is_file_) found_.files.push_back(file_);
    text_.clear();
  }

  int line_of_difference(std::string_view dcc) const {
    const auto differs = std::ranges::mismatch(dcc, written_).in1;
    return 1 + static_cast<int>(std::count(dcc.begin(), differs, '\n'));
  }

  QXmlStreamReader xml_;
  std::string written_, text_;
  std::vector<std::string> path_;
  bool is_file_ = false, has_language_ = false;
  IssuedFile file_;
  ReadDcc found_;
};

}  // namespace

Result<ReadDcc> read_dcc(std::string_view dcc, const std::string& file) { return DccReader(dcc).read(dcc, file); }

}  // namespace gyrotherm::report
