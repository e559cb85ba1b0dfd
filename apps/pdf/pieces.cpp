// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/pieces.hpp"

#include <fmt/format.h>

#include <QPainter>
#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

#include "apps/pdf/figure.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kPixelOfFigure = 0.64 * kPoint;  ///< a figure of 760 pixels is as wide as the text
constexpr double kLeastOfFigure = 0.68;           ///< so much smaller it still is read

class PieceMaker {
 public:
  PieceMaker(Typesetter& typesetter, double width) : typesetter_(typesetter), width_(width) {}

  void operator()(const Heading& heading) {
    if (heading.sub) {
      ++subsection_;
    } else {
      ++section_;
      subsection_ = 0;
    }
    const auto number = heading.sub ? fmt::format("{}.{}", section_, subsection_) : fmt::format("{}", section_);
    const TextLook& set = heading.sub ? look::kSubheading : look::kHeading;
    TextLook faint = set;
    faint.bold = false;
    faint.colour = ink::kFaint;
    const double indent = (heading.sub ? 11 : 9) * kMillimetre, above = heading.sub ? 0 : 2.2 * kMillimetre;
    const auto numeral = typesetter_.line(number, faint);
    const auto lines = typesetter_.lines(heading.text, set, width_ - indent);
    const double left = std::max(indent, numeral.width() + 2 * kMillimetre), width = width_;
    Piece piece{.extent = {.height = above + lines.height() + 1 * kMillimetre,
                           .space_before = (heading.sub ? 4.5 : 7) * kMillimetre,
                           .keep_with_next = true},
                .paint =
                    [=](QPainter& painter, double top, double) {
                      if (above > 0) paint_rule(painter, 0, width, top, ink::kText, 1.2 * kPoint);
                      numeral.paint(painter, 0, top + above);
                      lines.paint(painter, left, top + above);
                    },
                .bookmark = Bookmark{.title = number + "  " + heading.text, .sub = heading.sub}};
    made_.pieces.push_back(std::move(piece));
  }

  void operator()(const Paragraph& paragraph) {
    if (paragraph.style == Paragraph::Style::caution) return add_caution(paragraph.text);
    const TextLook& set = paragraph.style == Paragraph::Style::note ? look::kNote : look::kBody;
    append(pieces_of(typesetter_.lines(paragraph.text, set, width_), 0, 2 * kMillimetre));
  }

  void operator()(const Definitions& definitions) {
    const double left = 46 * kMillimetre, gap = 0.9 * kMillimetre, width = width_;
    TextLook term = look::kBody;
    term.colour = ink::kFaint;
    bool first = true;
    for (const auto& [what, value] : definitions.lines) {
      const auto terms = typesetter_.lines(what, term, left - 4 * kMillimetre);
      const auto values = typesetter_.lines(value, look::kBody, width_ - left);
      const int count = std::max(terms.count(), values.count());
      for (int k = 0; k < count; ++k) {
        const bool begins = k == 0, ends = k + 1 == count;
        Piece piece{.extent = {.height = terms.pitch() + (begins ? gap : 0) + (ends ? gap : 0),
                               .space_before = first ? 2 * kMillimetre : 0,
                               .keep_with_next = !ends && (k == 0 || k + 2 == count)},
                    .paint = [=](QPainter& painter, double top, double height) {
                      terms.paint(painter, 0, top + (begins ? gap : 0), k, k + 1);
                      values.paint(painter, left, top + (begins ? gap : 0), k, k + 1);
                      if (ends) paint_rule(painter, 0, width, top + height, ink::kLine, 0.5 * kPoint);
                    }};
        made_.pieces.push_back(std::move(piece));
        first = false;
      }
    }
  }

  void operator()(const KeyFigures& figures) { append(pieces_of(figures, typesetter_, width_)); }

  void operator()(const DocumentTable& table) { append(pieces_of(table, typesetter_, width_)); }

