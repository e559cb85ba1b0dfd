// SPDX-License-Identifier: Apache-2.0
#include "core/toml_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

namespace gyrotherm {
namespace {

TomlTable parsed(std::string_view text) { return TomlTable::parse(text, "f.toml").value(); }

std::string verdict(const TomlTable& table) {
  const auto verdict = table.verdict();
  return verdict ? "no error" : text(verdict.error());
}

TEST(TomlTable, ReadsEveryKindOfValue) {
  const auto t = parsed(R"(number = 2.5
integer = 7
boolean = true
text = "a"
duration = "1 h 30 min"
celsius = "-40 °C"
bare = 20
kelvins = "2 K"
rate = "5 °C/min"
numbers = [1, 2.5]
texts = ["a", "b"]
rows = [[1, 2], [3]]
rates = [1, "2 K/min"]
durations = ["1 s", "2 min"]
)");
  EXPECT_EQ(t.number("number"), 2.5);
  EXPECT_EQ(t.integer("integer"), 7);
  EXPECT_TRUE(t.boolean("boolean", false));
  EXPECT_EQ(t.text("text"), "a");
  EXPECT_EQ(t.duration("duration"), std::chrono::minutes(90));
  EXPECT_EQ(t.celsius("celsius"), Celsius{-40});
  EXPECT_EQ(t.celsius("bare"), Celsius{20});
  EXPECT_EQ(t.kelvins("kelvins", {}), Kelvins{2});
  EXPECT_EQ(t.rate("rate"), CelsiusPerMinute{5});
  EXPECT_EQ(t.numbers("numbers"), (std::vector<double>{1, 2.5}));
  EXPECT_EQ(t.texts("texts"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(t.number_rows("rows"), (std::vector<std::vector<double>>{{1, 2}, {3}}));
  EXPECT_EQ(t.rates("rates"), (std::vector<CelsiusPerMinute>{{1}, {2}}));
  EXPECT_EQ(t.durations("durations"), (std::vector<Duration>{std::chrono::seconds(1), std::chrono::minutes(2)}));
  EXPECT_EQ(verdict(t), "no error");
}

TEST(TomlTable, UsesFallbackForAbsentKeys) {
  const auto t = parsed("");
  EXPECT_EQ(t.number("a", 1.5), 1.5);
  EXPECT_EQ(t.text("b", "x"), "x");
  EXPECT_EQ(t.celsius("c", Celsius{3}), Celsius{3});
  EXPECT_TRUE(t.numbers("d").empty());
  EXPECT_TRUE(t.tables("e").empty());
  EXPECT_EQ(t.table("f").number("g", 2), 2);
  EXPECT_EQ(verdict(t), "no error");
}

TEST(TomlTable, ReportsErrorsWithPositionAndMissingKeysLast) {
  const auto t = parsed("a = \"x\"\nunknwon = 1\n[b]\nc = \"5 parsecs\"\n");
  (void)t.table("b").duration("c");
  (void)t.table("b").number("d");
  (void)t.number("a");
  (void)t.has("unknown");
  EXPECT_EQ(verdict(t),
            "f.toml:1:5: \"a\" is \"x\", expected a number\n"
            "f.toml:2:1: unknown key \"unknwon\", did you mean \"unknown\"?\n"
            "f.toml:4:5: \"c\" is \"5 parsecs\", expected a duration like \"2 h\" or \"90 s\"\n"
            "f.toml:3:1: missing key \"d\", expected a number");
}

TEST(TomlTable, DoesNotReportMisspeltKeyAsMissing) {
  const auto t = parsed("tmie = \"1 h\"\n");
  (void)t.duration("time");
  EXPECT_EQ(verdict(t), "f.toml:1:1: unknown key \"tmie\", did you mean \"time\"?");
}

TEST(TomlTable, ReportsWrongUnitWithExpectedUnit) {
  const auto t = parsed("at = \"68 °F\"\n");
  (void)t.celsius("at");
  EXPECT_EQ(verdict(t),
            "f.toml:1:6: \"at\" is \"68 °F\", expected a temperature like 20 or \"20 °C\"; 68 °F is \"20 °C\"");
}

TEST(TomlTable, ReportsErrorOnce) {
  const auto t = parsed("a = 1\n");
  t.ignore("a");
  for (int i = 0; i < 3; ++i) t.note_error("a", "odd");
  EXPECT_EQ(verdict(t), "f.toml:1:5: odd");
}

TEST(TomlTable, RejectsUnitsOfOtherQuantities) {
  const auto t = parsed("a = \"5 K\"\nb = \"5 °C\"\nc = \"5 °C/s\"\nd = nan\ne = \"+-5 °C\"\n");
  (void)t.celsius("a");
  (void)t.rate("b");
  (void)t.rate("c");
  (void)t.number("d");
  (void)t.celsius("e");
  const auto fault = t.verdict().error();
  EXPECT_EQ(fault.where, "f.toml:1:5");
  EXPECT_EQ(std::count(fault.what.begin(), fault.what.end(), '\n'), 4);
}

TEST(TomlTable, SuggestsNearestChoice) {
  const auto t = parsed("kind = \"hodl\"\n");
  EXPECT_EQ(t.choice("kind", {"ramp", "hold"}), "ramp");
  EXPECT_EQ(verdict(t), "f.toml:1:8: \"hodl\" is not one of ramp, hold; did you mean \"hold\"?");
}

TEST(TomlTable, QuotesChoicesThatAreMarks) {
  const auto t = parsed("separator = \"comma\"\n");
  (void)t.choice("separator", {",", ";", "blanks"});
  EXPECT_EQ(verdict(t), "f.toml:1:13: \"comma\" is not one of \",\", \";\", \"blanks\"");
}

TEST(TomlTable, SuggestsNoKeyThatIsPresent) {
  const auto t = parsed("time = 1\ntiem = 2\nRate = 3\n");
  (void)t.number("time");
  (void)t.number("rate");
  EXPECT_EQ(verdict(t), "f.toml:2:1: unknown key \"tiem\"\nf.toml:3:1: unknown key \"Rate\", did you mean \"rate\"?");
}

TEST(TomlTable, SuggestsTablesThatArePresent) {
  const auto t = parsed("[[segment]]\n[[segments]]\n[[Segment]]\n");
  (void)t.tables("segment");
  EXPECT_EQ(verdict(t),
            "f.toml:2:3: unknown key \"segments\", did you mean \"segment\"?\n"
            "f.toml:3:3: unknown key \"Segment\", did you mean \"segment\"?");
}

TEST(TomlTable, NamesTableOfMisplacedKey) {
  const auto told = [](const std::string& file) {
    const auto t = parsed(file);
    (void)t.text("name", "");
    const auto chamber = t.table("chamber"), limits = t.table("limits");
    (void)chamber.text("line", "");
    (void)limits.number("highest", 0);
    for (const auto& sensor : limits.tables("sensor")) (void)sensor.number("least", 0);
    return verdict(t);
  };
  EXPECT_EQ(told("[chamber]\nname = \"a\"\n[limits]\n"),
            "f.toml:2:1: unknown key \"name\"; it belongs before the first table");
  EXPECT_EQ(told("[chamber]\nhighest = 1\n[limits]\n"), "f.toml:2:1: unknown key \"highest\"; it belongs in [limits]");
  EXPECT_EQ(told("highest = 1\n[chamber]\n[limits]\n"), "f.toml:1:1: unknown key \"highest\"; it belongs in [limits]");
  EXPECT_EQ(told("least = 1\n[chamber]\n[limits]\n[[limits.sensor]]\n"),
            "f.toml:1:1: unknown key \"least\"; it belongs in [limits.sensor]");
  EXPECT_EQ(told("[chamber]\nhighest = 1\n[limits]\nhighest = 2\n"), "f.toml:2:1: unknown key \"highest\"")
      << "the other table has it too";
}

TEST(TomlTable, ShowsRefusedNumberAsWritten) {
  const auto t = parsed("class = 3.3\nname = 2.0\n");
  (void)t.text("class");
  (void)t.text("name");
  EXPECT_EQ(verdict(t), "f.toml:1:9: \"class\" is 3.3, expected text\nf.toml:2:8: \"name\" is 2.0, expected text");
}

TEST(TomlTable, ChoiceRefusesEmptyText) {
  const auto t = parsed("kind = \"\"\non_stop = \"\"\n");
  EXPECT_EQ(t.choice("kind", {"ramp", "hold"}), "ramp");
  EXPECT_EQ(t.choice("on_stop", {"safe", "hold"}, "safe"), "safe");
  EXPECT_EQ(verdict(t), "f.toml:1:8: \"\" is not one of ramp, hold\nf.toml:2:11: \"\" is not one of safe, hold");
}

TEST(TomlTable, ChoiceNotesMissingKeyOnce) {
  const auto t = parsed("other = 1\n");
  t.ignore("other");
  EXPECT_EQ(t.choice("kind", {"ramp", "hold"}), "");
  EXPECT_EQ(verdict(t), "f.toml:1:1: missing key \"kind\", expected text");
}

TEST(TomlTable, ExpectRefusesEmptyText) {
  const auto t = parsed("schema = \"\"\n");
  t.expect("schema", "b/1");
  EXPECT_EQ(verdict(t), "f.toml:1:10: \"\" is not understood, expected \"b/1\"");
}

TEST(TomlTable, RejectsOtherSchema) {
  const auto t = parsed("schema = \"b/2\"\n");
  t.expect("schema", "b/1");
  EXPECT_EQ(verdict(t), "f.toml:1:10: \"b/2\" is not understood, expected \"b/1\"");
}

TEST(TomlTable, ReportsMissingTableWithoutItsKeys) {
  const auto t = parsed("a = 1\n");
  t.ignore("a");
  const auto chamber = t.table("chamber");
  (void)chamber.text("line");
  (void)chamber.table("limits").number("lowest");
  chamber.note_error("line", "leads nowhere");
  EXPECT_EQ(verdict(t), "f.toml:1:1: missing [chamber]");
}

TEST(TomlTable, ReportsValueInsteadOfTableAsOnlyError) {
  const auto t = parsed("chamber = 5\n");
  (void)t.table("chamber").text("line");
  EXPECT_EQ(verdict(t), "f.toml:1:11: \"chamber\" is not a table, expected [chamber]");
}

TEST(TomlTable, NamesOtherFileFormat) {
  const auto json = TomlTable::parse("{\"a\": 1}", "f.toml");
  ASSERT_FALSE(json);
  EXPECT_EQ(text(json.error()), "f.toml:1:1: is JSON, expected TOML");
}

TEST(TomlTable, ReportsOnlySchemaForOtherKindOfFile) {
  const auto t = parsed("schema = \"a/1\"\nc = 1\n");
  t.expect("schema", "b/1");
  (void)t.number("d");
  EXPECT_EQ(verdict(t), "f.toml:1:10: the schema of this file is a/1, expected b/1");
}

TEST(TomlTable, KeepsPositionsInArraysOfTables) {
  const auto t = parsed("[[s]]\na = 1\n\n[[s]]\na = 2\n  [[s.s]]\n  a = 3\n");
  const auto tables = t.tables("s");
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[1].location(), "f.toml:4:1");
  EXPECT_EQ(tables[1].location("a"), "f.toml:5:5");
  EXPECT_EQ(tables[1].tables("s")[0].location(), "f.toml:6:3");
}

TEST(TomlTable, ListsKeysInFileOrder) {
  const auto t = parsed("z = 1\na = 2\nm.x = 3\n");
  EXPECT_EQ(t.keys(), (std::vector<std::string>{"z", "a", "m"}));
  EXPECT_TRUE(t.is_table("m"));
  EXPECT_FALSE(t.is_table("a"));
}

TEST(TomlTable, ReportsSyntaxErrorWithPosition) {
  const auto t = TomlTable::parse("a = 1\nb = = 2\n", "f.toml");
  ASSERT_FALSE(t);
  EXPECT_EQ(t.error().kind, FaultKind::bad_file);
  EXPECT_EQ(t.error().where.substr(0, 9), "f.toml:2:");
}

// toml++ cannot handle "ʿ" at the start of a key or value.
TEST(TomlTable, ReportsNonAsciiLetterOutsideStringsWithPosition) {
  for (const char* text : {"\xCA\xBF\n8", "a = 1\n\xCA\xBF = 2", "a = \xCA\xBF"}) {
    const auto t = TomlTable::parse(text, "f.toml");
    ASSERT_FALSE(t) << text;
    EXPECT_EQ(t.error().kind, FaultKind::bad_file);
  }
  EXPECT_EQ(TomlTable::parse("a = \"°\"\nb = °", "f.toml").error().where, "f.toml:2:5");
  EXPECT_EQ(TomlTable::parse("a = \"°\" # °\n", "f.toml")->text("a"), "°");
}

TEST(TomlTable, OmitsConsequencesOfRefusedAndMissingValues) {
  const auto table = parsed("low = \"0,01\"\nhigh = -1\nnmae = \"a\"\n");
  if (!(table.number("low") > 0)) table.note_error("low", "expected a number above 0");
  if (!(table.number("high") > 0)) table.note_error("high", "expected a number above 0");
  if (table.text("name").empty()) table.note_error("name", "expected a name");
  const auto verdict = table.verdict();
  ASSERT_FALSE(verdict);
  const auto all = text(verdict.error());
  EXPECT_EQ(all.find("above 0"), all.rfind("above 0")) << all;
  EXPECT_NE(all.find("2:8: expected a number above 0"), std::string::npos) << all;
  EXPECT_EQ(all.find("expected a name"), std::string::npos) << all;
}

}  // namespace
}  // namespace gyrotherm
