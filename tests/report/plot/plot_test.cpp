// SPDX-License-Identifier: Apache-2.0
#include "report/plot/plot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>
#include <string>
#include <utility>

#include "tests/support/markup.hpp"

namespace gyrotherm::plot {
namespace {

Plot long_plot(std::size_t length) {
  Curve curve{.name = "a <b> & \"c\"", .colour = "#123456"};
  for (std::size_t k = 0; k < length; ++k) {
    curve.x.push_back(static_cast<double>(k));
    curve.y.push_back(std::sin(static_cast<double>(k)));
  }
  Panel panel;
  panel.title = "R&D";
  panel.left.title = "°/h";
  panel.curves = {curve, curve};
  panel.right = AxisStyle{.title = "°C"};
  panel.curves[1].side = Side::right;
  return {.id = "long", .title = "t", .x = {.title = "h"}, .panels = {panel}};
}

TEST(Plot, IsWellFormedWithHostileTexts) { EXPECT_EQ(tests::markup_error(to_svg(long_plot(50))), ""); }

TEST(Plot, GivesEqualTextEachTime) { EXPECT_EQ(to_svg(long_plot(5000)), to_svg(long_plot(5000))); }

TEST(Plot, StaysSmallForMillionPoints) { EXPECT_LT(to_svg(long_plot(1000000)).size(), 150000U); }

TEST(Plot, ShowsSimulatedOnlyIfSimulated) {
  Plot plot = long_plot(10);
  EXPECT_EQ(tests::count_occurrences(to_svg(plot), "SIMULATED"), 0);
  plot.simulated = true;
  EXPECT_GE(tests::count_occurrences(to_svg(plot), "SIMULATED"), 3);
}

/// Returns the vertical positions of the x title and of the tag at the edge of a simulated plot.
std::pair<double, double> title_and_tag(const Plot& plot) {
  const std::string svg = to_svg(plot);
  const auto y_of = [&](const std::string& text, const char* anchor) {
    std::smatch found;
    const std::regex element("y=\"([0-9.]+)\"[^>]*text-anchor=\"" + std::string(anchor) + "\"[^>]*>" + text +
                             "</text>");
    return std::regex_search(svg, found, element) ? std::stod(found[1]) : std::nan("");
  };
  return {y_of(plot.x.title, "middle"), y_of(plot.language.simulated, "end")};
}

TEST(Plot, DrawsTagBelowTitleThatLeavesNoSpace) {
  Plot plot = long_plot(10);
  plot.simulated = true;
  plot.x.title = "Averaging time, s";
  for (const double width : {360.0, 420.0}) {
    plot.width_px = width;
    plot.language.simulated = "DRAFT · SIMULATED";
    const auto [title, tag] = title_and_tag(plot);
    EXPECT_GE(tag, title + 12) << width;
  }
  plot.width_px = 900;
  const auto [title, tag] = title_and_tag(plot);
  EXPECT_NEAR(tag, title, 4) << "one line";
}

TEST(Plot, IsFigureWithoutData) {
  Plot plot = long_plot(0);
  EXPECT_EQ(tests::markup_error(to_svg(plot)), "");
  plot.panels[0].curves.clear();
  EXPECT_EQ(tests::count_occurrences(to_svg(plot), "nan"), 0);
}

TEST(Plot, BreaksLineAtNan) {
  Plot plot = long_plot(5);
  plot.panels[0].curves.resize(1);
  plot.panels[0].right.reset();
  plot.panels[0].curves[0].y[2] = std::numeric_limits<double>::quiet_NaN();
  const std::string svg = to_svg(plot);
  const auto path = svg.substr(svg.find("<path d=\""), 120);
  EXPECT_EQ(tests::count_occurrences(path.substr(0, path.find("\" fill")), "M"), 2) << path;
}

TEST(Plot, DrawsDotForIsolatedPoint) {
  Plot plot = long_plot(5);
  plot.panels[0].curves.resize(1);
  plot.panels[0].right.reset();
  for (const std::size_t k : {1, 3}) plot.panels[0].curves[0].y[k] = std::numeric_limits<double>::quiet_NaN();
  const std::string svg = to_svg(plot);
  const auto path = svg.substr(svg.find("<path d=\""), 120);
  EXPECT_EQ(tests::count_occurrences(path.substr(0, path.find("\" fill")), "h1.2"), 3) << path;
}

/// The names of all curves must be inside the picture.
TEST(Plot, KeepsLongLegendInsidePicture) {
  Plot plot = long_plot(5);
  const auto height_of = [&] {
    const std::string svg = to_svg(plot);
    const auto at = svg.find(" height=\"") + 9;
    return std::stod(svg.substr(at));
  };
  const double before = height_of();
  for (int k = 0; k < 14; ++k) plot.panels[0].curves.push_back(plot.panels[0].curves[0]);
  for (std::size_t k = 0; k < 16; ++k)
    plot.panels[0].curves[k].name = "thermometer " + std::string(1, static_cast<char>('A' + k)) + " on the plate";
  const std::string svg = to_svg(plot);
  EXPECT_GT(height_of(), before) << "the legend does not reduce the plotting area";
  const std::regex name("<text x=\"(-?[0-9.]+)\" y=\"(-?[0-9.]+)\"[^>]*>thermometer");
  int names = 0;
  for (std::sregex_iterator one(svg.begin(), svg.end(), name), end; one != end; ++one, ++names) {
    EXPECT_GT(std::stod((*one)[1]), 0) << one->str();
    EXPECT_GT(std::stod((*one)[2]), 0) << one->str();
  }
  EXPECT_EQ(names, 16);
}

TEST(HeatMap, ShowsZeroOnDiagonalAndThreeDecimals) {
  const HeatMap map{
      .title = "r", .names = {"A", "B"}, .values = {{0, 0.9391}, {0.9391, 0}}, .threshold = 0.9, .caption = "<|r|>"};
  const std::string svg = to_svg(map);
  EXPECT_EQ(tests::markup_error(svg), "");
  EXPECT_EQ(tests::count_occurrences(svg, ">0.939<"), 2);
  EXPECT_EQ(tests::count_occurrences(svg, ">0<"), 2);
}

Plot logarithmic_plot() {
  Curve curve{.name = "σ", .colour = "#123456", .x = {1, 10, 100}, .y = {0.1, 0.01, 0.02}, .marker = Marker::circle};
  curve.error = {0.01, 0.001, 0.05};
  curve.line = false;
  Panel panel;
  panel.left = {.title = "°/h", .logarithmic = true};
  panel.curves = {curve};
  return {.id = "log", .title = "t", .x = {.title = "s", .logarithmic = true}, .panels = {panel}};
}

TEST(LogarithmicPlot, IsWellFormedWithoutPoints) {
  Plot plot = logarithmic_plot();
  EXPECT_EQ(tests::markup_error(to_svg(plot)), "");
  plot.panels[0].curves[0].y = {0, -1, std::numeric_limits<double>::quiet_NaN()};
  EXPECT_EQ(tests::markup_error(to_svg(plot)), "");
  EXPECT_EQ(tests::count_occurrences(to_svg(plot), "nan"), 0);
  EXPECT_EQ(tests::count_occurrences(to_svg(plot), "inf"), 0);
  plot.panels[0].curves.clear();
  EXPECT_EQ(tests::markup_error(to_svg(plot)), "");
}

TEST(LogarithmicPlot, DrawsBarWithCapsAtEachError) {
  Plot plot = logarithmic_plot();
  const auto strokes = [&] { return tests::count_occurrences(to_svg(plot), "<line"); };
  const int with = strokes();
  plot.panels[0].left.range = Range{0.005, 0.2};
  const int fixed = strokes();
  plot.panels[0].curves[0].error.clear();
  EXPECT_EQ(fixed - strokes(), 3 + 5) << "three bars and five caps; the lowest cap is outside the axis";
  EXPECT_GT(with, 0);
}

TEST(LogarithmicPlot, BreaksLineAtValueThatIsNotPositive) {
  Plot plot = logarithmic_plot();
  Curve& curve = plot.panels[0].curves[0];
  curve.line = true;
  curve.error.clear();
  curve.x = {1, 10, 100, 1000, 10000};
  curve.y = {0.1, 0.01, 0, 0.02, 0.03};
  const std::string svg = to_svg(plot);
  const auto path = svg.substr(svg.find("<path d=\""), 120);
  EXPECT_EQ(tests::count_occurrences(path.substr(0, path.find("\" fill")), "M"), 2) << path;
}

TEST(Plot, NamesCategoriesOfLeftAxis) {
  Plot plot = long_plot(10);
  plot.language.decimal_comma = true;
  plot.panels[0].curves.resize(1);
  plot.panels[0].right.reset();
  plot.panels[0].left.categories = {"u1.x", "u1.y", "skew<2>"};
  for (double& y : plot.panels[0].curves[0].y) y = std::fmod(y, 2) > 0 ? 1 : 2;
  const auto svg = to_svg(plot);
  for (const char* name : {">u1.x<", ">u1.y<", ">skew&lt;2&gt;<"})
    EXPECT_EQ(tests::count_occurrences(svg, name), 1) << name;
  EXPECT_EQ(tests::count_occurrences(svg, ">4<"), 1) << "only on the x axis";
}

}  // namespace
}  // namespace gyrotherm::plot
