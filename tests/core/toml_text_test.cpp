// SPDX-License-Identifier: Apache-2.0
#include "core/toml_text.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "core/file.hpp"
#include "core/toml_reader.hpp"
#include "tests/support/growth.hpp"

namespace gyrotherm {
namespace {

/// Returns "line:column" of the first flaw, or "" if there is none.
std::string flaw_position(std::string_view text) {
  const auto flaw = find_flaw(text);
  return flaw ? std::to_string(flaw->line) + ":" + std::to_string(flaw->column) : "";
}

TEST(TomlText, AcceptsAnyCharacterInStringsAndComments) {
  for (const char* text :
       {"a = \"20 °C\" # °C\nb = '°'\n", "a = \"\"\"°\n°\"\"\"\n", "a = '''°\n'°'''\n# °", "a = \"\" # °\nb = ''\n",
        "a = \"\\\"°\\\\\" # °\n", "a = \"\"\"\"°\"\"\"\"\" # °\n", "a = \"\"\"\"\"\" # °", "\xEF\xBB\xBF# °\na = 1",
        "a = \"\"\"x \\\n   y°\"\"\"", "a = '\\' # °"})
    EXPECT_EQ(flaw_position(text), "") << text;
}

TEST(TomlText, LocatesNonAsciiCharacterElsewhere) {
  EXPECT_EQ(flaw_position("\xCA\xBF\n8"), "1:1");
  EXPECT_EQ(flaw_position("a = \"°°\" °"), "1:10");
  EXPECT_EQ(flaw_position("a = 1\n  ° = 2"), "2:3");
  EXPECT_EQ(flaw_position("a = '''\n''' °"), "2:5");
  EXPECT_EQ(flaw_position("a = \"\"\"\n\"\"\"\"\" °"), "2:7");
  EXPECT_EQ(flaw_position("# °\n\u3000"), "2:1");
}

// After a line continuation toml++ skips blanks in the same way as outside strings.
TEST(TomlText, RejectsNonAsciiCharacterAtStartOfContinuedLine) {
  EXPECT_EQ(flaw_position("a = \"\"\"x \\\n  °\"\"\""), "2:3");
  EXPECT_EQ(flaw_position("a = \"\"\"x \\\n  y°\"\"\""), "");
  EXPECT_EQ(flaw_position("a = \"\\°\""), "1:7");
}

TEST(TomlText, LocatesInvalidUtf8) {
  for (const char* bytes : {"\x80", "\xC0\x80", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
                            "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF", "\xE2\x82", "\xC2"})
    EXPECT_EQ(flaw_position("# é\n# " + std::string(bytes)), "2:3") << bytes;
  for (const char* text :
       {"\xC2\x80", "\xE0\xA0\x80", "\xED\x9F\xBF", "\xEE\x80\x80", "\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF"})
    EXPECT_EQ(flaw_position("# " + std::string(text)), "") << text;
}

TEST(TomlText, LeavesUnterminatedStringToParser) {
  EXPECT_EQ(flaw_position("a = \"x\n° = 1"), "");
  EXPECT_EQ(flaw_position("a = 'x\n° = 1"), "");
}

TEST(TomlText, AcceptsEveryShippedFile) {
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(GYROTHERM_SOURCE_DIR "/profiles")) {
    if (entry.path().extension() != ".toml") continue;
    EXPECT_EQ(flaw_position(read_text_file(entry.path()).value()), "") << entry.path();
    ++files;
  }
  EXPECT_GT(files, 20);
}

std::string repeated(std::size_t count, std::string_view piece) {
  std::string all;
  all.reserve(count * piece.size());
  for (std::size_t i = 0; i < count; ++i) all += piece;
  return all;
}

/// Returns a dotted key of `parts` parts, such as "a.a.a".
std::string dotted_key(std::size_t parts) { return "a" + repeated(parts - 1, ".a"); }

/// Returns the error in a text, or "no error". The test program crashes if parsing exhausts the memory or the stack.
std::string parse_error(std::string_view bomb) {
  const auto read = TomlTable::parse(bomb, "b.toml");
  return read ? "no error" : text(read.error());
}

constexpr const char* kTooDeep = "is nested more than 32 keys, tables and arrays deep, expected fewer";

TEST(TomlBounds, LimitPartsOfDottedKey) {
  EXPECT_EQ(parse_error(dotted_key(30'780) + " = 1"), fmt::format("b.toml:1:66: {}", kTooDeep));
  EXPECT_EQ(parse_error("x = 1\n  " + dotted_key(34) + " = 1"), fmt::format("b.toml:2:68: {}", kTooDeep));
  EXPECT_EQ(parse_error(dotted_key(33) + " = 1"), "no error");
}

TEST(TomlBounds, LimitTotalNestingOfKeysTablesAndArrays) {
  EXPECT_NE(parse_error("[" + dotted_key(30'780) + "]").find(kTooDeep), std::string::npos);
  EXPECT_NE(parse_error("a = " + repeated(33, "[") + repeated(33, "]")).find(kTooDeep), std::string::npos);
  EXPECT_NE(parse_error("a = " + repeated(33, "{b=") + "1" + repeated(33, "}")).find(kTooDeep), std::string::npos);
  EXPECT_NE(parse_error("[" + dotted_key(20) + "]\n" + dotted_key(16) + " = 1").find(kTooDeep), std::string::npos);
  EXPECT_NE(parse_error(dotted_key(12) + " = {" + dotted_key(12) + " = {" + dotted_key(12) + " = 1}}").find(kTooDeep),
            std::string::npos);
  EXPECT_EQ(parse_error("a = " + repeated(32, "[") + repeated(32, "]")), "no error");
  EXPECT_EQ(parse_error(dotted_key(8) + " = {" + dotted_key(8) + " = {" + dotted_key(8) + " = 1}}"), "no error");
}

TEST(TomlBounds, DoNotCountClosedTables) {
  EXPECT_EQ(parse_error(repeated(1000, "[[s]]\nx.y.z = [[1.5, 2.5], [3.5]] # a.b.c.d.e\nt = '[[[['\n")), "no error");
  std::string tables;
  for (int i = 0; i < 1000; ++i)
    tables += fmt::format("[t{}.{}]\n{} = {{b.c = [1, [2]]}}\n", i, dotted_key(10), dotted_key(10));
  EXPECT_EQ(parse_error(tables), "no error");
}

TEST(TomlBounds, LimitKeysValuesStringsAndTokens) {
  EXPECT_EQ(parse_error(repeated(200'001, "[[a]]\n")),
            "b.toml:200001:1: more than 200000 keys and tables, expected fewer");
  std::string keys;
  for (int i = 0; i <= 200'000; ++i) keys += fmt::format("k{} = 1\n", i);
  EXPECT_EQ(parse_error(keys), "b.toml:200001:9: more than 200000 keys and tables, expected fewer");
  EXPECT_EQ(parse_error("a = [" + repeated(500'001, "1,") + "]"),
            "b.toml:1:1000007: more than 500000 values in arrays, expected fewer");
  EXPECT_EQ(parse_error("a = '" + repeated(65'536, "x") + "'"),
            "b.toml:1:65541: a text of more than 65536 bytes, expected a shorter one");
  EXPECT_EQ(parse_error("a = \"\"\"\n" + repeated(65'536, "\n") + "\"\"\"").substr(0, 13), "b.toml:65534:");
  EXPECT_EQ(parse_error(repeated(2000, "x") + " = 1"),
            "b.toml:1:1025: a token of more than 1024 bytes, expected a shorter one");
  EXPECT_EQ(parse_error("a = " + repeated(2000, "1")),
            "b.toml:1:1029: a token of more than 1024 bytes, expected a shorter one");
}

TEST(TomlBounds, LimitSizeOfText) {
  EXPECT_EQ(parse_error(std::string(100'000'000, '#')),
            "b.toml:1:1: the text has 100000000 bytes, expected at most 4000000");
  EXPECT_EQ(parse_error(repeated(kLargestText / 2, "#\n")), "no error");
}

TEST(TomlBounds, ScanUnterminatedQuotesOnce) {
  for (const char* quotes : {"'''", "\"\"\"", "\"", "'", "\"x\\\""})
    EXPECT_NE(parse_error(repeated(1'000'000, quotes)), "no error") << quotes;
}

/// Reading a text within the limits takes linear time.
TEST(TomlBounds, ReadLargestTextsInLinearTime) {
  const auto keys = [](int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += fmt::format("k{} = 1\n", i);
    return text;
  };
  const auto list_of = [](const char* item) {
    return [item](int count) { return "a = [" + repeated(2 * count, item) + "]"; };
  };
  const std::function<std::string(int)> forms[] = {[](int count) { return repeated(count, "[[a]]\n"); }, keys,
                                                   list_of("{},"), list_of("[],"), list_of("'',")};
  for (const auto& form : forms) {
    const auto read = [&](int count) {
      const auto table = TomlTable::parse(form(count), "b.toml");
      ASSERT_TRUE(table) << text(table.error());
      for (const auto& child : table->tables("a")) child.note_error("", "of each");
      EXPECT_FALSE(table->verdict());
    };
    EXPECT_LT(tests::growth_over_ten(read, 19'000), tests::kLargestLinearGrowth) << form(2);
  }
}

TEST(TomlText, RoundTripsQuotedText) {
  std::string all = "\"\\ °C \x7f";
  for (char c = 0; c < ' '; ++c) all += c;
  const auto table = TomlTable::parse("a = " + toml_quoted(all), "t");
  ASSERT_TRUE(table) << text(table.error());
  EXPECT_EQ(table->text("a"), all);
}

}  // namespace
}  // namespace gyrotherm