  void operator()(const DocumentFigure& figure) {
    const auto size = size_of_figure(figure.svg);
    if (!size) {
      made_.faults.push_back(figure.id + ": " + text(size.error()));
      return;
    }
    const double scale = std::min(kPixelOfFigure, width_ / size->width());
    const double ratio = size->height() / size->width(), height = ratio * size->width() * scale, width = width_;
    auto& typesetter = typesetter_;
    Piece piece{.extent = {.height = height,
                           .least_height = kLeastOfFigure * height,
                           .space_before = 4 * kMillimetre,
                           .keep_with_next = true},
                .paint = [=, svg = figure.svg, &typesetter](QPainter& painter, double top, double drawn) {
                  const QRectF target((width - drawn / ratio) / 2, top, drawn / ratio, drawn);
                  if (!paint_figure(painter, svg, target, typesetter)) return;
                }};
    made_.pieces.push_back(std::move(piece));
    auto caption = pieces_of(typesetter_.lines(figure.caption, look::kNote, width_), 0, 1.2 * kMillimetre);
    for (std::size_t k = 0; k + 1 < caption.size(); ++k) caption[k].extent.keep_with_next = true;
    append(std::move(caption));
  }

  Pieces finish(const std::string& end) && {
    if (!made_.pieces.empty()) made_.pieces.back().extent.keep_with_next = true;
    TextLook centred = look::kNote;
    centred.alignment = Qt::AlignHCenter;
    append(pieces_of(typesetter_.lines("— " + end + " —", centred, width_), 0, 6 * kMillimetre));
    return std::move(made_);
  }

 private:
  void append(std::vector<Piece> pieces) { std::ranges::move(pieces, std::back_inserter(made_.pieces)); }

  void add_caution(const std::string& caution) {
    const double indent = 4 * kMillimetre, pad = 1.2 * kMillimetre, width = width_;
    const auto lines = typesetter_.lines(caution, look::kBody, width_ - 2 * indent);
    for (int k = 0; k < lines.count(); ++k) {
      const double above = k == 0 ? pad : 0, below = k + 1 == lines.count() ? pad : 0;
      Piece piece{.extent = {.height = lines.pitch() + above + below,
                             .space_before = k == 0 ? 2.5 * kMillimetre : 0,
                             .keep_with_next = k + 1 < lines.count() && (k == 0 || k + 2 == lines.count())},
                  .paint = [=](QPainter& painter, double top, double height) {
                    painter.fillRect(QRectF(0, top, width, height), QColor(0xfb, 0xf3, 0xf0));
                    painter.fillRect(QRectF(0, top, 2 * kPoint, height), ink::kMark);
                    lines.paint(painter, indent, top + above, k, k + 1);
                  }};
      made_.pieces.push_back(std::move(piece));
    }
  }

  Typesetter& typesetter_;
  double width_;
  Pieces made_{};
  int section_ = 0, subsection_ = 0;
};

}  // namespace

void paint_rule(QPainter& painter, double left, double right, double y, const QColor& colour, double thickness) {
  painter.fillRect(QRectF(left, y - thickness / 2, right - left, thickness), colour);
}

std::vector<Piece> pieces_of(const Lines& lines, double left, double space_before) {
  std::vector<Piece> pieces;
  const int count = lines.count();
  for (int k = 0; k < count; ++k) {
    pieces.push_back({.extent = {.height = lines.pitch(),
                                 .space_before = k == 0 ? space_before : 0,
                                 .keep_with_next = k + 1 < count && (k == 0 || k + 2 == count)},
                      .paint = [lines, left, k](QPainter& painter, double top, double) {
                        lines.paint(painter, left, top, k, k + 1);
                      }});
  }
  return pieces;
}

Pieces pieces_of(const Document& document, Typesetter& typesetter, double width) {
  PieceMaker maker(typesetter, width);
  for (const Block& block : document.blocks) std::visit(maker, block);
  return std::move(maker).finish(document.end);
}

}  // namespace gyrotherm::report
