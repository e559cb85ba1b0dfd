// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/figure.hpp"

#include <QByteArray>
#include <QMap>
#include <QPainter>
#include <QPainterPath>
#include <QRegularExpression>
#include <QSvgRenderer>
#include <QXmlStreamReader>
#include <QXmlStreamWriter>
#include <cmath>
#include <utility>

namespace gyrotherm::report {
namespace {

/// Figures are drawn for a narrower face (plot::text_width); the condensed cut of this one has nine tenths of its
/// width.
constexpr double kCondensed = 0.88;

/// A colour as it looks on white paper.
QColor on_white(const QColor& colour, double opacity) {
  const auto mixed = [opacity](int part) { return static_cast<int>(std::lround(255 - opacity * (255 - part))); };
  return {mixed(colour.red()), mixed(colour.green()), mixed(colour.blue())};
}

QSizeF size_of(const QXmlStreamAttributes& root) {
  const auto box = root.value("viewBox").toString().split(QRegularExpression("[ ,]+"));
  return box.size() == 4 ? QSizeF(box[2].toDouble(), box[3].toDouble())
                         : QSizeF(root.value("width").toDouble(), root.value("height").toDouble());
}

tl::unexpected<Fault> no_figure(const QXmlStreamReader& xml) {
  const auto what = xml.hasError() ? xml.errorString().toStdString() : "expected svg with a size";
  return failure(FaultKind::bad_file, "figure, line " + std::to_string(xml.lineNumber()), what);
}

/// Reads to the root of an SVG.
Result<QSizeF> open_figure(QXmlStreamReader& xml) {
  if (!xml.readNextStartElement() || xml.name() != QLatin1String("svg")) return no_figure(xml);
  const QSizeF size = size_of(xml.attributes());
  if (!std::isfinite(size.width() * size.height()) || size.isEmpty()) return no_figure(xml);
  return size;
}

class FigurePainter {
 public:
  FigurePainter(QPainter& painter, const QRectF& target, QSizeF size, Typesetter& typesetter)
      : painter_(painter),
        target_(target),
        size_(size),
        scale_(target.width() / size.width()),
        typesetter_(typesetter) {}

  /// Paints what stands in the root, of which the start has been read.
  void paint(QXmlStreamReader& xml) {
    while (xml.readNextStartElement()) {
      if (xml.name() == QLatin1String("title")) {
        xml.skipCurrentElement();
      } else if (xml.name() == QLatin1String("clipPath")) {
        take_region(xml);
      } else if (xml.name() == QLatin1String("text")) {
        paint_shapes();
        const auto attributes = xml.attributes();
        paint_text(attributes, xml.readElementText(QXmlStreamReader::IncludeChildElements).toStdString());
      } else {
        take_shape(xml);
      }
    }
    paint_shapes();
  }

 private:
  void take_region(QXmlStreamReader& xml) {
    const auto id = xml.attributes().value("id").toString();
    while (xml.readNextStartElement()) {
      const auto at = [a = xml.attributes()](const char* name) { return a.value(QLatin1String(name)).toDouble(); };
      regions_[id] = {at("x"), at("y"), at("width"), at("height")};
      xml.skipCurrentElement();
    }
  }

  /// Puts the element aside, until one comes that is clipped otherwise or is no shape.
  void take_shape(QXmlStreamReader& xml) {
    const auto clip = xml.attributes().value("clip-path").toString().remove("url(#").remove(')');
    if (clip != clip_) paint_shapes();
    clip_ = clip;
    QXmlStreamWriter out(&shapes_);
    for (int depth = 0; !xml.hasError();) {
      if (xml.isStartElement()) {
        ++depth;
        out.writeStartElement(xml.name().toString());
        write_attributes(out, xml.attributes());
      } else if (xml.isEndElement()) {
        out.writeEndElement();
        if (--depth == 0) break;
      } else if (xml.isCharacters()) {
        out.writeCharacters(xml.text().toString());
      }
      xml.readNext();
    }
  }

