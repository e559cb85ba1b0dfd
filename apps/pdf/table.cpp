// SPDX-License-Identifier: Apache-2.0
#include <QPainter>
#include <algorithm>
#include <memory>
#include <utility>

#include "apps/pdf/pieces.hpp"
#include "apps/pdf/table_columns.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kGap = 3 * kMillimetre;  ///< between columns
constexpr double kPad = 0.7 * kMillimetre;
constexpr double kWidestWord = 0.4;    ///< that is not broken, of the table's width
constexpr double kNote = 0.86;         ///< letters of a note, in those of its cell
constexpr std::size_t kKeptWhole = 5;  ///< a table of so many rows is not parted
constexpr int kMostLines = 24;         ///< of a row that is not cut
constexpr double kSizes[] = {8 * kPoint, 7.2 * kPoint, 6.4 * kPoint};

struct Sign {
  const char* sign;
  QColor colour;
};

/// A verdict is said by a sign too, for whom colours are alike.
Sign sign_of(Cell::Mark mark) {
  switch (mark) {
    case Cell::Mark::none: break;
    case Cell::Mark::pass: return {"✓\u00a0", ink::kPass};
    case Cell::Mark::caution: return {"▲\u00a0", ink::kCaution};
    case Cell::Mark::fail: return {"✗\u00a0", ink::kMark};
  }
  return {"", ink::kText};
}

std::string text_of(const Cell& cell) { return sign_of(cell.mark).sign + cell.text; }

/// The text of a cell and the note below it, whose lines are as far apart.
struct BrokenCell {
  Lines text, note;
  [[nodiscard]] int count() const { return text.count() + note.count(); }
  [[nodiscard]] double height() const { return text.height() + note.height(); }
  void paint(QPainter& painter, double left, double top, int from, int to) const {
    const int of_text = text.count();
    if (from < of_text) text.paint(painter, left, top, from, std::min(to, of_text));
    const double shift = std::max(0, of_text - from) * text.pitch();
    if (to > of_text) note.paint(painter, left, top + shift, std::max(0, from - of_text), to - of_text);
  }
};

/// The cells of a row side by side, broken into lines.
struct Row {
  std::vector<BrokenCell> cells;
  [[nodiscard]] int lines() const {
    int most = 1;
    for (const BrokenCell& cell : cells) most = std::max(most, cell.count());
    return most;
  }
};

/// What all rows of a table share.
struct TableForm {
  double width;
  TextLook look{};
  std::vector<double> columns{};  ///< with the gap after each; the last one's lies outside of the table
  [[nodiscard]] double pitch() const { return look.leading * look.size; }
};

void paint_cells(QPainter& painter, const TableForm& form, const Row& row, double top, int from, int to) {
  double left = 0;
  for (std::size_t k = 0; k < row.cells.size(); ++k) {
    row.cells[k].paint(painter, left, top, from, to);
    left += form.columns[k];
  }
}

void paint_head(QPainter& painter, const TableForm& form, const Row& head, double top, double height) {
  paint_rule(painter, 0, form.width, top, ink::kText, 1 * kPoint);
  paint_rule(painter, 0, form.width, top + height, ink::kText, 0.6 * kPoint);
  double left = 0;
  for (std::size_t k = 0; k < head.cells.size(); ++k) {  // they stand on the line below
    const BrokenCell& cell = head.cells[k];
    cell.paint(painter, left, top + height - kPad - cell.height(), 0, cell.count());
    left += form.columns[k];
  }
}

class TableMaker {
 public:
  TableMaker(const DocumentTable& table, Typesetter& typesetter, double width)
      : table_(table), typesetter_(typesetter), form_{.width = width} {
    choose_size();
    shared_ = std::make_shared<const TableForm>(form_);
    head_ = std::make_shared<const Row>(head_row());
    head_height_ = head_->lines() * form_.pitch() + 2.4 * kPad;
  }

  std::vector<Piece> make() && {
    add_caption();
    pieces_.push_back({.extent = {.height = head_height_,
                                  .space_before = (pieces_.empty() ? 3.5 : 1) * kMillimetre,
                                  .keep_with_next = true},
                       .paint = [form = shared_, head = head_](QPainter& painter, double top, double height) {
                         paint_head(painter, *form, *head, top, height);
                       }});
    for (std::size_t k = 0; k < table_.rows.size(); ++k) add_row(k);
    return std::move(pieces_);
  }

 private:
  bool is_text(std::size_t column) const { return column < table_.text_columns; }

  TextLook look_of(std::size_t column, bool bold, const QColor& colour) const {
    TextLook look = form_.look;
    look.bold = bold;
    look.colour = colour;
    look.alignment = is_text(column) ? Qt::AlignLeft : Qt::AlignRight;
    return look;
  }

