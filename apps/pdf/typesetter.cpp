// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/typesetter.hpp"

#include <QFontInfo>
#include <QFontMetricsF>
#include <QGlyphRun>
#include <QPainter>
#include <QRawFont>
#include <QStringList>
#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrotherm::report {
namespace {

constexpr double kUnbroken = 1e7;

QFont font_of(const TextLook& look) {
  QFont font(Typesetter::kFamily);
  font.setPixelSize(std::max(1, static_cast<int>(std::lround(look.size))));
  font.setBold(look.bold);
  font.setHintingPreference(QFont::PreferNoHinting);
  // Any spacing at all keeps "fi" two letters, which can be found when they are looked for.
  font.setLetterSpacing(QFont::AbsoluteSpacing, 0.02);
  return font;
}

/// As a layout takes it: line ends as characters of it, and no other control character.
QString prepared(const std::string& text) {
  QString prepared = QString::fromStdString(text);
  for (QChar& letter : prepared) {
    if (letter == '\n') letter = QChar::LineSeparator;
    if (letter.category() == QChar::Other_Control) letter = ' ';
  }
  return prepared;
}

/// How many of the letters from `begin` to `end`, which would be a line, are one: no line ends at a stroke or a hyphen
/// inside a short word, so that "°/h" and "A-D" stay whole.
int line_length(const QString& text, qsizetype begin, qsizetype end) {
  constexpr qsizetype kShort = 16;
  const auto parts = [&](qsizetype at) { return text[at] == ' ' || text[at] == QChar::LineSeparator; };
  qsizetype from = end, to = end;
  if (end > begin && end < text.size() && (text[end - 1] == '/' || text[end - 1] == '-')) {
    while (from > begin && !parts(from - 1)) --from;
    while (to < text.size() && !parts(to)) ++to;
  }
  return static_cast<int>((from > begin && to - from <= kShort ? from : end) - begin);
}

std::shared_ptr<QTextLayout> broken(const QString& text, const QFont& font, const TextLook& look, double width) {
  auto layout = std::make_shared<QTextLayout>(text, font);
  QTextOption option(look.alignment);
  option.setWrapMode(QTextOption::WrapAtWordBoundaryOrAnywhere);
  layout->setTextOption(option);
  layout->beginLayout();
  for (QTextLine line = layout->createLine(); line.isValid(); line = layout->createLine()) {
    line.setLineWidth(std::max(width, look.size));
    const int all = line.textLength(), kept = line_length(text, line.textStart(), line.textStart() + all);
    if (kept < all) line.setNumColumns(kept, std::max(width, look.size));
  }
  layout->endLayout();
  return layout;
}

bool is_drawn(const QString& character, const QFont& font) {
  QTextLayout layout(character, font);
  layout.beginLayout();
  layout.createLine().setLineWidth(kUnbroken);
  layout.endLayout();
  for (const QGlyphRun& run : layout.glyphRuns())
    for (const quint32 glyph : run.glyphIndexes())
      if (glyph == 0) return false;
  return true;
}

}  // namespace

Lines::Lines(std::shared_ptr<QTextLayout> layout, const TextLook& look) : layout_(std::move(layout)), look_(look) {}

int Lines::count() const { return layout_ ? layout_->lineCount() : 0; }

double Lines::width() const {
  double width = 0;
  for (int k = 0; k < count(); ++k) width = std::max(width, layout_->lineAt(k).naturalTextWidth());
  return width;
}

void Lines::paint(QPainter& painter, double x, double y, int first, int last) const {
  painter.setPen(look_.colour);
  for (int k = first; k < std::min(last, count()); ++k) {
    const QTextLine line = layout_->lineAt(k);
    constexpr double kAscent = 0.76, kDescent = 0.24;  // of the letters that are mostly met, in sizes
    const double baseline = (pitch() + (kAscent - kDescent) * look_.size) / 2;
    line.draw(&painter, QPointF(x, y + (k - first) * pitch() + baseline - line.ascent()) - line.position());
  }
}

bool Typesetter::has_font() { return QFontInfo(QFont(kFamily)).family() == kFamily; }

Lines Typesetter::lines(const std::string& text, const TextLook& look, double width) {
  const QFont font = font_of(look);
  const QString whole = prepared(text);
  look_for_missing(whole, font);
  return {broken(whole, font, look, width), look};
}

Lines Typesetter::line(const std::string& text, const TextLook& look) {
  TextLook left = look;
  left.alignment = Qt::AlignLeft;
  return lines(text, left, kUnbroken);
}

double Typesetter::width(const std::string& text, const TextLook& look) { return line(text, look).width(); }

std::string Typesetter::shortened(const std::string& text, const TextLook& look, double width) {
  return QFontMetricsF(font_of(look)).elidedText(prepared(text), Qt::ElideRight, width).toStdString();
}

QPainterPath Typesetter::outline(const std::string& text, const TextLook& look) {
  QPainterPath path;
  path.addText(0, 0, font_of(look), prepared(text));
  return path;
}

double Typesetter::widest_word(const std::string& text, const TextLook& look) {
  const QFont font = font_of(look);
  double widest = 0;
  QString words = prepared(text);
  words.replace(QChar(QChar::LineSeparator), QChar(' '));
  for (const QString& word : words.split(QChar(' '), Qt::SkipEmptyParts))
    widest = std::max(widest, Lines(broken(word, font, look, kUnbroken), look).width());
  return widest;
}

void Typesetter::look_for_missing(const QString& text, const QFont& font) {
  for (const char32_t letter : text.toUcs4()) {
    if (QChar::category(letter) == QChar::Other_Format || letter == QChar::LineSeparator) continue;
    if (!seen_.insert(letter).second) continue;
    if (!is_drawn(QString::fromUcs4(&letter, 1), font)) missing_.insert(letter);
  }
}

}  // namespace gyrotherm::report