  static void write_attributes(QXmlStreamWriter& out, const QXmlStreamAttributes& attributes) {
    const bool is_pale = attributes.hasAttribute("fill-opacity");
    for (const auto& attribute : attributes) {
      const auto name = attribute.qualifiedName().toString();
      auto value = attribute.value().toString();
      if (name == "clip-path" || name == "fill-opacity") continue;
      if (name == "fill" && is_pale) value = on_white(value, attributes.value("fill-opacity").toDouble()).name();
      out.writeAttribute(name == "href" ? "xlink:href" : name, value);  // of SVG 1.1, which Qt knows
    }
  }

  void paint_shapes() {
    if (shapes_.isEmpty()) return;
    const QByteArray whole =
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" viewBox=\"0 0 " +
        QByteArray::number(size_.width()) + " " + QByteArray::number(size_.height()) + "\">" + shapes_.toUtf8() +
        "</svg>";
    shapes_.clear();
    QSvgRenderer renderer(whole);
    painter_.save();
    if (const auto region = regions_.constFind(clip_); region != regions_.constEnd()) {
      painter_.setClipRect(QRectF(on_sheet(region->topLeft()), region->size() * scale_));
    }
    renderer.render(&painter_, target_);
    painter_.restore();
  }

  QPointF on_sheet(QPointF point) const { return target_.topLeft() + scale_ * point; }

  void paint_text(const QXmlStreamAttributes& attributes, const std::string& text) {
    const auto number = [&](const char* name) { return attributes.value(QLatin1String(name)).toDouble(); };
    const bool is_pale = attributes.hasAttribute("fill-opacity");
    TextLook look{.size = number("font-size") * scale_,
                  .bold = attributes.value("font-weight").toInt() > 400,
                  .colour = on_white(QColor(attributes.value("fill").toString()), is_pale ? number("fill-opacity") : 1),
                  .leading = 1};
    const auto line = typesetter_.line(text, look);
    const auto anchor = attributes.value("text-anchor");
    const double before = anchor == QLatin1String("end") ? 1 : anchor == QLatin1String("middle") ? 0.5 : 0;
    static const QRegularExpression turn("rotate\\((-?[0-9.]+)");
    painter_.save();
    painter_.translate(on_sheet({number("x"), number("y")}));
    painter_.rotate(turn.match(attributes.value("transform").toString()).captured(1).toDouble());
    painter_.scale(kCondensed, 1);
    const QPointF corner(-before * line.width(), -kBaseline * look.size);
    if (attributes.hasAttribute("stroke")) paint_halo(attributes, text, look, corner);
    line.paint(painter_, corner.x(), corner.y());
    painter_.restore();
  }

  void paint_halo(const QXmlStreamAttributes& attributes, const std::string& text, const TextLook& look,
                  QPointF corner) {
    QPen pen(QColor(attributes.value("stroke").toString()), attributes.value("stroke-width").toDouble() * scale_);
    pen.setJoinStyle(Qt::RoundJoin);
    painter_.strokePath(Typesetter::outline(text, look).translated(corner.x(), corner.y() + kBaseline * look.size),
                        pen);
  }

  static constexpr double kBaseline = 0.76;  ///< of a line from its upper edge, in sizes, where lines are set solid
  QPainter& painter_;
  QRectF target_;
  QSizeF size_;
  double scale_;
  Typesetter& typesetter_;
  QMap<QString, QRectF> regions_{};
  QString shapes_{}, clip_{};
};

}  // namespace

Result<QSizeF> size_of_figure(const std::string& svg) {
  QXmlStreamReader xml(QByteArray::fromStdString(svg));
  return open_figure(xml);
}

Result<void> paint_figure(QPainter& painter, const std::string& svg, const QRectF& target, Typesetter& typesetter) {
  QXmlStreamReader xml(QByteArray::fromStdString(svg));
  const auto size = open_figure(xml);
  if (!size) return failure(size.error());
  FigurePainter(painter, target, *size, typesetter).paint(xml);
  if (xml.hasError()) return no_figure(xml);
  return {};
}

}  // namespace gyrotherm::report
