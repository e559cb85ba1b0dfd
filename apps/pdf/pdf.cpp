// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/pdf.hpp"

#include <fmt/format.h>

#include <QBuffer>
#include <QGuiApplication>
#include <QHashSeed>
#include <QImage>
#include <QPainter>
#include <QPdfWriter>
#include <cmath>
#include <utility>

#include "apps/pdf/figure.hpp"
#include "apps/pdf/logo.hpp"
#include "apps/pdf/page_breaks.hpp"
#include "apps/pdf/pdf_file.hpp"
#include "apps/pdf/pieces.hpp"
#include "apps/pdf/typesetter.hpp"
#include "core/text.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kSheetWidth = 210 * kMillimetre, kSheetHeight = 297 * kMillimetre;
constexpr double kSide = 18 * kMillimetre, kAbove = 24 * kMillimetre, kBelow = 21 * kMillimetre;
constexpr double kTextWidth = kSheetWidth - 2 * kSide, kTextHeight = kSheetHeight - kAbove - kBelow;
constexpr double kHeaderTop = 11 * kMillimetre, kFooterTop = kSheetHeight - 15 * kMillimetre;
constexpr QSize kLogo{1240, 472};  ///< pixels; 52.5 mm × 20 mm at 600 to the inch
constexpr double kLogoPixel = 72 * kPoint / 600;

/// Above the first heading: whose report it is, what it is called, and its number.
Piece title_block(const Document& document, const QImage& logo, Typesetter& typesetter) {
  const double logo_width = logo.width() * kLogoPixel, logo_height = logo.height() * kLogoPixel;
  const double room = kTextWidth - (logo.isNull() ? 0 : logo_width + 6 * kMillimetre);
  const auto laboratory =
      typesetter.lines(document.laboratory, {.size = 9 * kPoint, .bold = true, .colour = ink::kAccent}, room);
  const auto title = typesetter.lines(document.title, {.size = 19 * kPoint, .bold = true, .leading = 1.25}, room);
  const auto number = typesetter.lines(document.number, {.size = 11 * kPoint, .colour = ink::kFaint}, room);
  const double gap = 1.6 * kMillimetre;
  const double height = laboratory.height() + title.height() + number.height() + 2 * gap;
  return {.extent = {.height = std::max(height, logo_height) + 3 * kMillimetre, .keep_with_next = true},
          .paint = [=](QPainter& painter, double top, double) {
            laboratory.paint(painter, 0, top);
            title.paint(painter, 0, top + laboratory.height() + gap);
            number.paint(painter, 0, top + laboratory.height() + title.height() + 2 * gap);
            if (!logo.isNull()) painter.drawImage(QRectF(kTextWidth - logo_width, top, logo_width, logo_height), logo);
          }};
}

/// What stands on every page beside its text.
class Sheet {
 public:
  Sheet(const Document& document, const PdfOptions& options, Typesetter& typesetter)
      : document_(document), options_(options), typesetter_(typesetter) {}

  /// The mark is painted first, and lies behind everything.
  void paint(QPainter& painter, std::size_t page, std::size_t pages) {
    if (!document_.mark.empty()) paint_mark(painter);
    paint_header(painter);
    paint_rule(painter, kSide, kSheetWidth - kSide, kFooterTop, ink::kLine, 0.5 * kPoint);
    put(painter, kSide, kFooterTop + 2 * kMillimetre, options_.program, kSmall);
    const auto page_of = fill(fill(document_.page_of, page + 1), pages);
    put_right(painter, kFooterTop + 2 * kMillimetre, page_of, kSmall);
    if (!options_.source_sha256.empty()) paint_source(painter);
  }

 private:
  static inline const TextLook kSmall{.size = 7.2 * kPoint, .colour = ink::kFaint};

  static std::string fill(std::string text, std::size_t number) {
    if (const auto at = text.find("{}"); at != std::string::npos) text.replace(at, 2, std::to_string(number));
    return text;
  }

  void put(QPainter& painter, double left, double top, const std::string& text, const TextLook& look) {
    typesetter_.line(text, look).paint(painter, left, top);
  }

  void put_right(QPainter& painter, double top, const std::string& text, const TextLook& look) {
    const auto line = typesetter_.line(text, look);
    line.paint(painter, kSheetWidth - kSide - line.width(), top);
  }

