// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/page_breaks.hpp"

#include <gtest/gtest.h>

#include <random>

namespace gyrotherm::report {
namespace {

TEST(PageBreaks, PagesAreFilledFromTheFirstOn) {
  const auto places = page_breaks({{.height = 40}, {.height = 40, .space_before = 10}, {.height = 40}}, 100);
  ASSERT_EQ(places.size(), 3u);
  EXPECT_EQ(places[1].page, 0u);
  EXPECT_EQ(places[1].top, 50);
  EXPECT_EQ(places[2].page, 1u);
  EXPECT_EQ(places[2].top, 0);
}

TEST(PageBreaks, NoSpaceStandsAtTheTopOfAPage) {
  const auto places = page_breaks({{.height = 90}, {.height = 40, .space_before = 10}}, 100);
  EXPECT_EQ(places[1].page, 1u);
  EXPECT_EQ(places[1].top, 0);
}

TEST(PageBreaks, AHeadingGoesWithWhatItHeads) {
  const auto places = page_breaks({{.height = 70}, {.height = 10, .keep_with_next = true}, {.height = 30}}, 100);
  EXPECT_EQ(places[1].page, 1u);
  EXPECT_EQ(places[2].page, 1u);
  EXPECT_EQ(places[2].top, 10);
}

TEST(PageBreaks, AHeadIsRepeatedWhereItsTableGoesOn) {
  const auto places =
      page_breaks({{.height = 80}, {.height = 30, .repeated = 15}, {.height = 30, .repeated = 15}}, 100);
  EXPECT_FALSE(places[0].repeats);
  EXPECT_TRUE(places[1].repeats);
  EXPECT_EQ(places[1].top, 15);
  EXPECT_FALSE(places[2].repeats);
  EXPECT_EQ(places[2].top, 45);
}

TEST(PageBreaks, AFigureIsMadeSmallerBeforeItTurnsThePage) {
  const std::vector<Extent> extents{
      {.height = 60}, {.height = 50, .least_height = 30, .keep_with_next = true}, {.height = 5}};
  const auto places = page_breaks(extents, 100);
  EXPECT_EQ(places[1].page, 0u);
  EXPECT_DOUBLE_EQ(places[1].height, 35);
  EXPECT_EQ(places[2].page, 0u);
  EXPECT_EQ(page_breaks(extents, 94).at(1).page, 1u) << "it would have to be smaller than it may";
}

TEST(PageBreaks, WhatIsHigherThanAPageBeginsOneAndTheRestFollows) {
  const auto places = page_breaks({{.height = 10}, {.height = 150, .least_height = 140}, {.height = 10}}, 100);
  EXPECT_EQ(places[1].page, 1u);
  EXPECT_EQ(places[1].top, 0);
  EXPECT_EQ(places[1].height, 140);
  EXPECT_EQ(places[2].page, 2u);
}

TEST(PageBreaks, WhatKeepsTogetherAndIsHigherThanAPageIsPartedAndPagesAreFull) {
  const std::vector<Extent> rows(30, {.height = 10, .keep_with_next = true});
  const auto places = page_breaks(rows, 100);
  EXPECT_EQ(places.back().page, 2u);
}

std::vector<Extent> drawn(std::mt19937& engine) {
  std::uniform_real_distribution<double> height(1, 60), little(0, 8);
  std::vector<Extent> extents(1 + engine() % 60);
  for (Extent& extent : extents) {
    extent = {.height = height(engine), .space_before = little(engine), .keep_with_next = engine() % 4 == 0};
    if (engine() % 5 == 0) extent.least_height = extent.height / 2;
    if (engine() % 3 == 0) extent.repeated = little(engine);
  }
  return extents;
}

/// Of any pieces that a page has room for: none overlaps another or leaves the page, and none is left out.
TEST(PageBreaks, NothingOverlapsAndNothingLeavesItsPage) {
  constexpr double kPage = 100;
  for (unsigned seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 engine(seed);
    const auto extents = drawn(engine);
    const auto places = page_breaks(extents, kPage);
    ASSERT_EQ(places.size(), extents.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_GE(places[i].top, places[i].repeats ? extents[i].repeated - 1e-9 : 0);
      EXPECT_LE(places[i].top + places[i].height, kPage + 1e-5);
      EXPECT_GE(places[i].height, extents[i].least_height > 0 ? extents[i].least_height - 1e-9 : extents[i].height);
      if (i == 0) continue;
      if (places[i].page == places[i - 1].page) {
        EXPECT_GE(places[i].top, places[i - 1].top + places[i - 1].height - 1e-9);
      } else {
        EXPECT_EQ(places[i].page, places[i - 1].page + 1);
      }
    }
  }
}

}  // namespace
}  // namespace gyrotherm::report