  /// Numbers are not broken; words are, where one would take too much of the table.
  ColumnWish wish_of(std::size_t column) {
    const auto head_look = look_of(column, true, ink::kText);
    ColumnWish wish{.least = typesetter_.widest_word(table_.header[column], head_look),
                    .natural = typesetter_.width(table_.header[column], head_look)};
    for (const auto& row : table_.rows) {
      const auto look = look_of(column, row[column].mark != Cell::Mark::none, ink::kText);
      const auto text = text_of(row[column]);
      const double whole = typesetter_.width(text, look);
      wish.natural = std::max(wish.natural, whole);
      wish.least = std::max(wish.least, is_text(column) ? typesetter_.widest_word(text, look) : whole);
      if (row[column].note.empty()) continue;
      wish.least = std::max(wish.least, typesetter_.widest_word(row[column].note, note_look_of(column)));
      wish.natural = std::max(wish.natural, typesetter_.width(row[column].note, note_look_of(column)));
    }
    if (is_text(column)) wish.least = std::min(wish.least, kWidestWord * form_.width);
    return {.least = wish.least + kGap, .natural = wish.natural + kGap};
  }

  /// The largest letters in which the words of no column are cut, else the smallest.
  void choose_size() {
    std::vector<ColumnWish> wishes;
    for (const double size : kSizes) {
      form_.look = {.size = size, .leading = 1.32};
      wishes.clear();
      for (std::size_t k = 0; k < table_.header.size(); ++k) wishes.push_back(wish_of(k));
      if (least_fit(wishes, form_.width + kGap)) break;
    }
    form_.columns = column_widths(wishes, form_.width + kGap);
  }

  TextLook note_look_of(std::size_t column) const {
    TextLook look = look_of(column, false, ink::kFaint);
    look.size *= kNote;
    look.leading /= kNote;
    return look;
  }

  BrokenCell broken(std::size_t column, const Cell& cell, bool bold) {
    const double width = form_.columns[column] - kGap;
    BrokenCell made{typesetter_.lines(text_of(cell), look_of(column, bold, sign_of(cell.mark).colour), width), {}};
    if (!cell.note.empty()) made.note = typesetter_.lines(cell.note, note_look_of(column), width);
    return made;
  }

  Row head_row() {
    Row row;
    for (std::size_t k = 0; k < table_.header.size(); ++k)
      row.cells.push_back(broken(k, {.text = table_.header[k]}, true));
    return row;
  }

  void add_caption() {
    if (table_.caption.empty()) return;
    pieces_ = pieces_of(typesetter_.lines(table_.caption, look::kNote, form_.width), 0, 3.5 * kMillimetre);
    for (Piece& piece : pieces_) piece.extent.keep_with_next = true;
  }

  void add_row(std::size_t index) {
    auto row = std::make_shared<Row>();
    for (std::size_t k = 0; k < table_.header.size(); ++k) {
      const Cell& one = table_.rows[index][k];
      row->cells.push_back(broken(k, one, one.mark != Cell::Mark::none));
    }
    const int count = row->lines();
    for (int from = 0; from < count; from += kMostLines)
      add_part(index, row, from, std::min(count, from + kMostLines), count);
  }

  /// Lines of a row; a row that is not long is one part. The first two rows keep together, the last two, and all of a
  /// few.
  void add_part(std::size_t index, const std::shared_ptr<const Row>& row, int from, int to, int count) {
    const std::size_t rows = table_.rows.size();
    const bool ends = to == count, is_last = index + 1 == rows;
    const double above = from == 0 ? kPad : 0, below = ends ? kPad : 0;
    pieces_.push_back(
        {.extent = {.height = (to - from) * form_.pitch() + above + below,
                    .repeated = head_height_,
                    .keep_with_next = ends && !is_last && (index == 0 || index + 2 == rows || rows <= kKeptWhole)},
         .paint =
             [=, form = shared_](QPainter& painter, double top, double height) {
               paint_cells(painter, *form, *row, top + above, from, to);
               const QColor& colour = is_last ? ink::kText : ink::kLine;
               if (ends) paint_rule(painter, 0, form->width, top + height, colour, (is_last ? 1 : 0.5) * kPoint);
             },
         .paint_repeated = [form = shared_, head = head_, height = head_height_](
                               QPainter& painter,
                               double top) { paint_head(painter, *form, *head, top - height, height); }});
  }

  const DocumentTable& table_;
  Typesetter& typesetter_;
  TableForm form_;
  std::shared_ptr<const TableForm> shared_{};
  std::shared_ptr<const Row> head_{};
  double head_height_{};
  std::vector<Piece> pieces_{};
};

}  // namespace

std::vector<Piece> pieces_of(const DocumentTable& table, Typesetter& typesetter, double width) {
  if (table.header.empty()) return {};
  return TableMaker(table, typesetter, width).make();
}

}  // namespace gyrotherm::report
