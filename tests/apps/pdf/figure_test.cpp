// SPDX-License-Identifier: Apache-2.0
/// Figures of plot/ as pixels: what Qt's own SVG would leave out or draw otherwise.
#include <gtest/gtest.h>

#include <string>

#include "report/plot/svg.hpp"
#include "tests/apps/pdf/shared_program.hpp"

namespace gyrotherm::report {
namespace {

/// The PNG of a figure that `draw` draws.
template <class Draw>
std::string drawn(Draw draw) {
  plot::SvgWriter svg(200, 100, "figure");
  draw(svg);
  const auto png = shared_program().png_of(std::move(svg).finish(), {.width_px = 400});
  EXPECT_TRUE(png) << text(png.error());
  return png ? png->bytes : "";
}

TEST(Figure, APictureInItIsDrawn) {
  plot::Picture picture{2, 2, {{200, 0, 0}, {0, 200, 0}, {0, 0, 200}, {200, 200, 0}}};
  EXPECT_NE(drawn([&](auto& svg) { svg.picture(20, 20, 100, 50, png_of(picture)); }), drawn([](auto&) {}));
}

TEST(Figure, WhatIsClippedEndsAtItsRegion) {
  const auto within = drawn([](auto& svg) { svg.path("M20 50L80 50", {"#000000", 4}); });
  const auto clipped = drawn([](auto& svg) {
    svg.clip_region("r", 20, 0, 60, 100);
    svg.path("M0 50L200 50", {"#000000", 4}, "r");
  });
  EXPECT_EQ(within, clipped);
}

TEST(Figure, WhatIsPaleIsMixedWithWhite) {
  EXPECT_EQ(drawn([](auto& svg) { svg.rectangle(20, 20, 50, 50, "#000000", 0.2); }),
            drawn([](auto& svg) { svg.rectangle(20, 20, 50, 50, "#cccccc"); }));
}

TEST(Figure, TextIsDrawnWhereItIsAnchored) {
  const auto at = [](double x, plot::Anchor anchor) {
    return drawn([&](auto& svg) { svg.text(x, 50, "°/h", {.anchor = anchor}); });
  };
  EXPECT_NE(at(100, plot::Anchor::start), at(100, plot::Anchor::end));
  EXPECT_NE(at(100, plot::Anchor::start), drawn([](auto&) {}));
}

TEST(Figure, WhatIsNoSvgOrIsTooLargeIsRefused) {
  EXPECT_FALSE(shared_program().png_of("<svg", {}));
  EXPECT_FALSE(shared_program().png_of("<html/>", {}));
  EXPECT_FALSE(shared_program().png_of("<svg viewBox=\"0 0 1 1000000\"/>", {.width_px = 2000}));
  EXPECT_FALSE(shared_program().png_of("<svg viewBox=\"0 0 nan 1\"/>", {}));
}

}  // namespace
}  // namespace gyrotherm::report
