// SPDX-License-Identifier: Apache-2.0
/// Text of one style, broken into lines of a width, measured and painted; only for the sources of this folder.
///
/// Lengths here and in all of the folder are pixels of the sheet. They are so small that letters stand where they
/// belong, and so large that no number in a PDF/A-1 passes 32767, as it must not.
#pragma once

#include <QColor>
#include <QFont>
#include <QPainterPath>
#include <QString>
#include <QTextLayout>
#include <memory>
#include <set>
#include <string>

class QPainter;

namespace gyrotherm::report {

inline constexpr double kPoint = 32;                       ///< 1/72 inch
inline constexpr double kMillimetre = kPoint * 72 / 25.4;  ///< of the sheet
inline constexpr int kPixelsPerInch = 72 * 32;

namespace ink {
inline const QColor kText{0x1d, 0x27, 0x33};
inline const QColor kFaint{0x5b, 0x66, 0x73};
inline const QColor kLine{0xd5, 0xda, 0xe0};
inline const QColor kAccent{0x0b, 0x4f, 0x8a};
inline const QColor kMark{0xa8, 0x37, 0x1b};
inline const QColor kPass{0x00, 0x6b, 0x4c};
inline const QColor kCaution{0x8a, 0x5a, 0x00};
}  // namespace ink

struct TextLook {
  double size = 9 * kPoint;
  bool bold = false;
  QColor colour = ink::kText;
  Qt::Alignment alignment = Qt::AlignLeft;
  double leading = 1.4;  ///< from one line to the next, in sizes
};

namespace look {
inline const TextLook kBody{.size = 8.8 * kPoint, .leading = 1.45};
inline const TextLook kNote{.size = 7.6 * kPoint, .colour = ink::kFaint};
inline const TextLook kHeading{.size = 13 * kPoint, .bold = true, .leading = 1.3};
inline const TextLook kSubheading{.size = 10 * kPoint, .bold = true, .leading = 1.3};
}  // namespace look

/// Text that is broken already. Copies share it.
class Lines {
 public:
  Lines() = default;
  Lines(std::shared_ptr<QTextLayout> layout, const TextLook& look);

  [[nodiscard]] int count() const;
  [[nodiscard]] double pitch() const { return look_.leading * look_.size; }
  [[nodiscard]] double height() const { return count() * pitch(); }
  /// The widest line.
  [[nodiscard]] double width() const;

  /// Paints lines first … last - 1; (x, y) is the upper left corner of the first of these.
  void paint(QPainter& painter, double x, double y, int first, int last) const;
  void paint(QPainter& painter, double x, double y) const { paint(painter, x, y, 0, count()); }

 private:
  std::shared_ptr<QTextLayout> layout_;
  TextLook look_;
};

/// Owns the choice of font, and knows which characters no installed font has.
class Typesetter {
 public:
  /// Whether the font that all text is set in is installed.
  [[nodiscard]] static bool has_font();
  static constexpr const char* kFamily = "DejaVu Sans";

  /// Breaks at blanks, and inside a word where it alone is wider than `width`; "\n" begins a new line.
  [[nodiscard]] Lines lines(const std::string& text, const TextLook& look, double width);
  /// Without a break of ours.
  [[nodiscard]] Lines line(const std::string& text, const TextLook& look);
  /// How wide it is without any break.
  [[nodiscard]] double width(const std::string& text, const TextLook& look);
  /// Its letters as shapes; its baseline begins at the origin.
  [[nodiscard]] static QPainterPath outline(const std::string& text, const TextLook& look);
  /// The text, or as many of its letters as fit with "…"; for what stands whole elsewhere.
  [[nodiscard]] std::string shortened(const std::string& text, const TextLook& look, double width);
  /// The widest of what is parted by blanks at which a line may break.
  [[nodiscard]] double widest_word(const std::string& text, const TextLook& look);

  /// Characters that were set and that no installed font has.
  [[nodiscard]] const std::set<char32_t>& missing() const { return missing_; }

 private:
  void look_for_missing(const QString& text, const QFont& font);

  std::set<char32_t> seen_, missing_;
};

}  // namespace gyrotherm::report
