// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/text_lines.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

std::vector<std::string> read_lines(Bytes bytes, const std::string& comment = "") {
  auto lines = TextLines::open(std::move(bytes), comment).value();
  std::vector<std::string> all;
  while (lines.next().value()) all.push_back(std::to_string(lines.number()) + ":" + std::string(lines.line()));
  return all;
}

using Lines = std::vector<std::string>;

TEST(TextLines, AreEqualInEveryEncoding) {
  const Lines expected{"1:a;°", "3:𝄞"};
  EXPECT_EQ(read_lines(Bytes("a;°\n\n𝄞", "f")), expected);
  EXPECT_EQ(read_lines(Bytes("\xEF\xBB\xBF"
                             "a;°\r\n \r\n𝄞\r\n",
                             "f")),
            expected);
  using std::string_view_literals::operator""sv;
  EXPECT_EQ(read_lines(Bytes("\xFF\xFE"
                             "a\0;\0\xB0\0\r\0\n\0\n\0\x34\xD8\x1E\xDD\n\0"sv,
                             "f")),
            expected);
  EXPECT_EQ(read_lines(Bytes("\xFE\xFF\0a\0;\0\xB0\0\n\0\n\xD8\x34\xDD\x1E"sv, "f")), expected);
}

TEST(TextLines, ReplaceIncompletePairOfUtf16) {
  using std::string_view_literals::operator""sv;
  EXPECT_EQ(read_lines(Bytes("\xFF\xFE\x34\xD8"
                             "a\0\n\0\x1E\xDD\n\0\x34\xD8"sv,
                             "f")),
            (Lines{"1:\uFFFDa", "2:\uFFFD", "3:\uFFFD"}));
  EXPECT_EQ(read_lines(Bytes("\xFF\xFE"
                             "a\0b"sv,
                             "f")),
            Lines{"1:a"})
      << "half a code unit at the end is ignored";
}

TEST(TextLines, ReportUtf16WithoutMark) {
  using std::string_view_literals::operator""sv;
  const auto lines = TextLines::open(Bytes("t\0,\0"sv, "f"), "");
  ASSERT_FALSE(lines);
  EXPECT_EQ(text(lines.error()), "f:1:1: a NUL byte, expected UTF-8, or UTF-16 with a byte order mark");
}

TEST(TextLines, ReportCarriageReturnWithinLine) {
  const auto said = [](std::string_view text) {
    auto lines = TextLines::open(Bytes(text, "f"), "#").value();
    while (true) {
      const auto next = lines.next();
      if (!next) return gyrotherm::text(next.error());
      if (!*next) return std::string("read");
    }
  };
  const std::string what = "a carriage return within the line, expected lines that end with LF or CRLF";
  EXPECT_EQ(said("t;T;w\r0;20;1\r1;20;2\r"), "f:1:6: " + what);
  EXPECT_EQ(said("# made by hand\rt;T;w\r0;20;1\r"), "f:1:15: " + what);
  EXPECT_EQ(said("t;T;w\n0;20;\"1\r2\"\n"), "f:2:8: " + what) << "in quotes too";
  EXPECT_EQ(said("t;T;w\r\r\n0;20;1\r\n\r\n"), "read") << "several before the LF end the line with it";
}

TEST(TextLines, SkipLinesExceptComments) {
  const std::string text = "a\n\n#\nb\rb\n" + std::string(200'000, 'x') + "\nc\n";
  auto lines = TextLines::open(Bytes(text, "f"), "#").value();
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(lines.skip_line().value());
  EXPECT_EQ(lines.number(), 5u);
  ASSERT_TRUE(lines.next().value());
  EXPECT_EQ(lines.line(), "c");
  EXPECT_FALSE(lines.skip_line().value());
}

TEST(TextLines, AcceptCommentsAndEmptyLinesOfAnyLength) {
  const std::string text = "#" + std::string(200'000, 'x') + "\na\n" + std::string(3'000'000, ' ') + "\nb";
  EXPECT_EQ(read_lines(Bytes(text, "f"), "#"), (Lines{"2:a", "4:b"}));
}

TEST(TextLines, AreReadPieceByPiece) {
  const tests::TestFolder folder;
  Lines expected;
  {
    std::ofstream file(folder / "long.txt");
    for (int i = 1; i <= 100'000; ++i) {
      const std::string line(static_cast<std::size_t>(i % 50), 'x');
      file << line << "!\n";
      expected.push_back(std::to_string(i) + ":" + line + "!");
    }
  }
  EXPECT_EQ(read_lines(Bytes::open(folder / "long.txt").value()), expected);
}

TEST(TextLines, RefusePipeAndFolder) {
  EXPECT_FALSE(Bytes::open("/dev/zero"));
  EXPECT_FALSE(Bytes::open("/tmp"));
  EXPECT_FALSE(Bytes::open("/nowhere/x"));
}

}  // namespace
}  // namespace gyrotherm::exchange
