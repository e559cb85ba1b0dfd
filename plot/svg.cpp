#include "plot/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "plot/colour.hpp"
#include "plot/format.hpp"
#include "plot/png.hpp"

namespace gyrotherm {
namespace {

constexpr const char* kFontFamily =
    "'Source Sans 3','Helvetica Neue',Helvetica,Arial,'Liberation Sans','DejaVu Sans',sans-serif";

std::string attributes(const Stroke& stroke) {
  const std::string dashes = stroke.dashes.empty() ? "" : fmt::format(" stroke-dasharray=\"{}\"", stroke.dashes);
  return fmt::format("stroke=\"{}\" stroke-width=\"{}\"{}", stroke.colour, stroke.width_px, dashes);
}

const char* anchor_word(Anchor anchor) {
  switch (anchor) {
    case Anchor::start: return "start";
    case Anchor::middle: return "middle";
    case Anchor::end: return "end";
  }
  return "start";
}

}  // namespace

std::string pixels(double value) {
  const long long tenths = std::llround(10 * value);
  const char* sign = tenths < 0 ? "-" : "";
  const long long size = std::llabs(tenths);
  return size % 10 == 0 ? fmt::format("{}{}", sign, size / 10) : fmt::format("{}{}.{}", sign, size / 10, size % 10);
}

double text_width(std::string_view text, double size_px) {
  const auto letters =
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
  return 0.51 * size_px * static_cast<double>(letters);
}

SvgWriter::SvgWriter(double width_px, double height_px, std::string_view title) {
  out_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" "
      "font-family=\"{2}\">\n<title>{3}</title>\n",
      pixels(width_px), pixels(height_px), kFontFamily, escaped(title));
  rectangle(0, 0, width_px, height_px, "#ffffff");
}

void SvgWriter::rectangle(double x, double y, double width, double height, std::string_view fill, double opacity) {
  fmt::format_to(std::back_inserter(out_), "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"{}/>\n",
                 pixels(x), pixels(y), pixels(width), pixels(height), fill,
                 opacity < 1 ? fmt::format(" fill-opacity=\"{}\"", opacity) : "");
}

void SvgWriter::frame(double x, double y, double width, double height, const Stroke& stroke) {
  fmt::format_to(std::back_inserter(out_), "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" {}/>\n",
                 pixels(x), pixels(y), pixels(width), pixels(height), attributes(stroke));
}

void SvgWriter::line(double x1, double y1, double x2, double y2, const Stroke& stroke) {
  fmt::format_to(std::back_inserter(out_), "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {}/>\n", pixels(x1),
                 pixels(y1), pixels(x2), pixels(y2), attributes(stroke));
}

void SvgWriter::text(double x, double y, std::string_view content, const TextStyle& style) {
  std::string more;
  if (style.bold) more += " font-weight=\"600\"";
  if (style.opacity < 1) more += fmt::format(" fill-opacity=\"{}\"", style.opacity);
  if (!style.halo.empty()) {
    more += fmt::format(" paint-order=\"stroke\" stroke=\"{}\" stroke-width=\"2.6\"", style.halo);
  }
  if (style.turned_deg != 0) {
    more += fmt::format(" transform=\"rotate({} {} {})\"", pixels(-style.turned_deg), pixels(x), pixels(y));
  }
  fmt::format_to(std::back_inserter(out_),
                 "<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\" text-anchor=\"{}\"{}>{}</text>\n", pixels(x),
                 pixels(y), pixels(style.size_px), style.colour, anchor_word(style.anchor), more, escaped(content));
}

void SvgWriter::path(std::string_view data, const Stroke& stroke, std::string_view clip) {
  const std::string clipped = clip.empty() ? "" : fmt::format(" clip-path=\"url(#{})\"", clip);
  fmt::format_to(std::back_inserter(out_), "<path d=\"{}\" fill=\"none\" stroke-linejoin=\"round\" {}{}/>\n", data,
                 attributes(stroke), clipped);
}

void SvgWriter::shape(std::string_view data, std::string_view fill, std::string_view outline) {
  fmt::format_to(std::back_inserter(out_), "<path d=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1.2\"/>\n", data,
                 fill, outline);
}

void SvgWriter::picture(double x, double y, double width, double height, std::string_view png) {
  fmt::format_to(std::back_inserter(out_),
                 "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" "
                 "href=\"data:image/png;base64,{}\"/>\n",
                 pixels(x), pixels(y), pixels(width), pixels(height), base64(png));
}

void SvgWriter::clip_region(std::string_view id, double x, double y, double width, double height) {
  fmt::format_to(std::back_inserter(out_),
                 "<clipPath id=\"{}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n", id, pixels(x),
                 pixels(y), pixels(width), pixels(height));
}

std::string SvgWriter::finish() && {
  out_ += "</svg>\n";
  return std::move(out_);
}

void draw_simulated_mark(SvgWriter& svg, double x, double y, double width, double height) {
  const double size_px = std::clamp(0.2 * height, 18.0, 44.0);
  svg.text(x + width / 2, y + height / 2 + 0.35 * size_px, "SIMULATED",
           {.size_px = size_px,
            .colour = colour::kSimulated,
            .anchor = Anchor::middle,
            .bold = true,
            .turned_deg = 12,
            .opacity = 0.11});
}

void draw_simulated_tag(SvgWriter& svg, double x, double y) {
  svg.text(x, y, "SIMULATED", {.size_px = 10, .colour = colour::kSimulated, .anchor = Anchor::end, .bold = true});
}

}  // namespace gyrotherm