  /// Laboratory, mark and number.
  void paint_header(QPainter& painter) {
    TextLook strong{.size = kSmall.size, .bold = true, .colour = ink::kMark};
    const double mark = typesetter_.width(document_.mark, strong), room = (kTextWidth - mark) / 2 - 4 * kMillimetre;
    put(painter, kSide, kHeaderTop, typesetter_.shortened(document_.laboratory, kSmall, room), kSmall);
    put(painter, (kSheetWidth - mark) / 2, kHeaderTop, document_.mark, strong);
    put_right(painter, kHeaderTop, typesetter_.shortened(document_.number, kSmall, room), kSmall);
    paint_rule(painter, kSide, kSheetWidth - kSide, kHeaderTop + 5 * kMillimetre, ink::kLine, 0.5 * kPoint);
  }

  void paint_source(QPainter& painter) {
    const TextLook look{.size = 5.6 * kPoint, .colour = ink::kFaint};
    const auto line = typesetter_.line("calibration.json SHA-256 " + options_.source_sha256, look);
    line.paint(painter, (kSheetWidth - line.width()) / 2, kFooterTop + 2.4 * kMillimetre);
  }

  /// From the lower left to the upper right, as large as the sheet allows; pale, not transparent, which PDF/A-1
  /// forbids.
  void paint_mark(QPainter& painter) {
    constexpr double kTurn = 52;  // degrees
    TextLook look{.size = 90 * kPoint, .bold = true, .colour = QColor(0xf8, 0xed, 0xea), .leading = 1};
    const double most = 285 * kMillimetre, width = typesetter_.width(document_.mark, look);
    if (width > most) look.size *= most / width;
    const auto line = typesetter_.line(document_.mark, look);
    painter.save();
    painter.translate(kSheetWidth / 2, kSheetHeight / 2);
    painter.rotate(-kTurn);
    line.paint(painter, -line.width() / 2, -look.size / 2);
    painter.restore();
  }

  const Document& document_;
  const PdfOptions& options_;
  Typesetter& typesetter_;
};

/// Where the pieces lie; a little closer where that saves a last page with hardly anything on it.
std::vector<Placement> places_of(const std::vector<Piece>& pieces) {
  std::vector<Extent> extents;
  for (const Piece& piece : pieces) extents.push_back(piece.extent);
  auto places = page_breaks(extents, kTextHeight);
  constexpr double kHardly = 0.2, kCloser = 0.75;
  if (places.back().page == 0 || places.back().top > kHardly * kTextHeight) return places;
  for (Extent& extent : extents) extent.space_before *= kCloser;
  const auto closer = page_breaks(extents, kTextHeight);
  return closer.back().page < places.back().page ? closer : places;
}

/// Paints the pieces onto their pages; gives each bookmark its place.
std::vector<Bookmark> paint_pages(QPdfWriter& writer, std::vector<Piece>& pieces, Sheet& sheet) {
  const auto places = places_of(pieces);
  const std::size_t pages = places.back().page + 1;
  std::vector<Bookmark> bookmarks;
  QPainter painter(&writer);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Placement& place = places[i];
    if (i == 0 || place.page != places[i - 1].page) {
      if (i > 0) writer.newPage();
      sheet.paint(painter, place.page, pages);
    }
    painter.save();
    painter.translate(kSide, kAbove);
    if (place.repeats) pieces[i].paint_repeated(painter, place.top);
    pieces[i].paint(painter, place.top, place.height);
    painter.restore();
    if (!pieces[i].bookmark) continue;
    bookmarks.push_back(*pieces[i].bookmark);
    bookmarks.back().page = place.page;
    bookmarks.back().top_pt = (kAbove + place.top) / kPoint;
  }
  return bookmarks;
}

void set_up(QPdfWriter& writer) {
  writer.setPdfVersion(QPagedPaintDevice::PdfVersion_A1b);
  writer.setPageSize(QPageSize(QPageSize::A4));
  writer.setPageMargins(QMarginsF(0, 0, 0, 0));
  writer.setResolution(kPixelsPerInch);
}

/// The logo, or nothing and why.
QImage logo_of(const Document& document, std::vector<std::string>& remarks) {
  if (!document.logo || document.logo->base64.empty()) return {};
  const auto picture = picture_of(*document.logo, kLogo);
  if (picture) return *picture;
  remarks.push_back(text(picture.error()) + "; it is left out");
  return {};
}

