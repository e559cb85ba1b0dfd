// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/logo.hpp"

#include <QBuffer>
#include <QByteArray>
#include <QImageReader>
#include <QPainter>
#include <QSvgRenderer>
#include <QXmlStreamReader>
#include <set>
#include <string>

namespace gyrotherm::report {
namespace {

constexpr qsizetype kMostBytes = 2'000'000;
constexpr int kMostPixels = 4000;  ///< a side
constexpr int kMostElements = 5000;

tl::unexpected<Fault> refused(const std::string& what) { return failure(FaultKind::bad_file, "laboratory.logo", what); }

QImage on_white(const QImage& picture) {
  QImage flat(picture.size(), QImage::Format_RGB888);
  flat.fill(Qt::white);
  QPainter(&flat).drawImage(0, 0, picture);
  return flat;
}

Result<QImage> png(QByteArray bytes, QSize most) {
  if (!bytes.startsWith("\x89PNG\r\n\x1a\n")) return refused("is no PNG");
  QBuffer file(&bytes);
  QImageReader reader(&file, "png");
  const QSize size = reader.size();
  if (!size.isValid()) return refused("is a broken PNG");
  if (size.width() > kMostPixels || size.height() > kMostPixels) return refused("is wider or higher than 4000 pixels");
  const QImage picture = reader.read();
  if (picture.isNull()) return refused("is a broken PNG: " + reader.errorString().toStdString());
  if (size.width() <= most.width() && size.height() <= most.height()) return on_white(picture);
  return on_white(picture.scaled(most, Qt::KeepAspectRatio, Qt::SmoothTransformation));
}

/// Elements that draw, and those that group and describe them.
bool is_known(const QString& element) {
  static const std::set<QString> known{"svg",  "g",      "defs",    "title", "desc",           "metadata",
                                       "rect", "circle", "ellipse", "line",  "polyline",       "polygon",
                                       "path", "text",   "tspan",   "style", "linearGradient", "radialGradient",
                                       "stop", "switch"};
  return known.contains(element);
}

/// Whether a value, or a style sheet, stays inside the file and is quickly drawn. A backslash could hide any word.
bool is_harmless(const QString& value) {
  const QString tight = QString(value).remove(' ').toLower().remove("dasharray:none");
  if (tight.contains('\\') || tight.contains("@import") || tight.contains("dasharray")) return false;
  return tight.count("url(") == tight.count("url(#") + tight.count("url('#") + tight.count("url(\"#");
}

/// Nothing, or what is wrong with it.
std::string fault_of_element(const QXmlStreamReader& xml) {
  // What drawing programs keep beside the drawing has other namespaces, and is not drawn.
  if (xml.namespaceUri() != QLatin1String("http://www.w3.org/2000/svg")) return {};
  if (!is_known(xml.name().toString()))
    return "has <" + xml.name().toString().toStdString() + ">, which a logo may not";
  for (const auto& attribute : xml.attributes()) {
    const auto name = attribute.name();
    const auto value = attribute.value().toString();
    if (name == QLatin1String("href") && !value.startsWith('#')) return "refers to something outside itself";
    const bool is_dashed = name == QLatin1String("stroke-dasharray") && value != "none";
    if (is_dashed || !is_harmless(value))
      return "has \"" + name.toString().toStdString() + "\", which a logo may not have like that";
  }
  return {};
}

std::string fault_of(const QByteArray& svg) {
  QXmlStreamReader xml(svg);
  int elements = 0;
  while (!xml.atEnd()) {
    xml.readNext();
    if (xml.isDTD() && xml.text().contains(QLatin1String("ENTITY"))) return "has entities of its own";
    if (xml.isProcessingInstruction()) return "has an instruction to another program";
    if (xml.isCharacters() && !is_harmless(xml.text().toString())) return "has a style that a logo may not have";
    if (!xml.isStartElement()) continue;
    if (++elements == 1 && xml.name() != QLatin1String("svg")) return "is no SVG";
    if (elements > kMostElements) return "has more than 5000 elements";
    if (auto fault = fault_of_element(xml); !fault.empty()) return fault;
  }
  return xml.hasError() ? "is a broken SVG: " + xml.errorString().toStdString() : std::string();
}

Result<QImage> svg(const QByteArray& bytes, QSize most) {
  if (auto fault = fault_of(bytes); !fault.empty()) return refused(fault);
  QSvgRenderer renderer(bytes);
  const QSizeF size = renderer.viewBoxF().size();
  if (!renderer.isValid() || size.isEmpty()) return refused("is no SVG that can be drawn");
  const QSize scaled = size.scaled(most, Qt::KeepAspectRatio).toSize();
  if (scaled.isEmpty()) return refused("is much wider than high, or much higher than wide");
  QImage picture(scaled, QImage::Format_RGB888);
  picture.fill(Qt::white);
  QPainter painter(&picture);
  renderer.render(&painter);
  return picture;
}

}  // namespace

Result<QImage> picture_of(const Logo& logo, QSize most) {
  const auto decoded =
      QByteArray::fromBase64Encoding(QByteArray::fromStdString(logo.base64), QByteArray::AbortOnBase64DecodingErrors);
  if (!decoded) return refused("is not in base64");
  if ((*decoded).size() > kMostBytes) return refused("has more than 2 MB");
  return logo.media_type == "image/svg+xml" ? svg(*decoded, most) : png(*decoded, most);
}

}  // namespace gyrotherm::report
