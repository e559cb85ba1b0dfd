// SPDX-License-Identifier: Apache-2.0
#include <QPainter>
#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "apps/pdf/pieces.hpp"

namespace gyrotherm::report {
namespace {

using Figures = std::span<const KeyFigures::One>;

constexpr std::size_t kMostInARow = 4;
constexpr double kCellPad = 3 * kMillimetre;
constexpr double kLargest = 14 * kPoint, kLargeEnough = 11 * kPoint, kSmallest = 7 * kPoint;

TextLook big(double size, bool best) {
  return {.size = size, .bold = true, .colour = best ? ink::kPass : ink::kText, .leading = 1.3};
}

/// A number with its unit beside it, and below what it is.
struct Figure {
  Lines value, unit, label;
  bool best{};
  [[nodiscard]] double height() const { return value.height() + label.height(); }
  void paint(QPainter& painter, const QRectF& cell) const {
    painter.fillRect(cell, best ? QColor(0xee, 0xf6, 0xf2) : QColor(Qt::white));
    painter.setPen(QPen(ink::kLine, 0.6 * kPoint));
    painter.drawRect(cell);
    const double left = cell.left() + kCellPad, top = cell.top() + kCellPad;
    value.paint(painter, left, top);
    const double on_its_line = value.height() - 0.5 * value.pitch() - 0.42 * unit.pitch();
    unit.paint(painter, left + value.width() + 1.2 * kMillimetre, top + on_its_line);
    label.paint(painter, left, top + value.height());
  }
};

class KeyFigureMaker {
 public:
  KeyFigureMaker(Typesetter& typesetter, double width) : typesetter_(typesetter), width_(width) {}

  /// Rows of about as many; one only where even two beside each other are small.
  std::size_t number_in_a_row(Figures figures) {
    for (std::size_t rows = (figures.size() + kMostInARow - 1) / kMostInARow; rows < figures.size(); ++rows) {
      const std::size_t in_a_row = (figures.size() + rows - 1) / rows;
      const double room = room_of(in_a_row);
      if (std::ranges::all_of(figures, [&](const auto& one) { return size_in(one, room) >= kLargeEnough; }))
        return in_a_row;
    }
    return 1;
  }

  Piece row(Figures figures, std::size_t in_a_row) {
    const double cell = width_ / static_cast<double>(in_a_row), room = room_of(in_a_row);
    std::vector<Figure> made;
    double height = 0;
    for (const auto& one : figures) {
      made.push_back({.value = typesetter_.lines(one.value, big(size_in(one, room), one.best), room - of_unit(one)),
                      .unit = typesetter_.line(one.unit, look::kNote),
                      .label = typesetter_.lines(one.label, look::kNote, room),
                      .best = one.best});
      height = std::max(height, made.back().height());
    }
    return {.extent = {.height = height + 2 * kCellPad},
            .paint = [made = std::move(made), cell](QPainter& painter, double top, double all) {
              for (std::size_t k = 0; k < made.size(); ++k)
                made[k].paint(painter, QRectF(static_cast<double>(k) * cell, top, cell, all));
            }};
  }

 private:
  double room_of(std::size_t in_a_row) const { return width_ / static_cast<double>(in_a_row) - 2 * kCellPad; }

  double of_unit(const KeyFigures::One& one) {
    return one.unit.empty() ? 0 : typesetter_.width(one.unit, look::kNote) + 1.2 * kMillimetre;
  }

  /// In which the value stands on one line.
  double size_in(const KeyFigures::One& one, double room) {
    const double width = 1.01 * typesetter_.width(one.value, big(kLargest, one.best)), has = room - of_unit(one);
    return width <= has ? kLargest : std::max(kSmallest, kLargest * has / width);
  }

  Typesetter& typesetter_;
  double width_;
};

}  // namespace

std::vector<Piece> pieces_of(const KeyFigures& figures, Typesetter& typesetter, double width) {
  std::vector<Piece> pieces;
  if (figures.figures.empty()) return pieces;
  if (!figures.title.empty()) {
    pieces = pieces_of(typesetter.lines(figures.title, look::kSubheading, width), 0, 3 * kMillimetre);
    for (Piece& piece : pieces) piece.extent.keep_with_next = true;
  }
  KeyFigureMaker maker(typesetter, width);
  const Figures all = figures.figures;
  const std::size_t in_a_row = maker.number_in_a_row(all);
  for (std::size_t at = 0; at < all.size(); at += in_a_row) {
    pieces.push_back(maker.row(all.subspan(at, std::min(in_a_row, all.size() - at)), in_a_row));
    if (at == 0) pieces.back().extent.space_before = 1.5 * kMillimetre;
    pieces.back().extent.keep_with_next = at + in_a_row < all.size();
  }
  return pieces;
}

}  // namespace gyrotherm::report