void say_what_is_missing(const Typesetter& typesetter, std::vector<std::string>& remarks) {
  if (typesetter.missing().empty()) return;
  std::string letters;
  for (const char32_t letter : typesetter.missing())
    letters += fmt::format("{}U+{:04X}", letters.empty() ? "" : ", ", static_cast<std::uint32_t>(letter));
  remarks.push_back(fmt::format(
      "no installed font has {}; boxes stand in their place (Debian: fonts-noto-core, fonts-noto-cjk)", letters));
}

/// Qt's own messages are about displays and folders that this program does not need.
void say_nothing(QtMsgType, const QMessageLogContext&, const QString&) {}

}  // namespace

struct PdfProgram::Application {
  int argc = 1;
  char name[14] = "gyrotherm-pdf";
  char* argv[2] = {name, nullptr};
  std::unique_ptr<QGuiApplication> qt;
};

PdfProgram::PdfProgram() : application_(std::make_unique<Application>()) {
  qInstallMessageHandler(say_nothing);
  QHashSeed::setDeterministicGlobalSeed();  // fonts are written in the order of a hash
  if (qEnvironmentVariableIsEmpty("QT_QPA_PLATFORM")) qputenv("QT_QPA_PLATFORM", "offscreen");
  application_->qt = std::make_unique<QGuiApplication>(application_->argc, application_->argv);
}

PdfProgram::~PdfProgram() = default;

Result<FinishedFile> PdfProgram::pdf_of(const Document& document, const PdfOptions& options) const {
  if (!Typesetter::has_font())
    return failure(FaultKind::bad_file, Typesetter::kFamily, "the font is not installed (Debian: fonts-dejavu-core)");
  Typesetter typesetter;
  FinishedFile pdf;
  auto made = pieces_of(document, typesetter, kTextWidth);
  pdf.remarks = std::move(made.faults);
  made.pieces.insert(made.pieces.begin(), title_block(document, logo_of(document, pdf.remarks), typesetter));
  QByteArray bytes;
  PdfFacts facts{.title = document.title + " " + document.number,
                 .author = document.laboratory,
                 .keywords = options.source_sha256.empty() ? "" : "calibration.json sha256:" + options.source_sha256,
                 .creator = options.program,
                 .producer = fmt::format("{} with Qt {}", options.program, qVersion()),
                 .language = code(document.language),
                 .utc_s = options.utc_s,
                 .bookmarks = {},
                 .has_signature_field = options.has_signature_field};
  {
    QBuffer buffer(&bytes);
    buffer.open(QIODevice::WriteOnly);
    QPdfWriter writer(&buffer);
    set_up(writer);
    Sheet sheet(document, options, typesetter);
    facts.bookmarks = paint_pages(writer, made.pieces, sheet);
  }
  say_what_is_missing(typesetter, pdf.remarks);
  auto whole = finished({bytes.constData(), static_cast<std::size_t>(bytes.size())}, facts, kSheetHeight / kPoint);
  if (!whole) return failure(whole.error());
  pdf.bytes = std::move(*whole);
  return pdf;
}

Result<FinishedFile> PdfProgram::png_of(const std::string& svg, const PngOptions& options) const {
  const auto size = size_of_figure(svg);
  if (!size) return failure(size.error());
  constexpr double kMostPixels = 1e8;
  const double height = std::round(options.width_px * size->height() / size->width());
  if (height < 1 || height * options.width_px > kMostPixels)
    return failure(FaultKind::bad_file, "figure", "it would have more than 100 million pixels, or none");
  QImage picture(options.width_px, static_cast<int>(height), QImage::Format_RGB888);
  picture.fill(Qt::white);
  Typesetter typesetter;
  {
    QPainter painter(&picture);
    painter.setRenderHints(QPainter::Antialiasing | QPainter::TextAntialiasing | QPainter::SmoothPixmapTransform);
    if (auto painted = paint_figure(painter, svg, QRectF(picture.rect()), typesetter); !painted)
      return failure(painted.error());
  }
  FinishedFile png;
  QByteArray bytes;
  QBuffer buffer(&bytes);
  picture.save(&buffer, "PNG");
  png.bytes = bytes.toStdString();
  say_what_is_missing(typesetter, png.remarks);
  return png;
}

}  // namespace gyrotherm::report
