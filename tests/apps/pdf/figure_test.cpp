// SPDX-License-Identifier: Apache-2.0
/// Figures of report/plot, rendered to pixels.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "report/plot/svg.hpp"
#include "tests/apps/pdf/shell.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::pdf {
namespace {

/// Runs gyrotherm-pdf on an SVG. Returns the PNG; empty if there is none.
std::string png_of_svg(const std::string& svg, const std::string& width = "400") {
  const tests::TestFolder folder;
  std::ofstream(folder / "figure.svg") << svg;
  const auto ran = shell(GYROTHERM_PDF " --png " + (folder / "figure.svg") + " --width " + width + " --out " +
                         (folder / "figure.png"));
  EXPECT_EQ(ran.exit_code, std::filesystem::exists(folder / "figure.png") ? 0 : 4) << ran.out;
  return content_of(folder / "figure.png");
}

/// Returns the PNG of the figure that `draw` makes.
template <class Draw>
std::string drawn(Draw draw) {
  plot::SvgWriter svg(200, 100, "figure");
  draw(svg);
  const auto png = png_of_svg(std::move(svg).finish());
  EXPECT_TRUE(png.starts_with("\x89PNG"));
  return png;
}

TEST(Figure, DrawsEmbeddedPicture) {
  plot::Picture picture{2, 2, {{200, 0, 0}, {0, 200, 0}, {0, 0, 200}, {200, 200, 0}}};
  EXPECT_NE(drawn([&](auto& svg) { svg.picture(20, 20, 100, 50, to_png(picture)); }), drawn([](auto&) {}));
}

TEST(Figure, ClipsToRegion) {
  const auto within = drawn([](auto& svg) { svg.path("M20 50L80 50", {"#000000", 4}); });
  const auto clipped = drawn([](auto& svg) {
    svg.clip_region("r", 20, 0, 60, 100);
    svg.path("M0 50L200 50", {"#000000", 4}, "r");
  });
  EXPECT_EQ(within, clipped);
}

TEST(Figure, MixesOpacityWithWhite) {
  EXPECT_EQ(drawn([](auto& svg) { svg.rectangle(20, 20, 50, 50, "#000000", 0.2); }),
            drawn([](auto& svg) { svg.rectangle(20, 20, 50, 50, "#cccccc"); }));
}

TEST(Figure, DrawsTextAtItsAnchor) {
  const auto at = [](double x, plot::Anchor anchor) {
    return drawn([&](auto& svg) { svg.text(x, 50, "°/h", {.anchor = anchor}); });
  };
  EXPECT_NE(at(100, plot::Anchor::start), at(100, plot::Anchor::end));
  EXPECT_NE(at(100, plot::Anchor::start), drawn([](auto&) {}));
}

TEST(Figure, RefusesInvalidOrTooLargeSvg) {
  EXPECT_EQ(png_of_svg("<svg"), "");
  EXPECT_EQ(png_of_svg("<html/>"), "");
  EXPECT_EQ(png_of_svg("<svg viewBox=\"0 0 1 1000000\"/>", "2000"), "");
  EXPECT_EQ(png_of_svg("<svg viewBox=\"0 0 nan 1\"/>"), "");
}

}  // namespace
}  // namespace gyrotherm::pdf
