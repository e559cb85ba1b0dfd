// SPDX-License-Identifier: Apache-2.0
#include "core/number_hint.hpp"

#include <gtest/gtest.h>

#include "core/toml_reader.hpp"

namespace gyrotherm {
namespace {

TEST(NumberHint, NamesCauseOfUsualSlips) {
  EXPECT_EQ(hint_at_number("−22 °C"), "its minus sign is another character; write \"-\"");
  EXPECT_EQ(hint_at_number("–22 °C"), "its minus sign is another character; write \"-\"");
  EXPECT_EQ(hint_at_number("22,5 °C"), "it has a decimal comma; write \"22.5 °C\"");
  EXPECT_EQ(hint_at_number("140 °F"), "140 °F is \"60 °C\"");
  EXPECT_EQ(hint_at_number("-40F"), "-40 °F is \"-40 °C\"");
  EXPECT_EQ(hint_at_number("20 minutes"), "write \"20 min\"");
  EXPECT_EQ(hint_at_number("1.5 hrs"), "write \"1.5 h\"");
  EXPECT_EQ(hint_at_number("0:20"), "write the time with its units, as \"1 h 20 min\"");
}

TEST(NumberHint, IsSilentWhenCauseIsUnknown) {
  for (const char* text :
       {"", " ", "warm", "20 °C", "20", "20 furlongs", ",", "1,", ",5", "a,b", "nan", "1e999 F", "-"})
    EXPECT_EQ(hint_at_number(text), "") << text;
}

/// Returns the message for a file of one line whose key `x` is read as a temperature.
std::string refuse(const std::string& text) {
  const auto table = TomlTable::parse(text, "f");
  if (!table) return table.error().what;
  (void)table->celsius("x", Celsius{});
  (void)table->texts("list");
  const auto verdict = table->verdict();
  return verdict ? "" : verdict.error().what;
}

TEST(NumberHint, FollowsMessageOfTomlReader) {
  EXPECT_EQ(refuse("x = \"22,5 °C\""),
            "\"x\" is \"22,5 °C\", expected a temperature like 20 or \"20 °C\"; it has a decimal comma; write \"22.5 "
            "°C\"");
  EXPECT_TRUE(refuse("x = 22,5").ends_with("; a number has a decimal point"));
  EXPECT_TRUE(refuse("y = 1\n  x = 0,1").ends_with("; a number has a decimal point"));
  EXPECT_FALSE(refuse("x = 1 ,").ends_with("point"));
  EXPECT_FALSE(refuse("x = [1 2").ends_with("point"));
  EXPECT_NE(refuse(std::string("\xFF\xFEx\0=\0", 6)).find("UTF-16"), std::string::npos);
  EXPECT_NE(refuse(std::string("\xFE\xFF\0x\0=", 6)).find("UTF-16"), std::string::npos);
  EXPECT_EQ(refuse("x = \"\xFF\"").find("UTF-16"), std::string::npos);
}

TEST(SyntaxHint, NamesUsualCauses) {
  const auto ends_with = [](const std::string& text, const std::string& end) {
    const auto message = refuse(text);
    EXPECT_TRUE(message.ends_with(end)) << text << ": " << message;
  };
  ends_with("x = tcp://10.0.0.5", "; a text has quotation marks");
  ends_with("x = virtual", "; a text has quotation marks");
  ends_with("x = yes", "; expected true or false");
  ends_with("x = True", "; expected true or false");
  ends_with("x = “a”", "; write the quotation mark \"");
  ends_with("x = −4", "; write the minus sign -");
  ends_with("x\u00A0= 4", "; this is a no-break space, write a space");
  ends_with("[t]\nx = 1\n[t]\n", "as [[thermometer]]");
  for (const char* other : {"x = 1 2", "x == 1", "x: 1", "[x", "= 1", "x =", "x = \"a", "° = 1"})
    EXPECT_EQ(refuse(other).find(';'), std::string::npos) << refuse(other);
}

TEST(ToFillIn, IsReportedBeforeAnythingElse) {
  const auto table = TomlTable::parse(
      "odd = 1\nlist = [\"a\", \"FILL IN: b\"]\n[t]\nx = \"FILL IN\"\n[[t.u]]\ny = { z = \"FILL IN: the address\" }",
      "f");
  ASSERT_FALSE(table);
  EXPECT_EQ(table.error().where, "f:2:14");
  EXPECT_EQ(table.error().what,
            "\"list\" is still to be filled in: b\nf:4:5: \"x\" is still to be filled in\n"
            "f:6:11: \"z\" is still to be filled in: the address");
  EXPECT_EQ(table.error().kind, FaultKind::bad_file);
  EXPECT_EQ(refuse("list = [\"to FILL IN\"]"), "");
}

}  // namespace
}  // namespace gyrotherm
