// SPDX-License-Identifier: Apache-2.0
/// The laboratory's logo: accepted pictures, and refused ones with the reason.
#include <gtest/gtest.h>

#include <string>

#include "report/plot/png.hpp"
#include "tests/apps/pdf/paper.hpp"

namespace gyrotherm::pdf {
namespace {

using report::Document;
using report::Logo;

/// Returns the output for a report with this logo.
std::string remarks_on_logo(const std::string& media_type, const std::string& bytes, const std::string& base64 = {}) {
  Document document = small_document();
  document.logo = Logo{.media_type = media_type, .base64 = base64.empty() ? plot::base64(bytes) : base64};
  const Paper paper(document);
  EXPECT_EQ(paper.ran().exit_code, 0) << paper.ran().out;
  EXPECT_TRUE(paper.bytes().starts_with("%PDF-1.4"));
  return paper.ran().out;
}

std::string svg_with(const std::string& content) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" viewBox=\"0 0 40 "
         "20\">" +
         content + "</svg>";
}

std::string remarks_on_svg(const std::string& content) { return remarks_on_logo("image/svg+xml", svg_with(content)); }

TEST(Logo, DrawsSvgAndPng) {
  EXPECT_EQ(
      remarks_on_svg("<style>.a{fill:url(#g);stroke-dasharray:none}</style><defs><linearGradient id=\"g\"><stop "
                     "offset=\"0\" stop-color=\"red\"/></linearGradient></defs><circle class=\"a\" cx=\"9\" cy=\"9\" "
                     "r=\"5\" fill=\"url(#g)\" opacity=\"0.5\"/>"),
      "");
  plot::Picture picture{30, 20, {}};
  picture.points.assign(600, {200, 0, 0});
  EXPECT_EQ(remarks_on_logo("image/png", plot::to_png(picture)), "");
}

TEST(Logo, OmitsBrokenPictureWithRemark) {
  EXPECT_NE(remarks_on_logo("image/png", "", "!!!").find("base64"), std::string::npos);
  EXPECT_NE(remarks_on_logo("image/png", "no picture").find("not a PNG"), std::string::npos);
  EXPECT_NE(remarks_on_logo("image/svg+xml", "<svg").find("not a valid SVG"), std::string::npos);
  EXPECT_NE(remarks_on_logo("image/svg+xml", "<html/>").find("not an SVG"), std::string::npos);
  plot::Picture picture{200, 100, {}};
  for (int k = 0; k < 20000; ++k) picture.points.push_back({static_cast<std::uint8_t>(k * 97 % 251), 0, 0});
  const auto png = plot::to_png(picture);
  EXPECT_NE(remarks_on_logo("image/png", png.substr(0, png.size() / 2)).find("logo"), std::string::npos);
}

TEST(Logo, OmitsSvgWithExternalReferences) {
  for (const auto* content :
       {"<image href=\"file:///etc/passwd\"/>", "<image xlink:href=\"http://example.org/a.png\"/>",
        "<rect fill=\"url(http://example.org/a.svg#g)\"/>", "<style>@import 'a.css';</style>",
        "<style>rect { fill: \\75rl(a.svg) }</style>", "<linearGradient id=\"g\" xlink:href=\"b.svg#h\"/>",
        "<rect style=\"fill: u&#114;l(&#47;etc/a.svg#g)\"/>"})
    EXPECT_NE(remarks_on_svg(content).find("omitted"), std::string::npos) << content;
}

TEST(Logo, OmitsSvgThatIsExpensiveToDraw) {
  for (const auto* content : {"<g id=\"a\"><use href=\"#a\"/></g>", "<script>for(;;);</script>",
                              "<path stroke-dasharray=\"0.0001\" d=\"M0 0L1e9 0\"/>", "<foreignObject/>"})
    EXPECT_NE(remarks_on_svg(content).find("omitted"), std::string::npos) << content;
  const std::string laughs =
      "<!DOCTYPE svg [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;&a;\">]>" + svg_with("<text>&b;</text>");
  EXPECT_NE(remarks_on_logo("image/svg+xml", laughs).find("entities"), std::string::npos);
  std::string many;
  for (int k = 0; k < 6000; ++k) many += "<g/>";
  EXPECT_NE(remarks_on_svg(many).find("elements"), std::string::npos);
  EXPECT_NE(remarks_on_logo("image/svg+xml", std::string(3'000'000, ' ')).find("2 MB"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::pdf
