// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/csv.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gyrotherm::record {
namespace {

using Numbers = std::vector<double>;

Fault read_fault(std::string_view text) {
  LiveRows rows("stdin");
  auto read = rows.take(text);
  if (read) read = rows.finish();
  EXPECT_FALSE(read) << text;
  return read ? Fault{} : read.error();
}

TEST(SplitLine, ReportsColumnOfFault) {
  struct Case {
    std::string line;
    char separator;
    std::size_t column;
  };
  std::string wide = "\"a";
  wide += std::string(70'000, 'x');
  for (const auto& [line, separator, column] :
       {Case{"a,\"b", ',', 3}, Case{"\"a\"b", ',', 4}, Case{"a;  \"b\"  c", ';', 8}, Case{"a \"b", ' ', 3},
        Case{"\"a\"b", ' ', 4}, Case{wide, ',', 1}, Case{std::string(5000, ','), ',', 4097}}) {
    std::vector<Field> fields;
    const auto split = split_line(line, separator, fields);
    ASSERT_FALSE(split) << line;
    EXPECT_EQ(split.error().column, column) << line;
    EXPECT_FALSE(split.error().what.empty());
  }
}

TEST(LiveRows, DoNotDependOnPieces) {
  const std::string text =
      "\xEF\xBB\xBF"
      "A, B ,bias\r\n1,2.5,-3e-2\n\n\"4\" ,+5, 6 \r\n7,8,9";
  for (std::size_t step = 1; step <= text.size(); ++step) {
    LiveRows rows("stdin");
    for (std::size_t from = 0; from < text.size(); from += step) {
      ASSERT_TRUE(rows.take(std::string_view(text).substr(from, step)));
    }
    ASSERT_TRUE(rows.finish());
    EXPECT_EQ(rows.header(), (std::vector<std::string>{"A", "B", "bias"}));
    EXPECT_EQ(rows.numbers(), (Numbers{1, 2.5, -0.03, 4, 5, 6, 7, 8, 9})) << step;
  }
}

TEST(LiveRows, AreAvailableWhenLineEnds) {
  LiveRows rows("stdin");
  ASSERT_TRUE(rows.take("A,B\n1,2\n3,"));
  EXPECT_EQ(rows.numbers(), (Numbers{1, 2}));
  EXPECT_EQ(rows.lines(), std::vector<std::size_t>{2});
  rows.forget_rows();
  ASSERT_TRUE(rows.take("4\n\n5,6\n"));
  EXPECT_EQ(rows.numbers(), (Numbers{3, 4, 5, 6}));
  EXPECT_EQ(rows.lines(), (std::vector<std::size_t>{3, 5})) << "a blank line is not a row, but counts as a line";
}

TEST(LiveRows, TreatEmptyFieldAsMissing) {
  LiveRows rows("stdin");
  ASSERT_TRUE(rows.take("A,B,bias\n1,,3\n"));
  EXPECT_TRUE(std::isnan(rows.numbers()[1]));
}

TEST(LiveRows, ReadQuotesOfExport) {
  LiveRows rows("stdin", [](const auto&, const auto&) -> Result<std::vector<std::size_t>> { return {{0, 2}}; });
  ASSERT_TRUE(rows.take("\"in \"\"\"\"\",segment, \"B\"\n1,\"hold \"\"25\"\", again\",2\n"));
  EXPECT_EQ(rows.header(), (std::vector<std::string>{"in \"\"", "segment", "B"}));
  EXPECT_EQ(rows.numbers(), (Numbers{1, 2}));
}

TEST(LiveRows, ReportPositionOfError) {
  const struct {
    const char *text, *where;
  } laws[] = {{"A,B\n1,2\n\n1,x\n", "stdin:4:3"}, {"A,B\n1,nan\n", "stdin:2:3"},
              {"A,B\n1,2,3\n", "stdin:2:1"},      {"A,B\n1,1e999\n", "stdin:2:3"},
              {"A,B\n+-1,2\n", "stdin:2:1"},      {"A,B\n1;2\n", "stdin:2:1"},
              {"A,\"B\n", "stdin:1:3"},           {"", "stdin:1:1"}};
  for (const auto& law : laws) {
    const Fault fault = read_fault(law.text);
    EXPECT_EQ(fault.where, law.where) << law.text;
    EXPECT_EQ(fault.kind, FaultKind::bad_file);
  }
}

TEST(LiveRows, KeepRowsBeforeError) {
  LiveRows rows("stdin");
  EXPECT_FALSE(rows.take("A,B\n1,2\n3,x\n5,6\n"));
  EXPECT_EQ(rows.numbers(), (Numbers{1, 2}));
}

TEST(LiveRows, HoldAtMostOneLine) {
  const std::string endless(kLongestLine, '1');
  LiveRows rows("stdin");
  ASSERT_TRUE(rows.take("A,B\n"));
  ASSERT_TRUE(rows.take(endless));
  EXPECT_FALSE(rows.take("1"));
  EXPECT_EQ(read_fault("A,B\n" + endless + "1,2\n").where, "stdin:2:1");
}

}  // namespace
}  // namespace gyrotherm::record
