// SPDX-License-Identifier: Apache-2.0
#include "report/plot/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>

namespace gyrotherm::plot {
namespace {

constexpr std::array<Rgb, 5> kShades = {
    {{247, 250, 253}, {209, 225, 241}, {133, 180, 216}, {44, 115, 180}, {8, 48, 107}}};
constexpr std::array<Rgb, 11> kHeatColours = {{{49, 54, 149},
                                               {69, 117, 180},
                                               {116, 173, 209},
                                               {171, 217, 233},
                                               {224, 243, 248},
                                               {255, 255, 191},
                                               {254, 224, 144},
                                               {253, 174, 97},
                                               {244, 109, 67},
                                               {215, 48, 39},
                                               {165, 0, 38}}};

std::uint8_t interpolate_channel(std::uint8_t from, std::uint8_t to, double part) {
  return static_cast<std::uint8_t>(std::lround(from + part * (to - from)));
}

Rgb interpolate_colour(std::span<const Rgb> stops, double fraction) {
  const double place = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), stops.size() - 2);
  const double part = place - static_cast<double>(below);
  const Rgb &a = stops[below], &b = stops[below + 1];
  return {interpolate_channel(a.red, b.red, part), interpolate_channel(a.green, b.green, part),
          interpolate_channel(a.blue, b.blue, part)};
}

constexpr const char* kFontFamily =
    "'Source Sans 3','Helvetica Neue',Helvetica,Arial,'Liberation Sans','DejaVu Sans',sans-serif";

std::string attributes(const Stroke& stroke) {
  const std::string dashes = stroke.dashes.empty() ? "" : fmt::format(" stroke-dasharray=\"{}\"", stroke.dashes);
  return fmt::format("stroke=\"{}\" stroke-width=\"{}\"{}", stroke.colour, stroke.width_px, dashes);
}

const char* anchor_name(Anchor anchor) {
  switch (anchor) {
    case Anchor::start: return "start";
    case Anchor::middle: return "middle";
    case Anchor::end: return "end";
  }
  return "start";
}

}  // namespace

std::string palette(std::size_t index) {
  static constexpr std::array<const char*, kPaletteSize> kPalette = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                                     "#e69f00", "#56b4e9", "#000000", "#7a5195"};
  return kPalette[index % kPalette.size()];
}

std::string shade_colour(double fraction) {
  const Rgb rgb = interpolate_colour(kShades, fraction);
  return fmt::format("#{:02x}{:02x}{:02x}", rgb.red, rgb.green, rgb.blue);
}

Rgb heat_colour(double fraction) { return interpolate_colour(kHeatColours, fraction); }

bool is_shade_dark(double fraction) { return fraction > 0.6; }

std::string format_bias(double deg_per_h) { return decimal(deg_per_h, 4); }

std::string percent(double fraction) { return std::isfinite(fraction) ? decimal(100 * fraction, 1) + " %" : "–"; }

std::string digit_and_power(int digit, int exponent) {
  if (exponent >= -3 && exponent <= 3) return decimal(digit * std::pow(10.0, exponent), std::max(0, -exponent));
  const std::string power = "10" + superscript(exponent);
  return digit == 1 ? power : std::to_string(digit) + " × " + power;
}

std::string format_hours(double seconds) { return decimal(seconds / 3600, 2) + " h"; }

std::string escaped(std::string_view text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&': safe += "&amp;"; break;
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') safe += c;
    }
  }
  return safe;
}

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

SvgWriter::SvgWriter(double width_px, double height_px, std::string_view title, std::string_view description) {
  out_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" "
      "font-family=\"{2}\">\n<title>{3}</title>\n",
      pixels(width_px), pixels(height_px), kFontFamily, escaped(title));
  if (!description.empty()) out_ += fmt::format("<desc>{}</desc>\n", escaped(description));
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
                 pixels(y), pixels(style.size_px), style.colour, anchor_name(style.anchor), more, escaped(content));
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

namespace {

/// Letter width of bold capitals relative to the estimate of text_width().
constexpr double kBoldCapitals = 1.5;
constexpr double kTagSize = 10;

}  // namespace

void draw_simulated_mark(SvgWriter& svg, double x, double y, double width, double height, std::string_view mark) {
  constexpr double kShareOfWidth = 0.95;
  const double size_px = std::min(std::clamp(0.2 * height, 18.0, 44.0),
                                  kShareOfWidth * width / (kBoldCapitals * std::max(1.0, text_width(mark, 1))));
  svg.text(x + width / 2, y + height / 2 + 0.35 * size_px, mark,
           {.size_px = size_px,
            .colour = colour::kSimulated,
            .anchor = Anchor::middle,
            .bold = true,
            .turned_deg = 12,
            .opacity = 0.11});
}

void draw_simulated_tag(SvgWriter& svg, double x, double y, std::string_view mark) {
  svg.text(x, y, mark, {.size_px = kTagSize, .colour = colour::kSimulated, .anchor = Anchor::end, .bold = true});
}

double simulated_tag_width(std::string_view mark) { return kBoldCapitals * text_width(mark, kTagSize); }

}  // namespace gyrotherm::plot
